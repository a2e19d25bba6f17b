#include "fem_process/angular_balance.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace tandem::fem {
namespace {

Eigen::Vector3d at(const Eigen::VectorXd& field, Eigen::Index row) { return field.segment<3>(row); }

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
      arm_(step.carried.begin.x) {
  const Eigen::VectorXd p = multiply_scalar(model.pattern(), model.mass, step.begin.v);
  const Eigen::VectorXd p_end = multiply_scalar(model.pattern(), model.mass, step.after.v);
  internal_ = (p_end - p) / h_s_ - step.external - step.react;
  if (rotates_) {
    out_ = step.after.x - step.carried.begin.x;
    back_ = step.begin.x - step.carried.begin.x;
  } else {
    out_ = step.after.x - step.begin.x - h_s_ * step.after.v;
    back_ = Eigen::VectorXd::Zero(out_.size());
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
                         .mass = rotates_ && !grounded ? held(holder) / mass : 0.0,
                         .p = shared(part, holder, step.begin.v, p),
                         .p_end = shared(part, holder, step.after.v, p_end)});
    }
  }
}

Eigen::VectorXd AngularBalance::shared(const BodyPart& part, Eigen::Index holder,
                                       const Eigen::VectorXd& v, const Eigen::VectorXd& Mv) const {
  if (part.shares.cols() == 1) return Mv;
  Eigen::VectorXd own = Eigen::VectorXd::Zero(v.size());
  Eigen::VectorXd p = own;
  for (std::size_t i = 0; i < part.nodes.size(); ++i) {
    const Eigen::Index row = 3 * part.nodes[i];
    const double phi = part.shares(static_cast<Eigen::Index>(i), holder);
    own.segment<3>(row) = 0.5 * phi * v.segment<3>(row);
    p.segment<3>(row) = 0.5 * phi * Mv.segment<3>(row);
  }
  return p + multiply_scalar(model_.pattern(), model_.mass, own);
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

void AngularBalance::add(WrenchSet& wrenches) const {
  for (const Share& share : shares_) {
    Eigen::Vector3d turning = Eigen::Vector3d::Zero();
    Eigen::Vector3d moment = Eigen::Vector3d::Zero();
    for_nodes(share, [&](Eigen::Index row, double) {
      turning += at(out_, row).cross(at(share.p_end, row)) - at(back_, row).cross(at(share.p, row));
      moment += at(arm_, row).cross(at(internal_, row));
    });
    wrenches[share.port].t_P_W -= turning / h_s_ + share.mass * moment;
  }
}

void AngularBalance::add_change(const Change& change, WrenchSet& wrenches) const {
  const bool started = change.x_begin.size() > 0;
  const Eigen::VectorXd dp_end = multiply_scalar(model_.pattern(), model_.mass, change.v_end);
  Eigen::VectorXd d_out = change.x_end;
  Eigen::VectorXd d_force = dp_end / h_s_ - change.react;
  Eigen::VectorXd dp;
  Eigen::VectorXd d_back;
  if (!rotates_) d_out -= h_s_ * change.v_end;
  if (started) {
    dp = multiply_scalar(model_.pattern(), model_.mass, change.v_begin);
    d_force -= dp / h_s_;
    d_out -= rotates_ ? change.x_middle : change.x_begin;
    d_back = rotates_ ? Eigen::VectorXd(change.x_begin - change.x_middle)
                      : Eigen::VectorXd::Zero(d_out.size());
  }
  if (change.damping.size() > 0) d_force += change.damping;
  for (const Share& share : shares_) {
    const BodyPart& part = carry_.parts()[share.part];
    const Eigen::VectorXd own_end = shared(part, share.holder, change.v_end, dp_end);
    Eigen::VectorXd own;
    if (started) own = shared(part, share.holder, change.v_begin, dp);
    Eigen::Vector3d turning = Eigen::Vector3d::Zero();
    Eigen::Vector3d moment = Eigen::Vector3d::Zero();
    for_nodes(share, [&](Eigen::Index row, double) {
      turning += at(d_out, row).cross(at(share.p_end, row)) + at(out_, row).cross(at(own_end, row));
      moment += at(arm_, row).cross(at(d_force, row));
      if (!started) return;
      turning -= at(d_back, row).cross(at(share.p, row)) + at(back_, row).cross(at(own, row));
      // The centre's own change meets Σ internal = 0.
      moment += at(change.x_middle, row).cross(at(internal_, row));
    });
    wrenches[share.port].t_P_W -= turning / h_s_ + share.mass * moment;
  }
}

AngularBalance::Rows AngularBalance::rows() const {
  const std::size_t ports = model_.ports.size();
  std::vector<int> free(static_cast<std::size_t>(model_.mesh.nodes()), -1);
  for (std::size_t k = 0; k < model_.free.size(); ++k) {
    free[static_cast<std::size_t>(model_.free[k])] = static_cast<int>(k);
  }
  const auto count = static_cast<Eigen::Index>(ports);
  Rows rows;
  rows.free.setZero(3 * count, 3 * static_cast<Eigen::Index>(model_.free.size()));
  rows.ports.setZero(3 * count, 6 * count);
  rows.arms.setZero(out_.size(), count);
  rows.momenta.setZero(out_.size(), count);
  rows.mass.setZero(count);
  rows.part_of_node.resize(free.size());
  rows.part_of_port.resize(ports);
  for (std::size_t s = 0; s < carry_.parts().size(); ++s) {
    for (int node : carry_.parts()[s].nodes) rows.part_of_node[static_cast<std::size_t>(node)] = s;
  }
  for (const Share& share : shares_) {
    const BodyPart& part = carry_.parts()[share.part];
    const Eigen::Matrix3d half = rotates_
                                     ? Eigen::Matrix3d(h_s_ * step_.carried.turns[share.part].half)
                                     : Eigen::Matrix3d(h_s_ * Eigen::Matrix3d::Identity());
    const auto port = static_cast<Eigen::Index>(share.port);
    // Σ out × (φ M δv + M φ δv)/2 + μ Σ arm × M δv = Σ (M(…)) × δv, M being symmetric.
    const Eigen::VectorXd M_out = multiply_scalar(model_.pattern(), model_.mass, out_);
    const Eigen::VectorXd M_arm = multiply_scalar(model_.pattern(), model_.mass, arm_);
    rows.arms.col(port) = shared(part, share.holder, out_, M_out) + share.mass * M_arm;
    rows.momenta.col(port) = share.p_end;
    rows.mass(port) = share.mass;
    rows.part_of_port[share.port] = share.part;
    Eigen::Index i = 0;
    for_nodes(share, [&](Eigen::Index row, double) {
      const Eigen::Index own = i++;
      const int node = free[static_cast<std::size_t>(row / 3)];
      if (node < 0) return;
      const Eigen::Matrix3d momentum = cross_of(at(share.p_end, row)) / h_s_;
      Eigen::Matrix3d of_v = -cross_of(Eigen::Vector3d(rows.arms.col(port).segment<3>(row))) / h_s_;
      if (rotates_) of_v += momentum * half;
      rows.free.block<3, 3>(3 * port, 3 * node) = of_v;
      for (std::size_t l = 0; l < part.holders.size(); ++l) {
        if (part.holders[l] == BodyPart::kGround) continue;
        const Eigen::Index column = 6 * static_cast<Eigen::Index>(part.holders[l]);
        const Eigen::Matrix3d of_p = part.shares(own, static_cast<Eigen::Index>(l)) * momentum;
        rows.ports.block<3, 3>(3 * port, column) += of_p;
        rows.ports.block<3, 3>(3 * port, column + 3) -= of_p * half;
      }
    });
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
