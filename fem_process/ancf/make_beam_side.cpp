#include "fem_process/ancf/make_beam_side.h"

#include <optional>

#include "fem_process/ancf/ancf_keys.h"
#include "fem_process/ancf/beam_csv.h"
#include "fem_process/ancf/beam_vtu.h"
#include "fem_process/output/vtk_xml.h"
#include "protocol/scenario/common_keys.h"

namespace tandem::fem::ancf {
namespace {

struct Files {
  BeamCsv csv;
  std::optional<VtuSeries> vtu;
};

}  // namespace

std::unique_ptr<BeamBody> make_beam_side(const scenario::Node& root,
                                         const std::filesystem::path& directory) {
  auto body = std::make_unique<BeamBody>(read_beam_params(root));
  if (directory.empty()) return body;
  std::filesystem::create_directories(directory);

  // shared_ptr: std::function must be copyable, although this one never is copied.
  auto files = std::make_shared<Files>(
      Files{.csv = BeamCsv(directory / "beam.csv", body->params().watch), .vtu = std::nullopt});
  const std::int64_t every_steps = scenario::read_output(root).vtu_every_steps;
  if (every_steps > 0) files->vtu.emplace(directory / "fem", "fem", every_steps);
  const SimTime end = scenario::read_run(root).duration;
  body->on_accepted([files, end](const BeamBody& accepted) {
    files->csv.write(accepted);
    if (files->vtu && files->vtu->wants_next()) {
      files->vtu->write(accepted.state().time, vtu_text(accepted));
    }
    if (accepted.state().time >= end) files->csv.finish();
  });
  return body;
}

}  // namespace tandem::fem::ancf
