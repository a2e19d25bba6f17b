#include <algorithm>
#include <numeric>

#include "fem_process/elements/corotational_lanes.h"
#include "fem_process/elements/tet10_lanes.h"
#include "fem_process/matrix/node_vectors.h"

/// What Tet10Kernel finds beside forces and stiffness.
namespace tandem::fem {
namespace {

/// Batches that a thread takes at a time.
constexpr std::size_t kGrain = 8;

/// What all directions share at an integration point.
template <class Lanes>
struct Turned {
  LaneMatrix<Lanes> R;
  Lanes Z[9];
  Lanes sigma[9];      ///< V C : (Z − I)
  Lanes T_inverse[9];  ///< (tr U I − U)⁻¹, zero where a lane is inverted
  Lanes volume;
};

template <class Lanes>
TANDEM_INLINE void invert_spin(const Lanes (&U)[9], int inverted, Lanes (&T_inverse)[9]) {
  const Lanes trace = U[0] + U[4] + U[8];
  LaneMatrix<Lanes> T;
  LaneMatrix<Lanes> c;
  for (int k = 0; k < 9; ++k) T.at[k] = k % 4 == 0 ? trace - U[k] : -U[k];
  cofactor(T, c);
  Lanes factor = 1.0 / (T.at[0] * c.at[0] + T.at[1] * c.at[1] + T.at[2] * c.at[2]);
  if (inverted != 0) {
    double factors[kLanes];
    store(factor, factors);
    for (int n = 0; n < kLanes; ++n) {
      if ((inverted >> n & 1) != 0) factors[n] = 0.0;
    }
    load(factor, factors);
  }
  for (int k = 0; k < 9; ++k) T_inverse[k] = factor * c.at[3 * (k % 3) + k / 3];
}

template <class Lanes>
TANDEM_INLINE void turn_point(const Tet10Kernel::Point& point, const Lanes (&edge)[27],
                              const Lanes (&edge_whole)[27], double lambda, double mu,
                              Turned<Lanes>& turned) {
  LaneMatrix<Lanes> F;
  gradient_at(point, edge, F);
  const int inverted = polar_lanes(F, turned.R);
  Lanes U[9];
  turn_back(turned.R, F, U);
  invert_spin(U, inverted, turned.T_inverse);
  gradient_at(point, edge_whole, F);
  turn_back(turned.R, F, turned.Z);
  load(turned.volume, point.volume.data());
  corotated_stress(turned.Z, turned.volume, lambda, mu, turned.sigma);
}

/// [w] M, row by row.
template <class Lanes>
TANDEM_INLINE void cross(const Lanes (&w)[3], const Lanes (&M)[9], Lanes (&product)[9]) {
  for (int b = 0; b < 3; ++b) {
    product[b] = w[1] * M[6 + b] - w[2] * M[3 + b];
    product[3 + b] = w[2] * M[b] - w[0] * M[6 + b];
    product[6 + b] = w[0] * M[3 + b] - w[1] * M[b];
  }
}

/// Adds one direction's share of a point to the forces of nodes 1 … 9, which begin at row 3.
template <class Lanes>
TANDEM_INLINE void add_direction(const Tet10Kernel::Point& point, const Turned<Lanes>& turned,
                                 const Lanes (&edge)[27], double lambda, double mu,
                                 double (&force)[30][kLanes]) {
  LaneMatrix<Lanes> dF;
  gradient_at(point, edge, dF);
  Lanes A[9];
  turn_back(turned.R, dF, A);
  const Lanes axial[3] = {A[7] - A[5], A[2] - A[6], A[3] - A[1]};
  const Lanes* T = turned.T_inverse;
  Lanes w[3];
  for (int a = 0; a < 3; ++a) {
    w[a] = T[3 * a] * axial[0] + T[3 * a + 1] * axial[1] + T[3 * a + 2] * axial[2];
  }
  Lanes spun[9];
  Lanes P[9];
  cross(w, turned.Z, spun);
  cross(w, turned.sigma, P);
  for (int k = 0; k < 9; ++k) A[k] = A[k] - spun[k];
  const Lanes pressure = lambda * turned.volume * (A[0] + A[4] + A[8]);
  const Lanes shear = mu * turned.volume;
  for (int k = 0; k < 9; ++k) {
    P[k] += shear * (A[k] + A[3 * (k % 3) + k / 3]);
    if (k % 4 == 0) P[k] += pressure;
  }
  for (int a = 0; a < 3; ++a) {
    Lanes row[3];
    turned_row(turned.R, P, a, row);
    for (std::size_t i = 0; i < 9; ++i) {
      Lanes sum;
      load(sum, force[3 * i + 3 + static_cast<std::size_t>(a)]);
      for (std::size_t b = 0; b < 3; ++b) {
        Lanes g;
        load(g, point.gradient[3 * i + b].data());
        sum += row[b] * g;
      }
      store(sum, force[3 * i + 3 + static_cast<std::size_t>(a)]);
    }
  }
}

/// Positions x, x + y and up to four directions, null where there is none.
struct Fields {
  const Padded* x = nullptr;
  const Padded* whole = nullptr;
  const Padded* dx[4] = {};
};

/// Forces of one batch along the directions, side by side.
template <class Registers>
TANDEM_INLINE void derive_batch(const Tet10Kernel::Batch& batch, double lambda, double mu,
                                const Fields& fields, FourVectors* f) {
  using Lanes = typename Registers::Double8;
  Lanes edge[27];
  Lanes edge_whole[27];
  Lanes edge_dx[4][27];
  gather_edges<Registers>(batch, fields.x, edge);
  gather_edges<Registers>(batch, fields.whole, edge_whole);
  for (int c = 0; c < 4; ++c) {
    if (fields.dx[c] != nullptr) gather_edges<Registers>(batch, fields.dx[c], edge_dx[c]);
  }
  double force[4][30][kLanes] = {};
  for (const Tet10Kernel::Point& point : batch.points) {
    Turned<Lanes> turned;
    turn_point(point, edge, edge_whole, lambda, mu, turned);
    for (int c = 0; c < 4; ++c) {
      if (fields.dx[c] != nullptr) {
        add_direction(point, turned, edge_dx[c], lambda, mu, force[c]);
      }
    }
  }
  for (auto& direction : force) {
    for (int row = 3; row < 30; ++row) {
      for (int n = 0; n < kLanes; ++n) direction[row % 3][n] -= direction[row][n];
    }
  }
  for (int row = 0; row < 30; ++row) scatter_four<Registers>(force, row, f);
}

template <class Registers>
TANDEM_INLINE void derive_body(const Tet10Kernel::Batch* batch, std::size_t count, double lambda,
                               double mu, const Fields& fields, FourVectors* f) {
  for (std::size_t b = 0; b < count; ++b) {
    derive_batch<Registers>(batch[b], lambda, mu, fields, f + 10 * kLanes * b);
  }
}

TANDEM_REGISTER_FUNCTION(derive_batches, derive_body,
                         (const Tet10Kernel::Batch* batch, std::size_t count, double lambda,
                          double mu, const Fields& fields, FourVectors* f),
                         (batch, count, lambda, mu, fields, f))

/// Energy of one batch.
template <class Registers>
TANDEM_INLINE double energy_of(const Tet10Kernel::Batch& batch, double lambda, double mu,
                               const Padded* x) {
  using Lanes = typename Registers::Double8;
  Lanes edge[27];
  gather_edges<Registers>(batch, x, edge);
  Lanes twice{};
  for (const Tet10Kernel::Point& point : batch.points) {
    LaneMatrix<Lanes> F;
    LaneMatrix<Lanes> R;
    gradient_at(point, edge, F);
    polar_lanes(F, R);
    Lanes A[9];
    Lanes sigma[9];
    Lanes volume;
    load(volume, point.volume.data());
    turn_back(R, F, A);
    corotated_stress(A, volume, lambda, mu, sigma);
    for (int k = 0; k < 9; ++k) twice += sigma[k] * (k % 4 == 0 ? A[k] - 1.0 : A[k]);
  }
  double lanes[kLanes];
  store(twice, lanes);
  double sum = 0.0;
  for (int n = 0; n < batch.count; ++n) sum += lanes[n];
  return 0.5 * sum;
}

template <class Registers>
TANDEM_INLINE void energy_body(const Tet10Kernel::Batch* batch, std::size_t count, double lambda,
                               double mu, const Padded* x, double* energy) {
  for (std::size_t b = 0; b < count; ++b) {
    energy[b] = energy_of<Registers>(batch[b], lambda, mu, x);
  }
}

TANDEM_REGISTER_FUNCTION(energy_of_batches, energy_body,
                         (const Tet10Kernel::Batch* batch, std::size_t count, double lambda,
                          double mu, const Padded* x, double* energy),
                         (batch, count, lambda, mu, x, energy))

}  // namespace

Eigen::MatrixXd Tet10Kernel::derivatives(const Eigen::VectorXd& x, const Eigen::VectorXd& y,
                                         const Eigen::MatrixXd& dx, ThreadTeam& team) const {
  // Kept between calls: fresh memory of this size costs more than the arithmetic.
  static thread_local std::vector<Padded> positions;
  static thread_local std::vector<Padded> whole;
  static thread_local std::vector<Padded> directions[4];
  static thread_local std::vector<FourVectors> f;
  pad(x, positions);
  pad(x + y, whole);
  f.resize(10 * kLanes * batches_.size());
  FourVectors* const all_f = f.data();  // the helpers have thread-local vectors of their own
  Eigen::MatrixXd changes(dx.rows(), dx.cols());
  for (Eigen::Index first = 0; first < dx.cols(); first += 4) {
    const Eigen::Index count = std::min<Eigen::Index>(4, dx.cols() - first);
    Fields fields{positions.data(), whole.data(), {}};
    for (Eigen::Index c = 0; c < count; ++c) {
      pad(dx.col(first + c), directions[c]);
      fields.dx[c] = directions[c].data();
    }
    team.run_ranges(batches_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
      derive_batches(batches_.data() + begin, end - begin, lambda_, mu_, fields,
                     all_f + 10 * kLanes * begin);
    });
    assembly_.gather_forces(f, changes, first, count, team);
  }
  return changes;
}

double Tet10Kernel::energy(const Eigen::VectorXd& x, ThreadTeam& team) const {
  std::vector<Padded> positions;
  pad(x, positions);
  std::vector<double> energies(batches_.size());
  team.run_ranges(batches_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    energy_of_batches(batches_.data() + begin, end - begin, lambda_, mu_, positions.data(),
                      energies.data() + begin);
  });
  return std::accumulate(energies.begin(), energies.end(), 0.0);
}

}  // namespace tandem::fem
