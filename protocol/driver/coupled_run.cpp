#include "protocol/driver/coupled_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "protocol/contract/error.h"
#include "protocol/contract/hash.h"
#include "protocol/driver/journaled_side.h"
#include "protocol/schemes/alternation.h"
#include "protocol/schemes/counter_inertia.h"
#include "protocol/schemes/divergence_monitor.h"
#include "protocol/schemes/evaluation.h"
#include "protocol/schemes/step_controller.h"

namespace tandem {
namespace {

/// Far above what first-order steps make in any run of use.
constexpr double kMostCreated = 100.0;
/// A model at rest has nothing but round-off: its forces at motions far below this part of its
/// size.
constexpr double kStill = 1e-9;
/// Of the energies of a run, what is round-off of a macro step at most.
constexpr double kRoundOff = 1e-11;

/// Times at which a run looks into the sides' books. Each is an exchange, which no step pays for.
constexpr std::int64_t kLooks = 64;

/// The ledger of one macro step from what both sides' meters booked and the wall time of its parts.
Ledger step_ledger(const SideMeter& mbs, const SideMeter& fem, double advance_s) {
  Ledger ledger;
  ledger.add_transfer(mbs.cost);
  ledger.add_transfer(fem.cost);
  ledger.mbs_compute_s = mbs.cost.compute_s;
  ledger.fem_compute_s = fem.cost.compute_s;
  ledger.overlap_s = mbs.overlap_s + fem.overlap_s;
  ledger.discarded_s = mbs.discarded_s + fem.discarded_s;
  // What the scheme's own code took: its wall time outside of the calls to the sides.
  ledger.scheme_s = advance_s - mbs.duration_s - fem.duration_s;
  return ledger;
}

/// Why a run has diverged, as far as that can be told, and what helps.
std::string cause_of(const Divergence& seen, const CouplingParams& coupling,
                     const std::string& scheme_name) {
  const bool serial = scheme_name == to_string(SchemeKind::ExplicitSerial);
  if (!serial && scheme_name != to_string(SchemeKind::ExplicitParallel)) {
    return "The scheme itself makes no energy: lower run.macro_step_s or the sides' micro_step_s" +
           std::string(coupling.on_not_converged == OnNotConverged::Accept
                           ? ", or let coupling.on_not_converged stop the run at the first step "
                             "that does not converge."
                           : ".");
  }
  const std::string remedy =
      "use coupling.scheme: interface_jacobian (or implicit), or lower run.macro_step_s.";
  if (!serial || !(seen.growth_per_step > 1.0)) {
    return "The coupling is unstable at this step: " + remedy;
  }
  return fmt::format(
      "‖r‖ grew {:.3g} times per macro step, as {} lets it where the flexible side's effective "
      "mass "
      "(with H² times its stiffness) is {:.3g} times the rigid one's; the limit with "
      "coupling.prediction: {} is {:.3g}. Unless a side is unstable by itself, {}",
      seen.growth_per_step, scheme_name, ratio_of_growth(seen.growth_per_step, coupling.prediction),
      to_string(coupling.prediction), ratio_of_growth(1.0, coupling.prediction), remedy);
}

/// One coupled run in progress.
class CoupledRun {
 public:
  CoupledRun(const CoupledRunParams& params, PlacedSide<MbsSide> mbs, PlacedSide<FemSide> fem,
             StepSink& sink)
      : params_(params),
        sink_(sink),
        ports_(fem.side.info().ports),
        metered_mbs_(mbs.side, mbs.locality, mbs_meter_),
        metered_fem_(fem.side, fem.locality, fem_meter_),
        mbs_(metered_mbs_, journal_, dynamic_cast<const wire::TimedCalls*>(&mbs.side)),
        journaled_fem_(metered_fem_, journal_, dynamic_cast<const wire::TimedCalls*>(&fem.side)),
        counter_(counter_inertia(mbs.side.info().ports)),
        fem_(counter_ ? static_cast<FemSide&>(*counter_) : journaled_fem_),
        scheme_(params.make_scheme(ports_)),
        monitor_(params.coupling.divergence_growth, ports_),
        alternation_(ports_),
        pace_(params.run.pace) {
    require_same_ports(mbs.side.info().ports);
    report_.scheme = params.scheme_name;
    if (params.scheme_name == to_string(SchemeKind::Tlm)) report_.parasitic_mass_kg = 0.0;
    for (const PortInfo& port : ports_) report_.port_names.push_back(port.name);
  }

