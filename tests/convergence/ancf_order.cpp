// The explicit exchange of the tracked vehicle against the converged one at the same macro step:
// first order in H.

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/support/beam_pair.h"

namespace tandem::coupled_test {
namespace {

/// Positions and velocities of the five bodies after 10 ms, in which the released vehicle falls.
struct End {
  Eigen::Matrix<double, 15, 1> p, v;
};

End end_of(const std::string& scheme, const std::string& macro_step_s) {
  BeamPair pair(
      "tracked_vehicle/scenario.yaml",
      {"run.duration_s=0.01", "run.macro_step_s=" + macro_step_s, "coupling.scheme=" + scheme});
  const RunReport report = pair.run([](const BeamPair&) {});
  EXPECT_EQ(report.status, RunStatus::Done) << report.message;
  End end;
  Eigen::Index row = 0;
  for (const char* name : {"chassis", "sprocket", "idler", "roller1", "roller2"}) {
    end.p.segment<3>(row) = pair.body(name).p_WB;
    end.v.segment<3>(row) = pair.body(name).v_WB;
    row += 3;
  }
  return end;
}

TEST(AncfOrder, ExplicitCouplingIsOfFirstOrder) {
  double before_p = 0.0;
  double before_v = 0.0;
  for (const char* H : {"2e-4", "1e-4", "5e-5", "2.5e-5"}) {
    const End explicit_end = end_of("explicit_serial", H);
    const End converged = end_of("interface_jacobian", H);
    const double p = (explicit_end.p - converged.p).norm();
    const double v = (explicit_end.v - converged.v).norm();
    if (before_p > 0.0) {
      EXPECT_NEAR(std::log2(before_p / p), 1.0, 0.15) << H;
      EXPECT_NEAR(std::log2(before_v / v), 1.0, 0.15) << H;
    }
    before_p = p;
    before_v = v;
  }
}

}  // namespace
}  // namespace tandem::coupled_test
