#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "protocol/scenario/flexible_bodies.h"
#include "protocol/scenario/key_table.h"
#include "protocol/scenario/node.h"

namespace tandem::scenario {

/// The multibody worlds in the order of the scenario: one where `mbs` is a mapping or absent,
/// several where it is a list. A port belongs to the world that has its rigid body. Needs no more
/// of `mbs` than multibody_names_key(). Throws a Usage error at the place: a port whose body is in
/// no world, a body's name that two worlds have, a world without a port, names that are taken by
/// processes or flexible bodies.
[[nodiscard]] std::vector<BodyPorts> world_table(const Node& root);

/// One multibody world of a scenario.
struct MultibodyWorld {
  std::string name;  ///< empty where `mbs` is one mapping without a name
  /// The scenario as this world reads it: `mbs` is its own mapping, `ports` has its own ports
  /// alone.
  Node root;
  std::vector<std::size_t> ports;  ///< its ports' numbers in the table of all
};

/// The rows of world_table(), each with the scenario as the world reads it.
[[nodiscard]] std::vector<MultibodyWorld> multibody_worlds(const Node& root);

/// The worlds that one flexible body has ports on: `root` is the scenario as the body reads it, and
/// so is that of each, with the world's own mapping as `mbs`. `ports` count the body's.
[[nodiscard]] std::vector<MultibodyWorld> worlds_at(const Node& root);

/// The bodies of a world and its junctions, which ports, joints and springs name alike.
[[nodiscard]] std::vector<Node> frames_of(const Node& mbs);

/// `mbs` for a reader that wants to know its worlds' names and whose bodies are whose.
[[nodiscard]] Key multibody_names_key();

}  // namespace tandem::scenario
