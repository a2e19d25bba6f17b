#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "protocol/contract/error.h"
#include "protocol/scenario/key_table.h"
#include "protocol/scenario/node.h"
#include "protocol/scenario/yaml_tree.h"

namespace tandem::scenario {

using DataPtr = std::shared_ptr<const Data>;

/// What one key holds after validation. Text stands for Text, Name, Choice and Path (absolute).
struct Value {
  Place place;
  std::variant<double, std::int64_t, bool, std::string, std::vector<double>,
               std::vector<std::string>, DataPtr, std::vector<DataPtr>>
      content;
};

/// One validated mapping. Keys that are left out and have no default are not in `values`.
struct Data {
  Place place;
  std::string path_name;                   ///< from the root, "" for the root itself
  std::shared_ptr<const Section> section;  ///< its rows of the table
  std::map<std::string, Value, std::less<>> values;
};

/// What Node::fail() throws while the file is loaded: collected with the defects of the table.
class DefectError final : public Error {
 public:
  explicit DefectError(Defect defect);
  [[nodiscard]] const Defect& defect() const { return defect_; }

 private:
  Defect defect_;
};

/// "place: key: text", the line the user reads.
[[nodiscard]] std::string defect_line(const Defect& defect);

/// "mbs.bodies" + "crank" → "mbs.bodies.crank".
[[nodiscard]] std::string join_path(std::string_view parent, std::string_view key);

}  // namespace tandem::scenario
