#pragma once

#include <variant>
#include <vector>

#include "protocol/scenario/key_table.h"
#include "protocol/scenario/node.h"

namespace tandem {

struct ConstantLaw {
  double value = 0.0;
};
/// value_begin before t_begin, linear between, value_end after t_end.
struct RampLaw {
  double begin_s = 0.0, end_s = 1.0, value_begin = 0.0, value_end = 0.0;
};
/// offset + amplitude sin(2π f t + phase).
struct HarmonicLaw {
  double offset = 0.0, amplitude = 0.0, frequency_Hz = 1.0, phase_rad = 0.0;
};
/// Linear between the points (times strictly increasing), constant outside.
struct TableLaw {
  std::vector<double> times_s, values;
};

/// A prescribed function of time. The unit of its values belongs to the key that holds it.
class Law {
 public:
  Law() = default;
  template <class L>
  explicit Law(L law) : law_(std::move(law)) {}
  [[nodiscard]] double operator()(double t_s) const;
  /// The mean value between two times, begin < end: ∫ value dt / (end − begin), exact for every
  /// kind.
  [[nodiscard]] double mean(double begin_s, double end_s) const;

 private:
  std::variant<ConstantLaw, RampLaw, HarmonicLaw, TableLaw> law_;
};

namespace scenario {
/// Keys of a law: {kind: constant|ramp|harmonic|table, …}. Keys that the kind does not use are
/// refused.
[[nodiscard]] Key law(std::string name, std::string value_unit);
[[nodiscard]] Law read_law(const Node& node);
}  // namespace scenario

}  // namespace tandem
