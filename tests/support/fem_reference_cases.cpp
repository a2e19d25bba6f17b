#include "tests/support/fem_reference_cases.h"

#include <array>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "protocol/contract/error.h"

namespace tandem::fem::testing {
namespace {

const std::filesystem::path kRoot = TANDEM_SOURCE_DIR;

std::vector<ReferenceStep> read_steps(const std::string& name, double scale) {
  const std::filesystem::path file = kRoot / "tests/data/fem/static_reference.csv";
  std::ifstream csv(file);
  std::vector<ReferenceStep> steps;
  for (std::string line; std::getline(csv, line);) {
    if (!line.starts_with(name + ",")) continue;
    std::stringstream fields(line.substr(name.size() + 1));
    char separator = 0;
    double k = 0.0;
    double n = 1.0;
    fields >> k >> separator >> n;
    std::array<double, 9> u{};
    for (double& value : u) fields >> separator >> value;
    require(!fields.fail(), file.string() + ": " + line);
    const auto vector = [&](std::size_t i) {
      return Eigen::Vector3d(scale * Eigen::Vector3d(u[i], u[i + 1], u[i + 2]));
    };
    steps.push_back({k / n, vector(0), vector(3), vector(6)});
  }
  require(!steps.empty(), file.string() + ": no case " + name);
  return steps;
}

}  // namespace

std::vector<double> ReferenceCase::factors() const {
  std::vector<double> factors;
  for (const ReferenceStep& step : steps) factors.push_back(step.factor);
  return factors;
}

ReferenceCase reference_case(const std::string& name) {
  const bool steel = name == "hinge" || name == "lug";
  const double scale = steel ? 1e-3 : 1.0;
  ReferenceCase result{.name = name, .monitor = {name == "hinge" ? "load" : "monitor"}};
  Params& params = result.params;
  params.mesh.file =
      kRoot / (name == "hinge" ? "examples/hinge" : "tests/data/fem") / (name + ".msh");
  params.mesh.length_scale_m = scale;
  params.material = steel              ? Material{2.1e11, 0.3, 7850.0}
                    : name == "beam15" ? Material{1e6, 0.3, 1000.0}
                                       : Material{1e7, 0.3, 1000.0};
  params.fixed = {{"fixed"}};
  params.micro_step = SimTime(1'000'000);
  Load load{.kind = name == "hinge" ? Load::Kind::Nodal : Load::Kind::SurfaceForce,
            .set = {"load"},
            .value = {0, 0, -150}};
  if (name == "hinge") load.value = {-4800, 9000, 6600};
  if (name == "lug") load.value = {13000, 24000, 12000};
  if (name == "beam15") load.value = {100, 50, -12.5};
  params.loads = {load};
  result.steps = read_steps(name, scale);
  return result;
}

}  // namespace tandem::fem::testing
