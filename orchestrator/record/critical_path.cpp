#include "orchestrator/record/critical_path.h"

#include <algorithm>
#include <optional>

namespace tandem::orchestrator {
namespace {

/// A stretch of the driver's own time. `waits_for`: the errand, where that is all it did.
struct DriverPiece {
  Interval time;
  std::size_t place = 0;
  std::optional<std::size_t> waits_for;
  bool discarded = false;
};

/// What the driver did, from the begin of the step to its end without a gap.
class DriverTimeline {
 public:
  DriverTimeline(const StepTimes& step, std::size_t workers) : step_(step), workers_(workers) {
    add_calls();
    std::stable_sort(marks_.begin(), marks_.end(),
                     [](const Mark& a, const Mark& b) { return a.at_s < b.at_s; });
    const double tail_s = std::min(step.recording_s + step.credit_s, after_last_call());
    const double credit_s = std::min(step.credit_s, tail_s);
    sweep(step.whole.end_s - tail_s);
    add(step.whole.end_s - credit_s, {.time = {}, .place = place_of(Toll::Recording, workers)});
    add(step.whole.end_s, {.time = {}, .place = place_of(Toll::Credit, workers)});
  }

  [[nodiscard]] const std::vector<DriverPiece>& pieces() const { return pieces_; }

 private:
  /// A change of what the driver is in: calls by one more or less, an errand begun (+1) or ended.
  struct Mark {
    double at_s = 0.0;
    int calls = 0;
    int errands = 0;
    std::size_t errand = 0;
  };

  void add_calls() {
    for (const Interval& call : step_.calls) {
      marks_.push_back({call.begin_s, 1, 0, 0});
      marks_.push_back({call.end_s, -1, 0, 0});
    }
    for (std::size_t e = 0; e < step_.errands.size(); ++e) {
      const Errand& errand = step_.errands[e];
      if (errand.came_before()) {
        marks_.push_back({errand.awaited_s, 0, 0, e});
        continue;
      }
      marks_.push_back({errand.here ? errand.start_s : errand.awaited_s, 0, 1, e});
      marks_.push_back({errand.here ? errand.end_s : errand.arrived_s, 0, -1, e});
    }
  }

  [[nodiscard]] double after_last_call() const {
    double last_s = step_.whole.begin_s;
    for (const Interval& call : step_.calls) last_s = std::max(last_s, call.end_s);
    return std::max(0.0, step_.whole.end_s - last_s);
  }

  void sweep(double end_s) {
    int calls = 0;
    std::optional<std::size_t> errand;
    for (const Mark& mark : marks_) {
      add(std::min(mark.at_s, end_s), piece(calls, errand));
      calls += mark.calls;
      if (mark.errands > 0) errand = mark.errand;
      if (mark.errands < 0 && errand == mark.errand) errand.reset();
    }
    add(end_s, piece(calls, errand));
  }

  [[nodiscard]] DriverPiece piece(int calls, std::optional<std::size_t> errand) const {
    if (!errand) {
      return {.time = {}, .place = place_of(calls > 0 ? Toll::Coding : Toll::Driver, workers_)};
    }
    const Errand& e = step_.errands[*errand];
    if (e.here) return {.time = {}, .place = e.worker, .discarded = e.discarded};
    return {.time = {},
            .place = place_of(Toll::Wire, workers_),
            .waits_for = errand,
            .discarded = e.discarded};
  }

  /// Goes on with the piece to `until_s`.
  void add(double until_s, DriverPiece piece) {
    const double from_s = pieces_.empty() ? step_.whole.begin_s : pieces_.back().time.end_s;
    if (until_s <= from_s) return;
    piece.time = {from_s, until_s};
    pieces_.push_back(piece);
  }

  const StepTimes& step_;
  std::size_t workers_;
  std::vector<Mark> marks_;
  std::vector<DriverPiece> pieces_;
};

/// The run of a macro step on the driver's timeline, with other computing times.
class Rerun {
 public:
  Rerun(const StepTimes& step, std::size_t worker, double factor)
      : step_(step), worker_(worker), factor_(factor), sent_s_(step.errands.size(), 0.0) {
    for (std::size_t e = 0; e < step.errands.size(); ++e) {
      const Errand& errand = step.errands[e];
      if (errand.here) continue;
      sendings_.push_back(e);
      if (errand.came_before()) found_.push_back(e);
    }
    sort_by(sendings_, &Errand::sent_s);
    sort_by(found_, &Errand::awaited_s);
  }

  double duration(const std::vector<DriverPiece>& pieces) {
    for (const DriverPiece& piece : pieces) {
      look_at_found(piece.time.begin_s);
      send_during(piece.time);
      spend(piece);
    }
    look_at_found(step_.whole.end_s);
    return now_s_;
  }

 private:
  void sort_by(std::vector<std::size_t>& errands, double Errand::*time_s) const {
    std::stable_sort(errands.begin(), errands.end(), [&](std::size_t a, std::size_t b) {
      return step_.errands[a].*time_s < step_.errands[b].*time_s;
    });
  }

