#include "fem_process/body/boundary.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "protocol/contract/error.h"

namespace tandem::fem {
namespace {

constexpr const char* kCommands =
    "Say 'release SET', 'fix SET' or 'force SET FX,FY,FZ' (N, three numbers with commas).";

Eigen::Vector3d parse_force(const std::string& text) {
  Eigen::Vector3d force;
  const char* at = text.data();
  const char* const end = at + text.size();
  for (int axis = 0; axis < 3; ++axis) {
    const std::from_chars_result read = std::from_chars(at, end, force[axis]);
    const bool last = axis == 2;
    require(read.ec == std::errc{} && std::isfinite(force[axis]) &&
                (last ? read.ptr == end : read.ptr != end && *read.ptr == ','),
            "fem: '" + text + "' is no force. " + kCommands);
    at = read.ptr + (last ? 0 : 1);
  }
  return force;
}

}  // namespace

Boundary changed(const Boundary& boundary, const std::string& command, const TetMesh& mesh) {
  Boundary after = boundary;
  const std::size_t space = command.find(' ');
  const std::string verb = command.substr(0, space);
  std::string set = space == std::string::npos ? "" : command.substr(space + 1);
  const auto held = std::find(after.fixed.begin(), after.fixed.end(), set);
  if (verb == "release") {
    static_cast<void>(find_set(mesh, {.name = set}));
    require(held != after.fixed.end(), "fem: the set '" + set +
                                           "' is not fixed: there is nothing "
                                           "to release.");
    after.fixed.erase(held);
  } else if (verb == "fix") {
    static_cast<void>(find_set(mesh, {.name = set}));
    require(held == after.fixed.end(), "fem: the set '" + set + "' is fixed already.");
    after.fixed.push_back(set);
  } else if (verb == "force") {
    // The last word: names of sets may hold spaces.
    const std::size_t last = set.rfind(' ');
    const bool named = last != std::string::npos;
    const Eigen::Vector3d total_N = parse_force(named ? set.substr(last + 1) : set);
    set.resize(named ? last : 0);
    static_cast<void>(find_set(mesh, {.name = set}));
    std::erase_if(after.forces, [&](const Boundary::Force& force) { return force.set == set; });
    if (!total_N.isZero(0.0)) after.forces.push_back({set, total_N});
  } else {
    throw Error(ErrorKind::Usage, "fem: '" + command + "' is no command. " + kCommands);
  }
  return after;
}

std::string force_command(const Eigen::Vector3d& total_N, const std::string& set) {
  std::string text = "force " + set;
  for (int axis = 0; axis < 3; ++axis) {
    std::array<char, 32> digits{};
    const auto end = std::to_chars(digits.begin(), digits.end(), total_N[axis]).ptr;
    text += axis == 0 ? ' ' : ',';
    text.append(digits.begin(), end);
  }
  return text;
}

void add_forces(const Boundary& boundary, const TetMesh& mesh, Eigen::VectorXd& f) {
  for (const Boundary::Force& force : boundary.forces) {
    const std::vector<int>& nodes = find_set(mesh, {.name = force.set}).nodes;
    const Eigen::Vector3d share = force.total_N / static_cast<double>(nodes.size());
    for (int node : nodes) f.segment<3>(3 * node) += share;
  }
}

}  // namespace tandem::fem
