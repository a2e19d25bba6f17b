#include "orchestrator/warnings/material_warnings.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "fem_process/ancf/ancf_keys.h"

namespace tandem::orchestrator {
namespace {

constexpr double kLightest_kg_per_m3 = 10.0;
constexpr double kDensest_kg_per_m3 = 25000.0;
constexpr double kSlowest_m_per_s = 1.0;
constexpr double kFastest_m_per_s = 2e4;
constexpr double kStone_kg_per_m3 = 2000.0;
constexpr double kSlowestStone_m_per_s = 30.0;
constexpr double kMostPoissonLocking = 1.1;

bool plausible_density(double density) {
  return density >= kLightest_kg_per_m3 && density <= kDensest_kg_per_m3;
}

/// A unit, and what its numbers are multiplied by to be kg/m³.
struct Unit {
  const char* name;
  double factor;
};

/// The unit in which the number is a density of solids.
const Unit* likely_unit(double density) {
  static constexpr std::array<Unit, 4> kUnits{
      {{"t/mm³", 1e12}, {"kg/mm³", 1e9}, {"g/cm³", 1e3}, {"g/m³", 1e-3}}};
  for (const Unit& unit : kUnits) {
    const double value = density * unit.factor;
    if (value >= 500.0 && value <= kDensest_kg_per_m3) return &unit;
  }
  return nullptr;
}

std::optional<Finding> implausible_density(const scenario::Node& material, double density) {
  if (plausible_density(density)) return std::nullopt;
  std::string text = fmt::format("{:g} kg/m³ is no density of a solid ({:g} to {:g}). ", density,
                                 kLightest_kg_per_m3, kDensest_kg_per_m3);
  if (const Unit* unit = likely_unit(density)) {
    text += fmt::format(
        "In {} it would be {:g} kg/m³: write that, and forces in N, lengths in m, "
        "moduli in Pa.",
        unit->name, density * unit->factor);
  } else {
    text += "Write it in kg/m³.";
  }
  return finding_at(material, "density_kg_per_m3", "implausible_density", text);
}

bool plausible_speed(double speed_m_per_s, double density) {
  const double slowest = density >= kStone_kg_per_m3 ? kSlowestStone_m_per_s : kSlowest_m_per_s;
  return speed_m_per_s >= slowest && speed_m_per_s <= kFastest_m_per_s;
}

/// The unit in which the number is a modulus of the solid with that density.
const Unit* unit_of_modulus(double modulus, double density) {
  static constexpr std::array<Unit, 3> kUnits{{{"GPa", 1e9}, {"MPa", 1e6}, {"kPa", 1e3}}};
  for (const Unit& unit : kUnits) {
    const double speed = std::sqrt(modulus * unit.factor / density);
    if (speed > 500.0 && speed <= kFastest_m_per_s) return &unit;
  }
  return nullptr;
}

std::optional<Finding> implausible_modulus(const scenario::Node& node, double modulus_Pa,
                                           double density) {
  const double speed = std::sqrt(modulus_Pa / density);
  if (!plausible_density(density) || plausible_speed(speed, density)) return std::nullopt;
  std::string text = fmt::format(
      "with {:g} Pa and {:g} kg/m³ waves would run along a rod at {:.3g} m/s, as in no solid. ",
      modulus_Pa, density, speed);
  if (const Unit* unit = unit_of_modulus(modulus_Pa, density)) {
    text += fmt::format("A modulus of {:g} {} is {:g} Pa: write that.", modulus_Pa, unit->name,
                        modulus_Pa * unit->factor);
  } else {
    text += "Check modulus (Pa) and density (kg/m³).";
  }
  return finding_at(node, "", "implausible_modulus", text);
}

/// Calls judge(section of the scenario, material) for every material.
template <class Judge>
void for_materials(const scenario::Node& root, const fem::Model& model, const Judge& judge) {
  const scenario::Node fem = root.section("fem");
  if (model.params.materials.empty()) {
    judge(fem.section("material"), model.materials.list.at(0));
    return;
  }
  const std::vector<scenario::Node> sections = fem.list("materials");
  for (std::size_t s = 0; s < sections.size(); ++s) judge(sections[s], model.materials.list.at(s));
}

}  // namespace

std::vector<Finding> implausible_densities(const scenario::Node& root, const fem::Model& model) {
  std::vector<Finding> findings;
  for_materials(root, model, [&](const scenario::Node& node, const fem::Material& material) {
    auto found = implausible_density(node, material.density_kg_per_m3);
    if (found) findings.push_back(std::move(*found));
  });
  return findings;
}

std::vector<Finding> implausible_moduli(const scenario::Node& root, const fem::Model& model) {
  std::vector<Finding> findings;
  for_materials(root, model, [&](const scenario::Node& node, const fem::Material& material) {
    const double density = material.density_kg_per_m3;
    auto found = implausible_modulus(node, fem::squared_wave_speed(material) * density, density);
    if (found) findings.push_back(std::move(*found));
  });
  return findings;
}

std::vector<Finding> implausible_chain_material(const scenario::Node& root) {
  const scenario::Node ancf = root.section("fem").section("ancf");
  const scenario::Node node = ancf.section("material");
  const fem::ancf::BeamMaterial material = fem::ancf::read_beam_params(root).model.material;
  std::vector<Finding> findings;
  if (auto found = implausible_density(node, material.density_kg_per_m3)) {
    findings.push_back(std::move(*found));
  }
  if (auto found = implausible_modulus(node, material.young_Pa(), material.density_kg_per_m3)) {
    findings.push_back(std::move(*found));
  }
  const double nu = material.poisson();
  const double times = (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu));
  const scenario::Node integration = ancf.section("integration");
  if (integration.text("kind") == "full" && times > kMostPoissonLocking) {
    findings.push_back(finding_at(
        integration, "kind", "poisson_locking",
        fmt::format("full integration bends {:.3g} times as stiffly as the beam, since no section "
                    "gets wider or narrower across its height (Poisson's ratio {:.4g}). Set "
                    "fem.ancf.integration.kind: axis_d0 where the chain bends.",
                    times, nu)));
  }
  return findings;
}

}  // namespace tandem::orchestrator
