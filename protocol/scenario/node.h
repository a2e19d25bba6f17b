#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/scenario/key_table.h"

namespace tandem::scenario {

/// Where a value stands in a file; line and column count from 1, 0 = a --set value. A default
/// stands where the mapping stands that leaves it out.
struct Place {
  std::string file;
  int line = 0;
  int column = 0;
  [[nodiscard]] std::string text() const;  ///< "lug/scenario.yaml:12:7"
};

struct Data;  // one validated mapping, see data.h

/// A validated mapping of a scenario: every key is known, typed, in range and has its default, so
/// readers ask and never check. Asking for a key that the table does not have is a defect of ours
/// and throws std::logic_error; so is asking for an optional key that is left out: ask has() first.
class Node {
 public:
  explicit Node(std::shared_ptr<const Data> data) : data_(std::move(data)) {}

  [[nodiscard]] bool has(std::string_view key) const;
  [[nodiscard]] double real(std::string_view key) const;
  [[nodiscard]] std::int64_t integer(std::string_view key) const;
  [[nodiscard]] bool boolean(std::string_view key) const;
  [[nodiscard]] std::string text(std::string_view key) const;            ///< Text, Name and Choice
  [[nodiscard]] std::filesystem::path path(std::string_view key) const;  ///< resolved, absolute
  /// The path of a file that can be read, by any number of processes: a missing one, a folder, a
  /// pipe and a device are the scenario's error, at its place.
  [[nodiscard]] std::filesystem::path input_file(std::string_view key) const;
  [[nodiscard]] std::vector<double> reals(std::string_view key) const;
  [[nodiscard]] std::vector<std::string> names(std::string_view key) const;
  [[nodiscard]] Eigen::Vector3d vector3(std::string_view key) const;
  /// Reads [w, x, y, z] and normalises. Fails at the place when the norm is off by more than 1e-3.
  [[nodiscard]] Eigen::Quaterniond quaternion_wxyz(std::string_view key) const;
  [[nodiscard]] Node section(std::string_view key) const;
  /// Whether a list stands where one mapping may (Key::or_several): then ask for list().
  [[nodiscard]] bool holds_list(std::string_view key) const;
  [[nodiscard]] std::vector<Node> list(std::string_view key) const;

  /// The mapping itself, for what walks through all of them.
  [[nodiscard]] const Data& data() const { return *data_; }

  /// Name from the root, as --set takes it: "mbs.bodies.crank", with `key` appended when given.
  [[nodiscard]] std::string path_name(std::string_view key = {}) const;

  /// Place of a key's value, or of the mapping itself when `key` is empty or left out.
  [[nodiscard]] Place place(std::string_view key = {}) const;

  /// Throws a Usage error "file:line:column: key: text", key as path_name(), for what the table
  /// cannot express.
  [[noreturn]] void fail(std::string_view key, const std::string& text) const;

 private:
  std::shared_ptr<const Data> data_;
};

/// The name in `known` nearest to `given` by edit distance, as " Did you mean 'x'?", or "".
[[nodiscard]] std::string did_you_mean(std::string_view given,
                                       const std::vector<std::string>& known);

}  // namespace tandem::scenario
