#include "fem_process/ancf/attachment.h"

#include <Eigen/Geometry>
#include <set>

#include "fem_process/kernels/cross_matrix.h"

namespace tandem::fem::ancf {

Attachments::Attachments(BeamMesh& mesh, const std::vector<Attachment>& attached) {
  for (const Attachment& attachment : attached) {
    support(mesh, attachment.at_end, attachment.support);
    const BeamElement& element = attachment.at_end ? mesh.elements.back() : mesh.elements.front();
    const int first_slot = attachment.at_end ? 4 : 0;
    std::set<int> seen;  // the gradients of an oblique pin are sums of several vectors
    for (const Term& term : element.terms) {
      const bool here = term.slot >= first_slot && term.slot < first_slot + 4;
      const bool point = term.slot == first_slot;
      if (!here || !(point || attachment.support == Support::Clamped)) continue;
      if (!seen.insert(term.vector).second) continue;
      vectors_.push_back({attachment.port, 3 * term.vector, point, Eigen::Vector3d::Zero()});
    }
  }
}

void Attachments::take_places(const MotionSet& motions, const Eigen::VectorXd& q) {
  for (Vector& vector : vectors_) {
    const Motion& port = motions[static_cast<std::size_t>(vector.port)];
    const Eigen::Vector3d x = q.segment<3>(vector.row);
    vector.in_port = port.q_WP.conjugate() * (vector.point ? Eigen::Vector3d(x - port.p_WP) : x);
  }
}

void Attachments::place(const MotionSet& motions, Eigen::VectorXd& q, Eigen::VectorXd& v) const {
  for (const Vector& vector : vectors_) {
    const Motion& port = motions[static_cast<std::size_t>(vector.port)];
    const Eigen::Vector3d turned = port.q_WP * vector.in_port;
    q.segment<3>(vector.row) = turned;
    v.segment<3>(vector.row) = port.w_WP.cross(turned);
    if (!vector.point) continue;
    q.segment<3>(vector.row) += port.p_WP;
    v.segment<3>(vector.row) += port.v_WP;
  }
}

void Attachments::advance(const MotionSet& motions, double h_s, const Eigen::VectorXd& v_begin,
                          const Eigen::VectorXd& A_begin, Eigen::VectorXd& q, Eigen::VectorXd& v,
                          Eigen::VectorXd& a, Eigen::VectorXd& A) const {
  place(motions, q, v);
  for (const Vector& vector : vectors_) {
    const Eigen::Vector3d mean = (v.segment<3>(vector.row) - v_begin.segment<3>(vector.row)) / h_s;
    a.segment<3>(vector.row) = mean + 0.5 * (mean - A_begin.segment<3>(vector.row));
    A.segment<3>(vector.row) = mean;
  }
}

void Attachments::add_wrenches(const MotionSet& motions, const Eigen::VectorXd& balance,
                               WrenchSet& wrenches) const {
  for (const Vector& vector : vectors_) {
    const auto port = static_cast<std::size_t>(vector.port);
    const Eigen::Vector3d load = balance.segment<3>(vector.row);
    wrenches[port].t_P_W += (motions[port].q_WP * vector.in_port).cross(load);
    if (vector.point) wrenches[port].f_P_W += load;
  }
}

Attachments::Derivatives Attachments::derivatives(const MotionSet& motions,
                                                  const Eigen::VectorXd& balance) const {
  const auto ports = static_cast<Eigen::Index>(motions.size());
  const Eigen::Index n = balance.size();
  Derivatives d{Eigen::MatrixXd::Zero(n, 12 * ports), Eigen::MatrixXd::Zero(n, 12 * ports),
                Eigen::MatrixXd::Zero(n, 6 * ports), Eigen::MatrixXd::Zero(6 * ports, 12 * ports)};
  for (const Vector& vector : vectors_) {
    const Motion& port = motions[static_cast<std::size_t>(vector.port)];
    const Eigen::Index column = 12 * vector.port;
    const Eigen::Index load = 6 * vector.port;
    const Eigen::Matrix3d turned = cross_matrix(port.q_WP * vector.in_port);
    if (vector.point) {
      d.q.block<3, 3>(vector.row, column).setIdentity();
      d.v.block<3, 3>(vector.row, column + 6).setIdentity();
      d.loads.block<3, 3>(vector.row, load).setIdentity();
    }
    d.q.block<3, 3>(vector.row, column + 3) = -turned;
    d.v.block<3, 3>(vector.row, column + 3) = -cross_matrix(port.w_WP) * turned;
    d.v.block<3, 3>(vector.row, column + 9) = -turned;
    d.loads.block<3, 3>(vector.row, load + 3) = -turned;  // (x × R)ᵀ
    d.turn.block<3, 3>(load + 3, column + 3) +=
        cross_matrix(balance.segment<3>(vector.row)) * turned;
  }
  return d;
}

}  // namespace tandem::fem::ancf
