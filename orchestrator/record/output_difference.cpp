#include "orchestrator/record/output_difference.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

namespace tandem::orchestrator {
namespace {

constexpr std::array<const char*, 13> kMotionComponents{
    "p_x_m",         "p_y_m",         "p_z_m",        "q_w",         "q_x",
    "q_y",           "q_z",           "v_x_m_per_s",  "v_y_m_per_s", "v_z_m_per_s",
    "w_x_rad_per_s", "w_y_rad_per_s", "w_z_rad_per_s"};
constexpr std::array<const char*, 6> kWrenchComponents{"f_x_N",  "f_y_N",  "f_z_N",
                                                       "t_x_Nm", "t_y_Nm", "t_z_Nm"};

std::array<double, 13> values_of(const Motion& m) {
  return {m.p_WP.x(), m.p_WP.y(), m.p_WP.z(), m.q_WP.w(), m.q_WP.x(), m.q_WP.y(), m.q_WP.z(),
          m.v_WP.x(), m.v_WP.y(), m.v_WP.z(), m.w_WP.x(), m.w_WP.y(), m.w_WP.z()};
}

std::array<double, 6> values_of(const Wrench& w) {
  return {w.f_P_W.x(), w.f_P_W.y(), w.f_P_W.z(), w.t_P_W.x(), w.t_P_W.y(), w.t_P_W.z()};
}

bool same(double logged, double replayed, double tolerance) {
  if (std::bit_cast<std::uint64_t>(logged) == std::bit_cast<std::uint64_t>(replayed)) return true;
  return std::abs(replayed - logged) <= tolerance * std::max(1.0, std::abs(logged)) &&
         tolerance > 0.0;
}

template <class Set, class Names>
std::string find_difference(const Set& logged, const Set& replayed, const Names& names,
                            const std::vector<std::string>& ports, double tolerance) {
  if (logged.size() != replayed.size()) {
    return fmt::format("logged {} ports, replayed {}", logged.size(), replayed.size());
  }
  for (std::size_t i = 0; i < logged.size(); ++i) {
    const auto a = values_of(logged[i]);
    const auto b = values_of(replayed[i]);
    for (std::size_t c = 0; c < a.size(); ++c) {
      if (same(a[c], b[c], tolerance)) continue;
      return fmt::format("port '{}', {}: logged {}, replayed {} (difference {:.3g})", ports.at(i),
                         names[c], a[c], b[c], b[c] - a[c]);
    }
  }
  return {};
}

}  // namespace

std::string first_difference(const MotionSet& logged, const MotionSet& replayed,
                             const std::vector<std::string>& ports, double tolerance) {
  return find_difference(logged, replayed, kMotionComponents, ports, tolerance);
}

std::string first_difference(const WrenchSet& logged, const WrenchSet& replayed,
                             const std::vector<std::string>& ports, double tolerance) {
  return find_difference(logged, replayed, kWrenchComponents, ports, tolerance);
}

}  // namespace tandem::orchestrator
