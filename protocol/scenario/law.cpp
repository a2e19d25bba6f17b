#include "protocol/scenario/law.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numbers>
#include <utility>

namespace tandem {
namespace {

struct Evaluate {
  double t_s;

  double operator()(const ConstantLaw& law) const { return law.value; }

  double operator()(const RampLaw& law) const {
    if (t_s <= law.begin_s) return law.value_begin;
    if (t_s >= law.end_s) return law.value_end;
    const double s = (t_s - law.begin_s) / (law.end_s - law.begin_s);
    return law.value_begin + s * (law.value_end - law.value_begin);
  }

  double operator()(const HarmonicLaw& law) const {
    return law.offset + law.amplitude * std::sin(2.0 * std::numbers::pi * law.frequency_Hz * t_s +
                                                 law.phase_rad);
  }

  double operator()(const TableLaw& law) const {
    if (t_s <= law.times_s.front()) return law.values.front();
    if (t_s >= law.times_s.back()) return law.values.back();
    const auto after = std::ranges::upper_bound(law.times_s, t_s);
    const auto i = static_cast<std::size_t>(std::distance(law.times_s.begin(), after)) - 1;
    const double s = (t_s - law.times_s[i]) / (law.times_s[i + 1] - law.times_s[i]);
    return law.values[i] + s * (law.values[i + 1] - law.values[i]);
  }
};

/// The mean of a law that is linear between the knots is made of trapezoids.
struct Mean {
  double begin_s, end_s;

  double operator()(const ConstantLaw& law) const { return law.value; }

  double operator()(const RampLaw& law) const {
    return of_trapezoids(law, std::array{law.begin_s, law.end_s});
  }

  double operator()(const HarmonicLaw& law) const {
    const double half_angle = std::numbers::pi * law.frequency_Hz * (end_s - begin_s);
    const double middle = Evaluate{0.5 * (begin_s + end_s)}(law);
    return law.offset + (middle - law.offset) * std::sin(half_angle) / half_angle;
  }

  double operator()(const TableLaw& law) const { return of_trapezoids(law, law.times_s); }

  template <class L, class Knots>
  [[nodiscard]] double of_trapezoids(const L& law, const Knots& knots) const {
    double sum = 0.0;
    double t_s = begin_s;
    const auto add_until = [&](double next_s) {
      sum += 0.5 * (Evaluate{t_s}(law) + Evaluate{next_s}(law)) * (next_s - t_s);
      t_s = next_s;
    };
    for (const double knot_s : knots) {
      if (knot_s > t_s && knot_s < end_s) add_until(knot_s);
    }
    add_until(end_s);
    return sum / (end_s - begin_s);
  }
};

}  // namespace

double Law::operator()(double t_s) const { return std::visit(Evaluate{t_s}, law_); }

double Law::mean(double begin_s, double end_s) const {
  return std::visit(Mean{begin_s, end_s}, law_);
}

namespace scenario {
namespace {

void check_law(const Node& node) {
  const std::string kind = node.text("kind");
  if (kind == "ramp" && node.real("end_s") <= node.real("begin_s")) {
    node.fail("end_s", fmt::format("{} s is not after begin_s = {} s. The ramp needs a duration.",
                                   node.real("end_s"), node.real("begin_s")));
  }
  if (kind != "table") return;
  const std::vector<double> times = node.reals("times_s");
  const std::vector<double> values = node.reals("values");
  if (times.size() != values.size()) {
    node.fail("values", fmt::format("has {} numbers for {} times_s. Give one value per time.",
                                    values.size(), times.size()));
  }
  for (std::size_t i = 1; i < times.size(); ++i) {
    if (times[i] > times[i - 1]) continue;
    node.fail("times_s", fmt::format("entry {} ({} s) is not after entry {} ({} s). Times must "
                                     "increase strictly.",
                                     i, times[i], i - 1, times[i - 1]));
  }
}

Section law_section(const std::string& unit) {
  Section law;
  law.title = "Law";
  law.doc =
      "A prescribed function of time. A plain number is short for a constant law. Keys that the "
      "kind does not use are refused.";
  law.shorthand = "value";
  law.shared = true;
  law.check = check_law;
  law.keys = {
      choice("kind", {"constant", "ramp", "harmonic", "table"})
          .by_default("constant")
          .doc_is("Form of the function."),
      real("value", unit).must().only_when("kind", {"constant"}).doc_is("Value at all times."),
      real("begin_s", "s")
          .by_default("0")
          .only_when("kind", {"ramp"})
          .doc_is("Time until which the value is value_begin."),
      real("end_s", "s")
          .must()
          .only_when("kind", {"ramp"})
          .doc_is("Time from which the value is value_end; linear between."),
      real("value_begin", unit)
          .by_default("0")
          .only_when("kind", {"ramp"})
          .doc_is("Value before the ramp."),
      real("value_end", unit).must().only_when("kind", {"ramp"}).doc_is("Value after the ramp."),
      real("offset", unit)
          .by_default("0")
          .only_when("kind", {"harmonic"})
          .doc_is("Mean value c in c + a sin(2π f t + φ)."),
      real("amplitude", unit)
          .must()
          .only_when("kind", {"harmonic"})
          .doc_is("Amplitude a in c + a sin(2π f t + φ)."),
      real("frequency_Hz", "Hz")
          .must()
          .above(0)
          .only_when("kind", {"harmonic"})
          .doc_is("Frequency f in c + a sin(2π f t + φ)."),
      real("phase_rad", "rad")
          .by_default("0")
          .only_when("kind", {"harmonic"})
          .doc_is("Phase φ in c + a sin(2π f t + φ)."),
      reals("times_s", "s")
          .must()
          .at_least_count(1)
          .only_when("kind", {"table"})
          .doc_is("Times of the table, strictly increasing; constant before the first and after "
                  "the last."),
      reals("values", unit)
          .must()
          .at_least_count(1)
          .only_when("kind", {"table"})
          .doc_is("Values at times_s, linear between."),
  };
  return law;
}

}  // namespace

Key law(std::string name, std::string value_unit) {
  Key key = section(std::move(name), law_section(value_unit));
  key.unit = std::move(value_unit);
  return key;
}

Law read_law(const Node& node) {
  const std::string kind = node.text("kind");
  if (kind == "ramp") {
    return Law(RampLaw{.begin_s = node.real("begin_s"),
                       .end_s = node.real("end_s"),
                       .value_begin = node.real("value_begin"),
                       .value_end = node.real("value_end")});
  }
  if (kind == "harmonic") {
    return Law(HarmonicLaw{.offset = node.real("offset"),
                           .amplitude = node.real("amplitude"),
                           .frequency_Hz = node.real("frequency_Hz"),
                           .phase_rad = node.real("phase_rad")});
  }
  if (kind == "table") {
    return Law(TableLaw{.times_s = node.reals("times_s"), .values = node.reals("values")});
  }
  return Law(ConstantLaw{.value = node.real("value")});
}

}  // namespace scenario
}  // namespace tandem
