#include "mbs_process/kick_response.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "mbs_process/step_work.h"

namespace tandem::mbs {
namespace {

/// Least pivot of the factorisation, part of the largest: below it rows are not told apart.
constexpr double kLeastPivot = 1e-14;
/// How closely the twists must be ODE's, which solves the same system by another factorisation.
constexpr double kSameTwists = 1e-9;
/// What the rounding of the fastest body leaves in those that it is jointed to.
constexpr double kSameRounding = 1e-12;

Eigen::Index rows_of(std::size_t bodies) { return 6 * static_cast<Eigen::Index>(bodies); }

Eigen::VectorXd twists_of(const std::vector<BodyState>& bodies) {
  Eigen::VectorXd twists(rows_of(bodies.size()));
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    twists.segment<3>(rows_of(b)) = bodies[b].v_WB;
    twists.segment<3>(rows_of(b) + 3) = bodies[b].w_WB;
  }
  return twists;
}

/// All that acts but for the rows.
Eigen::VectorXd forces_of(const Params& params, const Kick& kick) {
  Eigen::VectorXd forces(rows_of(kick.begin.size()));
  for (std::size_t b = 0; b < kick.begin.size(); ++b) {
    const BodyParams& body = params.bodies[b];
    const double weighs_kg = body.massless ? 0.0 : body.mass_kg;
    forces.segment<3>(rows_of(b)) =
        kick.rule.share * (kick.applied[b].f_B_W + weighs_kg * params.gravity_m_per_s2);
    forces.segment<3>(rows_of(b) + 3) = kick.rule.share * kick.applied[b].t_B_W;
    if (params.integrator != IntegratorKind::Euler) continue;
    forces.segment<3>(rows_of(b) + 3) += implicit_gyroscopic_torque(body, kick.begin[b], kick.h_s);
  }
  return forces;
}

}  // namespace

KickResponse::KickResponse(const Params& params, const std::vector<JointGeometry>& joints,
                           const Kick& kick)
    : joints_(joints), h_s_(kick.h_s) {
  for (std::size_t b = 0; b < kick.begin.size(); ++b) {
    const Eigen::Matrix3d R_WB = kick.begin[b].q_WB.toRotationMatrix();
    inverse_inertia_W_.emplace_back(R_WB * params.bodies[b].inertia_B().inverse() *
                                    R_WB.transpose());
    inverse_mass_.push_back(1.0 / params.bodies[b].mass_kg);
  }
  for (const JointGeometry& joint : joints) add_joint_rows(kick, joint);
  for (const EffortRow& effort : kick.efforts) add_effort_row(params, kick, effort);
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    if (rows_[i].acts) acting_.push_back(i);
  }
  if (factorise()) check_against(params, kick);
}

KickResponse::Row KickResponse::row_of(const JointGeometry& joint, const TwistRow& J) const {
  Row row{.J = J,
          .first = rows_of(joint.body1()),
          .second = joint.body2() ? rows_of(*joint.body2()) : -1};
  const auto weigh = [&](std::size_t body, Eigen::Index at) {
    row.WJ.segment<3>(at) = inverse_mass_[body] * J.segment<3>(at).transpose();
    row.WJ.segment<3>(at + 3) = inverse_inertia_W_[body] * J.segment<3>(at + 3).transpose();
  };
  weigh(joint.body1(), 0);
  if (joint.body2()) weigh(*joint.body2(), 6);
  return row;
}

void KickResponse::add_joint_rows(const Kick& kick, const JointGeometry& joint) {
  const JointRows found = joint.rows(kick.begin[joint.body1()], joint.second(kick.begin));
  for (Eigen::Index i = 0; i < found.J.rows(); ++i) {
    Row row = row_of(joint, found.J.row(i));
    row.cfm = kick.rule.cfm;
    row.rhs = -kick.rule.erp / kick.h_s * found.error[i];
    rows_.push_back(row);
  }
}

