#pragma once

#include <Eigen/Core>
#include <vector>

#include "fem_process/body/model.h"
#include "fem_process/kernels/thread_team.h"
#include "fem_process/sides/step_benchmark.h"
#include "fem_process/transient/step_matrix.h"
#include "tests/support/fem_support.h"

namespace tandem::fem::testing {

/// The step matrix M/h + h K (kg/s) of the standard lug at rest, 1455 tets, over its free nodes.
struct LugSystem {
  LugSystem()
      : model(
            benchmark_params(benchmark_case("soft"), data_file("lug_1k.msh"), "clamp", "eye", {})) {
    Eigen::VectorXd f_int;
    BlockValues K;
    model.formulation->evaluate(model.reference(), f_int, K);
    ThreadTeam alone;
    const double h_s = to_seconds(model.params.micro_step);
    combine(model.interior, 1.0 / h_s, model.mass, h_s, &K, A, alone);
    for (int node : model.free) X.push_back(model.mesh.X[static_cast<std::size_t>(node)]);
  }
  [[nodiscard]] const BlockPattern& pattern() const { return model.interior.pattern; }

  Model model;
  BlockValues A;
  std::vector<Eigen::Vector3d> X;  ///< of the free nodes (m)
};

}  // namespace tandem::fem::testing
