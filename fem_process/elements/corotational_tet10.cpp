#include "fem_process/elements/corotational_tet10.h"

namespace tandem::fem {

CorotationalTet10::CorotationalTet10(const TetMesh& mesh, const Material& material,
                                     ThreadTeam* team)
    : general_(mesh, Materials(material)),
      kernel_(general_.elements(), general_.pattern(), material),
      alone_(team != nullptr ? nullptr : std::make_unique<ThreadTeam>()),
      team_(team != nullptr ? team : alone_.get()) {}

int CorotationalTet10::evaluate(const Eigen::VectorXd& x, Eigen::VectorXd& f_int,
                                BlockValues& K) const {
  return kernel_.evaluate(x, f_int, K, *team_);
}

Eigen::VectorXd CorotationalTet10::derivative(const Eigen::VectorXd& x, const Eigen::VectorXd& y,
                                              const Eigen::VectorXd& dx) const {
  return kernel_.derivatives(x, y, dx, *team_);
}

Eigen::MatrixXd CorotationalTet10::derivatives(const Eigen::VectorXd& x,
                                               const Eigen::MatrixXd& dx) const {
  return kernel_.derivatives(x, Eigen::VectorXd::Zero(x.size()), dx, *team_);
}

double CorotationalTet10::energy(const Eigen::VectorXd& x) const {
  return kernel_.energy(x, *team_);
}

std::vector<ElementResult> CorotationalTet10::element_results(const Eigen::VectorXd& x) const {
  return general_.element_results(x);
}

}  // namespace tandem::fem
