#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "fem_process/body/body_parts.h"
#include "fem_process/body/integrator.h"
#include "fem_process/body/model.h"
#include "fem_process/body/state.h"
#include "fem_process/ports/loose_ports.h"
#include "protocol/contract/port.h"

namespace tandem::fem {

/// What a step starts from, seen from axes that turn with the body: see Carry.
struct Carried {
  /// How one part of the body turns over the step, at a constant rate.
  struct Turn {
    Eigen::Vector3d omega = Eigen::Vector3d::Zero();     ///< rad/s
    Eigen::Vector3d about = Eigen::Vector3d::Zero();     ///< a free part's centre of mass (m)
    Eigen::Matrix3d Q = Eigen::Matrix3d::Identity();     ///< exp(h [ω]×)
    Eigen::Matrix3d half = Eigen::Matrix3d::Identity();  ///< Q^½
    Eigen::Matrix3d mean = Eigen::Matrix3d::Identity();  ///< T of mean_over(h ω)
    /// X and L of GeneralisedAlpha, for ports that go round with the part.
    Eigen::Matrix3d circle_lead = Eigen::Matrix3d::Zero();
    Eigen::Matrix3d prescribed_circle_lead = Eigen::Matrix3d::Zero();
  };
  double h_s = 0.0;
  std::vector<Turn> turns;            ///< per part
  bool turning = false;               ///< whether any part turns
  State begin;                        ///< the state as the plain step takes it
  StepMap map;                        ///< of `begin`
  LoosePorts::RigidStep rigid;        ///< of `begin`, where the integrator keeps a history
  MotionSet ports;                    ///< at the beginning of the step
  std::vector<Eigen::Matrix3d> back;  ///< of PortsSeen
  State holder;                       ///< origins of the ports as if they were nodes, and
  StepMap holder_map;                 ///< where the integrator takes them
  /// Newmark's family: (1 − Qᵀ) w, w the relative velocities at the beginning (m/s). The relative
  /// velocities solved for are turned by Q from where damping has them at the end: to O(h²) by
  /// this.
  Eigen::VectorXd lag;
  /// Velocities in W at the end less those that are solved for, of free nodes (m/s): what mass
  /// damping needs. Exact with MiddleCarry, to O(h²) with EndCarry.
  Eigen::VectorXd drag;
  Eigen::VectorXd velocity;  ///< backward Euler: of the carried nodes at the end (m/s)
};

/// How a step knows nothing of the turning of the whole body. Every part of the body is carried
/// rigidly with what holds it (see BodyPart), or with its own mean motion; the plain step of the
/// integrator then acts on what is left. In steady turning nothing is left: shape, forces along the
/// axis of turning and energies are those of the static centrifugal state, at any ω h.
///
/// A plain step x⁺ = x + h v⁺ takes the turn itself for strain, (ω h)²/2 of every length, and lets
/// forces act along axes along which the momentum does not change.
///
/// Two pictures of the same state, chosen by the integrator's kind:
/// * MiddleCarry (backward Euler): axes at the middle of the step's turn, where momentum changes
///   along the chord and forces that turn along have their mean.
/// * EndCarry (Newmark's family): axes at its end, where the forces are balanced.
/// The linear formulation cannot turn: it is carried without rotation.
class Carry {
 public:
  virtual ~Carry() = default;

  /// What a step of length h starts from. Const, and smooth in the state.
  [[nodiscard]] virtual Carried begin(const State& state, double h_s) const = 0;

  /// Port motions at the end of the step as the picture has them.
  [[nodiscard]] virtual MotionSet seen(const Carried& carried, const MotionSet& end) const = 0;
  [[nodiscard]] PortsSeen ports_seen(const Carried& carried, const MotionSet& end) const {
    return {seen(carried, end), carried.back};
  }

  /// How far the ports end from where the plain step takes their origins, spread over the body:
  /// what the plain step's displacements of the free nodes lack in the balance of forces (m).
  /// Empty: none.
  [[nodiscard]] virtual Eigen::VectorXd drift(const Carried& carried,
                                              const MotionSet& end) const = 0;

