#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "fem_process/body/integrator.h"
#include "fem_process/body/model.h"
#include "fem_process/body/state.h"
#include "fem_process/mesh/node_average.h"
#include "fem_process/ports/port_arms.h"
#include "fem_process/ports/port_relation.h"
#include "fem_process/solvers/linear_solver.h"
#include "protocol/contract/port.h"

namespace tandem::fem {

/// Where the forces on ports have their arms, and about which points their torques are taken.
struct TorqueArms {
  MotionSet pose;                      ///< of the ports when the forces act
  std::vector<Eigen::Vector3d> about;  ///< per port (m)
};

/// The motions that the relations of a step hold for. The velocities y that a step solves for may
/// be those of axes that turn (see EndCarry); per loose port B turns what is relative to the port
/// back:
///   q˙ ← v_P + B (q˙ − v_P),  w ← B w   of motions.w_WP and of q˙ = Nᵀ y.
struct PortsSeen {
  MotionSet motions;
  std::vector<Eigen::Matrix3d> back;  ///< B per loose port
};

/// The ports whose nodes do not follow them rigidly: averaging ports and bushings. Their nodes are
/// free nodes of the body, with the forces N φ on them, Nᵀ the functionals of NodeAverage, twelve
/// per port: `coordinates` q = Nᵀ x. A step of the body solves
///   S δv = −residual + N δφ,   F(q, q˙, φ; motion) = 0 per port,
/// by the columns Z = S⁻¹ N, which belong to the factorised step matrix, and Y = Nᵀ Z: q˙ moves
/// with φ by Y, q by c_x Y, so the relations are left in 12 unknowns per port.
///
/// The rigid part of an averaging port's nodes enters a step as the nodes of a rigid port do: d and
/// a by prescribe(), v by the relation, x by follow(). Deformed nodes turn at other velocities than
/// the undeformed set would, by δ = (nodes' rates) − ρ with ρ of rigid_rates(): ρ has the
/// accelerations of prescribed nodes, δ those of free ones.
class LoosePorts {
 public:
  LoosePorts(const Model& model, const PortArms& arms);

  struct Port {
    std::size_t index = 0;  ///< in the scenario's table
    NodeAverage average;
    std::optional<Bushing> bushing;  ///< none: averaging
  };
  [[nodiscard]] const std::vector<Port>& ports() const { return ports_; }
  [[nodiscard]] bool empty() const { return ports_.empty(); }
  /// 12 per port.
  [[nodiscard]] Eigen::Index size() const { return 12 * static_cast<Eigen::Index>(ports_.size()); }

  /// q = Nᵀ x of a vector over all nodes.
  [[nodiscard]] Eigen::VectorXd coordinates(const Eigen::VectorXd& x) const;
  /// f += scale N φ.
  void add_forces(const Eigen::VectorXd& phi, double scale, Eigen::VectorXd& f) const;
  /// N on the free nodes.
  [[nodiscard]] Eigen::MatrixXd columns() const;
  /// Nᵀ of columns over the free nodes.
  [[nodiscard]] Eigen::MatrixXd coordinates_of(const Eigen::MatrixXd& columns) const;

