#include "fem_process/solvers/pcg_columns.h"

#include <fmt/format.h>

namespace tandem::fem {
namespace {

constexpr std::size_t kWidth = 8;
/// Nodes that a thread takes, and whose products are summed, at a time.
constexpr std::size_t kColumnGroup = 256;

/// Unknowns [begin, end).
template <class Registers>
TANDEM_INLINE void dot_body(const double* a, const double* b, std::size_t begin, std::size_t end,
                            double* products) {
  using Lanes = typename Registers::Double8;
  Lanes sum{};
  for (std::size_t i = begin; i < end; ++i) {
    Lanes a_i;
    Lanes b_i;
    load(a_i, a + kWidth * i);
    load(b_i, b + kWidth * i);
    sum += a_i * b_i;
  }
  store(sum, products);
}

template <class Registers>
TANDEM_INLINE void turn_body(const double* betas, const double* z, double* p, std::size_t begin,
                             std::size_t end) {
  using Lanes = typename Registers::Double8;
  Lanes beta;
  load(beta, betas);
  for (std::size_t i = begin; i < end; ++i) {
    Lanes z_i;
    Lanes p_i;
    load(z_i, z + kWidth * i);
    load(p_i, p + kWidth * i);
    p_i = z_i + beta * p_i;
    store(p_i, p + kWidth * i);
  }
}

template <class Registers>
TANDEM_INLINE void step_body(const double* alphas, const double* p, const double* Ap, double* x,
                             double* r, std::size_t begin, std::size_t end, double* squares) {
  using Lanes = typename Registers::Double8;
  Lanes alpha;
  load(alpha, alphas);
  Lanes sum{};
  for (std::size_t i = begin; i < end; ++i) {
    Lanes p_i;
    Lanes Ap_i;
    Lanes x_i;
    Lanes r_i;
    load(p_i, p + kWidth * i);
    load(Ap_i, Ap + kWidth * i);
    load(x_i, x + kWidth * i);
    load(r_i, r + kWidth * i);
    x_i += alpha * p_i;
    r_i = r_i - alpha * Ap_i;
    store(x_i, x + kWidth * i);
    store(r_i, r + kWidth * i);
    sum += r_i * r_i;
  }
  store(sum, squares);
}

/// Nodes [begin, end) of z = D⁻¹ r and of r · z; the inverse blocks are symmetric.
template <class Registers>
TANDEM_INLINE void jacobi_body(const Padded* inverse, const double* r, double* z, std::size_t begin,
                               std::size_t end, double* products) {
  using Lanes = typename Registers::Double8;
  Lanes sum{};
  for (std::size_t i = begin; i < end; ++i) {
    Lanes r_i[3];
    for (std::size_t a = 0; a < 3; ++a) load(r_i[a], r + kWidth * (3 * i + a));
    for (std::size_t b = 0; b < 3; ++b) {
      const double* column = inverse[3 * i + b].at;
      const Lanes z_b = column[0] * r_i[0] + column[1] * r_i[1] + column[2] * r_i[2];
      store(z_b, z + kWidth * (3 * i + b));
      sum += r_i[b] * z_b;
    }
  }
  store(sum, products);
}

TANDEM_REGISTER_FUNCTION(dot, dot_body,
                         (const double* a, const double* b, std::size_t begin, std::size_t end,
                          double* products),
                         (a, b, begin, end, products))
TANDEM_REGISTER_FUNCTION(turn, turn_body,
                         (const double* betas, const double* z, double* p, std::size_t begin,
                          std::size_t end),
                         (betas, z, p, begin, end))
TANDEM_REGISTER_FUNCTION(move, step_body,
                         (const double* alphas, const double* p, const double* Ap, double* x,
                          double* r, std::size_t begin, std::size_t end, double* squares),
                         (alphas, p, Ap, x, r, begin, end, squares))
TANDEM_REGISTER_FUNCTION(jacobi, jacobi_body,
                         (const Padded* inverse, const double* r, double* z, std::size_t begin,
                          std::size_t end, double* products),
                         (inverse, r, z, begin, end, products))

}  // namespace

template <class Work>
PcgColumns::Eight PcgColumns::sum_groups(ThreadTeam& team, std::size_t nodes, const Work& work) {
  sums_.resize(kWidth * ((nodes + kColumnGroup - 1) / kColumnGroup));
  team.run_ranges(nodes, kColumnGroup, [&](std::size_t begin, std::size_t end) {
    work(begin, end, sums_.data() + kWidth * (begin / kColumnGroup));
  });
  Eight total = Eight::Zero();
  for (std::size_t k = 0; k < sums_.size(); k += kWidth) {
    total += Eigen::Map<const Eight>(sums_.data() + k);
  }
  return total;
}

PcgColumns::Eight PcgColumns::precondition(const PcgSystem& system, const Eight& residual,
                                           int columns, const EightVectors& r) {
  if (system.rest != nullptr) {
    return system.rest->solve_eight(r, residual, columns, system.rotations, z_, scratch_,
                                    system.team);
  }
  return sum_groups(system.team, static_cast<std::size_t>(r.cols()) / 3,
                    [&](std::size_t begin, std::size_t end, double* sums) {
                      jacobi(system.inverse_diagonal.data(), r.data(), z_.data(), begin, end, sums);
                    });
}

SolveReport PcgColumns::solve(const PcgSystem& system, const Eight& limits, int columns,
                              int max_iterations, EightVectors& r, EightVectors& x) {
  const auto nodes = static_cast<std::size_t>(r.cols()) / 3;
  x.setZero(8, r.cols());
  p_.setZero(8, r.cols());
  z_.resize(8, r.cols());
  Eight residual =
      sum_groups(system.team, nodes, [&](std::size_t begin, std::size_t end, double* sums) {
        dot(r.data(), r.data(), 3 * begin, 3 * end, sums);
      }).sqrt();
  SolveReport report;
  Eight rz = Eight::Ones();
  const auto unsolved = [&] { return (residual > limits).eval(); };
  for (int k = 0; unsolved().any() && k < max_iterations; ++k) {
    const Eigen::Array<bool, 8, 1> active = unsolved();
    const Eight rz_next = precondition(system, residual, columns, r);
    const Eight beta = active.select(rz_next / rz, Eight::Zero());
    rz = active.select(rz_next, Eight::Ones());
    system.team.run_ranges(nodes, kColumnGroup, [&](std::size_t begin, std::size_t end) {
      turn(beta.data(), z_.data(), p_.data(), 3 * begin, 3 * end);
    });
    multiply_eight(system.pattern, system.A, p_, Ap_, system.team);
    const Eight curvature =
        sum_groups(system.team, nodes, [&](std::size_t begin, std::size_t end, double* sums) {
          dot(p_.data(), Ap_.data(), 3 * begin, 3 * end, sums);
        });
    if ((active && !(curvature > 0.0)).any()) {
      return {.outcome = Outcome::Failed,
              .message = "the step matrix is not positive definite. Halve fem.micro_step_s.",
              .iterations = report.iterations};
    }
    const Eight alpha = active.select(rz / curvature, Eight::Zero());
    residual =
        sum_groups(system.team, nodes, [&](std::size_t begin, std::size_t end, double* sums) {
          move(alpha.data(), p_.data(), Ap_.data(), x.data(), r.data(), 3 * begin, 3 * end, sums);
        }).sqrt();
    report.iterations += static_cast<int>(active.count());
  }
  if ((residual <= limits).all()) return report;
  Eigen::Index worst = 0;
  (residual - limits).maxCoeff(&worst);
  report.outcome = Outcome::NotConverged;
  report.message = fmt::format(
      "PCG: residual {:.3g} N, limit {:.3g} N after {} iterations. Raise "
      "fem.solver.max_iterations or use fem.solver.kind: cholmod.",
      residual[worst], limits[worst], max_iterations);
  return report;
}

}  // namespace tandem::fem
