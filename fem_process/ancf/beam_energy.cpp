#include "fem_process/ancf/beam_step.h"
#include "fem_process/transient/interface_work.h"

namespace tandem::fem::ancf {
bool BeamStep::note_forces(const MotionSet& motions, BeamState& state, ContactSums& sums) const {
  // Kept between calls: its memory is larger than the arithmetic's.
  static thread_local ElementArrays elements;
  const double t_s = to_seconds(state.time);
  Eigen::VectorXd balance = Eigen::VectorXd::Zero(state.q.size());
  WrenchSet attached(motions.size());
  if (attachments_ != nullptr) {
    if (elements.force.size() != system_.mesh().elements.size() * kCoordinates) {
      elements = system_.element_arrays();
    }
    if (!imbalance(state, motions, t_s, params_.mass_damping_per_s, std::nullopt, elements, sums,
                   balance)) {
      return false;
    }
    attachments_->add_wrenches(motions, balance, attached);
  }
  elements.force.assign(system_.mesh().elements.size() * kCoordinates, 0.0);
  contact_.add(state.q, state.v, motions, params_.friction, std::nullopt, elements, sums);
  for (std::size_t p = 0; p < attached.size(); ++p) {
    sums.wheels[p].f_P_W += attached[p].f_P_W;
    sums.wheels[p].t_P_W += attached[p].t_P_W;
  }
  state.motions = motions;
  state.wheels = sums.wheels;
  state.contact_loss_W = sums.loss_W;
  const BeamMaterial& material = system_.model().material;
  if (material.dilatation_s == 0.0 && material.deviation_s == 0.0) return true;
  // The balance says what all internal forces are; those at rest are elastic.
  Eigen::VectorXd rest = balance;
  system_.add_forces(elements, rest);
  const Eigen::VectorXd still = Eigen::VectorXd::Zero(state.v.size());
  if (system_.kernel().forces(state.q, still, elements) > 0) return false;
  system_.add_forces(elements, rest);
  state.viscous =
      system_.external_forces(t_s) - rest -
      system_.mass_times(Eigen::VectorXd(state.a + params_.mass_damping_per_s * state.v));
  return true;
}

void BeamStep::book(const BeamState& begin, double h_s, BeamState& end) const {
  const Eigen::VectorXd moved = end.q - begin.q;
  const Eigen::VectorXd mean_v = 0.5 * (begin.v + end.v);
  const Eigen::VectorXd mean_a = 0.5 * (begin.a + end.a);
  EnergyBook& book = end.book;
  if (!system_.model().loads.empty()) {
    const double t_s = to_seconds(begin.time);
    book.external_work_J +=
        0.5 * moved.dot(system_.load_forces(t_s) + system_.load_forces(t_s + h_s));
  }
  book.interface_work_J -=
      interface_trapezoid_J(begin.motions, end.motions, begin.wheels, end.wheels);
  book.damping_loss_J += 0.5 * h_s * (begin.contact_loss_W + end.contact_loss_W);
  if (begin.viscous.size() > 0) {
    book.damping_loss_J += 0.5 * moved.dot(begin.viscous + end.viscous);
  }
  if (params_.mass_damping_per_s > 0.0) {
    book.damping_loss_J += params_.mass_damping_per_s * moved.dot(system_.mass_times(mean_v));
  }
  book.numerical_loss_J +=
      moved.dot(system_.mass_times(mean_a)) - mean_v.dot(system_.mass_times(end.v - begin.v));
}

}  // namespace tandem::fem::ancf
