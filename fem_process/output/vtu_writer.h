#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "fem_process/body/model.h"
#include "fem_process/body/state.h"
#include "fem_process/output/vtk_xml.h"

namespace tandem::fem {

/// Writes every n-th state it is shown as NAME_<step>.vtu (XML UnstructuredGrid, base64 binary
/// arrays inline) and keeps NAME.pvd, the ParaView collection with their times, up to date.
/// Point data: displacement (m), velocity (m/s). Cell data: von Mises stress (Pa) of the
/// co-rotated stress, element rotation (rad).
class VtuWriter {
 public:
  /// Creates the folder. `model` must outlive the writer.
  VtuWriter(const Model& model, std::filesystem::path folder, std::string name,
            std::int64_t every_steps);

  /// Call once per accepted state, the first one included.
  void write(const State& state);

 private:
  const Model& model_;
  VtuSeries series_;
};

/// One state as the text of a .vtu file.
[[nodiscard]] std::string vtu_text(const Model& model, const State& state);

}  // namespace tandem::fem