  /// When the errand's reply is there, which was `after_sending_s` behind its request.
  [[nodiscard]] double ready_s(std::size_t e, double after_sending_s) const {
    const Errand& errand = step_.errands[e];
    const double compute_s = errand.end_s - errand.start_s;
    const double saved_s = errand.worker == worker_ ? (1.0 - factor_) * compute_s : 0.0;
    return sent_s_[e] + after_sending_s - saved_s;
  }

  /// Replies that were there before they were waited for may now have to be.
  void look_at_found(double until_s) {
    for (; next_found_ < found_.size(); ++next_found_) {
      const std::size_t e = found_[next_found_];
      if (step_.errands[e].awaited_s > until_s) return;
      now_s_ = std::max(now_s_, ready_s(e, step_.errands[e].arrived_s - step_.errands[e].sent_s));
    }
  }

  /// Requests leave where they did within the driver's own work.
  void send_during(const Interval& time) {
    for (; next_sending_ < sendings_.size(); ++next_sending_) {
      const std::size_t e = sendings_[next_sending_];
      if (step_.errands[e].sent_s > time.end_s) return;
      sent_s_[e] = now_s_ + std::max(0.0, step_.errands[e].sent_s - time.begin_s);
    }
  }

  void spend(const DriverPiece& piece) {
    const double length_s = piece.time.end_s - piece.time.begin_s;
    if (!piece.waits_for) {
      now_s_ += piece.place == worker_ ? factor_ * length_s : length_s;
      return;
    }
    // A reply that lay there has to be taken all the same.
    const Errand& errand = step_.errands[*piece.waits_for];
    const double end_s = errand.blocked() ? errand.arrived_s : errand.end_s;
    now_s_ = std::max(now_s_, ready_s(*piece.waits_for, end_s - errand.sent_s)) +
             (errand.blocked() ? 0.0 : length_s);
  }

  const StepTimes& step_;
  std::size_t worker_;
  double factor_;
  std::vector<double> sent_s_;
  std::vector<std::size_t> sendings_, found_;
  std::size_t next_sending_ = 0, next_found_ = 0;
  double now_s_ = 0.0;
};

/// Collects the path from its end to its begin.
class BackwardPath {
 public:
  BackwardPath(double end_s, double begin_s) : at_s_(end_s), begin_s_(begin_s) {}

  [[nodiscard]] double at_s() const { return at_s_; }

  /// The piece from `from_s` to where the path has come.
  void back_to(double from_s, std::size_t place, bool discarded) {
    const double to_s = std::max(from_s, begin_s_);
    if (to_s >= at_s_) return;
    path_.push_back({{to_s, at_s_}, place, discarded});
    at_s_ = to_s;
  }

  /// Through the process that was waited for, to its request.
  void back_through(const Errand& errand, std::size_t workers) {
    const std::size_t wire = place_of(Toll::Wire, workers);
    const std::size_t coding = place_of(Toll::Coding, workers);
    back_to(errand.end_s + errand.encode_s, wire, errand.discarded);
    back_to(errand.end_s, coding, errand.discarded);
    back_to(errand.start_s, errand.worker, errand.discarded);
    back_to(errand.start_s - errand.decode_s, coding, errand.discarded);
    back_to(errand.sent_s, wire, errand.discarded);
  }

  [[nodiscard]] std::vector<PathPiece> in_order() && {
    std::reverse(path_.begin(), path_.end());
    return std::move(path_);
  }

 private:
  double at_s_, begin_s_;
  std::vector<PathPiece> path_;
};

}  // namespace

const char* text_of(Toll toll) {
  constexpr const char* kNames[kTolls] = {"wire", "coding", "driver", "recording", "credit"};
  return kNames[static_cast<std::size_t>(toll)];
}

std::vector<PathPiece> critical_path(const StepTimes& step, std::size_t workers) {
  const DriverTimeline driver(step, workers);
  BackwardPath path(step.whole.end_s, step.whole.begin_s);
  for (auto piece = driver.pieces().rbegin(); piece != driver.pieces().rend(); ++piece) {
    if (piece->time.begin_s >= path.at_s()) continue;  // passed by in another process
    const bool blocked = piece->waits_for && step.errands[*piece->waits_for].blocked();
    // Where the path comes back into the midst of a wait, this wait is not what it went through.
    if (blocked && path.at_s() >= piece->time.end_s) {
      path.back_through(step.errands[*piece->waits_for], workers);
    } else {
      path.back_to(piece->time.begin_s, piece->place, piece->discarded);
    }
  }
  return std::move(path).in_order();
}

double duration_if(const StepTimes& step, std::size_t worker, double factor) {
  // Tolls get numbers behind the worker's.
  return Rerun(step, worker, factor).duration(DriverTimeline(step, worker + 1).pieces());
}

}  // namespace tandem::orchestrator
