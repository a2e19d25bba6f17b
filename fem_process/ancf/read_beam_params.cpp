#include <algorithm>
#include <cmath>

#include "fem_process/ancf/ancf_keys.h"
#include "fem_process/transient/micro_step.h"
#include "protocol/contract/error.h"
#include "protocol/scenario/common_keys.h"
#include "protocol/scenario/law.h"

namespace tandem::fem::ancf {
namespace {

using scenario::Node;

BeamMaterial read_material(const Node& node) {
  BeamMaterial material;
  if (node.text("law") == "svk") {
    material = BeamMaterial::from_young(ElasticLaw::SaintVenantKirchhoff, node.real("young_Pa"),
                                        node.real("poisson"));
  } else {
    const double factor = node.text("constant_is") == "c10" ? 2.0 : 1.0;
    material.mu_Pa = factor * node.real("neo_hookean_Pa");
    material.k_Pa = node.real("bulk_Pa");
  }
  material.density_kg_per_m3 = node.real("density_kg_per_m3");
  material.dilatation_s = node.real("dilatation_s");
  material.deviation_s = node.real("deviation_s");
  material.viscosity = node.text("viscosity") == "green" ? Viscosity::Green : Viscosity::Spatial;
  return material;
}

Integration read_integration(const std::string& kind) {
  if (kind == "volume_on_axis") return Integration::VolumeOnAxis;
  return kind == "axis_d0" ? Integration::AxisD0 : Integration::Full;
}

Support read_support(const std::string& kind) {
  if (kind == "hinged") return Support::Hinged;
  return kind == "clamped" ? Support::Clamped : Support::Free;
}

Laying read_laying(const Node& chain, const BeamMaterial& material) {
  Laying laying{.elements = static_cast<int>(chain.integer("elements")),
                .strain = chain.real("strain")};
  laying.lateral_stretch = lateral_stretch(material, 1.0 + laying.strain);
  const std::string joint = chain.text("joint");
  laying.joint = joint == "pin" ? Joint::Pin : joint == "ball" ? Joint::Ball : Joint::Rigid;
  if (laying.joint == Joint::Pin) {
    const Eigen::Vector3d axis = chain.vector3("pin_axis");
    if (axis.norm() == 0.0) chain.fail("pin_axis", "has no direction.");
    laying.pin_axis = axis.normalized();
  }
  laying.curved_reference = chain.text("stress_free") == "path";
  if (laying.curved_reference && laying.strain != 0.0) {
    chain.fail("strain", "must be zero where stress_free is path.");
  }
  return laying;
}

BeamMesh read_mesh(const Node& ancf, const BeamMaterial& material) {
  const Node path = ancf.section("path");
  const Node chain = ancf.section("chain");
  const Laying laying = read_laying(chain, material);
  const bool open = path.text("kind") == "line";
  const Eigen::Vector3d lateral = path.vector3("lateral");
  if (lateral.norm() == 0.0) path.fail("lateral", "has no direction.");
  const Support left = read_support(chain.text("left_support"));
  const Support right = read_support(chain.text("right_support"));
  if (!open && (left != Support::Free || right != Support::Free)) {
    chain.fail(left != Support::Free ? "left_support" : "right_support",
               "a closed chain has no ends. Use path.kind: line.");
  }
  try {
    BeamMesh mesh = open ? join(lay(LinePath{.start = path.vector3("start_m"),
                                             .direction = path.vector3("direction"),
                                             .lateral = lateral,
                                             .length_m = path.real("length_m")},
                                    laying))
                         : join(lay(LoopPath{.center1 = path.vector3("center1_m"),
                                             .center2 = path.vector3("center2_m"),
                                             .radius1_m = path.real("radius1_m"),
                                             .radius2_m = path.real("radius2_m"),
                                             .lateral = lateral},
                                    laying));
    support(mesh, false, left);
    support(mesh, true, right);
    return mesh;
  } catch (const Error& error) {
    path.fail("", error.what());
  }
}

Teeth read_teeth(const Node& node, const ContactParams& contact) {
  return {.count = static_cast<int>(node.integer("count")),
          .phase_rad = node.real("phase_rad"),
          .pin_radius_m = node.real("pin_radius_m"),
          .backlash = node.real("backlash"),
          .height_m = node.real("height_m"),
          .stiffness_N_per_m = node.real("stiffness_N_per_m"),
          .damping_N_s_per_m = node.real("damping_N_s_per_m"),
          .damping_depth_m = contact.damping_depth_m};
}

/// Index of the port that `port` names.
int port_of(const Node& node, const BeamParams& params) {
  const auto port = std::find(params.ports.begin(), params.ports.end(), node.text("port"));
  if (port == params.ports.end()) {
    node.fail("port", "names no port." + scenario::did_you_mean(node.text("port"), params.ports));
  }
  return static_cast<int>(port - params.ports.begin());
}

ContactParams with_friction(ContactParams params, const Node& surface) {
  if (surface.has("friction")) params.friction = surface.real("friction");
  return params;
}

Face read_face(const Node& node) {
  return node.text("face") == "inner" ? Face::Inner : Face::Outer;
}

void read_surfaces(const Node& ancf, BeamParams& params) {
  const Node contact = ancf.section("contact");
  const ContactParams common{
      .stiffness_N_per_m3 = contact.real("stiffness_N_per_m3"),
      .damping_N_s_per_m3 = contact.real("damping_N_s_per_m3"),
      .damping_depth_m = contact.real("damping_depth_m"),
      .friction = contact.real("friction"),
      .friction_slope_N_s_per_m3 = contact.real("friction_slope_N_s_per_m3")};
  params.grid = {static_cast<int>(contact.integer("points_along")),
                 static_cast<int>(contact.integer("points_across"))};
  if (ancf.has("wheels")) {
    for (const Node& node : ancf.list("wheels")) {
      Wheel wheel{.port = port_of(node, params),
                  .radius_m = node.real("radius_m"),
                  .face = read_face(node),
                  .contact = with_friction(common, node)};
      if (node.has("teeth")) wheel.teeth = read_teeth(node.section("teeth"), common);
      params.wheels.push_back(wheel);
    }
  }
  if (!ancf.has("grounds")) return;
  for (const Node& node : ancf.list("grounds")) {
    const Eigen::Vector3d normal = node.vector3("normal");
    if (normal.norm() == 0.0) node.fail("normal", "has no direction.");
    params.grounds.push_back({.point_m = node.vector3("point_m"),
                              .normal = normal.normalized(),
                              .face = read_face(node),
                              .contact = with_friction(common, node)});
  }
}

/// Element and ξ of a part of the chain's length.
std::pair<int, double> place_on(const BeamMesh& mesh, double part) {
  const int n = static_cast<int>(mesh.elements.size());
  const int element = std::min(n - 1, static_cast<int>(std::floor(part * n)));
  return {element, part * n - element};
}

void read_ports_of(const Node& root, BeamParams& params) {
  if (!root.has("ports")) return;
  for (const scenario::PortParams& port : scenario::read_ports(root)) {
    require(
        port.node_set.empty(),
        port.place.text() + ": port '" + port.name +
            "' names a node set, which an ANCF chain does not have. Take node_set away and name "
            "the port in fem.ancf.wheels or fem.ancf.attachments.");
    require(
        !port.attachment.loose(),
        port.place.text() + ": port '" + port.name +
            "' has averaged or bushed nodes, and ANCF chains have no node sets. Take attachment "
            "away; fem.ancf.attachments holds an end of a chain.");
    params.ports.push_back(port.name);
  }
}

void read_attachments(const Node& ancf, BeamParams& params) {
  if (!ancf.has("attachments")) return;
  const bool closed = ancf.section("path").text("kind") == "loop";
  const Node chain = ancf.section("chain");
  for (const Node& node : ancf.list("attachments")) {
    if (closed) node.fail("end", "is of no use: a closed chain has no ends.");
    const std::string end = node.text("end");
    if (chain.text(end + "_support") != "free") {
      node.fail("end", "is held by chain." + end + "_support already. Leave that one free.");
    }
    const bool at_end = end == "right";
    for (const Attachment& other : params.attachments) {
      if (other.at_end == at_end) node.fail("end", "is attached already. Use the other end.");
    }
    params.attachments.push_back(
        {.port = port_of(node, params),
         .at_end = at_end,
         .support = node.text("kind") == "clamped" ? Support::Clamped : Support::Hinged});
    // Without a multibody side the end stays where it lies.
    support(params.model.mesh, at_end, params.attachments.back().support);
  }
}

void require_use(const Node& root, const BeamParams& params) {
  for (std::size_t p = 0; p < params.ports.size(); ++p) {
    const auto here = [&](const auto& part) { return part.port == static_cast<int>(p); };
    const bool used = std::any_of(params.wheels.begin(), params.wheels.end(), here) ||
                      std::any_of(params.attachments.begin(), params.attachments.end(), here);
    require(used, scenario::read_ports(root)[p].place.text() + ": port '" + params.ports[p] +
                      "' belongs to no wheel of fem.ancf.wheels and no end of "
                      "fem.ancf.attachments. Add one or take the port away.");
  }
}

void read_times(const Node& root, BeamParams& params) {
  const Node fem = root.section("fem");
  const MicroStep step = read_micro_step(root);
  params.micro_step = step.length;
  params.follows_macro_step = step.follows_macro_step;
  const Node ancf = fem.section("ancf");
  if (!ancf.has("settle")) return;
  const Node settle = ancf.section("settle");
  params.settle = {.duration = sim_time_from_seconds(settle.real("duration_s")),
                   .step = sim_time_from_seconds(settle.real("step_s")),
                   .mass_damping_per_s = settle.real("mass_damping_per_s")};
  if (params.settle.step <= SimTime{} || params.settle.duration % params.settle.step != SimTime{}) {
    settle.fail("duration_s", "is not a whole multiple of step_s.");
  }
}

}  // namespace

BeamParams read_beam_params(const Node& root) {
  const Node fem = root.section("fem");
  const Node ancf = fem.section("ancf");
  BeamParams params;
  BeamModel& model = params.model;
  model.material = read_material(ancf.section("material"));
  const Node section = ancf.section("section");
  model.section = {section.real("width_m"), section.real("height_m")};
  model.mesh = read_mesh(ancf, model.material);
  const Node integration = ancf.section("integration");
  model.integration = read_integration(integration.text("kind"));
  if (model.integration == Integration::VolumeOnAxis &&
      model.material.law != ElasticLaw::NeoHookean) {
    integration.fail("kind", "volume_on_axis splits the neo-Hookean law only. Use axis_d0.");
  }
  model.strain = integration.text("strain") == "compatible" ? Strain::Compatible : Strain::Assumed;
  if (integration.has("points")) {
    const std::vector<double> points = integration.reals("points");
    model.order = {static_cast<int>(points[0]), static_cast<int>(points[1]),
                   static_cast<int>(points[2])};
  }
  model.gravity_m_per_s2 = fem.vector3("gravity_m_per_s2");
  if (ancf.has("loads")) {
    for (const Node& node : ancf.list("loads")) {
      const auto [element, xi] = place_on(model.mesh, node.real("at"));
      model.loads.push_back(
          {element, xi, node.vector3("force_N"), scenario::read_law(node.section("law"))});
    }
  }
  read_ports_of(root, params);
  read_surfaces(ancf, params);
  read_attachments(ancf, params);
  require_use(root, params);
  const Node integrator = ancf.section("integrator");
  params.step = {.rho_inf = integrator.real("rho_inf"),
                 .tolerance_m = integrator.real("tolerance_m"),
                 .newton_steps = static_cast<int>(integrator.integer("newton_steps")),
                 .halvings = static_cast<int>(integrator.integer("halvings"))};
  const Node velocity = ancf.section("velocity");
  params.velocity = {velocity.vector3("linear_m_per_s"), velocity.vector3("angular_rad_per_s"),
                     velocity.vector3("about_m")};
  if (ancf.has("watch")) {
    for (const Node& node : ancf.list("watch")) {
      const auto [element, xi] = place_on(model.mesh, node.real("at"));
      params.watch.push_back({node.text("name"), element, xi});
    }
  }
  read_times(root, params);
  return params;
}

}  // namespace tandem::fem::ancf