  /// What the plain step's accelerations lack of ports whose origins go round (m/s²), over the
  /// nodes. Empty: none.
  [[nodiscard]] virtual Eigen::VectorXd circling(const Carried&, const MotionSet&) const {
    return {};
  }
  /// Carried::rigid with the same.
  [[nodiscard]] virtual LoosePorts::RigidStep rigid(const Carried& carried,
                                                    const MotionSet&) const {
    return carried.rigid;
  }

  /// Rigid velocities of the body with the mean motion of what holds it, in the picture (m/s):
  /// stiffness damping acts on the velocities beyond these. A free part goes as f_ext (N)
  /// accelerates its centre of mass.
  [[nodiscard]] Eigen::VectorXd reference(const State& begin, const Carried& carried,
                                          const MotionSet& end, const Eigen::VectorXd& f_ext) const;
  /// The same in W at a state that no step has led to: of rigid velocities at the motions given.
  [[nodiscard]] Eigen::VectorXd reference_at(const State& state, const MotionSet& motions) const;

  /// The velocities of nodes with prescribed motion as the picture has them.
  virtual void see_prescribed(const Carried& carried, Eigen::VectorXd& v) const = 0;

  /// The same less their velocities in W, which they have in the balance; zero at free nodes (m/s).
  [[nodiscard]] virtual Eigen::VectorXd prescribed_shift(const Carried& carried,
                                                         const MotionSet& end,
                                                         const Eigen::VectorXd& x,
                                                         const Eigen::VectorXd& v) const = 0;

  /// What the plain step has made of `carried.begin`.
  struct Made {
    Eigen::VectorXd x;        ///< x̃ + d
    Eigen::VectorXd v;        ///< solved for
    Eigen::VectorXd a;        ///< of the balance of forces
    LoosePorts::Rates rates;  ///< of LoosePorts
    MotionSet end;
  };
  /// The state in W: positions, velocities, accelerations and histories of `after`.
  virtual void conclude(const State& begin, const Carried& carried, Made made,
                        State& after) const = 0;

  /// Forces that turn with the body become what the balance has of them (N): with MiddleCarry their
  /// mean over the step, T f part by part; with EndCarry they stay.
  virtual void take_mean(const Carried& carried, Eigen::VectorXd& f) const = 0;

  [[nodiscard]] const std::vector<BodyPart>& parts() const { return parts_; }
  /// False: the formulation cannot turn.
  [[nodiscard]] bool rotates() const { return rotates_; }
  /// The ports where their part's half turn about its centre takes them.
  [[nodiscard]] MotionSet turned_by_half(const Carried& carried) const;

 protected:
  Carry(const Model& model, const LoosePorts& loose);

  /// Mass centre, velocity and angular velocity of a part, weighted with the nodal masses.
  struct OwnMotion {
    Eigen::Vector3d centre, velocity, omega;
  };
  [[nodiscard]] OwnMotion own_motion(const BodyPart& part, const Eigen::VectorXd& x,
                                     const Eigen::VectorXd& v) const;
  /// Mean of a nodal field over a part, weighted with the nodal masses.
  [[nodiscard]] Eigen::Vector3d mean(const BodyPart& part, const Eigen::VectorXd& field) const;
  [[nodiscard]] double mass(const BodyPart& part) const;
  void turn(const Eigen::Vector3d& omega, double h_s, Carried::Turn& turn) const;
  /// The mean place of the fixed nodes of a part (m).
  [[nodiscard]] Eigen::Vector3d ground(const BodyPart& part, const Eigen::VectorXd& x) const;
  /// The rigid velocities of reference() for the nodes of a part that is held, s of parts().
  virtual void refer(std::size_t s, const State& begin, const Carried& carried,
                     const MotionSet& end, Eigen::VectorXd& v) const = 0;

  const Model& model_;
  const LoosePorts& loose_;
  std::vector<BodyPart> parts_;
  std::vector<std::size_t> part_of_port_;
  bool rotates_;  ///< false: the formulation cannot turn
};

/// The carry that belongs to a model's integrator; both references are kept.
[[nodiscard]] std::unique_ptr<const Carry> make_carry(const Model& model, const LoosePorts& loose);

}  // namespace tandem::fem
