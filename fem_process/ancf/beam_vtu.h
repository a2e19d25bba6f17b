#pragma once

#include <string>

#include "fem_process/ancf/beam_body.h"

namespace tandem::fem::ancf {

/// The present state as the text of a .vtu file: the swept section as hexahedra, each element cut
/// into `slices` along its axis; elements do not share points. Point data: velocity (m/s). Cell
/// data: axial strain |r_x| − 1 on the centre line, mean contact pressure on both faces of the
/// element (Pa), its index.
[[nodiscard]] std::string vtu_text(const BeamBody& body, int slices = 4);

}  // namespace tandem::fem::ancf
