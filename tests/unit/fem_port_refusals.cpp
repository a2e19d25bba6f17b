#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "fem_process/make_side.h"
#include "protocol/contract/error.h"
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

}  // namespace
}  // namespace tandem::fem
