#pragma once

#include <algorithm>

#include "protocol/contract/cost.h"
#include "protocol/contract/subsystem.h"

namespace tandem {

/// What the calls to one side have cost since the last reset.
struct SideMeter {
  CallCost cost;             ///< as the side reports it
  double duration_s = 0.0;   ///< time the caller spent inside the calls
  double discarded_s = 0.0;  ///< compute of advances that were rolled back
  /// Booked time that passed beside other booked time: of begun advances outside of the calls, and
  /// of bodies that compute at the same time.
  double overlap_s = 0.0;
  double pending_s = 0.0;  ///< compute of the last advance, discarded if a rollback follows
};

/// Where a side computes: its compute time is the duration of the call (here) or reported
/// (elsewhere).
enum class Locality { Here, Elsewhere };

/// Forwards every call and books its time and bytes.
template <class In, class Out>
class MeteredSide final : public Subsystem<In, Out> {
 public:
  MeteredSide(Subsystem<In, Out>& inner, Locality locality, SideMeter& meter)
      : inner_(inner), locality_(locality), meter_(meter) {}

  const SubsystemInfo& info() const override { return inner_.info(); }
  Out initialize(const In& input) override { return inner_.initialize(input); }
  Observation observe() override { return inner_.observe(); }
  void checkpoint() override {
    meter_.pending_s = 0.0;
    book([this] { inner_.checkpoint(); });
  }
  void rollback() override {
    meter_.discarded_s += meter_.pending_s;
    meter_.pending_s = 0.0;
    book([this] { inner_.rollback(); });
  }
  CommandResult command(const std::string& text) override {
    const double start_s = now_s();
    CommandResult result = inner_.command(text);
    const double duration_s = now_s() - start_s;
    if (locality_ == Locality::Here) result.cost.compute_s = duration_s;
    meter_.cost += result.cost;
    meter_.duration_s += duration_s;
    return result;
  }
  StepResult<Out> advance(const StepRequest<In>& request) override {
    const double start_s = now_s();
    StepResult<Out> result = inner_.advance(request);
    const double duration_s = now_s() - start_s;
    if (locality_ == Locality::Here) result.cost.compute_s = duration_s;
    // Several bodies of one side compute at the same time.
    meter_.overlap_s += std::max(0.0, result.cost.total_s() - duration_s);
    book_advance(result.cost, duration_s);
    return result;
  }
  void begin_advance(const StepRequest<In>& request) override {
    const double start_s = now_s();
    inner_.begin_advance(request);
    begun_s_ = now_s() - start_s;
  }
  StepResult<Out> finish_advance() override {
    const double start_s = now_s();
    StepResult<Out> result = inner_.finish_advance();
    const double duration_s = begun_s_ + (now_s() - start_s);
    if (locality_ == Locality::Here) result.cost.compute_s = duration_s;
    meter_.overlap_s += std::max(0.0, result.cost.total_s() - duration_s);
    book_advance(result.cost, duration_s);
    return result;
  }

 private:
  void book_advance(const CallCost& cost, double duration_s) {
    meter_.cost += cost;
    meter_.duration_s += duration_s;
    meter_.pending_s = cost.compute_s;
  }

  template <class Call>
  void book(Call call) {
    const double start_s = now_s();
    call();
    const double duration_s = now_s() - start_s;
    meter_.duration_s += duration_s;
    if (locality_ == Locality::Here) meter_.cost.compute_s += duration_s;
  }

  Subsystem<In, Out>& inner_;
  Locality locality_;
  SideMeter& meter_;
  double begun_s_ = 0.0;  ///< spent in begin_advance()
};

}  // namespace tandem
