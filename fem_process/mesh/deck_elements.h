#pragma once

#include <cstddef>
#include <string_view>

namespace tandem::fem {

/// What an element type of Abaqus or CalculiX is to a mesh of tetrahedra.
enum class DeckShape {
  Tetrahedron,  ///< read
  Triangle,     ///< passed over as an element; its sets are surfaces
  Line,         ///< passed over; its sets have its nodes
  Other,        ///< passed over: quadrilaterals, springs, masses, gaps …; its sets have its nodes
  Solid         ///< refused: bricks, wedges, pyramids hold volume that would be missing
};

struct DeckElementType {
  DeckShape shape = DeckShape::Other;
  /// Of one element; zero where that is not known and a row is an element.
  std::size_t nodes = 0;
};

/// Of a type in upper case. Variants of tetrahedra that differ in their interpolation of stress
/// or pressure alone (C3D10M, C3D4H, DC3D10 …) are tetrahedra.
[[nodiscard]] DeckElementType deck_element_type(std::string_view type);

}  // namespace tandem::fem
