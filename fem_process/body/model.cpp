#include "fem_process/body/model.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "fem_process/elements/make_formulation.h"
#include "fem_process/mesh/node_average.h"
#include "fem_process/mesh/surface.h"
#include "protocol/contract/error.h"

namespace tandem::fem {
namespace {

Eigen::VectorXd stacked(const std::vector<Eigen::Vector3d>& points) {
  Eigen::VectorXd x(3 * static_cast<Eigen::Index>(points.size()));
  for (std::size_t i = 0; i < points.size(); ++i) {
    x.segment<3>(3 * static_cast<Eigen::Index>(i)) = points[i];
  }
  return x;
}

/// Who moves a node: a port's index, or
constexpr int kNobody = -1;
constexpr int kGround = -2;  // a fixed set

std::string tag_of(const TetMesh& mesh, int node) {
  return "node " + std::to_string(mesh.node_tags[static_cast<std::size_t>(node)]);
}

/// Weights of a loose port's nodes. Throws a Usage error where the set has no least-squares frame.
std::vector<double> weights_of(const TetMesh& mesh, const PortSet& port, const NodeSet& set,
                               const Integrator& integrator) {
  const auto fail = [&](const std::string& what) {
    throw Error(ErrorKind::Usage, port.set.where() + "port '" + port.name + "': the set '" +
                                      port.set.name + "' " + what);
  };
  // K alone, without the mass in the step matrix, is singular where only loose ports hold a body.
  if (!integrator.inertia()) {
    fail(
        "is not attached rigidly, which fem.integrator.kind quasi_static needs. Set attachment: "
        "rigid, or choose backward_euler, which settles to the same equilibrium.");
  }
  std::vector<double> weights(set.nodes.size(), 1.0);
  if (port.attachment.weights == scenario::NodeWeights::Area) {
    if (set.triangles.empty()) {
      fail("is no surface, so its nodes have no areas. Set weights: uniform, or name a surface.");
    }
    const std::vector<double> areas = nodal_areas(mesh, set);
    for (std::size_t k = 0; k < weights.size(); ++k) {
      weights[k] = areas[static_cast<std::size_t>(set.nodes[k])];
    }
  }
  std::vector<Eigen::Vector3d> positions;
  for (int node : set.nodes) positions.push_back(mesh.X[static_cast<std::size_t>(node)]);
  if (NodeAverage(set.nodes, weights, positions).collinear()) {
    fail("has " + std::to_string(set.nodes.size()) +
         " node(s) in one line or point, and a least-squares frame needs three that are not in "
         "line. Name a larger set, or set attachment: rigid.");
  }
  return weights;
}

}  // namespace

double length_of(const TetMesh& mesh, const PortSet& port, const NodeSet& set) {
  const auto X = [&](int node) { return mesh.X[static_cast<std::size_t>(node)]; };
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (int node : set.nodes) centre += X(node);
  centre /= static_cast<double>(set.nodes.size());
  if (port.p_WP) centre = *port.p_WP;
  double sum = 0.0;
  for (int node : set.nodes) sum += (X(node) - centre).squaredNorm();
  const double length = std::sqrt(sum / static_cast<double>(set.nodes.size()));
  const double diagonal = diagonal_of(mesh);
  return length > 1e-9 * diagonal ? length : diagonal;
}

Model::Model(Params given) : params(std::move(given)) {
  check(params);
  if (params.integrator.kind == IntegratorKind::QuasiStatic) {
    params.damping = {};
    // The equilibria are the same; without inertia in the matrix the simplified tangent, which
    // leaves out the stiffness of tension, would not lead there.
    if (params.formulation == FormulationKind::Corotational) {
      params.formulation = FormulationKind::ConsistentCorotational;
    }
    if (params.integrator.newton_steps == 0) params.integrator.newton_steps = 100;
  }
  mesh = read_mesh(params.mesh);
  team = std::make_unique<ThreadTeam>(params.threads);
  materials = params.materials.empty() ? Materials(params.material)
                                       : assign_materials(mesh, params.materials);
  formulation = make_formulation(params.formulation, mesh, materials, team.get());
  integrator = make_integrator(params.integrator);
  mass = mass_matrix(mesh, pattern(), materials, params.mass);
  nodal_mass = nodal_masses(pattern(), mass);
  load_case_ = LoadCase(mesh, params.loads);
  for (const SetName& name : params.watch) static_cast<void>(find_set(mesh, name));  // must exist
  find_ports();
  hold(params.fixed);
}

void Model::find_ports() {
  owner_.assign(mesh.X.size(), kNobody);
  for (const PortSet& port : params.ports) {
    const NodeSet& set = find_set(mesh, port.set);
    for (int node : set.nodes) {
      int& owner = owner_[static_cast<std::size_t>(node)];
      if (owner != kNobody) {
        throw Error(ErrorKind::Usage,
                    port.set.where() + tag_of(mesh, node) + " belongs to the ports '" +
                        ports[static_cast<std::size_t>(owner)].name + "' and '" + port.name +
                        "'. Let every node follow one port: choose sets without "
                        "common nodes.");
      }
      owner = static_cast<int>(ports.size());
    }
    Port& made =
        ports.emplace_back(Port{port.name, set.nodes, length_of(mesh, port, set), port.attachment});
    if (port.attachment.loose()) made.weights = weights_of(mesh, port, set, *integrator);
  }
}

/// Says whose set it is that leaves no node free, where it is one alone.
void Model::refuse_nothing_free(const std::vector<SetName>& sets) const {
  const auto holds_all = [&](const SetName& name) {
    return find_set(mesh, name).nodes.size() == mesh.X.size();
  };
  const std::string remedy =
      "Name the part of its surface that is meant, or make the part a body of mbs if it need not "
      "deform.";
  for (const PortSet& port : params.ports) {
    require(!holds_all(port.set), port.set.where() + "the set '" + port.set.name + "' of port '" +
                                      port.name + "' holds every node of " + mesh.file.string() +
                                      ": nothing could deform. " + remedy);
  }
  for (const SetName& name : sets) {
    require(!holds_all(name), name.where() + "the fixed set '" + name.name +
                                  "' holds every node of " + mesh.file.string() +
                                  ": nothing could move. " + remedy);
  }
  throw Error(ErrorKind::Usage, "fem: every node of " + mesh.file.string() +
                                    " is in a rigid port or fixed: nothing can move. Choose "
                                    "smaller sets, or mesh finer.");
}

void Model::hold(const std::vector<SetName>& sets) {
  std::vector<int> owners = owner_;
  std::vector<int> held;
  for (const SetName& name : sets) {
    for (int node : find_set(mesh, name).nodes) {
      int& owner = owners[static_cast<std::size_t>(node)];
      if (owner == kGround) continue;  // held by another fixed set already
      if (owner != kNobody) {
        throw Error(ErrorKind::Usage, name.where() + tag_of(mesh, node) + " is in the fixed set '" +
                                          name.name + "' and in the port '" +
                                          ports[static_cast<std::size_t>(owner)].name +
                                          "'. Choose sets without common nodes.");
      }
      owner = kGround;
      held.push_back(node);
    }
  }
  const auto moves = [&](int owner) {
    return owner == kNobody ||
           (owner >= 0 && ports[static_cast<std::size_t>(owner)].attachment.loose());
  };
  if (std::none_of(owners.begin(), owners.end(), moves)) refuse_nothing_free(sets);
  fixed = std::move(held);
  free.clear();
  prescribed.clear();
  for (int node = 0; node < mesh.nodes(); ++node) {
    (moves(owners[static_cast<std::size_t>(node)]) ? free : prescribed).push_back(node);
  }
  interior = sub_pattern(pattern(), free);
}

Eigen::VectorXd Model::reference() const { return stacked(mesh.X); }

Eigen::VectorXd Model::initial_velocities() const {
  const InitialVelocity& field = params.initial_velocity;
  std::vector<Eigen::Vector3d> velocities;
  velocities.reserve(mesh.X.size());
  for (const Eigen::Vector3d& X : mesh.X) {
    const Eigen::Vector3d arm = X - field.about_m;
    velocities.push_back(field.linear_m_per_s + field.angular_rad_per_s.cross(arm) +
                         field.gradient_per_s * arm);
  }
  return stacked(velocities);
}

Eigen::Vector3d mean_displacement(const Model& model, const SetName& set,
                                  const Eigen::VectorXd& x) {
  const std::vector<int>& nodes = find_set(model.mesh, set).nodes;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int node : nodes) {
    sum += x.segment<3>(3 * node) - model.mesh.X[static_cast<std::size_t>(node)];
  }
  return sum / static_cast<double>(nodes.size());
}

Eigen::VectorXd Model::loads(double t_s) const {
  Eigen::VectorXd f = Eigen::VectorXd::Zero(3 * mesh.nodes());
  load_case_.add(t_s, f);
  return f;
}

Eigen::VectorXd Model::external_forces(double t_s) const {
  Eigen::VectorXd f = loads(t_s);
  for (int i = 0; i < mesh.nodes(); ++i) {
    f.segment<3>(3 * i) += nodal_mass[static_cast<std::size_t>(i)] * params.gravity_m_per_s2;
  }
  return f;
}

}  // namespace tandem::fem