  RunReport run() {
    initialize();
    const double start_s = now_s();
    pace_.begin();
    for (std::int64_t n = 1;
         state_.time < params_.run.duration && report_.status == RunStatus::Done; ++n) {
      make_step(n);
    }
    report_.wall_s = now_s() - start_s - looking_s_;
    report_.pace = pace_.report();
    report_.ledger.other_s = report_.wall_s - report_.pace.waited_s - report_.ledger.named_s();
    finish();
    return std::move(report_);
  }

 private:
  std::optional<CounterInertia> counter_inertia(const std::vector<PortInfo>& ports) {
    if (!CounterInertia::needed(ports)) return std::nullopt;
    return std::optional<CounterInertia>(std::in_place, journaled_fem_, ports);
  }

  void require_same_ports(const std::vector<PortInfo>& mbs_ports) const {
    const bool same =
        std::equal(ports_.begin(), ports_.end(), mbs_ports.begin(), mbs_ports.end(),
                   [](const PortInfo& a, const PortInfo& b) { return a.name == b.name; });
    require(same, "the two sides have different port tables. Start both from the same scenario.");
  }

  void initialize() {
    state_.motions = mbs_.initialize(WrenchSet(ports_.size()));
    state_.wrenches = fem_.initialize(state_.motions);
    if (params_.coupling.adaptive.active()) {
      controller_.emplace(params_.coupling, params_.run.macro_step, ports_, state_.motions);
    }
    observe(report_.energy_start, &report_.worlds_start, &report_.bodies_start);
    book_range(report_.energy_start);
    wire::StepRecord step;
    if (params_.energy_every_steps > 0) step.energy = report_.energy_start;
    sink_.record({.step = step, .calls = journal_.take()});
  }

  void make_step(std::int64_t n) {
    const double start_s = now_s();
    mbs_meter_ = {};
    fem_meter_ = {};
    take_commands(n);
    mbs_.checkpoint();
    fem_.checkpoint();
    SimTime H{};
    const MacroStepEnd end = advance(H);
    const SimTime t_end = state_.time + H;
    wire::StepRecord step{.macro_step = n,
                          .time = t_end,
                          .step = H,
                          .iterations = end.iterations,
                          .residual_N = end.residual_N,
                          .energy_defect_J = defect_J(H, end),
                          .outcome = end.outcome};
    judge(n, H, t_end, end);
    step.ledger = step_ledger(mbs_meter_, fem_meter_, now_s() - start_s);
    report_.book(step);
    record(step, start_s);
    if (report_.status != RunStatus::Done) return;
    report_.book_interface(step.energy_defect_J, exchanged_J(H, end));
    accept(n, t_end, end);
    pace_.end_step(t_end, last_ledger_, now_s() - start_s,
                   [this](double seconds) { sink_.rest(seconds); });
  }

  void take_commands(std::int64_t n) {
    if (params_.commands == nullptr) return;
    for (const Command& command : params_.commands->take()) {
      params_.commands->answer(command, n, fem_.command(command.text));
    }
  }

  /// One macro step, of the length that is given back: with adaptive steps repeated from the
  /// checkpoint, shorter and shorter, until the controller accepts it. The iterations are those of
  /// all attempts.
  MacroStepEnd advance(SimTime& H) {
    if (!controller_) {
      H = params_.run.macro_step;
      return scheme_->advance(H, state_, mbs_, fem_);
    }
    const SimTime target = next_target();
    std::int32_t discarded_iterations = 0;
    for (;;) {
      H = controller_->step(target - state_.time);
      MacroStepEnd end = scheme_->advance(H, state_, mbs_, fem_);
      end.iterations += discarded_iterations;
      if (controller_->accepts(H, end, state_)) {
        const bool solved = end.outcome == Outcome::Done;
        report_.steps_beyond_tolerance += solved && controller_->beyond_tolerance() ? 1 : 0;
        return end;
      }
      discarded_iterations = end.iterations;
      ++report_.rejected_steps;
      mbs_.rollback();
      fem_.rollback();
    }
  }

