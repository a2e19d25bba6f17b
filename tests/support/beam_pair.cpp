#include "tests/support/beam_pair.h"

#include <filesystem>
#include <utility>

#include "fem_process/ancf/make_beam_side.h"
#include "mbs_process/make_side.h"
#include "protocol/contract/error.h"
#include "protocol/scenario/override.h"
#include "protocol/schemes/transmission_line.h"

namespace tandem::coupled_test {
namespace {

class NoRecord final : public StepSink {
 public:
  double record(wire::StepJournal) override { return 0.0; }
};

BeamPair::Overrides parsed(const std::vector<std::string>& texts) {
  BeamPair::Overrides overrides;
  for (const std::string& text : texts) overrides.push_back(scenario::parse_override(text));
  return overrides;
}

}  // namespace

BeamPair::BeamPair(const std::string& scenario, const std::vector<std::string>& overrides)
    : model_(orchestrator::load_model(
          std::filesystem::path(TANDEM_SOURCE_DIR) / "examples" / scenario, parsed(overrides))),
      mbs_(mbs::make_side(model_.scenario.root, {})) {
  auto chain = fem::ancf::make_beam_side(model_.scenario.root, {});
  fem_ = chain.get();
  fem_side_ = prepared_for(model_.coupling, std::move(chain));
}

RunReport BeamPair::run(const Observer& observer) {
  // The flexible side is the last to be told that a step is accepted.
  fem_->on_accepted([&](const fem::ancf::BeamBody&) { observer(*this); });
  NoRecord sink;
  return run_coupled(scheme_run(model_.run, model_.coupling), {*mbs_, Locality::Here},
                     {*fem_side_, Locality::Here}, sink);
}

const mbs::BodyState& BeamPair::body(const std::string& name) const {
  for (std::size_t i = 0; i < mbs_->params().bodies.size(); ++i) {
    if (mbs_->params().bodies[i].name == name) return mbs_->state().bodies[i];
  }
  throw Error(ErrorKind::Usage, "no body " + name);
}

Eigen::Vector3d BeamPair::momentum() const {
  Eigen::Vector3d sum = fem_->system().momentum(fem_->state().v);
  for (std::size_t i = 0; i < mbs_->params().bodies.size(); ++i) {
    sum += mbs_->params().bodies[i].mass_kg * mbs_->state().bodies[i].v_WB;
  }
  return sum;
}

double BeamPair::mass_kg() const {
  double sum = fem_->system().mass_kg();
  for (const auto& body : mbs_->params().bodies) sum += body.mass_kg;
  return sum;
}

}  // namespace tandem::coupled_test
