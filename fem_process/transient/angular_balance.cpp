#include "fem_process/transient/angular_balance.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <utility>

#include "fem_process/matrix/node_vectors.h"

namespace tandem::fem {
namespace {

Eigen::Matrix3d cross_of(const Eigen::Vector3d& a) {
  Eigen::Matrix3d A;
  A << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0;
  return A;
}

}  // namespace

AngularBalance::AngularBalance(const Model& model, const Carry& carry, const Step& step)
    : model_(model),
      carry_(carry),
      step_(step),
      h_s_(step.carried.h_s),
      rotates_(carry.rotates()),
      v_{step.begin.v, step.momentum},
      v_end_(weighed(step.after.v)),
      internal_((v_end_.Ma - v_.Ma) / h_s_ - step.external - step.react),
      arm_(step.carried.begin.x) {
  if (rotates_) {
    out_ = weighed(step.after.x - step.carried.begin.x);
    back_ = {step.begin.x - step.carried.begin.x, step.behind};
  } else {
    out_ = weighed(step.after.x - step.begin.x - h_s_ * step.after.v);
  }
  const std::vector<BodyPart>& parts = carry.parts();
  for (std::size_t s = 0; s < parts.size(); ++s) {
    const BodyPart& part = parts[s];
    double mass = 0.0;
    Eigen::VectorXd held = Eigen::VectorXd::Zero(part.shares.cols());
    for (std::size_t i = 0; i < part.nodes.size(); ++i) {
      const double m = model.nodal_mass[static_cast<std::size_t>(part.nodes[i])];
      mass += m;
      if (held.size() > 0) held += m * part.shares.row(static_cast<Eigen::Index>(i)).transpose();
      arm_.segment<3>(3 * part.nodes[i]) -= step.carried.turns[s].about;
    }
    const bool grounded = std::find(part.holders.begin(), part.holders.end(), BodyPart::kGround) !=
                          part.holders.end();
    for (std::size_t k = 0; k < part.holders.size(); ++k) {
      if (part.holders[k] == BodyPart::kGround) continue;
      const auto holder = static_cast<Eigen::Index>(k);
      shares_.push_back({.port = static_cast<std::size_t>(part.holders[k]),
                         .part = s,
                         .holder = holder,
                         .mass = rotates_ && !grounded ? held(holder) / mass : 0.0});
    }
  }
}

AngularBalance::Weighed AngularBalance::weighed(Eigen::VectorXd a) const {
  Eigen::VectorXd Ma = multiply_scalar(model_.pattern(), model_.mass, a);
  return {std::move(a), std::move(Ma)};
}

/// Calls work(row of the node, φ).
template <class Work>
void AngularBalance::for_nodes(const Share& share, const Work& work) const {
  const BodyPart& part = carry_.parts()[share.part];
  for (std::size_t i = 0; i < part.nodes.size(); ++i) {
    work(static_cast<Eigen::Index>(3 * part.nodes[i]),
         part.shares(static_cast<Eigen::Index>(i), share.holder));
  }
}

Eigen::Vector3d AngularBalance::moment(const Share& share, const Weighed& a,
                                       const Weighed& b) const {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for_nodes(share, [&](Eigen::Index row, double phi) {
    sum += phi * (at(a.a, row).cross(at(b.Ma, row)) + at(a.Ma, row).cross(at(b.a, row)));
  });
  return 0.5 * sum;
}

Eigen::VectorXd AngularBalance::shared(const Share& share, const Weighed& a) const {
  Eigen::VectorXd own = Eigen::VectorXd::Zero(a.a.size());
  Eigen::VectorXd sum = own;
  for_nodes(share, [&](Eigen::Index row, double phi) {
    own.segment<3>(row) = 0.5 * phi * at(a.a, row);
    sum.segment<3>(row) = 0.5 * phi * at(a.Ma, row);
  });
  return sum + multiply_scalar(model_.pattern(), model_.mass, own);
}

void AngularBalance::add(WrenchSet& wrenches) const {
  for (const Share& share : shares_) {
    Eigen::Vector3d torque = moment(share, out_, v_end_) / h_s_;
    if (rotates_) torque -= moment(share, back_, v_) / h_s_;
    if (share.mass > 0.0) {
      for_nodes(share, [&](Eigen::Index row, double) {
        torque += share.mass * at(arm_, row).cross(at(internal_, row));
      });
    }
    wrenches[share.port].t_P_W -= torque;
  }
}

void AngularBalance::add_change(const Change& change, WrenchSet& wrenches) const {
  const bool started = change.x_begin.size() > 0;
  const Weighed dv_end = weighed(change.v_end);
  Eigen::VectorXd d_force = dv_end.Ma / h_s_ - change.react;
  Weighed d_out{change.x_end, {}};
  Weighed dv;
  Weighed d_back;
  if (!rotates_) d_out.a -= h_s_ * change.v_end;
  if (started) {
    dv = weighed(change.v_begin);
    d_force -= dv.Ma / h_s_;
    d_out.a -= rotates_ ? change.x_middle : change.x_begin;
    if (rotates_) d_back = weighed(change.x_begin - change.x_middle);
  }
  d_out = weighed(std::move(d_out.a));
  if (change.damping.size() > 0) d_force += change.damping;
  for (const Share& share : shares_) {
    Eigen::Vector3d torque = (moment(share, d_out, v_end_) + moment(share, out_, dv_end)) / h_s_;
    if (started && rotates_) {
      torque -= (moment(share, d_back, v_) + moment(share, back_, dv)) / h_s_;
    }
    if (share.mass > 0.0) {
      for_nodes(share, [&](Eigen::Index row, double) {
        torque += share.mass * at(arm_, row).cross(at(d_force, row));
        // The centre's own change meets Σ internal = 0.
        if (!started) return;
        torque += share.mass * at(change.x_middle, row).cross(at(internal_, row));
      });
    }
    wrenches[share.port].t_P_W -= torque;
  }
}

AngularBalance::Rows AngularBalance::rows() const {
  const std::size_t ports = model_.ports.size();
  const auto count = static_cast<Eigen::Index>(ports);
  Rows rows;
  rows.free.setZero(3 * static_cast<Eigen::Index>(model_.free.size()), 3 * count);
  rows.ports.setZero(3 * count, 6 * count);
  rows.arms.setZero(out_.a.size(), count);
  rows.momenta.setZero(out_.a.size(), count);
  rows.mass.setZero(count);
  rows.part_of_port.resize(ports);
  rows.part_of_node.resize(static_cast<std::size_t>(model_.mesh.nodes()));
  for (std::size_t s = 0; s < carry_.parts().size(); ++s) {
    for (int node : carry_.parts()[s].nodes) rows.part_of_node[static_cast<std::size_t>(node)] = s;
  }
  std::vector<int> free(rows.part_of_node.size(), -1);
  for (std::size_t k = 0; k < model_.free.size(); ++k) {
    free[static_cast<std::size_t>(model_.free[k])] = static_cast<int>(k);
  }
  const Eigen::VectorXd M_arm = multiply_scalar(model_.pattern(), model_.mass, arm_);
  for (const Share& share : shares_) {
    const BodyPart& part = carry_.parts()[share.part];
    const Eigen::Matrix3d half = rotates_
                                     ? Eigen::Matrix3d(h_s_ * step_.carried.turns[share.part].half)
                                     : Eigen::Matrix3d(h_s_ * Eigen::Matrix3d::Identity());
    const auto port = static_cast<Eigen::Index>(share.port);
    const Eigen::VectorXd arms = shared(share, out_) + share.mass * M_arm;
    rows.arms.col(port) = arms;
    rows.momenta.col(port) = shared(share, v_end_);
    rows.mass(port) = share.mass;
    rows.part_of_port[share.port] = share.part;
    Eigen::Index i = 0;
    for_nodes(share, [&](Eigen::Index row, double) {
      const Eigen::Index own = i++;
      const int node = free[static_cast<std::size_t>(row / 3)];
      if (node < 0) return;
      const Eigen::Matrix3d momentum =
          cross_of(Eigen::Vector3d(rows.momenta.col(port).segment<3>(row))) / h_s_;
      Eigen::Matrix3d of_v = -cross_of(at(arms, row)) / h_s_;
      if (rotates_) of_v += momentum * half;
      rows.free.block<3, 3>(3 * node, 3 * port) = of_v.transpose();
      for (std::size_t l = 0; l < part.holders.size(); ++l) {
        if (part.holders[l] == BodyPart::kGround) continue;
        const Eigen::Index column = 6 * static_cast<Eigen::Index>(part.holders[l]);
        const double phi = part.shares(own, static_cast<Eigen::Index>(l));
        rows.ports.block<3, 3>(3 * port, column) += phi * momentum;
      }
    });
    for (std::size_t l = 0; l < part.holders.size(); ++l) {
      if (part.holders[l] == BodyPart::kGround) continue;
      const Eigen::Index column = 6 * static_cast<Eigen::Index>(part.holders[l]);
      rows.ports.block<3, 3>(3 * port, column + 3) =
          -rows.ports.block<3, 3>(3 * port, column) * half;
    }
  }
  return rows;
}

Eigen::Vector3d AngularBalance::held(const Rows& rows, std::size_t k, int node,
                                     const Held& change) const {
  if (rows.part_of_port[k] != rows.part_of_node[static_cast<std::size_t>(node)]) {
    return Eigen::Vector3d::Zero();
  }
  const auto port = static_cast<Eigen::Index>(k);
  const Eigen::Index row = 3 * node;
  const Eigen::Vector3d arm = rows.arms.col(port).segment<3>(row);
  const Eigen::Vector3d momentum = rows.momenta.col(port).segment<3>(row);
  const Eigen::Vector3d moved = rotates_ ? change.x : Eigen::Vector3d(change.x - h_s_ * change.v);
  return (momentum.cross(moved) - arm.cross(change.v)) / h_s_ +
         rows.mass(port) * at(arm_, row).cross(change.r);
}

}  // namespace tandem::fem
