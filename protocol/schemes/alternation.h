#pragma once

#include <string>
#include <utility>
#include <vector>

#include "protocol/contract/port.h"
#include "protocol/schemes/prediction.h"

namespace tandem {

/// How much of the port wrenches changes sign from one macro step to the next: the mean over the
/// last steps (weights falling by e in 16 of them) of
///   ‖λ_n − 2 λ_{n−1} + λ_{n−2}‖ / (‖λ_n‖ + 2 ‖λ_{n−1}‖ + ‖λ_{n−2}‖),
/// 1 for (−1)ⁿ, O(H²) for what the steps resolve. It is what two undamped integrators of second
/// order keep, and turning feeds, where the flexible side is too stiff for the step.
class Alternation {
 public:
  explicit Alternation(std::vector<PortInfo> ports) : ports_(std::move(ports)) {}

  /// The interface at the end of an accepted macro step.
  void add(const InterfaceState& state);
  [[nodiscard]] double part() const { return part_; }
  /// What a run that ends early says of it; empty while it is small.
  [[nodiscard]] std::string remark() const;

 private:
  std::vector<PortInfo> ports_;
  double part_ = 0.0;
};

}  // namespace tandem
