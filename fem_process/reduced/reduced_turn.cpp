#include "fem_process/reduced/reduced_turn.h"

#include <algorithm>

#include "fem_process/kernels/turn.h"

namespace tandem::fem {
namespace {

using VectorField = Eigen::VectorXd State::*;
constexpr VectorField kFields[] = {&State::x, &State::v, &State::a, &State::acceleration,
                                   &State::a_mean};
constexpr Eigen::VectorXd StepMap::*kMaps[] = {&StepMap::x_tilde, &StepMap::d_hat, &StepMap::a_hat,
                                               &StepMap::a_hat_prescribed};

double largest(const Eigen::VectorXd& x) { return x.size() > 0 ? x.cwiseAbs().maxCoeff() : 0.0; }

}  // namespace

ReducedTurn reduced_turn(const Integrator& integrator, const State& fields, const FieldMotion& Y,
                         const Eigen::Vector3d& omega, double h_s) {
  ReducedTurn turn{fields, {}, FieldMotion::Zero(3, Y.cols())};
  if (!integrator.keeps_history()) {
    turn.map = integrator.map(fields, h_s);
    return turn;
  }
  const Eigen::Matrix3d Q = turned_by(h_s * omega);
  State steady;
  steady.x = steady.a = steady.acceleration = Eigen::VectorXd::Zero(fields.v.size());
  steady.v = steady.a_mean = steady.x;
  Eigen::VectorXd end = steady.x;
  for (Eigen::Index c = 1; c < Y.cols(); ++c) {
    const Eigen::Vector3d r = Y.col(c);
    const Eigen::Vector3d v = omega.cross(r);
    const Eigen::Vector3d inward = omega.cross(v);
    for (Eigen::VectorXd* a : {&turn.fields.a, &turn.fields.acceleration}) {
      a->segment<3>(3 * c) = (Q * (a->segment<3>(3 * c) - inward)).eval();
    }
    turn.carried.col(c) = Q * inward;
    steady.v.segment<3>(3 * c) = v;
    steady.a_mean.segment<3>(3 * c) = (v - Q.transpose() * v) / h_s;
    end.segment<3>(3 * c) = Q * v;
  }
  turn.map = integrator.map(turn.fields, h_s);
  const StepMap found = integrator.map(steady, h_s);
  const Eigen::Map<const Eigen::VectorXd> carried(turn.carried.data(), turn.carried.size());
  turn.map.a_hat += carried - found.a_hat - found.c_a * end;
  turn.map.a_hat_prescribed += carried - found.a_hat_prescribed - found.c_a_prescribed * end;
  return turn;
}

ReducedTurn reduced_turn_change(const Integrator& integrator, const State& fields,
                                const FieldMotion& Y, const Eigen::Vector3d& omega, double h_s,
                                const ReducedTurnChange& change) {
  const Eigen::Map<const Eigen::VectorXd> dY(change.Y.data(), change.Y.size());
  const double moved =
      std::max({dY.size() > 0 ? dY.cwiseAbs().maxCoeff() : 0.0, h_s * largest(change.fields.v),
                h_s * h_s * largest(change.fields.a), h_s * change.omega.norm()});
  const double size = std::max(Y.rightCols(Y.cols() - 1).cwiseAbs().maxCoeff(), 1e-300);
  const double amount = 1e-5 / std::max(moved / size, 1e-3);
  const auto at = [&](double by) {
    State state = fields;
    for (const auto field : kFields) {
      if ((change.fields.*field).size() > 0) state.*field += by * (change.fields.*field);
    }
    FieldMotion moved_Y = Y;
    if (change.Y.size() > 0) moved_Y += by * change.Y;
    return reduced_turn(integrator, state, moved_Y, omega + by * change.omega, h_s);
  };
  const ReducedTurn below = at(-amount);
  const ReducedTurn above = at(amount);
  const double scale = 0.5 / amount;
  ReducedTurn slope;
  for (const auto field : kFields) {
    slope.fields.*field = scale * (above.fields.*field - below.fields.*field);
  }
  slope.map = above.map;
  for (const auto map : kMaps) slope.map.*map = scale * (above.map.*map - below.map.*map);
  slope.carried = scale * (above.carried - below.carried);
  return slope;
}

}  // namespace tandem::fem
