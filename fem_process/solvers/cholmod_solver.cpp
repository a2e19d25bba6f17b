#include "fem_process/solvers/cholmod_solver.h"

#include <cholmod.h>
#include <dlfcn.h>

#include <algorithm>
#include <string>
#include <vector>

#include "protocol/contract/error.h"

// Of the OpenMP runtime that CHOLMOD itself is linked to. Declared here because <omp.h> belongs to
// the compiler's OpenMP, which need not be installed.
extern "C" {
int omp_get_max_active_levels();
void omp_set_max_active_levels(int levels);
}

namespace tandem::fem {
namespace {

/// Runs the enclosed CHOLMOD calls on one thread.
class SerialOpenMp {
 public:
  SerialOpenMp() : levels_(omp_get_max_active_levels()) { omp_set_max_active_levels(0); }
  ~SerialOpenMp() { omp_set_max_active_levels(levels_); }
  SerialOpenMp(const SerialOpenMp&) = delete;
  SerialOpenMp& operator=(const SerialOpenMp&) = delete;

 private:
  int levels_;
};

/// OpenBLAS is one of several libraries that may serve as BLAS: its thread count is set when it is
/// the one that is loaded.
void use_one_blas_thread() {
  using SetThreads = void (*)(int);
  const auto set = reinterpret_cast<SetThreads>(dlsym(RTLD_DEFAULT, "openblas_set_num_threads"));
  if (set != nullptr) set(1);
}

}  // namespace

std::vector<int> fill_reducing_order(const BlockPattern& pattern) {
  const auto n = static_cast<std::size_t>(pattern.rows());
  std::vector<int> order(n);
  std::vector<int> parent(n);
  std::vector<int> member(n);
  cholmod_common common{};
  cholmod_start(&common);
  common.print = 0;
  // The pattern is symmetric; the upper triangle by columns is read, the rest ignored.
  cholmod_sparse* graph =
      cholmod_allocate_sparse(n, n, pattern.blocks(), 1, 1, 1, CHOLMOD_PATTERN, &common);
  bool found = false;
  if (graph != nullptr) {
    std::copy(pattern.row_start.begin(), pattern.row_start.end(), static_cast<int*>(graph->p));
    std::copy(pattern.column.begin(), pattern.column.end(), static_cast<int*>(graph->i));
    found = cholmod_nested_dissection(graph, nullptr, 0, order.data(), parent.data(), member.data(),
                                      &common) >= 0 ||
            cholmod_amd(graph, nullptr, 0, order.data(), &common) != 0;
  }
  const int status = common.status;
  cholmod_free_sparse(&graph, &common);
  cholmod_finish(&common);
  require(found, "fem: CHOLMOD cannot order the step matrix (status " + std::to_string(status) +
                     "). Use a coarser mesh.");
  return order;
}

struct CholmodSolver::Handles {
  cholmod_common common{};
  cholmod_sparse* matrix = nullptr;  // lower triangle by columns
  cholmod_factor* factor = nullptr;
  cholmod_dense* solution = nullptr;
  cholmod_dense* work_y = nullptr;
  cholmod_dense* work_e = nullptr;
  std::vector<std::size_t> source;  // position in BlockValues of each entry

  Handles() { cholmod_start(&common); }
  ~Handles() {
    cholmod_free_dense(&work_e, &common);
    cholmod_free_dense(&work_y, &common);
    cholmod_free_dense(&solution, &common);
    cholmod_free_factor(&factor, &common);
    cholmod_free_sparse(&matrix, &common);
    cholmod_finish(&common);
  }
  Handles(const Handles&) = delete;
  Handles& operator=(const Handles&) = delete;

