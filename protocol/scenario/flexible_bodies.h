#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "protocol/scenario/key_table.h"
#include "protocol/scenario/node.h"

namespace tandem::scenario {

/// Name and ports of a flexible body, or of a multibody world: a row of the table of sides.
struct BodyPorts {
  std::string name;                ///< empty where there is one mapping without a name
  std::vector<std::size_t> ports;  ///< numbers in the table of all ports
};

/// The flexible bodies in the order of the scenario: one where `fem` is a mapping, several where it
/// is a list. Each port then says which one it belongs to (`flexible`). Needs no more of `fem` than
/// the names. Throws a Usage error at the place: a port that names no body, a body without a port,
/// names that are taken by processes.
[[nodiscard]] std::vector<BodyPorts> body_table(const Node& root);

/// One flexible body of a scenario.
struct FlexibleBody {
  std::string name;  ///< empty where `fem` is one mapping without a name
  /// The scenario as this body reads it: `fem` is its own mapping, `ports` has its own ports alone.
  Node root;
  std::vector<std::size_t> ports;  ///< its ports' numbers in the table of all
};

/// The rows of body_table(), each with the scenario as the body reads it.
[[nodiscard]] std::vector<FlexibleBody> flexible_bodies(const Node& root);

/// `fem` for a reader that wants to know its bodies' names alone.
[[nodiscard]] Key flexible_names_key();

}  // namespace tandem::scenario
