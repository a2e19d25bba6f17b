#include "protocol/schemes/transmission_line.h"

#include "protocol/schemes/evaluation.h"

namespace tandem {

Eigen::VectorXd line_impedance(double stiffness_N_per_m, SimTime delay,
                               const std::vector<PortInfo>& ports) {
  Eigen::VectorXd Z(6 * static_cast<Eigen::Index>(ports.size()));
  for (std::size_t i = 0; i < ports.size(); ++i) {
    const auto row = 6 * static_cast<Eigen::Index>(i);
    const double z = stiffness_N_per_m * to_seconds(delay);
    Z.segment<3>(row).setConstant(z);
    Z.segment<3>(row + 3).setConstant(z * ports[i].length_m * ports[i].length_m);
  }
  return Z;
}

TransmissionLine::TransmissionLine(const CouplingParams& params, std::vector<PortInfo> ports)
    : stiffness_N_per_m_(params.tlm.stiffness_N_per_m),
      ports_(std::move(ports)),
      rigid_end_(ports_) {}

MacroStepEnd TransmissionLine::advance(SimTime H, const InterfaceState& state, MbsSide& mbs,
                                       FemSide& fem) {
  if (begun_ && state.time > *begun_) line_ = pending_;
  begun_ = state.time;
  const bool first = !line_.has_value();
  const Eigen::VectorXd Z = line_impedance(stiffness_N_per_m_, H, ports_);
  const Eigen::VectorXd lambda2 = stack(state.wrenches);
  // At t = 0 the line is at rest between equal ends.
  const Eigen::VectorXd lambda1 = first ? lambda2 : line_->lambda1;
  const Eigen::VectorXd V1 = (first ? Z : line_->Z).cwiseProduct(twists(state.motions));
  const Eigen::VectorXd a1 =
      first ? Eigen::VectorXd(lambda2 + V1) : Eigen::VectorXd(2.0 * lambda2 - line_->a2);

  fem.begin_advance({.step = H, .input = {state.motions, state.motions}});
  const WrenchSet begin = unstack_wrenches(lambda1);
  const ImpedanceEnd rigid = rigid_end_.advance(H, begin, a1, Z.asDiagonal(), begin, mbs);
  const auto flexible = fem.finish_advance();
  pending_ = Line{.Z = Z, .lambda1 = stack(rigid.applied), .a2 = lambda1 - V1};
  return end_of(joined(rigid.result, flexible, rigid.applied, ports_), rigid.applied, 1);
}

}  // namespace tandem
