#pragma once

#include <string>
#include <string_view>

namespace tandem::fem {

/// What a keyword of an Abaqus or CalculiX deck is to the mesh.
enum class DeckKeyword {
  Node,
  Element,
  Nset,
  Elset,
  Surface,
  System,
  Part,
  EndPart,
  Assembly,
  EndAssembly,
  Instance,
  EndInstance,
  Material,
  Elastic,
  Density,
  SolidSection,
  ChangesMesh,  ///< makes or moves nodes or elements in a way that is not read
  Connects,     ///< ties nodes to each other, which this side does not do
  LeavesMesh,   ///< leaves nodes, elements and sets alone
  Unknown
};

/// `keyword` as DeckLine has it. Blanks do not count, as in CalculiX.
[[nodiscard]] DeckKeyword kind_of_keyword(std::string_view keyword);

/// " Did you mean *NODE?", for a keyword that is not known; empty when none is close.
[[nodiscard]] std::string keyword_meant(std::string_view keyword);

}  // namespace tandem::fem
