#include "orchestrator/advise/trials.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "orchestrator/run/observed_run.h"
#include "protocol/contract/cost.h"
#include "protocol/contract/error.h"

namespace tandem::orchestrator {
namespace {

constexpr double kGaugeSteps = 10.0;
/// A macro step of the reference costs about three of the scenario's: it is linearised anew, and
/// its integrators are of second order.
constexpr double kReferenceCost = 3.0;
/// Steps of all candidates together, in those of a trial run: a step and half of it, of five.
constexpr double kCandidateRuns = 15.0;
constexpr double kFewestTrialSteps = 10.0;
/// Errors of two converged schemes that are as near are the error of their integrators.
constexpr double kSameError = 0.01;

double refinement(const IntegratorPair& pair) { return pair.order == 2 ? 8.0 : 16.0; }

class TrialRuns {
 public:
  TrialRuns(const LoadTrial& load, const Model& model, const TrialOptions& options)
      : load_(load), model_(model), options_(options), pairs_(integrator_pairs(model)) {
    trials_.step_s = options.step_s;
  }

  Trials run() {
    if (!choose_length() || !find_reference()) return std::move(trials_);
    const IntegratorPair& own = pairs_.front();
    const std::string scheme = to_string(model_.coupling.scheme);
    if (scheme == "implicit" || (scheme == "explicit_serial" && options_.explicit_serial)) {
      measure(scheme, own);
    }
    measure("interface_jacobian", own);
    for (const IntegratorPair& pair : pairs_) {
      if (pair.order == 2) measure("interface_jacobian", pair);
    }
    if (options_.explicit_serial) measure("explicit_serial", own);
    measure("implicit", own);
    for (const IntegratorPair& pair : pairs_) {
      measure("interface_jacobian", pair);
      for (const char* other : {"explicit_serial", "implicit"}) {
        if (costs_less(other)) measure(other, pair);
      }
    }
    return std::move(trials_);
  }

 private:
  ObservedRun observe(const Settings& settings, Mode mode, double step_s, double length_s,
                      const std::string& name) {
    return observe_run(load_(settings, step_s, length_s), mode,
                       options_.folder / name / fmt::format("{:g}", step_s),
                       fmt::format("trial: {}, H = {:g} s over {:g} s", name, step_s, length_s),
                       options_.deadline_s);
  }

  /// As many steps as asked for, or as the wall time suffices for.
  bool choose_length() {
    const double step_s = options_.step_s;
    const ObservedRun gauge = observe({}, Mode::Inproc, step_s, kGaugeSteps * step_s, "gauge");
    const double made = std::max(1.0, gauge.summary.at("macro_steps").get<double>());
    const double per_step_s = gauge.summary.at("wall_s").get<double>() / made;
    trials_.own_wall_per_step_s = per_step_s;
    const double all = kReferenceCost * 1.5 * refinement(pairs_.front()) + kCandidateRuns;
    const double affordable = (options_.deadline_s - now_s()) / (all * per_step_s);
    const double asked = std::min(static_cast<double>(options_.steps),
                                  std::round(to_seconds(model_.run.duration) / step_s));
    const double steps = std::floor(std::min(asked, affordable));
    if (steps < std::min(kFewestTrialSteps, asked)) {
      trials_.undecided.push_back(fmt::format(
          "what the candidates' errors are: a macro step takes {:.2g} s of wall time, too much for "
          "trial runs against a fine one. Raise --most-s.",
          per_step_s));
      return false;
    }
    trials_.length_s = steps * step_s;
    if (steps < asked) {
      trials_.undecided.push_back(
          fmt::format("what the errors are after {:g} s: the trial runs have {:g} of the {:g} "
                      "steps that they should have. Raise --most-s.",
                      trials_.length_s, steps, asked));
    }
    return true;
  }

  /// False where no reference was solved: said.
  bool find_reference() {
    std::vector<IntegratorPair> order = pairs_;
    std::stable_sort(order.begin(), order.end(),
                     [](const auto& a, const auto& b) { return a.order > b.order; });
    std::string why;
    for (const IntegratorPair& pair : order) {
      if (try_reference(pair, why)) return true;
    }
    trials_.undecided.push_back("what the candidates' errors are: " + why +
                                " Raise --most-s, or shorten the trials by --trial-steps.");
    return false;
  }

