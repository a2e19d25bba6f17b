#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "fem_process/mesh/mesh.h"
#include "protocol/contract/sim_time.h"

namespace tandem::fem {

/// The boundary conditions that commands can change while a body runs: part of its state.
struct Boundary {
  struct Force {
    std::string set;
    Eigen::Vector3d total_N = Eigen::Vector3d::Zero();
    bool operator==(const Force&) const = default;
  };
  std::vector<std::string> fixed;  ///< sets held now, each where its nodes are
  std::vector<Force> forces;       ///< dead loads by command, beside those of the scenario
  int scheduled = 0;               ///< how many of the scenario's changes have been made
  bool operator==(const Boundary&) const = default;
};

/// The boundary after a command:
///   release SET      the nodes of a fixed set move again (but for those of another fixed set)
///   fix SET          the nodes of a set are held where they are
///   force X,Y,Z SET  the total force (N), in equal parts on the nodes of the set, in place of the
///                    last one by command on this set; 0,0,0 ends it
/// Throws a Usage error when the command is none of these, or the set does not fit.
[[nodiscard]] Boundary changed(const Boundary& boundary, const std::string& command,
                               const TetMesh& mesh);

/// "force SET FX,FY,FZ" with numbers that read back exactly.
[[nodiscard]] std::string force_command(const Eigen::Vector3d& total_N, const std::string& set);

/// Adds the forces to the nodal forces f (N).
void add_forces(const Boundary& boundary, const TetMesh& mesh, Eigen::VectorXd& f);

/// A change that the scenario makes: before the first macro step that begins at or after `at`.
struct ScheduledChange {
  SimTime at{};
  std::string command;
  scenario::Place place;
};

}  // namespace tandem::fem