void KickResponse::add_effort_row(const Params& params, const Kick& kick, const EffortRow& effort) {
  const JointGeometry& joint = joints_[effort.joint];
  const BodyState& body1 = kick.begin[joint.body1()];
  const BodyState body2 = joint.second(kick.begin);
  Row row = row_of(joint, joint.axis_row(effort.axis, body1, body2));
  row.cfm = effort.cfm;
  row.effort = joint.axis_W(effort.axis, body1, body2).dot(effort.on_body1);
  // A slider's stop is one of its joint's rows, which leave their rounding in the projection.
  if (std::abs(row.effort) <= 1e-12 * effort.on_body1.norm()) row.effort = 0.0;
  if (effort.motor) {
    if (!(effort.most > 0.0)) return;
    row.rhs = effort.speed;
    row.bounded = effort.most < std::numeric_limits<double>::max();
    row.most = effort.most;
    row.acts = !row.bounded || std::abs(row.effort) < (1.0 - 1e-12) * effort.most;
    rows_.push_back(row);
    return;
  }
  const auto axis = static_cast<std::size_t>(effort.axis - 1);
  const bool slides = joint.kind() == JointKind::Slider;
  const double at = slides ? joint.slide(body1, body2) : kick.coordinates[effort.joint][axis];
  for (const LimitParams& limit : params.joints[effort.joint].limits) {
    if (limit.axis != effort.axis || (at > limit.lower && at < limit.upper)) continue;
    row.rhs = -kick.rule.erp / kick.h_s * (at <= limit.lower ? at - limit.lower : at - limit.upper);
    row.bounded = limit.lower < limit.upper;
    row.acts = !row.bounded || row.effort != 0.0;
    rows_.push_back(row);
  }
}

bool KickResponse::factorise() {
  // Rows by body, in their own order: sums are made in one order, whatever the mechanism.
  std::vector<std::vector<std::pair<Eigen::Index, Eigen::Index>>> on_body(inverse_mass_.size());
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t k = 0; k < acting_.size(); ++k) {
    const Row& row = rows_[acting_[k]];
    const auto index = static_cast<Eigen::Index>(k);
    on_body[static_cast<std::size_t>(row.first / 6)].emplace_back(index, 0);
    if (row.second >= 0) on_body[static_cast<std::size_t>(row.second / 6)].emplace_back(index, 6);
    entries.emplace_back(static_cast<int>(k), static_cast<int>(k), row.cfm / h_s_);
  }
  for (const auto& on_one : on_body) {
    for (std::size_t i = 0; i < on_one.size(); ++i) {
      const auto [row, at] = on_one[i];
      for (std::size_t j = 0; j <= i; ++j) {
        const auto [column, from] = on_one[j];
        const double value = acting(row).J.segment<6>(at).dot(acting(column).WJ.segment<6>(from));
        entries.emplace_back(static_cast<int>(row), static_cast<int>(column), value);
      }
    }
  }
  if (acting_.empty()) return true;
  const auto count = static_cast<Eigen::Index>(acting_.size());
  Eigen::SparseMatrix<double> system(count, count);
  system.setFromTriplets(entries.begin(), entries.end());
  factor_.compute(system);
  if (factor_.info() != Eigen::Success) return false;
  const Eigen::VectorXd pivots = factor_.vectorD();
  return pivots.minCoeff() > kLeastPivot * pivots.maxCoeff();
}

void KickResponse::add_efforts(Eigen::Index column, Eigen::MatrixXd& twists) const {
  for (std::size_t k = 0; k < acting_.size(); ++k) {
    const Row& row = rows_[acting_[k]];
    const double impulse = h_s_ * efforts_(static_cast<Eigen::Index>(k), column);
    twists.col(column).segment<6>(row.first) += impulse * row.WJ.head<6>();
    if (row.second >= 0) twists.col(column).segment<6>(row.second) += impulse * row.WJ.tail<6>();
  }
}

Eigen::MatrixXd KickResponse::solved(const Eigen::MatrixXd& free, const Eigen::MatrixXd& rhs) {
  Eigen::MatrixXd twists = free;
  efforts_ = rhs;
  for (Eigen::Index column = 0; column < free.cols(); ++column) {
    for (std::size_t k = 0; k < acting_.size(); ++k) {
      efforts_(static_cast<Eigen::Index>(k), column) -=
          product(rows_[acting_[k]], free.col(column));
    }
  }
  if (!acting_.empty()) efforts_ = Eigen::MatrixXd(factor_.solve(efforts_ / h_s_));
  for (Eigen::Index column = 0; column < free.cols(); ++column) add_efforts(column, twists);
  return twists;
}

