#include "fem_process/ancf/beam_system.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

namespace tandem::fem::ancf {
namespace {

/// Forces N, N m of one unit of acceleration g on the vectors of an element: ∫ ρ s_a dV.
Eigen::Matrix<double, kVectors, 1> mass_moments(
    const Eigen::Matrix<double, kVectors, kVectors>& mass) {
  // s1 + s5 = 1: the sum of the columns of r¹ and r².
  return mass.col(0) + mass.col(4);
}

Eigen::Matrix<double, kVectors, kVectors> mass_of(const BeamModel& model, std::size_t e) {
  const double length = model.mesh.elements[e].length_m;
  if (model.mesh.reference.empty()) {
    return mass_matrix(model.material.density_kg_per_m3, length, model.section);
  }
  return mass_matrix(model.material.density_kg_per_m3, length, model.section,
                     model.mesh.reference[e]);
}

}  // namespace

ColumnPattern BeamSystem::pattern_of(const BeamMesh& mesh) {
  std::vector<std::set<int>> rows(static_cast<std::size_t>(mesh.vectors));
  for (const BeamElement& element : mesh.elements) {
    for (const Term& a : element.terms) {
      for (const Term& b : element.terms) {
        rows[static_cast<std::size_t>(b.vector)].insert(a.vector);
      }
    }
  }
  ColumnPattern pattern{.size = mesh.unknowns()};
  pattern.column_start.push_back(0);
  for (const std::set<int>& column : rows) {
    for (int c = 0; c < 3; ++c) {
      for (int vector : column) {
        for (int i = 0; i < 3; ++i) pattern.row.push_back(3 * vector + i);
      }
      pattern.column_start.push_back(static_cast<int>(pattern.row.size()));
    }
  }
  return pattern;
}

BeamSystem::BeamSystem(BeamModel model)
    : model_(std::move(model)),
      kernel_(model_.mesh, model_.section, rule_laws(model_.material, model_.integration),
              model_.order, model_.strain),
      solver_(pattern_of(model_.mesh)) {
  list_blocks();
  list_masses();
}

void BeamSystem::list_blocks() {
  const ColumnPattern& pattern = solver_.pattern();
  const auto stride_of = [&](int vector) {
    const auto column = static_cast<std::size_t>(3 * vector);
    return pattern.column_start[column + 1] - pattern.column_start[column];
  };
  for (const BeamElement& element : mesh().elements) {
    std::vector<BlockTerm>& blocks = blocks_.emplace_back();
    for (const Term& a : element.terms) {
      for (const Term& b : element.terms) {
        blocks.push_back({3 * a.slot * kCoordinates + 3 * b.slot,
                          pattern.find(3 * a.vector, 3 * b.vector), stride_of(b.vector),
                          a.factor * b.factor});
      }
    }
  }
  for (int column = 0; column < pattern.size; ++column) {
    const auto at = static_cast<std::size_t>(column);
    for (int p = pattern.column_start[at]; p < pattern.column_start[at + 1]; ++p) {
      const int row = pattern.row[static_cast<std::size_t>(p)];
      const bool held = mesh().fixed[at / 3] || mesh().fixed[static_cast<std::size_t>(row) / 3];
      if (held) (row == column ? units_ : cleared_).push_back(p);
    }
  }
}

void BeamSystem::list_masses() {
  std::map<std::pair<int, int>, double> masses;
  gravity_forces_ = Eigen::VectorXd::Zero(mesh().unknowns());
  for (std::size_t e = 0; e < mesh().elements.size(); ++e) {
    const auto m = mass_of(model_, e);
    const auto moments = mass_moments(m);
    mass_kg_ += moments(0) + moments(4);
    for (const Term& a : mesh().elements[e].terms) {
      gravity_forces_.segment<3>(3 * a.vector) +=
          a.factor * moments(a.slot) * model_.gravity_m_per_s2;
      for (const Term& b : mesh().elements[e].terms) {
        const double mass = a.factor * b.factor * m(a.slot, b.slot);
        if (mass != 0.0) masses[{b.vector, a.vector}] += mass;
      }
    }
  }
  const ColumnPattern& pattern = solver_.pattern();
  for (const auto& [key, mass] : masses) {
    const auto [column, row] = key;
    const auto first = static_cast<std::size_t>(3 * column);
    masses_.push_back({row, column, mass, pattern.find(3 * row, 3 * column),
                       pattern.column_start[first + 1] - pattern.column_start[first]});
  }
}

ElementArrays BeamSystem::element_arrays() const {
  const std::size_t n = mesh().elements.size();
  return {std::vector<double>(n * kCoordinates),
          std::vector<double>(n * kCoordinates * kCoordinates)};
}

Eigen::VectorXd BeamSystem::mass_times(const Eigen::VectorXd& x) const {
  Eigen::VectorXd product = Eigen::VectorXd::Zero(x.size());
  for (const MassEntry& entry : masses_) {
    product.segment<3>(3 * entry.row) += entry.mass * x.segment<3>(3 * entry.column);
  }
  return product;
}

Eigen::Vector3d BeamSystem::momentum(const Eigen::VectorXd& v) const {
  Eigen::Vector3d momentum = Eigen::Vector3d::Zero();
  for (std::size_t e = 0; e < mesh().elements.size(); ++e) {
    momentum += mesh().gather(static_cast<int>(e), v) * mass_moments(mass_of(model_, e));
  }
  return momentum;
}

Eigen::VectorXd BeamSystem::load_forces(double t_s) const {
  Eigen::VectorXd f = Eigen::VectorXd::Zero(mesh().unknowns());
  for (const PointLoad& load : model_.loads) {
    const BeamElement& element = mesh().elements[static_cast<std::size_t>(load.element)];
    const auto s = shape_values(element.length_m, load.xi, 0.0, 0.0);
    const double factor = load.law(t_s);
    for (const Term& term : element.terms) {
      f.segment<3>(3 * term.vector) += term.factor * s(term.slot) * factor * load.force_N;
    }
  }
  return f;
}

Eigen::VectorXd BeamSystem::external_forces(double t_s) const {
  return model_.loads.empty() ? gravity_forces_
                              : Eigen::VectorXd(gravity_forces_ + load_forces(t_s));
}

void BeamSystem::add_forces(const ElementArrays& elements, Eigen::VectorXd& f) const {
  const double* force = elements.force.data();
  for (const BeamElement& element : mesh().elements) {
    for (const Term& term : element.terms) {
      double* to = f.data() + 3 * static_cast<std::ptrdiff_t>(term.vector);
      for (int c = 0; c < 3; ++c) to[c] += term.factor * force[3 * term.slot + c];
    }
    force += kCoordinates;
  }
}

void BeamSystem::sum(const ElementArrays& elements, double mass_factor,
                     std::vector<double>& values) const {
  values.assign(solver_.pattern().entries(), 0.0);
  for (const MassEntry& entry : masses_) {
    for (int c = 0; c < 3; ++c) {
      values[static_cast<std::size_t>(entry.position + c * entry.stride + c)] =
          mass_factor * entry.mass;
    }
  }
  const double* tangent = elements.tangent.data();
  for (const std::vector<BlockTerm>& blocks : blocks_) {
    for (const BlockTerm& block : blocks) {
      const double* from = tangent + block.element_entry;
      double* to = values.data() + block.position;
      for (int k = 0; k < 3; ++k) {
        for (int i = 0; i < 3; ++i) {
          to[k * block.stride + i] += block.factor * from[i * kCoordinates + k];
        }
      }
    }
    tangent += kCoordinates * kCoordinates;
  }
}

void BeamSystem::hold(std::vector<double>& values) const {
  for (int position : cleared_) values[static_cast<std::size_t>(position)] = 0.0;
  for (int position : units_) values[static_cast<std::size_t>(position)] = 1.0;
}

void BeamSystem::clear_fixed(Eigen::Ref<Eigen::VectorXd> x) const {
  for (std::size_t v = 0; v < mesh().fixed.size(); ++v) {
    if (mesh().fixed[v]) x.segment<3>(3 * static_cast<Eigen::Index>(v)).setZero();
  }
}

Equilibrium find_equilibrium(const BeamSystem& system, double t_s, double factor,
                             double tolerance_m, int most_iterations, Eigen::VectorXd& q) {
  ElementArrays elements = system.element_arrays();
  const Eigen::VectorXd rest = Eigen::VectorXd::Zero(q.size());
  const Eigen::VectorXd f_ext = factor * system.external_forces(t_s);
  std::vector<double> values;
  Equilibrium result;
  while (result.iterations < most_iterations) {
    ++result.iterations;
    if (system.kernel().tangents(q, rest, 0.0, elements) > 0) return result;
    Eigen::VectorXd change = Eigen::VectorXd::Zero(q.size());
    system.add_forces(elements, change);
    change = f_ext - change;
    system.clear_fixed(change);
    result.residual_N = change.cwiseAbs().maxCoeff();
    system.assemble(elements, 0.0, values);
    const auto factors = system.solver().factorize(values);
    if (!factors) return result;
    factors->solve(change);
    if (!change.allFinite()) return result;
    q += change;
    if (change.cwiseAbs().maxCoeff() < tolerance_m) {
      result.found = true;
      return result;
    }
  }
  return result;
}

}  // namespace tandem::fem::ancf
