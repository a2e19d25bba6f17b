#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "fem_process/turning/elastic_turn.h"

namespace tandem::orchestrator {

/// What a finished run says of itself: its books, what its steps did, and what of its model decides
/// which remedy helps. Energies in J.
struct RunBooks {
  // The scale: the largest of them at the times at which the run looked into the books.
  double held_J = 0.0;              ///< in motion and in strain beyond that of the start
  double external_work_J = 0.0;     ///< size of the work of loads, force laws and motors
  double potential_change_J = 0.0;  ///< size of what height and springs hold more or less
  double still_J = 0.0;             ///< below this everything is round-off of a model at rest
  double given_J = 0.0;             ///< what the run began with, released and was given

  double exchanged_J = 0.0;          ///< Σ H |λ·V|, either way; 0 without an interface
  double lost_J = 0.0;               ///< by the steps, at the end; negative: made
  double lost_max_J = 0.0;           ///< the most that they had lost
  double made_max_J = 0.0;           ///< the most that they had made
  double balance_error_J = 0.0;      ///< at the end
  double balance_error_max_J = 0.0;  ///< its largest size

  double largest_turn_rad = 0.0;  ///< of a body or port in a macro step
  std::string turning;            ///< "port 'hub'"
  double largest_step_s = 0.0;    ///< H
  double elastic_turn_rad = 0.0;  ///< of an element whose shapes add up linearly
  double joint_gap_part = 0.0;    ///< by which a joint came apart, of its arm; see mbs::JointGaps
  double joint_gap_m = 0.0;
  std::string open_joint;  ///< its name

  std::int64_t macro_steps = 0;
  std::int64_t not_converged_steps = 0;
  std::string not_converged_message;  ///< of the first
  std::int64_t steps_beyond_tolerance = 0;
  double residual_part = 0.0;  ///< largest that an iterated step has left, of the largest wrench
  double accuracy = 1.0;       ///< run.accuracy: what it may leave
  std::int64_t steps_out_of_budget = 0;  ///< ended by coupling.max_evaluations
  std::int64_t paced_steps = 0;          ///< held to the wall clock
  std::int64_t missed_steps = 0;         ///< of these, late
  std::string missed_by;                 ///< the part that most of these are booked to

  std::optional<double> parasitic_mass_kg;  ///< of the lines, with tlm
  double lightest_port_body_kg = 0.0;       ///< what carries a port; 0: not known

  bool coupled = true;  ///< false: the flexible side alone
  bool explicit_scheme = false;
  bool adaptive = false;
  bool contact = false;
  bool linearised = false;  ///< one linearised step of the mesh, without iteration
  bool reduced = false;     ///< craig_bampton
  /// Path of a flexible body's section of the scenario, for remedies: the first that is of first
  /// order, reduced, linearised.
  std::string first_order_key = "fem", reduced_key = "fem", linearised_key = "fem";
  bool mbs_second_order = false;
  bool fem_second_order = false;
};

/// Above these a run is not simply done. Parts are of the scale; docs/coupling.md has the table.
struct VerdictLimits {
  static constexpr double kMissed = 1e-3;  ///< part of the macro steps that were late
  static constexpr double kLost = 0.05;
  static constexpr double kMade = 0.05;  ///< part of what the run began with and was given
  static constexpr double kBalanceError = 0.01;
  /// What a step turns by H ω it misses by up to (H ω)²/2: 2 % here.
  static constexpr double kTurn_rad = 0.2;
  static constexpr double kJointGap = 0.01;  ///< part of the joint's arm
  static constexpr double kElasticTurn_rad = fem::kMostElasticTurn_rad;
  static constexpr double kParasiticMass = 0.1;  ///< part of the lightest body that carries a port
};

/// One thing that bounds a run's accuracy.
struct Cause {
  std::string name;  ///< "numerical_loss", as in summary.json
  double value = 0.0;
  double threshold = 0.0;
  std::string text;    ///< with the numbers
  std::string remedy;  ///< an imperative sentence
};

struct Verdict {
  double scale_J = 0.0;  ///< what energies are held against
  RunBooks books;
  std::vector<Cause> causes;

  [[nodiscard]] bool clean() const { return causes.empty(); }
  [[nodiscard]] std::string status() const;  ///< "done" or "done, but"
  /// "done", or "done, but CAUSE: REMEDY" with one line for each further cause.
  [[nodiscard]] std::string text() const;
  /// What was exchanged and lost, and the size of the balance error, with the scale.
  [[nodiscard]] std::string numbers() const;
};

/// The verdict on a run that reached its end.
[[nodiscard]] Verdict judge(const RunBooks& books);

/// The object `verdict` of summary.json and fem.json.
[[nodiscard]] nlohmann::ordered_json to_json(const Verdict& verdict);

}  // namespace tandem::orchestrator
