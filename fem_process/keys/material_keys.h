#pragma once

#include <Eigen/Core>
#include <vector>

#include "fem_process/material/materials.h"
#include "protocol/scenario/key_table.h"
#include "protocol/scenario/node.h"

namespace tandem::fem {

/// `fem.material`: one material for all elements.
[[nodiscard]] scenario::Key material_key();

/// `fem.materials`: materials by element set.
[[nodiscard]] scenario::Key materials_key();

/// Defect unless section `fem` has exactly one of the two.
void check_materials(const scenario::Node& fem);

/// One material; R_WM turns the axes of the mesh file into W.
[[nodiscard]] Material read_material(const scenario::Node& node, const Eigen::Matrix3d& R_WM);

[[nodiscard]] std::vector<MaterialSection> read_materials(const scenario::Node& fem,
                                                          const Eigen::Matrix3d& R_WM);

}  // namespace tandem::fem
