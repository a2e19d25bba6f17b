#include "orchestrator/run/local_run.h"

#include "protocol/driver/coupled_run.h"
#include "protocol/schemes/monolithic.h"

namespace tandem::orchestrator {

RunReport run_here(const Model& model, const RunDirectory& directory, Mode mode,
                   Recorder& recorder) {
  const auto mbs = make_mbs(model, directory.path());
  // The monolithic step couples the sides themselves, whatever stands between them in the scheme.
  Model plain = model;
  if (mode == Mode::Monolithic) plain.coupling.scheme = SchemeKind::InterfaceNewton;
  const auto fem = make_fem(plain, directory.path());
  CoupledRunParams params = scheme_run(model.run, model.coupling);
  params.energy_every_steps = scenario::read_output(model.scenario.root).energy_every_steps;
  if (mode == Mode::Monolithic) {
    params.scheme_name = "monolithic";
    params.make_scheme = [](std::vector<PortInfo> ports) {
      return std::make_unique<MonolithicStep>(std::move(ports));
    };
  }
  return run_coupled(params, {*mbs, Locality::Here}, {*fem, Locality::Here}, recorder);
}

}  // namespace tandem::orchestrator
