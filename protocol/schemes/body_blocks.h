#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "protocol/contract/port.h"
#include "protocol/schemes/jacobian_block.h"

namespace tandem {

/// The flexible side's interface Jacobian L = ∂Λ/∂m (6P × 12P): one JacobianBlock for each flexible
/// body (PortInfo::body), zero between them. Secants are those of each body, so that what is
/// learned of one says nothing of another, and ten bodies learn as fast as one.
class BodyBlocks {
 public:
  BodyBlocks(const std::vector<PortInfo>& ports, Refresh refresh, std::int32_t every_steps,
             std::size_t secants);

  /// As those of JacobianBlock, for all ports.
  [[nodiscard]] bool begin_step(SimTime H, std::int64_t micro_steps);
  void turn_with(const MotionSet& motions);
  void take(const Eigen::MatrixXd& jacobian);
  bool learn(const Eigen::VectorXd& d_in, const Eigen::VectorXd& d_out,
             const Eigen::VectorXd& weights);
  [[nodiscard]] const Eigen::MatrixXd& value() const { return value_; }

 private:
  struct Block {
    std::vector<std::size_t> ports;
    JacobianBlock jacobian;
  };
  void assemble();

  std::vector<Block> blocks_;
  Eigen::MatrixXd value_;
};

}  // namespace tandem
