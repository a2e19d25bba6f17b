#include "orchestrator/warnings/setup_warnings.h"

#include <fmt/format.h>

#include "mbs_process/motor_rate.h"
#include "orchestrator/verdict/run_books.h"

namespace tandem::orchestrator {
namespace {

/// Masses of the flexible side that the multibody side carries.
bool carries_no_mass(const scenario::Node& fem) {
  if (fem.text("model") == "ancf") return false;
  return fem.text("coupling") == "nodal" ||
         fem.section("integrator").text("kind") == "quasi_static";
}

struct Turning {
  double rate_rad_per_s = 0.0;
  std::string what;
};

Turning fastest(const Model& model, const mbs::Params& params) {
  Turning found;
  const auto keep = [&](double rate, const std::string& what) {
    if (rate > found.rate_rad_per_s) found = {rate, what};
  };
  const double H_s = to_seconds(model.run.macro_step);
  const double h_s = params.micro_step ? to_seconds(*params.micro_step) : H_s;
  for (const mbs::JointParams& joint : params.joints) {
    if (!joint.motor || joint.kind == mbs::JointKind::Slider) continue;
    keep(mbs::largest_motor_rate(*joint.motor, h_s, to_seconds(model.run.duration)),
         "the motor of joint '" + joint.name + "'");
  }
  for (const mbs::BodyParams& body : params.bodies) {
    keep(body.w_WB.norm(), "body '" + body.name + "' at t = 0");
  }
  const scenario::Node fem = model.scenario.root.section("fem");
  if (fem.has("initial_velocity")) {
    keep(fem.section("initial_velocity").vector3("angular_rad_per_s").norm(),
         "the flexible body at t = 0");
  }
  return found;
}

}  // namespace

std::optional<Finding> gravity_on_one_side(const scenario::Node& root) {
  const scenario::Node mbs = root.section("mbs");
  const scenario::Node fem = root.section("fem");
  if (carries_no_mass(fem)) return std::nullopt;
  const std::string key = "gravity_m_per_s2";
  const Eigen::Vector3d rigid = mbs.vector3(key);
  const Eigen::Vector3d flexible = fem.vector3(key);
  if (rigid == flexible) return std::nullopt;
  const auto text = [](const Eigen::Vector3d& g) {
    return fmt::format("[{:g}, {:g}, {:g}]", g.x(), g.y(), g.z());
  };
  const bool on_rigid = flexible.isZero(0.0);
  const scenario::Node& where = on_rigid ? fem : mbs;
  return finding_at(where, key, "gravity_on_one_side",
                    fmt::format("{} is {}, {} is {}: each side has its own, and one is left out or "
                                "other. Set {}: {}.",
                                mbs.path_name(key), text(rigid), fem.path_name(key), text(flexible),
                                where.path_name(key), text(on_rigid ? rigid : flexible)));
}

std::optional<Finding> orders_differ(const scenario::Node& root) {
  const scenario::Node mbs = root.section("mbs");
  const scenario::Node fem = root.section("fem");
  // Chains have one integrator, nodes of the multibody side and statics none.
  if (fem.text("model") == "ancf" || carries_no_mass(fem)) return std::nullopt;
  const bool rigid = mbs.text("integrator") != "euler";
  const bool flexible = is_second_order(fem);
  if (rigid == flexible) return std::nullopt;
  const std::string text =
      "the other side's integrator is of second order and this one of first, and so is the run; "
      "the interface loses or makes energy. Set {}, or leave both at their defaults.";
  if (rigid) {
    return finding_at(
        fem.section("integrator"), "kind", "orders_differ",
        fmt::format(fmt::runtime(text), fem.path_name("integrator.kind") + ": generalised_alpha"));
  }
  return finding_at(mbs, "integrator", "orders_differ",
                    fmt::format(fmt::runtime(text), mbs.path_name("integrator") + ": verlet"));
}

std::optional<Finding> turn_per_step(const Model& model, const mbs::Params& params) {
  if (model.coupling.adaptive.active()) return std::nullopt;
  const Turning found = fastest(model, params);
  const double H_s = to_seconds(model.run.macro_step);
  const double turn_rad = found.rate_rad_per_s * H_s;
  if (turn_rad <= VerdictLimits::kTurn_rad * (1.0 + 1e-9)) return std::nullopt;
  return finding_at(
      model.scenario.root.section("run"), "macro_step_s", "turn_per_step",
      fmt::format("{} turns with {:.4g} rad/s, {:.3g} rad in a macro step. Set run.macro_step_s to "
                  "{:.2g} or less ({:g} rad).",
                  found.what, found.rate_rad_per_s, turn_rad,
                  H_s * VerdictLimits::kTurn_rad / turn_rad, VerdictLimits::kTurn_rad));
}

std::vector<Finding> coarse_tolerances(const scenario::Node& root) {
  const double accuracy = root.section("run").real("accuracy");
  std::vector<Finding> findings;
  const auto judge = [&](const scenario::Node& node, const std::string& key) {
    if (!node.has(key) || node.real(key) <= accuracy) return;
    findings.push_back(
        finding_at(node, key, "coarse_tolerance",
                   fmt::format("{:g} leaves more than run.accuracy, {:g}, asks for. Leave it out "
                               "(it follows from run.accuracy), or raise run.accuracy.",
                               node.real(key), accuracy)));
  };
  judge(root.section("coupling"), "relative_tolerance");
  const scenario::Node fem = root.section("fem");
  const bool solves = fem.text("model") != "ancf" && fem.text("formulation") != "craig_bampton";
  if (solves && fem.section("solver").text("kind") == "pcg")
    judge(fem.section("solver"), "tolerance");
  return findings;
}

}  // namespace tandem::orchestrator