  void fill_pattern(const BlockPattern& pattern);
};

/// Column 3 J + k of the lower triangle holds entries (3 I + r, 3 J + k) = A_JI(k, r), I ≥ J: the
/// pattern's row J read as a column.
void CholmodSolver::Handles::fill_pattern(const BlockPattern& pattern) {
  std::vector<int> start{0};
  std::vector<int> row;
  for (int J = 0; J < pattern.rows(); ++J) {
    const auto at = static_cast<std::size_t>(J);
    for (int k = 0; k < 3; ++k) {
      for (int b = pattern.row_start[at]; b < pattern.row_start[at + 1]; ++b) {
        const int I = pattern.column[static_cast<std::size_t>(b)];
        for (int r = I == J ? k : 0; I >= J && r < 3; ++r) {
          row.push_back(3 * I + r);
          source.push_back(9 * static_cast<std::size_t>(b) + static_cast<std::size_t>(3 * k + r));
        }
      }
      start.push_back(static_cast<int>(row.size()));
    }
  }
  const std::size_t n = 3 * static_cast<std::size_t>(pattern.rows());
  matrix = cholmod_allocate_sparse(n, n, row.size(), 1, 1, -1, CHOLMOD_REAL, &common);
  require(matrix != nullptr, "fem: not enough memory for the step matrix. Use a coarser mesh.");
  std::copy(start.begin(), start.end(), static_cast<int*>(matrix->p));
  std::copy(row.begin(), row.end(), static_cast<int*>(matrix->i));
}

CholmodSolver::CholmodSolver(const BlockPattern& pattern) : handles_(std::make_unique<Handles>()) {
  use_one_blas_thread();
  const SerialOpenMp serial;
  cholmod_common& common = handles_->common;
  common.print = 0;
  common.supernodal = CHOLMOD_SUPERNODAL;
  handles_->fill_pattern(pattern);
  std::vector<int> order;
  for (int node : fill_reducing_order(pattern)) {
    for (int k = 0; k < 3; ++k) order.push_back(3 * node + k);
  }
  common.nmethods = 1;
  common.method[0].ordering = CHOLMOD_GIVEN;
  handles_->factor = cholmod_analyze_p(handles_->matrix, order.data(), nullptr, 0, &common);
  require(handles_->factor != nullptr && common.status == CHOLMOD_OK,
          "fem: CHOLMOD cannot analyse the step matrix (status " + std::to_string(common.status) +
              "). Use fem.solver.kind: pcg.");
}

CholmodSolver::~CholmodSolver() = default;

SolveReport CholmodSolver::factorize(const BlockValues& A,
                                     const std::vector<NodeRotation>& /*rotations*/) {
  const SerialOpenMp serial;
  auto* values = static_cast<double*>(handles_->matrix->x);
  for (std::size_t i = 0; i < handles_->source.size(); ++i) values[i] = A[handles_->source[i]];
  cholmod_factorize(handles_->matrix, handles_->factor, &handles_->common);
  if (handles_->common.status == CHOLMOD_OK && handles_->factor->minor == handles_->factor->n) {
    return {};
  }
  if (handles_->common.status == CHOLMOD_NOT_POSDEF) {
    return {.outcome = Outcome::Failed,
            .message = "the step matrix is not positive definite (row " +
                       std::to_string(handles_->factor->minor) + "). Halve fem.micro_step_s."};
  }
  return {.outcome = Outcome::Failed,
          .message = "CHOLMOD cannot factorise the step matrix (status " +
                     std::to_string(handles_->common.status) + "). Use fem.solver.kind: pcg."};
}

SupernodalFactor CholmodSolver::factor() const {
  const cholmod_factor& L = *handles_->factor;
  const auto ints = [](const void* from, std::size_t count) {
    const auto* first = static_cast<const int*>(from);
    return std::vector<int>(first, first + count);
  };
  const auto* x = static_cast<const double*>(L.x);
  return {.permutation = ints(L.Perm, L.n),
          .first_column = ints(L.super, L.nsuper + 1),
          .row_start = ints(L.pi, L.nsuper + 1),
          .row = ints(L.s, L.ssize),
          .value_start = ints(L.px, L.nsuper + 1),
          .value = std::vector<double>(x, x + L.xsize)};
}

SolveReport CholmodSolver::solve(Eigen::MatrixXd& r, const Eigen::VectorXd& /*b_norms*/) {
  const SerialOpenMp serial;
  cholmod_dense rhs{};
  rhs.nrow = static_cast<std::size_t>(r.rows());
  rhs.ncol = static_cast<std::size_t>(r.cols());
  rhs.nzmax = rhs.nrow * rhs.ncol;
  rhs.d = rhs.nrow;
  rhs.x = r.data();
  rhs.xtype = CHOLMOD_REAL;
  rhs.dtype = CHOLMOD_DOUBLE;
  Handles& h = *handles_;
  if (cholmod_solve2(CHOLMOD_A, h.factor, &rhs, nullptr, &h.solution, nullptr, &h.work_y, &h.work_e,
                     &h.common) == 0) {
    return {.outcome = Outcome::Failed,
            .message = "CHOLMOD cannot solve (status " + std::to_string(h.common.status) +
                       "). Use fem.solver.kind: pcg."};
  }
  const auto* x = static_cast<const double*>(h.solution->x);
  std::copy(x, x + rhs.nzmax, r.data());
  return {};
}

}  // namespace tandem::fem