  /// The next event of the scenario, on the grid of the steps at or before it, or the end of the
  /// run. Where one is due now, the controller begins anew.
  SimTime next_target() {
    const SimTime unit = controller_->shortest();
    for (const SimTime event : params_.run.events) {
      const SimTime before = event / unit * unit;
      if (before > state_.time) return std::min(before, params_.run.duration);
      if (before == state_.time) controller_->restart();
    }
    return params_.run.duration;
  }

  static double defect_J(SimTime H, const MacroStepEnd& end) {
    if (end.outcome == Outcome::Failed) return 0.0;
    double sum_J = 0.0;
    for (double defect : energy_defects_J(H, end)) sum_J += defect;
    return sum_J;
  }

  static double exchanged_J(SimTime H, const MacroStepEnd& end) {
    if (end.outcome == Outcome::Failed) return 0.0;
    return to_seconds(H) * std::abs(interface_power_W(end.of_bodies(), end.motions));
  }

  /// Turns the end of a macro step into the run's status: diverged, not converged, failed, or go
  /// on.
  void judge(std::int64_t n, SimTime H, SimTime t_end, const MacroStepEnd& end) {
    const auto located = [&](const char* what) {
      return fmt::format("{}: {} at t = {:.9g} s (macro step {}, iteration {}): ",
                         params_.scheme_name, what, to_seconds(t_end), n, end.iterations);
    };
    if (end.outcome == Outcome::Failed) {
      stop(RunStatus::SolverFailed, located("a side failed") + end.message + remark());
      return;
    }
    const auto divergence = monitor_.check(H, end);
    // In free fall the interface carries nothing but round-off, which may grow by any factor.
    const double round_off_J = kRoundOff * report_.energy_range.largest_J();
    if (divergence && divergence->defect_J > round_off_J) {
      stop(RunStatus::Diverged, located("diverged") + divergence->text + ". " +
                                    cause_of(*divergence, params_.coupling, params_.scheme_name));
      return;
    }
    if (end.outcome != Outcome::NotConverged) return;
    if (report_.not_converged_message.empty()) report_.not_converged_message = end.message;
    if (params_.coupling.on_not_converged == OnNotConverged::Stop) {
      stop(RunStatus::NotConverged, located("not converged") + end.message + remark());
    }
  }

  /// Explicit schemes alternate by themselves: the mass ratio is their cause.
  [[nodiscard]] std::string remark() const {
    const SchemeKind kind = params_.coupling.scheme;
    const bool iterates = kind == SchemeKind::InterfaceNewton || kind == SchemeKind::Implicit;
    return iterates ? alternation_.remark() : std::string{};
  }

  void stop(RunStatus status, std::string message) {
    report_.status = status;
    report_.message = std::move(message);
  }

  void record(const wire::StepRecord& step, double start_s) {
    wire::StepJournal journal{.step = step, .calls = journal_.take()};
    // The row that is written cannot hold the time of writing it: it carries that of the row
    // before.
    journal.step.ledger.record_s = last_record_s_;
    journal.step.ledger.wait_s = last_wait_s_;
    const double record_start_s = now_s();
    journal.step.ledger.other_s = (record_start_s - start_s) - step.ledger.named_s();
    if (observes_at(step.macro_step)) observe(journal.step.energy.emplace());
    const double wait_s = sink_.record(std::move(journal));
    const double end_s = now_s();
    last_wait_s_ = wait_s;
    last_record_s_ = end_s - record_start_s - wait_s;

    Ledger ledger = step.ledger;
    ledger.record_s = last_record_s_;
    ledger.wait_s = wait_s;
    ledger.other_s = (end_s - start_s) - ledger.named_s();
    report_.ledger += ledger;
    last_ledger_ = ledger;
  }