  bool try_reference(const IntegratorPair& pair, std::string& why) {
    const double fine_s = options_.step_s / refinement(pair);
    const auto run = [&](double step_s) -> std::optional<ObservedRun> {
      try {
        ObservedRun made = observe(pair.settings, Mode::Monolithic, step_s, trials_.length_s,
                                   "reference, " + pair.name);
        if (made.exit_code == 0) return made;
        why = fmt::format("the fine monolithic run, H = {:g} s, was not solved: {}", step_s,
                          made.summary.at("message").get<std::string>());
      } catch (const Error& error) {
        if (error.kind() != ErrorKind::Usage) throw;
        why = error.what();
      }
      return std::nullopt;
    };
    std::optional<ObservedRun> coarser = run(2.0 * fine_s);
    if (!coarser) return false;
    std::optional<ObservedRun> fine = run(fine_s);
    if (!fine) return false;
    ports_ = make_fem(load_(pair.settings, fine_s, trials_.length_s), {})->info().ports;
    reference_ = std::move(fine->history);
    trials_.reference_pair = pair.name;
    trials_.reference_step_s = fine_s;
    trials_.reference_error_m = motion_distance(coarser->history, reference_, ports_).motion_m;
    trials_.travel_m = largest_travel_m(reference_, ports_);
    return true;
  }

  [[nodiscard]] const TrialRow* row_of(const std::string& scheme, const std::string& pair) const {
    for (const TrialRow& row : trials_.rows) {
      if (row.candidate.scheme == scheme && row.candidate.pair.name == pair) return &row;
    }
    return nullptr;
  }

  /// Whether a macro step of the scheme has cost less than one of interface_jacobian.
  [[nodiscard]] bool costs_less(const std::string& scheme) const {
    const TrialRow* row = row_of(scheme, "own");
    const TrialRow* newton = row_of("interface_jacobian", "own");
    return row != nullptr && row->numbers.solved && newton != nullptr &&
           row->numbers.wall_per_step_s < newton->numbers.wall_per_step_s;
  }

  /// The error with half the step that a converged scheme with the same integrators has; 0: none.
  [[nodiscard]] double known_half_error_m(const TrialRow& row) const {
    if (!row.candidate.converges()) return 0.0;
    for (const TrialRow& other : trials_.rows) {
      if (!other.candidate.converges() || other.candidate.pair.name != row.candidate.pair.name) {
        continue;
      }
      const double error_m = other.numbers.error_m;
      if (std::abs(row.numbers.error_m - error_m) <= kSameError * error_m) {
        return other.numbers.half_error_m;
      }
    }
    return 0.0;
  }

  void leave_out(const std::string& name, const std::string& why) {
    trials_.undecided.push_back(fmt::format("how good {} is: {}", name, why));
  }

  void measure(const std::string& scheme, const IntegratorPair& pair) {
    if (row_of(scheme, pair.name) != nullptr) return;
    TrialRow row{.candidate = make_candidate(model_, scheme, pair), .status = "", .numbers = {}};
    const std::string name = row.candidate.name();
    if (now_s() >= options_.deadline_s) {
      leave_out(name, "the wall time for trial runs is spent. Raise --most-s.");
      return;
    }
    try {
      measure(name, row);
    } catch (const Error& error) {
      if (error.kind() != ErrorKind::Usage) throw;
      leave_out(name, error.what());
      return;
    }
    if (row.status == kOutOfTime) {
      leave_out(name, "the wall time for trial runs is spent. Raise --most-s.");
      return;
    }
    trials_.rows.push_back(std::move(row));
  }

  void measure(const std::string& name, TrialRow& row) {
    const double step_s = options_.step_s;
    const ObservedRun run =
        observe(row.candidate.settings, Mode::Inproc, step_s, trials_.length_s, name);
    row.status = run.summary.at("status").get<std::string>();
    if (run.out_of_time) return;
    row.exchanges_per_step = run.summary.at("iterations").at("mean").get<double>();
    const double made = std::max(1.0, run.summary.at("macro_steps").get<double>());
    row.numbers = {.solved = run.exit_code == 0,
                   .step_s = step_s,
                   .error_m = motion_distance(run.history, reference_, ports_).motion_m,
                   .wall_per_step_s = run.summary.at("wall_s").get<double>() / made};
    if (!row.numbers.solved) return;
    row.numbers.half_error_m = known_half_error_m(row);
    if (row.numbers.half_error_m > 0.0) return;
    const ObservedRun half =
        observe(row.candidate.settings, Mode::Inproc, 0.5 * step_s, trials_.length_s, name);
    if (half.exit_code == 0) {
      row.numbers.half_error_m = motion_distance(half.history, reference_, ports_).motion_m;
    }
  }

  const LoadTrial& load_;
  const Model& model_;
  const TrialOptions& options_;
  std::vector<IntegratorPair> pairs_;
  History reference_;
  std::vector<PortInfo> ports_;
  Trials trials_;
};

}  // namespace

Trials run_trials(const LoadTrial& load, const Model& model, const TrialOptions& options) {
  return TrialRuns(load, model, options).run();
}

}  // namespace tandem::orchestrator
