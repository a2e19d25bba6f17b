#pragma once

#include <Eigen/Core>
#include <optional>

#include "fem_process/mesh/node_average.h"
#include "protocol/contract/port.h"
#include "protocol/scenario/attachment.h"

namespace tandem::fem {

/// The average motion of a port's nodes and the forces on them, in axes of the port frame P.
struct PortView {
  Vector12 q;         ///< (Rᵀ (x̄ − p_WP), Rᵀ q_k)
  Vector12 u;         ///< (Rᵀ (x̄˙ − v_WP), Rᵀ q˙_k): rates with respect to W but for Po's
  Eigen::Vector3d w;  ///< Rᵀ w_WP
  Vector12 phi;       ///< Rᵀ φ
};
/// `back` turns relative velocities to W from where `motion.w_WP` and `q_rate` have them: see
/// PortsSeen.
[[nodiscard]] PortView port_view(const Motion& motion, const Eigen::Matrix3d& back,
                                 const Vector12& q, const Vector12& q_rate, const Vector12& phi);

/// What ties q, its rates and φ: twelve equations F = 0 with their derivatives.
struct PortRelation {
  Vector12 F;
  Matrix12 F_q;
  Matrix12 F_u;
  Eigen::Matrix<double, 12, 3> F_w;
  Matrix12 F_phi;
};

/// An averaging port: the least-squares frame of the nodes moves as P,
///   x̄˙ − v − w × R c = 0,   Σ_k e_k × (u_k − w × q̂_k) = 0,
/// and the forces have no part that deforms the set on average: φ_k = τ × e_k, so that node i has
///   f_i = w_i (F + τ × R r_i/ℓ),   moment about the centroid  H τ,  H = Σ_k (e_k·q̂_k) 1 − q̂_k
///   e_kᵀ.
/// q̂ is q after its rigid part is put where the port has it: see averaged().
[[nodiscard]] PortRelation averaging_relation(const NodeAverage& average, const PortView& at);

/// q with the rigid part of the port: x̄ at c, Σ_k e_k × q̂_k = 0 (port axes).
[[nodiscard]] Vector12 averaged(const NodeAverage& average, const Vector12& q);

/// A bushing between P and the frame (x̄ − R̄ c, R̄) of the nodes. In bushing axes B, which turn with
/// P, displacement u, rotation vector θ and the relative twist ν = (u˙, ω):
///   u = R_PBᵀ (x̄ − R̄ c),  exp([θ]×) = R_PBᵀ R̄ R_PB,
///   s = K (u, θ),  wrench on the nodes  −(s_u, J_r(θ)⁻¹ s_θ) − D ν,
/// J_r⁻¹ = 1 + ½ [θ]× + b [θ]×², b = 1/θ² − (1 + cos θ)/(2 θ sin θ), so that the elastic power is
/// −d/dt ½ (u, θ)ᵀ K (u, θ). On the nodes the wrench (F, M) acts as φ_0 = F, φ_k = τ × R̄ e_k with
/// H τ = M − R̄ c × F: the same resultants.
class Bushing {
 public:
  explicit Bushing(const scenario::BushingParams& params)
      : params_(params), R_PB_(params.q_PB.toRotationMatrix()) {}

  struct Deflection {
    Eigen::Vector3d u = Eigen::Vector3d::Zero();      ///< m
    Eigen::Vector3d theta = Eigen::Vector3d::Zero();  ///< rad
  };
  /// `q` in port axes.
  [[nodiscard]] Deflection deflection(const NodeAverage& average, const Vector12& q) const;
  [[nodiscard]] double energy_J(const Deflection& deflection) const;
  /// φ − Φ(q, rates) = 0.
  [[nodiscard]] PortRelation relation(const NodeAverage& average, const PortView& at) const;

 private:
  struct Response {
    Vector12 phi;
    Matrix12 phi_q;
    Matrix12 phi_rate;  ///< of the rates with respect to P
  };
  [[nodiscard]] Response response(const NodeAverage& average, const Vector12& q,
                                  const Vector12& rate) const;

  scenario::BushingParams params_;
  Eigen::Matrix3d R_PB_;
};

}  // namespace tandem::fem
