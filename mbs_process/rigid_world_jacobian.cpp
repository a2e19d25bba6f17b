#include <Eigen/Geometry>

#include "mbs_process/kick_response.h"
#include "mbs_process/port_jacobian.h"
#include "mbs_process/rigid_world.h"

namespace tandem::mbs {

void RigidWorld::record(double h_s, const StepRule& rule, const std::vector<BodyState>& begin,
                        const std::vector<std::array<double, 2>>& coordinates,
                        const std::vector<BodyWrench>& applied, const std::vector<BodyState>& end) {
  if (!recording_) return;
  kicks_.push_back({.h_s = h_s,
                    .rule = rule,
                    .begin = begin,
                    .coordinates = coordinates,
                    .applied = applied,
                    .efforts = world_.effort_rows(),
                    .end = end});
}

ProbeSizes RigidWorld::sizes_of(std::size_t port, SimTime macro_step) const {
  return probe_sizes(params_.bodies[ports_[port].body], ports_[port].p_BP, to_seconds(macro_step));
}

std::optional<InterfaceJacobian> RigidWorld::linearised(const State& begin, const State& end,
                                                        const StepRequest<WrenchSet>& request,
                                                        std::string& failure) {
  const auto columns = 6 * static_cast<Eigen::Index>(ports_.size());
  InterfaceJacobian jacobian(2 * columns, columns);
  std::vector<bool> found(static_cast<std::size_t>(columns), false);
  respond(end, request.step, jacobian, found);
  probed_columns_ = 0;
  for (Eigen::Index column = 0; column < columns; ++column) {
    if (found[static_cast<std::size_t>(column)]) continue;
    ++probed_columns_;
    if (auto failed = probe(column, begin, end, request, jacobian)) {
      failure = *failed;
      return std::nullopt;
    }
  }
  return jacobian;
}

void RigidWorld::respond(const State& end, SimTime macro_step, InterfaceJacobian& jacobian,
                         std::vector<bool>& found) const {
  if (kicks_.size() != 1) return;
  const Kick& kick = kicks_.front();
  KickResponse response(params_, joints_, kick);
  if (!response.reproduces_step()) return;
  const auto rows = 6 * static_cast<Eigen::Index>(kick.begin.size());
  Eigen::MatrixXd forces = Eigen::MatrixXd::Zero(rows, jacobian.cols());
  for (std::size_t i = 0; i < ports_.size(); ++i) {
    const auto body = 6 * static_cast<Eigen::Index>(ports_[i].body);
    const auto column = 6 * static_cast<Eigen::Index>(i);
    forces.block<6, 6>(body, column).setIdentity();
    forces.block<3, 3>(body + 3, column) =
        cross_matrix(kick.begin[ports_[i].body].q_WB * ports_[i].p_BP);
  }
  const Eigen::MatrixXd twists = response.twists(forces);
  for (std::size_t i = 0; i < ports_.size(); ++i) {
    const ProbeSizes sizes = sizes_of(i, macro_step);
    for (Eigen::Index direction = 0; direction < 6; ++direction) {
      const Eigen::Index column = 6 * static_cast<Eigen::Index>(i) + direction;
      const double size = direction < 3 ? sizes.force_N : sizes.torque_Nm;
      found[static_cast<std::size_t>(column)] = !response.switches(column, size);
    }
  }
  for (std::size_t k = 0; k < ports_.size(); ++k) {
    const Port& port = ports_[k];
    const auto change = twists.middleRows<6>(6 * static_cast<Eigen::Index>(port.body));
    jacobian.middleRows<12>(12 * static_cast<Eigen::Index>(k)) =
        port_change_by_twist(end.bodies[port.body], port.p_BP, kick.h_s) * change;
  }
}

std::optional<std::string> RigidWorld::probe(Eigen::Index column, const State& begin,
                                             const State& end,
                                             const StepRequest<WrenchSet>& request,
                                             InterfaceJacobian& jacobian) {
  const auto i = static_cast<std::size_t>(column / 6);
  const Eigen::Index direction = column % 6;
  const ProbeSizes sizes = sizes_of(i, request.step);
  Segment<WrenchSet> input = request.input;
  Wrench& wrench = input.end[i];
  const bool is_force = direction < 3;
  double& component = is_force ? wrench.f_P_W[direction] : wrench.t_P_W[direction - 3];
  const double unperturbed = component;
  component += is_force ? sizes.force_N : sizes.torque_Nm;
  const double delta = component - unperturbed;
  State state = begin;
  if (auto failed = integrate(state, request.step, input, Booking::Off)) {
    return "mbs: probing port '" + info_.ports[i].name + "' failed: " + *failed;
  }
  for (std::size_t k = 0; k < ports_.size(); ++k) {
    const Port& port = ports_[k];
    jacobian.block<12, 1>(12 * static_cast<Eigen::Index>(k), column) =
        port_derivative(end.bodies[port.body], state.bodies[port.body], port.p_BP, delta);
  }
  return std::nullopt;
}

}  // namespace tandem::mbs
