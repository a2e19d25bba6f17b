#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "fem_process/body/integrator.h"
#include "fem_process/body/loads.h"
#include "fem_process/body/params.h"
#include "fem_process/elements/formulation.h"
#include "fem_process/kernels/thread_team.h"
#include "fem_process/matrix/block_matrix.h"
#include "fem_process/mesh/mesh.h"

namespace tandem::fem {

/// Everything about a flexible body that no step changes. Sets are resolved, forces have units.
class Model {
 public:
  explicit Model(Params params);

  struct Port {
    std::string name;
    std::vector<int> nodes;
    double length_m = 0.0;  ///< see length_of
    scenario::Attachment attachment{};
    std::vector<double> weights{};  ///< of the nodes, where the attachment is not rigid
  };

  Params params;
  TetMesh mesh;
  Materials materials;
  std::unique_ptr<ThreadTeam> team;  ///< that the loops of a step share
  std::unique_ptr<const Formulation> formulation;
  std::unique_ptr<const Integrator> integrator;
  std::vector<double> mass;        ///< per block (kg)
  std::vector<double> nodal_mass;  ///< row sums (kg)
  std::vector<Port> ports;
  std::vector<int> fixed;       ///< held: at their initial positions, or where a command found them
  std::vector<int> prescribed;  ///< nodes of rigid ports and fixed nodes
  std::vector<int> free;
  SubPattern interior;  ///< free nodes

  /// Divides the nodes anew: those of rigid ports and of these sets are prescribed, others free. A
  /// set that shares nodes with a port is a Usage error, and changes nothing.
  void hold(const std::vector<SetName>& sets);

  [[nodiscard]] const BlockPattern& pattern() const { return formulation->pattern(); }
  /// Reference positions as one vector (m).
  [[nodiscard]] Eigen::VectorXd reference() const;
  /// Velocities of the initial field (m/s).
  [[nodiscard]] Eigen::VectorXd initial_velocities() const;
  /// Loads without gravity at time t (N).
  [[nodiscard]] Eigen::VectorXd loads(double t_s) const;
  /// Loads and gravity at time t (N).
  [[nodiscard]] Eigen::VectorXd external_forces(double t_s) const;

 private:
  void find_ports();
  [[noreturn]] void refuse_nothing_free(const std::vector<SetName>& sets) const;

  LoadCase load_case_;
  std::vector<int> owner_;  ///< index of every node's port; below zero: none
};

/// Mean displacement (m) of the nodes of a set at the positions x, not weighted.
[[nodiscard]] Eigen::Vector3d mean_displacement(const Model& model, const SetName& set,
                                                const Eigen::VectorXd& x);

/// Root-mean-square distance (m) of a port's nodes from Po when the scenario states where Po is,
/// else from their centroid. A port of one node, or of none away from Po, takes the diagonal of the
/// mesh's bounding box: never zero.
[[nodiscard]] double length_of(const TetMesh& mesh, const PortSet& port, const NodeSet& set);

}  // namespace tandem::fem