  /// ρ of ports at constant twist and its rates, with which a body starts.
  [[nodiscard]] RateHistory rigid_start(const MotionSet& motions) const;
  /// What a step knows of ρ and δ before it is made.
  struct RigidStep {
    StepMap map;          ///< of ρ
    Eigen::VectorXd lag;  ///< δ at the beginning of the step
  };
  /// `begin` as the plain step takes it.
  [[nodiscard]] RigidStep rigid_step(const Integrator& integrator, const State& begin,
                                     double h_s) const;
  struct Rates {
    Eigen::VectorXd v;
    Eigen::VectorXd a;
  };
  /// Gives the rigid part of an averaging port's nodes the displacements and accelerations of
  /// prescribed nodes: adds to d and a what the step's maps lack of them. δ at the beginning of the
  /// step, turned along with the body, stands for δ at its end there: the force of the difference
  /// is of second order. Returns ρ and its rates at the end of the step. `d_hat` is that of the
  /// free nodes, the drift of the ports included. Positions and velocities are those that the
  /// balance sees, the prescribed accelerations follow from velocities in W: see Carry.
  struct EndMotions {
    const MotionSet& in_world;
    const PortsSeen& seen;
  };
  Rates prescribe(const StepMap& map, const RigidStep& rigid, const Eigen::VectorXd& d_hat,
                  const EndMotions& end, Eigen::VectorXd& d, Eigen::VectorXd& a) const;
  /// Puts the rigid part of an averaging port's nodes where the port is.
  void follow(const MotionSet& end, Eigen::VectorXd& x) const;
  /// The coordinates of x after follow() from those before.
  [[nodiscard]] Eigen::VectorXd followed(const MotionSet& end, const Eigen::VectorXd& q) const;
  /// Gives the nodes of averaging ports the port's rigid velocity field.
  void set_velocities(const MotionSet& motions, Eigen::VectorXd& v) const;

  /// Newton's iteration for F = 0 along q(φ), q˙(φ). On entry φ and the q, q˙ that belong to it, on
  /// return the solution. `near` are coordinates to linearise at first.
  SolveReport close(const PortsSeen& end, double c_x, const Eigen::MatrixXd& Y,
                    const Eigen::VectorXd& near, Eigen::VectorXd& q, Eigen::VectorXd& q_rate,
                    Eigen::VectorXd& phi) const;

  /// φ for which the rigid parts of averaging ports' nodes keep their accelerations, those of
  /// bushings given: `q_acceleration` without φ is changed by Y φ. The frames stand as q says.
  void close_accelerations(const Eigen::MatrixXd& Y, const Eigen::VectorXd& q,
                           const Eigen::VectorXd& q_acceleration, Eigen::VectorXd& phi) const;

  /// Forces of the bushings at given motion, those of averaging ports zero.
  [[nodiscard]] Eigen::VectorXd bushing_forces(const MotionSet& motions, const Eigen::VectorXd& q,
                                               const Eigen::VectorXd& q_rate) const;
  /// Strain energy of the bushings (J).
  [[nodiscard]] double energy_J(const MotionSet& motions, const Eigen::VectorXd& q) const;

  /// Subtracts the resultants of φ about the points given, the arms as in q.
  void add_wrenches(const std::vector<Eigen::Vector3d>& about, const Eigen::VectorXd& q,
                    const Eigen::VectorXd& phi, WrenchSet& wrenches) const;

  /// Relation of port k of these.
  [[nodiscard]] PortRelation relation(std::size_t k, const PortsSeen& seen,
                                      const Eigen::VectorXd& q, const Eigen::VectorXd& q_rate,
                                      const Eigen::VectorXd& phi) const;
  /// dF/dφ along q(φ), q˙(φ).
  [[nodiscard]] Eigen::MatrixXd tangent(const std::vector<PortRelation>& relations,
                                        const PortsSeen& seen, double c_x,
                                        const Eigen::MatrixXd& Y) const;

 private:
  std::vector<Port> ports_;
  Eigen::Index free_rows_ = 0;
  std::vector<std::vector<Eigen::Index>> free_at_;  ///< row of every node of a port in free vectors
  std::vector<std::string> names_;
};

/// (p + R c, R inertia): coordinates of a port's nodes that stand as the port has them.
[[nodiscard]] Vector12 rigid_coordinates(const NodeAverage& average, const Motion& motion);
/// Their rates with the port.
[[nodiscard]] Vector12 rigid_rates(const NodeAverage& average, const Motion& motion);

/// What the next steps need of ρ. Linear in all arguments.
[[nodiscard]] RateHistory kept_rates(const Integrator& integrator, const RateHistory& begin,
                                     const LoosePorts::Rates& rates, double h_s);

/// Solves G x = b with the rows brought to one size: they have different units.
[[nodiscard]] Eigen::VectorXd solve_equilibrated(const Eigen::MatrixXd& G,
                                                 const Eigen::VectorXd& b);

}  // namespace tandem::fem
