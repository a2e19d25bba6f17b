#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "fem_process/block_matrix.h"
#include "fem_process/boundary.h"
#include "protocol/contract/hash.h"
#include "protocol/contract/sim_time.h"

namespace tandem::fem {

/// All that changes in a flexible body. A checkpoint is a copy of it. 3 numbers per node, in W.
/// Backward Euler needs x and v alone; the other vectors are then empty.
struct State {
  SimTime time{};
  Eigen::VectorXd x;  ///< positions (m)
  Eigen::VectorXd v;  ///< velocities (m/s)
  Eigen::VectorXd a;  ///< Newmark's accelerations (m/s²), at t + α h or t + (α_m − α_f) h
  Eigen::VectorXd acceleration;  ///< of the balance of forces at t (m/s²), where it is not a
  Eigen::VectorXd a_mean;  ///< (v − v_previous)/h of the last step: prescribed nodes' history
  Eigen::VectorXd force;   ///< C v + f_int − f_ext (N)
  Eigen::VectorXd react;   ///< nodal reactions (N), zero at free nodes
  /// Velocities of the free nodes at the last eight times, for the initial guess of the next step;
  /// empty when it is not made of them. Row `past_next` is the oldest.
  EightVectors past;
  int past_next = 0;
  Eigen::VectorXd attached;  ///< forces φ of averaging ports and bushings, see LoosePorts
  double bushing_J = 0.0;    ///< strain energy of the bushings
  Boundary boundary;         ///< what is held, and forces by command
  double external_work_J = 0.0;
  int inverted_elements = 0;  ///< at the last linearisation
  /// Number of this state: equal numbers mean equal states, so that what was computed from a state
  /// is found again after a rollback. Not part of the hash.
  std::uint64_t generation = 0;

  [[nodiscard]] std::uint64_t hash() const {
    StateHash hash;
    hash.add(static_cast<std::int64_t>(time.count()));
    for (const Eigen::VectorXd* values :
         {&x, &v, &a, &acceleration, &a_mean, &force, &react, &attached}) {
      hash.add(std::span<const double>(values->data(), static_cast<std::size_t>(values->size())));
    }
    if (past.size() > 0) {
      hash.add(std::span<const double>(past.data(), static_cast<std::size_t>(past.size())));
      hash.add(static_cast<std::int64_t>(past_next));
    }
    for (const std::string& set : boundary.fixed) {
      for (char c : set) hash.add(static_cast<std::int64_t>(c));
    }
    for (const Boundary::Force& commanded : boundary.forces) {
      hash.add(std::span<const double>(commanded.total_N.data(), 3));
    }
    hash.add(external_work_J);
    return hash.value();
  }
};

}  // namespace tandem::fem
