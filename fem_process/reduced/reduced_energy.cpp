#include "fem_process/reduced/reduced_energy.h"

#include "fem_process/transient/interface_work.h"

namespace tandem::fem {
namespace {

double dot(const FieldMotion& a, const FieldMotion& b) { return a.cwiseProduct(b).sum(); }

/// a·K b of the coordinates [ζ; η].
double stiffness_product(const ReducedModel& reduced, const Eigen::VectorXd& a,
                         const Eigen::VectorXd& b) {
  const Eigen::Index n = reduced.boundary();
  return a.head(n).dot(reduced.K_boundary() * b.head(n)) +
         a.tail(reduced.modes()).dot(reduced.omega2().cwiseProduct(b.tail(reduced.modes())));
}

/// One end of a step and its powers (W).
struct End {
  Eigen::VectorXd z, z_dot;
  FieldMotion Y, V, inertia, loads;
  double stored_J = 0.0, kinetic_J = 0.0;
  double damping_W = 0.0;
};

FieldMotion motion_of(const ReducedModel& reduced, const Eigen::VectorXd& flat) {
  return Eigen::Map<const FieldMotion>(flat.data(), 3, reduced.fields());
}

End end_of(const ReducedModel& reduced, const ReducedState& state,
           const FloatingFrame::Placement& at) {
  const Damping damping = damping_of(reduced.model());
  End end;
  end.z = state.z;
  end.z_dot = joined(at.z_dot, state.modal.v);
  end.Y = motion_of(reduced, state.fields.x);
  end.V = motion_of(reduced, state.fields.v);
  const FieldMotion momentum = end.V * reduced.T();
  if (state.fields.acceleration.size() > 0) {
    end.inertia = motion_of(reduced, state.fields.acceleration) * reduced.T();
  } else {
    end.inertia = FieldMotion::Zero(3, reduced.fields());
  }
  end.loads = reduced.loads(to_seconds(state.time));
  end.stored_J = 0.5 * stiffness_product(reduced, end.z, end.z);
  if (reduced.model().integrator->inertia()) end.kinetic_J = 0.5 * dot(momentum, end.V);
  end.damping_W = damping.alpha_per_s * dot(momentum, end.V) +
                  damping.beta_s * stiffness_product(reduced, end.z_dot, end.z_dot);
  return end;
}

/// −Σ λ⁺·V⁺ with the wrenches' arms at the end of the step.
double reaction_power_W(const ReducedModel& reduced, const ReducedStep::Result& step) {
  Eigen::VectorXd Q = generalised_forces(reduced, step.Y, step.end.R_WF, step.balance);
  Q.tail(step.end.z.size()) +=
      reduced.K_boundary() * (step.end.z + damping_of(reduced.model()).beta_s * step.end.z_dot);
  const WrenchSet wrenches =
      wrenches_of(step.end.jacobian.transpose() * Q, step.state.ports.size());
  return -interface_power_W(wrenches, step.state.ports);
}

void book_end_forces(const ReducedModel& reduced, const End& a, const End& b,
                     ReducedStep::Result& step) {
  const double h_s = step.h_s;
  const FieldMotion moved = b.Y - a.Y;
  const FieldMotion change = b.V - a.V;
  const FieldMotion beyond = moved - h_s * b.V;
  const double interface_J = -h_s * interface_power_W(step.wrenches, step.state.ports);
  EnergyBook& book = step.state.book;
  book.interface_work_J += interface_J;
  book.external_work_J += dot(b.loads, moved);
  book.damping_loss_J += h_s * b.damping_W;
  book.numerical_loss_J += 0.5 * dot(change * reduced.T(), change) +
                           h_s * stiffness_product(reduced, b.z_dot, b.z) -
                           (b.stored_J - a.stored_J) + dot(b.loads + reduced.gravity(), beyond) +
                           interface_J - h_s * reaction_power_W(reduced, step);
}

void book_trapezoids(const ReducedModel& reduced, const ReducedState& begin, const End& a,
                     const End& b, ReducedStep::Result& step) {
  const double half_s = 0.5 * step.h_s;
  const FieldMotion moved = b.Y - a.Y;
  const FieldMotion f_a = a.loads + reduced.gravity();
  const FieldMotion f_b = b.loads + reduced.gravity();
  const double interface_J =
      -interface_trapezoid_J(begin.ports, step.state.ports, begin.wrenches, step.wrenches);
  EnergyBook& book = step.state.book;
  book.interface_work_J += interface_J;
  book.external_work_J += 0.5 * dot(a.loads + b.loads, moved);
  book.damping_loss_J += half_s * (a.damping_W + b.damping_W);
  double numerical_J =
      half_s * (dot(a.V, a.inertia) + dot(b.V, b.inertia)) - (b.kinetic_J - a.kinetic_J);
  numerical_J += half_s * (stiffness_product(reduced, a.z_dot, a.z) +
                           stiffness_product(reduced, b.z_dot, b.z)) -
                 (b.stored_J - a.stored_J);
  numerical_J += 0.5 * dot(f_a + f_b, moved) - half_s * (dot(f_a, a.V) + dot(f_b, b.V));
  numerical_J += interface_J + half_s * (port_power_W(begin) + port_power_W(step.state));
  book.numerical_loss_J += numerical_J;
}

}  // namespace

double port_power_W(const ReducedState& state) {
  return interface_power_W(state.wrenches, state.ports);
}

void book_step(const ReducedModel& reduced, const ReducedState& begin, ReducedStep::Result& step) {
  step.state.book = begin.book;
  step.state.wrenches = step.wrenches;
  const End a = end_of(reduced, begin, step.begin);
  const End b = end_of(reduced, step.state, step.end);
  if (reduced.model().integrator->constant_forces()) {
    book_end_forces(reduced, a, b, step);
  } else {
    book_trapezoids(reduced, begin, a, b, step);
  }
}

}  // namespace tandem::fem
