#pragma once

#include <array>
#include <cmath>

namespace tandem::mbs::testing {

struct JacobiElliptic {
  double sn, cn, dn;
};

/// Jacobi's elliptic functions of argument u and modulus k, 0 ≤ k < 1, by the arithmetic-geometric
/// mean: a0 = 1, b0 = √(1 − k²), then φ_N = 2^N a_N u and sin(2 φ_{n−1} − φ_n) = (c_n/a_n) sin φ_n.
/// [Abramowitz & Stegun 1964, 16.4]
inline JacobiElliptic jacobi_elliptic(double u, double k) {
  constexpr std::size_t kMax = 12;  // the mean converges quadratically
  std::array<double, kMax> a{1.0};
  std::array<double, kMax> c{k};
  double b = std::sqrt(1.0 - k * k);
  std::size_t n = 0;
  while (n + 1 < kMax && std::abs(c[n]) > 1e-17) {
    a[n + 1] = 0.5 * (a[n] + b);
    c[n + 1] = 0.5 * (a[n] - b);
    b = std::sqrt(a[n] * b);
    ++n;
  }
  double phi = std::ldexp(a[n] * u, static_cast<int>(n));
  for (std::size_t i = n; i > 0; --i) {
    phi = 0.5 * (phi + std::asin(c[i] / a[i] * std::sin(phi)));
  }
  const double sn = std::sin(phi);
  return {sn, std::cos(phi), std::sqrt(1.0 - k * k * sn * sn)};
}

}  // namespace tandem::mbs::testing