  void accept(std::int64_t n, SimTime t_end, const MacroStepEnd& end) {
    report_.macro_steps = n;
    report_.steps_out_of_budget += end.out_of_budget ? 1 : 0;
    report_.simulated = t_end;
    if (report_.parasitic_mass_kg) {
      const double H_s = to_seconds(t_end - state_.time);
      const double mass_kg = params_.coupling.tlm.stiffness_N_per_m * H_s * H_s;
      report_.parasitic_mass_kg = std::max(*report_.parasitic_mass_kg, mass_kg);
    }
    state_.history.insert(state_.history.begin(), {state_.time, state_.motions, state_.wrenches});
    if (state_.history.size() > InterfaceState::kHistory) state_.history.pop_back();
    state_.time = t_end;
    book_moment(end);
    book_residual(end);
    report_.book_turn(state_.time - state_.history.front().time, state_.motions, end.motions);
    state_.motions = end.motions;
    state_.wrenches = end.wrenches;
    state_.own = end.own;
    alternation_.add(state_);
    look();
  }

  /// Books the sides' energies, now and then: their largest ones are what the errors are held
  /// against.
  void look() {
    if (state_.time * kLooks < params_.run.duration * looks_) return;
    while (state_.time * kLooks >= params_.run.duration * looks_) ++looks_;
    const double start_s = now_s();
    SideEnergies energy;
    observe(energy);
    book_range(energy);
    looking_s_ += now_s() - start_s;
  }

  void book_range(const SideEnergies& now) {
    report_.energy_range.book(report_.energy_start.sum(), now.sum(),
                              params_.scheme_name == to_string(SchemeKind::Tlm));
  }

  /// The model's scale of energy: its wrench over its size.
  void book_moment(const MacroStepEnd& end) {
    double size_m = 0.0;
    for (std::size_t i = 0; i < ports_.size(); ++i) {
      size_m = std::max(size_m, end.motions[i].p_WP.norm() + ports_[i].length_m);
    }
    largest_moment_J_ =
        std::max(largest_moment_J_, size_m * wrench_norm_N(end.of_bodies(), ports_));
  }

  /// What the iterations have left; the residual of the others is no error.
  void book_residual(const MacroStepEnd& end) {
    const SchemeKind scheme = params_.coupling.scheme;
    if (scheme != SchemeKind::InterfaceNewton && scheme != SchemeKind::Implicit) return;
    report_.residual_max_N = std::max(report_.residual_max_N, end.residual_N);
    report_.wrench_max_N = std::max(report_.wrench_max_N, wrench_norm_N(end.of_bodies(), ports_));
  }

  [[nodiscard]] bool observes_at(std::int64_t macro_step) const {
    return params_.energy_every_steps > 0 && macro_step % params_.energy_every_steps == 0 &&
           report_.status == RunStatus::Done;
  }

  /// `worlds` and `bodies`: what is known of single ones.
  void observe(SideEnergies& energy, std::vector<BodyObservation>* worlds = nullptr,
               std::vector<BodyObservation>* bodies = nullptr) {
    Observation mbs = mbs_.observe();
    Observation fem = fem_.observe();
    energy = {.mbs = mbs.energy, .fem = fem.energy};
    for (const BodyObservation& world : mbs.bodies) energy.parts.push_back(world.energy);
    for (const BodyObservation& body : fem.bodies) energy.parts.push_back(body.energy);
    report_.elastic_turn_rad = std::max(report_.elastic_turn_rad, fem.elastic_turn_rad);
    if (!(mbs.widest_joint.part <= report_.widest_joint.part)) {
      report_.widest_joint = mbs.widest_joint;
    }
    StateHash hash;
    hash.add(mbs.state_hash);
    hash.add(fem.state_hash);
    report_.state_hash = hash.value();
    if (worlds != nullptr) *worlds = std::move(mbs.bodies);
    if (bodies != nullptr) *bodies = std::move(fem.bodies);
  }

