#include "tests/support/coupled_pair.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "fem_process/sides/make_model.h"
#include "mbs_process/make_side.h"
#include "orchestrator/run/step_tables.h"
#include "protocol/contract/error.h"
#include "protocol/driver/composite_side.h"
#include "protocol/schemes/monolithic.h"
#include "protocol/schemes/transmission_line.h"

namespace tandem::coupled_test {
namespace {

class ObservingSink final : public StepSink {
 public:
  explicit ObservingSink(const CoupledPair::Observer& observer) : observer_(observer) {}

  double record(wire::StepJournal journal) override {
    if (journal.step.outcome != Outcome::Done) return 0.0;
    orchestrator::AcceptedInterface interface = orchestrator::accepted_interface(journal);
    Sample sample{.t_s = to_seconds(journal.step.time),
                  .motions = std::move(interface.motions),
                  .wrenches = std::move(interface.wrenches),
                  .iterations = journal.step.iterations,
                  .residual_N = journal.step.residual_N};
    for (const wire::CallRecord& call : journal.calls) {
      if (call.accepted && call.kind == wire::CallKind::Advance &&
          call.side == wire::SideName::Mbs) {
        sample.applied = call.wrenches.end;
      }
    }
    observer_(sample);
    return 0.0;
  }

 private:
  const CoupledPair::Observer& observer_;
};

Eigen::VectorXd nodal_momenta(const fem::FlexibleSide& body) {
  return fem::multiply_scalar(body.model().pattern(), body.model().mass, body.nodal_state().v);
}

/// p, q, v, w, f, t of one port.
std::array<Eigen::VectorXd, 6> quantities(const Sample& sample, std::size_t port) {
  const Motion& m = sample.motions[port];
  const Wrench& w = sample.wrenches[port];
  return {m.p_WP, m.q_WP.coeffs(), m.v_WP, m.w_WP, w.f_P_W, w.t_P_W};
}

/// Of one quantity of a port in two runs, largest over all steps: its norm in the first, and the
/// difference.
struct Gap {
  double norm = 0.0;
  double difference = 0.0;
};
using QuantityGaps = std::array<Gap, 6>;

QuantityGaps gaps_of(const std::vector<Sample>& a, const std::vector<Sample>& b, std::size_t port) {
  QuantityGaps gaps{};
  for (std::size_t n = 0; n < a.size(); ++n) {
    const auto qa = quantities(a[n], port);
    const auto qb = quantities(b[n], port);
    for (std::size_t k = 0; k < gaps.size(); ++k) {
      // Index 1 is a quaternion: q and −q are one rotation.
      const double distance = k == 1 ? std::min((qa[k] - qb[k]).norm(), (qa[k] + qb[k]).norm())
                                     : (qa[k] - qb[k]).norm();
      gaps[k].norm = std::max(gaps[k].norm, qa[k].norm());
      gaps[k].difference = std::max(gaps[k].difference, distance);
    }
  }
  return gaps;
}

/// What tests compare with each other is iterated to round-off unless they say otherwise.
CoupledPair::Overrides exact(const CoupledPair::Overrides& overrides) {
  CoupledPair::Overrides all{{"run.accuracy", "1e-10"}};
  all.insert(all.end(), overrides.begin(), overrides.end());
  return all;
}

}  // namespace

CoupledPair::CoupledPair(const std::string& scenario, const Overrides& overrides)
    : model_(orchestrator::load_model(
          std::filesystem::path(TANDEM_SOURCE_DIR) / "examples" / scenario, exact(overrides))) {
  std::vector<MbsPart> worlds;
  for (const scenario::MultibodyWorld& world : model_.worlds) {
    auto side = mbs::make_side(world.root, {});
    worlds_.push_back(side.get());
    worlds.push_back({world.name, std::move(side), world.ports});
  }
  mbs_ = composed(std::move(worlds));
  std::vector<FemPart> parts;
  for (const scenario::FlexibleBody& body : model_.bodies) {
    auto side = fem::make_model(body.root, {});
    // Chains have no mesh.
    if (const auto* meshed = dynamic_cast<const fem::FlexibleSide*>(side.get())) {
      meshed_.push_back(meshed);
    }
    parts.push_back({body.name, prepared_for(model_.coupling, std::move(side)), body.ports});
  }
  fem_ = composed(std::move(parts));
}

RunReport CoupledPair::run(orchestrator::Mode mode, const Observer& observer) {
  CoupledRunParams params = scheme_run(model_.run, model_.coupling);
  if (mode == orchestrator::Mode::Monolithic) {
    params.scheme_name = "monolithic";
    params.make_scheme = [](std::vector<PortInfo> ports) {
      return std::make_unique<MonolithicStep>(std::move(ports));
    };
  }
  ObservingSink sink(observer);
  return run_coupled(params, {*mbs_, Locality::Here}, {*fem_, Locality::Here}, sink);
}

Eigen::Vector3d CoupledPair::linear_momentum() const {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const mbs::RigidWorld* world : worlds_) {
    for (std::size_t i = 0; i < world->params().bodies.size(); ++i) {
      if (world->params().bodies[i].massless) continue;
      sum += world->params().bodies[i].mass_kg * world->state().bodies[i].v_WB;
    }
  }
  for (const fem::FlexibleSide* body : meshed_) {
    const Eigen::VectorXd momenta = nodal_momenta(*body);
    for (Eigen::Index row = 0; row < momenta.size(); row += 3) sum += momenta.segment<3>(row);
  }
  return sum;
}

Eigen::Vector3d CoupledPair::angular_momentum() const {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const mbs::RigidWorld* world : worlds_) {
    for (std::size_t i = 0; i < world->params().bodies.size(); ++i) {
      const mbs::BodyParams& params = world->params().bodies[i];
      if (params.massless) continue;
      const mbs::BodyState& body = world->state().bodies[i];
      const Eigen::Matrix3d R_WB = body.q_WB.toRotationMatrix();
      sum += params.mass_kg * body.p_WB.cross(body.v_WB) +
             R_WB * params.inertia_B() * R_WB.transpose() * body.w_WB;
    }
  }
  for (const fem::FlexibleSide* body : meshed_) {
    const fem::State state = body->nodal_state();
    const Eigen::VectorXd momenta = nodal_momenta(*body);
    for (Eigen::Index row = 0; row < momenta.size(); row += 3) {
      sum += state.x.segment<3>(row).cross(momenta.segment<3>(row));
    }
  }
  return sum;
}

std::string text_of(double value) { return fmt::format("{}", value); }

RelativeDifference largest_relative_difference(const std::vector<Sample>& a,
                                               const std::vector<Sample>& b, Scale scale) {
  require(a.size() == b.size() && !a.empty(), "two runs of different length");
  std::vector<QuantityGaps> gaps;
  QuantityGaps any{};
  for (std::size_t port = 0; port < a.front().motions.size(); ++port) {
    gaps.push_back(gaps_of(a, b, port));
    for (std::size_t k = 0; k < any.size(); ++k) {
      any[k].norm = std::max(any[k].norm, gaps.back()[k].norm);
    }
  }
  RelativeDifference largest;
  for (const QuantityGaps& own : gaps) {
    for (std::size_t k = 0; k < own.size(); ++k) {
      const double norm = scale == Scale::AnyPort ? any[k].norm : own[k].norm;
      double& kind = k < 4 ? largest.motions : largest.wrenches;
      if (norm > 0.0) kind = std::max(kind, own[k].difference / norm);
    }
  }
  return largest;
}

}  // namespace tandem::coupled_test
