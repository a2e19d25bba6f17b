#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <string>

#include "fem_process/keys/fem_keys.h"
#include "fem_process/sides/make_side.h"
#include "protocol/contract/error.h"
#include "protocol/scenario/common_keys.h"
#include "protocol/scenario/scenario_file.h"
#include "tests/support/fem_box.h"
#include "tests/support/fem_ports.h"

namespace tandem::fem {
namespace {

using namespace testing;
using scenario::NodeWeights;

std::string refusal(const std::function<void()>& made) {
  try {
    made();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::Usage);
    return error.what();
  }
  return "accepted";
}

TEST(LoosePorts, WhatHasNoLeastSquaresFrameIsRefused) {
  Params params = bar_with_two_ports();
  params.ports[0].attachment = averaging();
  params.integrator.kind = IntegratorKind::QuasiStatic;
  EXPECT_NE(refusal([&] { Model model(params); }).find("quasi_static needs. Set attachment: rigid"),
            std::string::npos);

  params.integrator = {};
  params.formulation = FormulationKind::CraigBampton;
  EXPECT_NE(refusal([&] {
              static_cast<void>(make_body(params));
            }).find("constraint modes of craig_bampton"),
            std::string::npos);

  Params box;
  box.mesh.file = temporary_file("ports.inp", box_inp(2) + "*NSET, NSET=EDGE\n1, 2\n");
  box.material = {.young_Pa = 1e6, .poisson = 0.3, .density_kg_per_m3 = 1000.0};
  box.micro_step = SimTime(1'000'000);
  box.ports = {{"edge", {"EDGE"}, std::nullopt, averaging()}};
  EXPECT_NE(refusal([&] {
              Model model(box);
            }).find("port 'edge': the set 'EDGE' has 2 node(s) in one line or point"),
            std::string::npos);

  box.ports = {{"left", {"LEFT"}, std::nullopt, averaging(NodeWeights::Area)}};
  EXPECT_NE(refusal([&] { Model model(box); }).find("is no surface, so its nodes have no areas"),
            std::string::npos);

  box.ports = {{"left", {"LEFT"}, std::nullopt, averaging()}};
  box.fixed = {{"LEFT"}};
  EXPECT_NE(refusal([&] { Model model(box); }).find("and in the port 'left'"), std::string::npos);
}

/// The message of what a scenario with a port on a bushing in line 3 makes.
std::string refusal_of(const std::string& fem) {
  const std::filesystem::path file = temporary_file(
      "bushing.yaml",
      "run: {duration_s: 1.0, macro_step_s: 0.001}\n"
      "ports:\n  - {name: left, body: arm, node_set: LEFT, attachment: bushing, bushing: "
      "{stiffness_N_per_m: [1, 1, 1]}}\n"
      "fem:\n  mesh: {file: " +
          temporary_file("bushing.inp", box_inp(2)).string() +
          "}\n  mass: lumped\n  material: {young_Pa: 1e6, poisson: 0.3, density_kg_per_m3: "
          "1000}\n" +
          fem);
  scenario::Section table;
  table.keys = {scenario::run_keys(), scenario::ports_keys(), fem_keys()};
  std::string message =
      refusal([&] { static_cast<void>(make_body(read_params(scenario::load(file, table).root))); });
  if (message.rfind(file.string(), 0) == 0) message.erase(0, file.string().size());
  return message;
}

TEST(LoosePorts, AreRefusedAtTheirPlaceByModelsWithoutThem) {
  EXPECT_EQ(refusal_of(""), "accepted");
  EXPECT_EQ(refusal_of("  integrator: {kind: quasi_static}\n"),
            ":3:5: port 'left': the set 'LEFT' is not attached rigidly, which fem.integrator.kind "
            "quasi_static needs. Set attachment: rigid, or choose backward_euler, which settles to "
            "the same equilibrium.");
  EXPECT_EQ(refusal_of("  formulation: craig_bampton\n"),
            ":3:5: port 'left' is not rigid, and the constraint modes of craig_bampton move every "
            "port's nodes rigidly. Set attachment: rigid, or choose another fem.formulation.");
  EXPECT_EQ(refusal_of("  coupling: nodal\n"),
            ":3:5: ports: with fem.coupling: nodal they are made from the mesh, one for each free "
            "node, and these are not they. Leave out ports and mbs.bodies.");
}

}  // namespace
}  // namespace tandem::fem