Eigen::MatrixXd KickResponse::free_twists(const Eigen::MatrixXd& forces) const {
  Eigen::MatrixXd twists(forces.rows(), forces.cols());
  for (std::size_t b = 0; b < inverse_mass_.size(); ++b) {
    const Eigen::Index at = rows_of(b);
    twists.middleRows<3>(at) = h_s_ * inverse_mass_[b] * forces.middleRows<3>(at);
    twists.middleRows<3>(at + 3) = h_s_ * (inverse_inertia_W_[b] * forces.middleRows<3>(at + 3));
  }
  return twists;
}

Eigen::MatrixXd KickResponse::twists(const Eigen::MatrixXd& forces) {
  const auto count = static_cast<Eigen::Index>(acting_.size());
  twists_ = solved(free_twists(forces), Eigen::MatrixXd::Zero(count, forces.cols()));
  return twists_;
}

void KickResponse::check_against(const Params& params, const Kick& kick) {
  Eigen::VectorXd resting = forces_of(params, kick);
  for (const Row& row : rows_) {
    if (row.acts) continue;
    resting.segment<6>(row.first) += row.effort * row.J.head<6>().transpose();
    if (row.second < 0) continue;
    resting.segment<6>(row.second) += row.effort * row.J.tail<6>().transpose();
  }
  Eigen::VectorXd rhs(static_cast<Eigen::Index>(acting_.size()));
  for (std::size_t k = 0; k < acting_.size(); ++k) {
    rhs[static_cast<Eigen::Index>(k)] = rows_[acting_[k]].rhs;
  }
  const Eigen::VectorXd begin = twists_of(kick.begin);
  const Eigen::VectorXd end = twists_of(kick.end);
  const Eigen::VectorXd free = begin + free_twists(resting);
  const Eigen::VectorXd found = solved(free, rhs);
  reproduces_ = found.allFinite();
  const Eigen::VectorXd terms = begin.cwiseAbs() + (free - begin).cwiseAbs() + kicks_of_rows();
  const double rounding = kSameRounding * terms.lpNorm<Eigen::Infinity>();
  for (Eigen::Index at = 0; at < end.size(); at += 3) {
    const double difference = (found - end).segment<3>(at).norm();
    const double most = kSameTwists * terms.segment<3>(at).norm() + rounding;
    if (!(difference <= most)) reproduces_ = false;
  }
  find_slacks(found);
}

Eigen::VectorXd KickResponse::kicks_of_rows() const {
  Eigen::VectorXd kicks = Eigen::VectorXd::Zero(rows_of(inverse_mass_.size()));
  for (std::size_t k = 0; k < acting_.size(); ++k) {
    const Row& row = rows_[acting_[k]];
    const double impulse = h_s_ * std::abs(efforts_(static_cast<Eigen::Index>(k), 0));
    kicks.segment<6>(row.first) += impulse * row.WJ.head<6>().cwiseAbs();
    if (row.second >= 0) kicks.segment<6>(row.second) += impulse * row.WJ.tail<6>().cwiseAbs();
  }
  return kicks;
}

void KickResponse::find_slacks(const Eigen::VectorXd& twists) {
  for (std::size_t k = 0; k < acting_.size(); ++k) {
    rows_[acting_[k]].effort = efforts_(static_cast<Eigen::Index>(k), 0);
  }
  for (Row& row : rows_) {
    if (row.acts) {
      row.slack = std::abs(row.most - std::abs(row.effort));
    } else {
      row.slack = std::abs(product(row, twists) + row.cfm * row.effort - row.rhs);
    }
  }
}

bool KickResponse::switches(Eigen::Index column, double size) const {
  std::size_t k = 0;
  for (const Row& row : rows_) {
    const double change = row.acts ? efforts_(static_cast<Eigen::Index>(k++), column)
                                   : product(row, twists_.col(column));
    if (row.bounded && change != 0.0 && !(2.0 * std::abs(change) * size < row.slack)) return true;
  }
  return false;
}

double KickResponse::product(const Row& row, const Eigen::Ref<const Eigen::VectorXd>& twists) {
  const double first = row.J.head<6>() * twists.segment<6>(row.first);
  return row.second < 0 ? first : first + row.J.tail<6>() * twists.segment<6>(row.second);
}

}  // namespace tandem::mbs
