#include "protocol/schemes/body_blocks.h"

#include <algorithm>
#include <utility>

namespace tandem {
namespace {

constexpr Eigen::Index kMotion = 12, kWrench = 6;

/// Rows of the ports, `rows` each.
Eigen::VectorXd rows_of(const Eigen::VectorXd& all, const std::vector<std::size_t>& ports,
                        Eigen::Index rows) {
  Eigen::VectorXd own(rows * static_cast<Eigen::Index>(ports.size()));
  for (std::size_t i = 0; i < ports.size(); ++i) {
    own.segment(rows * static_cast<Eigen::Index>(i), rows) =
        all.segment(rows * static_cast<Eigen::Index>(ports[i]), rows);
  }
  return own;
}

/// Calls `use(row, column, own row, own column)` for all pairs of the ports.
template <class Use>
void for_pairs(const std::vector<std::size_t>& ports, const Use& use) {
  for (std::size_t r = 0; r < ports.size(); ++r) {
    for (std::size_t c = 0; c < ports.size(); ++c) {
      use(kWrench * static_cast<Eigen::Index>(ports[r]),
          kMotion * static_cast<Eigen::Index>(ports[c]), kWrench * static_cast<Eigen::Index>(r),
          kMotion * static_cast<Eigen::Index>(c));
    }
  }
}

}  // namespace

BodyBlocks::BodyBlocks(const std::vector<PortInfo>& ports, Refresh refresh,
                       std::int32_t every_steps, std::size_t secants) {
  std::int32_t bodies = 1;
  for (const PortInfo& port : ports) bodies = std::max(bodies, port.body + 1);
  blocks_.resize(static_cast<std::size_t>(bodies),
                 {.ports = {}, .jacobian = JacobianBlock(refresh, every_steps, secants)});
  for (std::size_t p = 0; p < ports.size(); ++p) {
    blocks_[static_cast<std::size_t>(ports[p].body)].ports.push_back(p);
  }
  const auto n = static_cast<Eigen::Index>(ports.size());
  value_ = Eigen::MatrixXd::Zero(kWrench * n, kMotion * n);
}

bool BodyBlocks::begin_step(SimTime H, std::int64_t micro_steps) {
  bool due = false;
  for (Block& block : blocks_) due |= block.jacobian.begin_step(H, micro_steps);
  return due;
}

void BodyBlocks::turn_with(const MotionSet& motions) {
  for (Block& block : blocks_) {
    MotionSet own;
    for (const std::size_t port : block.ports) own.push_back(motions[port]);
    block.jacobian.turn_with(own);
  }
  assemble();
}

void BodyBlocks::take(const Eigen::MatrixXd& jacobian) {
  for (Block& block : blocks_) {
    const auto n = static_cast<Eigen::Index>(block.ports.size());
    Eigen::MatrixXd own(kWrench * n, kMotion * n);
    for_pairs(block.ports, [&](auto row, auto column, auto own_row, auto own_column) {
      own.block<kWrench, kMotion>(own_row, own_column) =
          jacobian.block<kWrench, kMotion>(row, column);
    });
    block.jacobian.take(std::move(own));
  }
  assemble();
}

bool BodyBlocks::learn(const Eigen::VectorXd& d_in, const Eigen::VectorXd& d_out,
                       const Eigen::VectorXd& weights) {
  bool changed = false;
  for (Block& block : blocks_) {
    changed |= block.jacobian.learn(rows_of(d_in, block.ports, kMotion),
                                    rows_of(d_out, block.ports, kWrench),
                                    rows_of(weights, block.ports, kMotion));
  }
  if (changed) assemble();
  return changed;
}

void BodyBlocks::assemble() {
  for (const Block& block : blocks_) {
    const Eigen::MatrixXd& own = block.jacobian.value();
    if (own.size() == 0) continue;
    for_pairs(block.ports, [&](auto row, auto column, auto own_row, auto own_column) {
      value_.block<kWrench, kMotion>(row, column) =
          own.block<kWrench, kMotion>(own_row, own_column);
    });
  }
}

}  // namespace tandem
