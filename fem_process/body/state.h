#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "fem_process/body/boundary.h"
#include "fem_process/matrix/block_matrix.h"
#include "protocol/contract/energy.h"
#include "protocol/contract/hash.h"
#include "protocol/contract/port.h"
#include "protocol/contract/sim_time.h"

namespace tandem::fem {

/// What a velocity field of few coordinates leaves to the next steps, as v, a, acceleration and
/// a_mean of State do for the nodes: 12 per averaging port or bushing, or the origins of the ports.
struct RateHistory {
  Eigen::VectorXd v;
  Eigen::VectorXd a;
  Eigen::VectorXd acceleration;
  Eigen::VectorXd a_mean;
};

/// All that changes in a flexible body. A checkpoint is a copy of it. 3 numbers per node, in W.
/// Backward Euler needs x and v alone; the other vectors are then empty.
struct State {
  SimTime time{};
  Eigen::VectorXd x;             ///< positions (m)
  Eigen::VectorXd v;             ///< velocities (m/s)
  Eigen::VectorXd a;             ///< Newmark's accelerations (m/s²), at t + (α_m − α_f) h
  Eigen::VectorXd acceleration;  ///< of the balance of forces at t (m/s²)
  Eigen::VectorXd a_mean;  ///< (v − v_previous)/h of the last step: prescribed nodes' history
  /// Mean velocity over the last step relative to what carries the node (m/s), see EndCarry; empty
  /// before the first step.
  Eigen::VectorXd relative_velocity;
  /// Velocities of the free nodes at the last eight times, for the initial guess of the next step;
  /// empty when it is not made of them. Row `past_next` is the oldest.
  EightVectors past;
  int past_next = 0;
  Eigen::VectorXd attached;  ///< forces φ of averaging ports and bushings, see LoosePorts
  RateHistory rigid;         ///< of LoosePorts::rigid_rates(); empty with backward Euler
  double bushing_J = 0.0;    ///< strain energy of the bushings
  Boundary boundary;         ///< what is held, and forces by command
  EnergyBook book;           ///< works and losses since t = 0; its energies stay 0
  /// What the next step of backward Euler corrects of the last one's book: see book_step.
  Eigen::VectorXd moved;         ///< Δx (m)
  double elastic_guess_J = 0.0;  ///< ΔU as booked − ½ Δx·f_int(x)
  /// What the next step's trapezoids of work need of this one; empty with backward Euler.
  Eigen::VectorXd support;        ///< forces of the ports on nodes (N)
  Eigen::VectorXd damping_force;  ///< C v (N); empty without damping
  /// K e (N), e how far nodes of averaging ports stand from where the balance of forces has them;
  /// empty without such ports.
  Eigen::VectorXd beyond;
  double bushing_loss_W = 0.0;
  MotionSet port_motions;
  /// Backward Euler: 1 for ports whose last step was h times their velocity at its end, 0 where it
  /// was rather the mean of both ends; empty before the first step.
  Eigen::VectorXd port_chords;
  RateHistory port_rates;  ///< of the ports' origins, v left out; with backward Euler a_mean alone
  WrenchSet port_wrenches;
  int inverted_elements = 0;  ///< at the last linearisation
  /// Number of this state: equal numbers mean equal states, so that what was computed from a state
  /// is found again after a rollback. Not part of the hash.
  std::uint64_t generation = 0;

  [[nodiscard]] std::uint64_t hash() const {
    StateHash hash;
    hash.add(static_cast<std::int64_t>(time.count()));
    for (const Eigen::VectorXd* values :
         {&x, &v, &a, &acceleration, &a_mean, &relative_velocity, &attached, &rigid.v, &rigid.a,
          &rigid.acceleration, &rigid.a_mean, &port_rates.a, &port_rates.acceleration,
          &port_rates.a_mean, &port_chords, &moved, &support, &damping_force, &beyond}) {
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
    for (const Motion& motion : port_motions) {
      for (const Eigen::Vector3d* value : {&motion.p_WP, &motion.v_WP, &motion.w_WP}) {
        hash.add(std::span<const double>(value->data(), 3));
      }
      hash.add(std::span<const double>(motion.q_WP.coeffs().data(), 4));
    }
    for (const Wrench& wrench : port_wrenches) {
      hash.add(std::span<const double>(wrench.f_P_W.data(), 3));
      hash.add(std::span<const double>(wrench.t_P_W.data(), 3));
    }
    for (const Boundary::Force& commanded : boundary.forces) {
      for (char c : commanded.set) hash.add(static_cast<std::int64_t>(c));
    }
    hash.add(elastic_guess_J);
    hash.add(bushing_J);
    hash.add(bushing_loss_W);
    for (double work : {book.external_work_J, book.interface_work_J, book.damping_loss_J,
                        book.numerical_loss_J}) {
      hash.add(work);
    }
    return hash.value();
  }
};

}  // namespace tandem::fem
