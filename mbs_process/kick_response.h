#pragma once

#include <Eigen/SparseCholesky>
#include <vector>

#include "mbs_process/joint_rows.h"
#include "mbs_process/kick.h"
#include "mbs_process/params.h"

namespace tandem::mbs {

/// How the twists after a dWorldStep follow what acts in it, from one factorisation of the step's
/// own system: with W = M⁻¹ and the rows that act (all of the joints, stops that press, motors
/// that do not yield),
///   V⁺ = V + h W (F + Jᵀ μ),   J V⁺ + cfm μ = c,   so   (J W Jᵀ + cfm / h) μ = c / h − J (V / h +
///   W F).
/// Which rows act is what ODE found. The rows themselves are JointGeometry's: that they are those
/// of ODE is seen from ODE's own V⁺, which they must give as well.
///
/// Cost: J W Jᵀ has an entry for each pair of rows that share a body; its Cholesky factor of a
/// chain or tree is linear in the bodies, and so is each response.
class KickResponse {
 public:
  KickResponse(const Params& params, const std::vector<JointGeometry>& joints, const Kick& kick);
  KickResponse(const KickResponse&) = delete;
  KickResponse& operator=(const KickResponse&) = delete;

  /// Whether the rows give what ODE gave, to 1e-9 of the terms that make each body's twist
  /// and 1e-12 of those of all bodies.
  [[nodiscard]] bool reproduces_step() const { return reproduces_; }

  /// δV⁺ by δF (columns; 6 rows per body, [f | t] about its centre of mass).
  [[nodiscard]] Eigen::MatrixXd twists(const Eigen::MatrixXd& forces);
  /// Whether a stop or motor comes within a factor of two of taking hold, letting go or yielding
  /// when `size` of column `column` of the last twists() is added: it is no response then.
  [[nodiscard]] bool switches(Eigen::Index column, double size) const;

 private:
  struct Row {
    TwistRow J = TwistRow::Zero();
    Eigen::Matrix<double, 12, 1> WJ = Eigen::Matrix<double, 12, 1>::Zero();  ///< W Jᵀ
    Eigen::Index first = 0, second = -1;  ///< where the bodies' twists begin; −1: world
    double cfm = 0.0, rhs = 0.0;          ///< c
    bool bounded = false;                 ///< a stop, or a motor that may yield
    bool acts = true;                     ///< else it rests at `effort`
    double most = 0.0;                    ///< effort at which it yields; of a stop 0: it lets go
    double effort = 0.0;                  ///< μ
    double slack = 0.0;                   ///< of the effort, or of the rate of a row that rests
  };

  [[nodiscard]] Row row_of(const JointGeometry& joint, const TwistRow& J) const;
  void add_joint_rows(const Kick& kick, const JointGeometry& joint);
  void add_effort_row(const Params& params, const Kick& kick, const EffortRow& effort);
  [[nodiscard]] const Row& acting(Eigen::Index k) const {
    return rows_[acting_[static_cast<std::size_t>(k)]];
  }
  bool factorise();
  void check_against(const Params& params, const Kick& kick);
  /// What the rows that act add to each twist, sizes without signs.
  [[nodiscard]] Eigen::VectorXd kicks_of_rows() const;
  void find_slacks(const Eigen::VectorXd& twists);

  /// h W F
  [[nodiscard]] Eigen::MatrixXd free_twists(const Eigen::MatrixXd& forces) const;
  /// V⁺ of the rows with the right sides `rhs`, from `free` = V + h W F; leaves μ in efforts_.
  [[nodiscard]] Eigen::MatrixXd solved(const Eigen::MatrixXd& free, const Eigen::MatrixXd& rhs);
  void add_efforts(Eigen::Index column, Eigen::MatrixXd& twists) const;
  [[nodiscard]] static double product(const Row& row,
                                      const Eigen::Ref<const Eigen::VectorXd>& twists);

  const std::vector<JointGeometry>& joints_;
  double h_s_;
  std::vector<Eigen::Matrix3d> inverse_inertia_W_;
  std::vector<double> inverse_mass_;
  std::vector<Row> rows_;
  std::vector<std::size_t> acting_;  ///< of rows_
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower, Eigen::AMDOrdering<int>> factor_;
  bool reproduces_ = false;
  Eigen::MatrixXd twists_, efforts_;  ///< of the last twists(); efforts of those that act
};

}  // namespace tandem::mbs
