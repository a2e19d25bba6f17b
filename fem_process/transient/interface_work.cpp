#include "fem_process/transient/interface_work.h"

namespace tandem::fem {

double interface_trapezoid_J(const MotionSet& begin, const MotionSet& end,
                             const WrenchSet& at_begin, const WrenchSet& at_end) {
  const Eigen::VectorXd moved = difference(begin, end);
  const Eigen::VectorXd sum = stack(at_begin) + stack(at_end);
  double work_J = 0.0;
  for (Eigen::Index i = 0; 6 * i < sum.size(); ++i) {
    work_J += 0.5 * sum.segment<6>(6 * i).dot(moved.segment<6>(12 * i));
  }
  return work_J;
}

}  // namespace tandem::fem
