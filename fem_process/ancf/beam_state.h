#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>

#include "fem_process/ancf/contact_model.h"
#include "fem_process/ancf/klu_solver.h"
#include "protocol/contract/energy.h"
#include "protocol/contract/hash.h"
#include "protocol/contract/port.h"
#include "protocol/contract/sim_time.h"

namespace tandem::fem::ancf {

/// A factorised step matrix, kept from step to step while Newton's iteration converges with it.
struct StepMatrix {
  std::shared_ptr<const LuFactor> factor;
  double h_s = 0.0;
  double mass_damping_per_s = 0.0;
  bool friction = true;
  std::uint64_t fingerprint = 0;  ///< of the unknowns it was made at
};

/// All that changes in a beam structure. A checkpoint is a copy of it; the step matrix is shared
/// because it never changes.
struct BeamState {
  SimTime time{};
  Eigen::VectorXd q;  ///< unknowns (m; gradients without unit)
  Eigen::VectorXd v;  ///< 1/s of these
  Eigen::VectorXd a;  ///< true accelerations
  Eigen::VectorXd A;  ///< algorithmic accelerations of the generalised-α method
  std::shared_ptr<const StepMatrix> matrix;
  EnergyBook book;  ///< works and losses since t = 0; its energies stay 0
  /// What the next step's trapezoids of work need of this one.
  MotionSet motions;
  WrenchSet wheels;
  Eigen::VectorXd viscous;      ///< internal forces but the elastic ones; empty without viscosity
  double contact_loss_W = 0.0;  ///< taken by contact damping and friction

  [[nodiscard]] std::uint64_t hash() const {
    StateHash hash;
    hash.add(time.count());
    for (const Eigen::VectorXd* x : {&q, &v, &a, &A}) {
      hash.add(std::span<const double>(x->data(), static_cast<std::size_t>(x->size())));
    }
    for (double work : {book.external_work_J, book.interface_work_J, book.damping_loss_J,
                        book.numerical_loss_J}) {
      hash.add(work);
    }
    if (matrix) hash.add(matrix->fingerprint);
    return hash.value();
  }
};

}  // namespace tandem::fem::ancf
