#include "fem_process/body/round_off.h"

#include <cmath>
#include <limits>

namespace tandem::fem {

double round_off(const Model& model, const BlockValues& K, const Eigen::VectorXd& x) {
  double sum = 0.0;
  for (int node : model.free) {
    const double force =
        block(K, model.pattern().find(node, node)).norm() * x.segment<3>(3 * node).norm();
    sum += force * force;
  }
  return std::numeric_limits<double>::epsilon() * std::sqrt(sum);
}

}  // namespace tandem::fem
