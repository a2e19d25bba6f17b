#pragma once

#include "fem_process/body/integrator.h"
#include "fem_process/body/model.h"

namespace tandem::fem {

/// Statics at given port motions, the first implementation of [Marinkovic & Zehn 2012, section 6]:
///   f_int(x⁺) = f_ext(t⁺) on the free nodes, port nodes and fixed nodes given.
/// No inertia and no damping: the wrench is the condensed static reaction, its derivative with
/// respect to the ports' positions the condensed stiffness, with respect to their velocities zero.
/// As an integrator: x⁺ = x + h v⁺ with a⁺ = 0, so that v⁺ is the mean velocity of the
/// step. Iterated to equilibrium in every step, co-rotational
/// bodies with the consistent tangent. Damping keys are passed over.
class QuasiStatic final : public Integrator {
 public:
  [[nodiscard]] StepMap map(const State& state, double h_s) const override;
  void keep(const State&, const Eigen::VectorXd&, const Eigen::VectorXd&, double,
            State&) const override {
    // An equilibrium has no history but the positions that it is sought from.
  }
  [[nodiscard]] bool keeps_history() const override { return false; }
  [[nodiscard]] bool inertia() const override { return false; }
};

}  // namespace tandem::fem
