#include "fem_process/kernels/turn.h"
#include "fem_process/turning/end_carry.h"

/// Ports whose origins go round themselves, see GeneralisedAlpha::circle_lead.
namespace tandem::fem {

void EndCarry::lead_circles(const Integrator& integrator, double h_s, Carried::Turn& turn) {
  const double rate = turn.omega.norm();
  if (rate == 0.0) return;
  const Eigen::Vector3d axis = turn.omega / rate;
  turn.circle_lead = across(axis, integrator.circle_lead(h_s * rate));
  turn.prescribed_circle_lead = across(axis, integrator.prescribed_circle_lead(h_s * rate));
}

EndCarry::Lead EndCarry::lead(const Carried& carried, const MotionSet& end) const {
  Lead lead;
  for (std::size_t p = 0; p < end.size(); ++p) {
    const auto row = 3 * static_cast<Eigen::Index>(p);
    const Carried::Turn& turn = carried.turns[part_of_port_[p]];
    const Eigen::Vector3d mean = (end[p].v_WP - carried.holder.v.segment<3>(row)) / carried.h_s;
    lead.sigma.emplace_back(carried.h_s * turn.circle_lead *
                            (mean - carried.holder.a.segment<3>(row)));
    lead.prescribed.emplace_back(turn.prescribed_circle_lead *
                                 (mean - carried.holder.a_mean.segment<3>(row)));
  }
  return lead;
}

Eigen::VectorXd EndCarry::circling(const Carried& carried, const MotionSet& end) const {
  if (!rotates_) return {};
  const Lead lead = this->lead(carried, end);
  Eigen::VectorXd a = carried.map.c_a * spread(lead.sigma);
  for (int node : model_.fixed) a.segment<3>(3 * node).setZero();
  for (std::size_t p = 0; p < end.size(); ++p) {
    if (model_.ports[p].attachment.loose()) continue;
    for (int node : model_.ports[p].nodes) a.segment<3>(3 * node) = lead.prescribed[p];
  }
  return a;
}

LoosePorts::RigidStep EndCarry::rigid(const Carried& carried, const MotionSet& end) const {
  LoosePorts::RigidStep rigid = carried.rigid;
  const Lead lead = this->lead(carried, end);
  for (std::size_t k = 0; k < loose_.ports().size(); ++k) {
    const Eigen::Index row = 12 * static_cast<Eigen::Index>(k);
    const std::size_t p = loose_.ports()[k].index;
    rigid.map.a_hat.segment<3>(row) += carried.map.c_a * lead.sigma[p];
    rigid.map.a_hat_prescribed.segment<3>(row) += lead.prescribed[p];
  }
  return rigid;
}

}  // namespace tandem::fem