  /// Slow growth passes the monitor, which looks at the interface alone. Motion and strain cannot
  /// hold more than the run began with and was given, but for what the steps have made up. The
  /// lines of tlm hold energy of their own, and make none.
  void judge_energy() {
    if (params_.coupling.scheme == SchemeKind::Tlm) return;
    const EnergyBook a = report_.energy_start.sum();
    const EnergyBook b = report_.energy_end.sum();
    const double raised_J = b.potential_J - a.potential_J;
    const double held_J = b.kinetic_J + b.elastic_J + std::max(0.0, raised_J);
    const double given_J = std::abs(a.kinetic_J) + std::abs(a.elastic_J) +
                           std::max(0.0, -raised_J) +
                           std::abs(b.external_work_J - a.external_work_J);
    // Written so that an energy that is no number fails, too.
    if (held_J <= kMostCreated * given_J + kStill * largest_moment_J_) return;
    const std::string share =
        given_J > 0.0 ? fmt::format("{:.3g} times what the run began with and was given ({:.3g} J)",
                                    held_J / given_J, given_J)
                      : "while the run began with none and was given none";
    const std::string newton = to_string(SchemeKind::InterfaceNewton);
    stop(RunStatus::Diverged,
         fmt::format("{}: unstable: at t = {:.9g} s motion and strain hold {:.3g} J, {}. The steps "
                     "make energy: lower run.macro_step_s or the sides' micro_step_s{}.",
                     params_.scheme_name, to_seconds(state_.time), held_J, share,
                     params_.scheme_name == newton ? "" : ", or use coupling.scheme: " + newton) +
             remark());
  }

  void finish() {
    if (report_.status == RunStatus::Done) {
      mbs_.checkpoint();
      fem_.checkpoint();
    } else {
      // The books and the hash are those of the last accepted state.
      roll_back(mbs_, fem_);
    }
    observe(report_.energy_end, &report_.worlds_end, &report_.bodies_end);
    book_range(report_.energy_end);
    report_.still_J = kStill * largest_moment_J_;
    if (report_.status == RunStatus::Done) judge_energy();
    report_.motions = state_.motions;
    report_.wrenches = state_.of_bodies();
  }

  const CoupledRunParams& params_;
  StepSink& sink_;
  std::vector<PortInfo> ports_;
  SideMeter mbs_meter_, fem_meter_;
  wire::CallJournal journal_;
  MeteredSide<WrenchSet, MotionSet> metered_mbs_;
  MeteredSide<MotionSet, WrenchSet> metered_fem_;
  wire::JournaledMbs mbs_;
  wire::JournaledFem journaled_fem_;
  std::optional<CounterInertia> counter_;  ///< of junctions
  FemSide& fem_;
  std::unique_ptr<Scheme> scheme_;
  DivergenceMonitor monitor_;
  Alternation alternation_;
  std::optional<StepController> controller_;  ///< of adaptive steps
  InterfaceState state_;
  RunReport report_;
  Pace pace_;
  Ledger last_ledger_;             ///< of the last macro step
  double largest_moment_J_ = 0.0;  ///< of all accepted macro steps
  double last_record_s_ = 0.0, last_wait_s_ = 0.0;
  std::int64_t looks_ = 1;  ///< the next one is due at looks_/kLooks of the run
  double looking_s_ = 0.0;  ///< time that looks took
};

}  // namespace

CoupledRunParams scheme_run(const scenario::RunParams& run, const CouplingParams& coupling) {
  return {.run = run,
          .coupling = coupling,
          .scheme_name = to_string(coupling.scheme),
          .make_scheme = [coupling](std::vector<PortInfo> ports) {
            return make_scheme(coupling, std::move(ports));
          }};
}

RunReport run_coupled(const CoupledRunParams& params, PlacedSide<MbsSide> mbs,
                      PlacedSide<FemSide> fem, StepSink& sink) {
  return CoupledRun(params, mbs, fem, sink).run();
}

}  // namespace tandem
