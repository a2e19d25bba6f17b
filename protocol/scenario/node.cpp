#include "protocol/scenario/node.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "protocol/scenario/data.h"

namespace tandem::scenario {
namespace {

[[noreturn]] void defect_of_ours(const Data& data, std::string_view key, const char* what) {
  throw std::logic_error(
      fmt::format("scenario reader: '{}' {}", join_path(data.path_name, key), what));
}

/// Keys are few per section, so a linear search is as quick as any other.
const Key& row_of(const Data& data, std::string_view key) {
  const auto& keys = data.section->keys;
  const auto row = std::ranges::find(keys, key, &Key::name);
  if (row == keys.end()) defect_of_ours(data, key, "is not a key of the table");
  return *row;
}

template <class T>
const T& content_of(const Data& data, std::string_view key) {
  (void)row_of(data, key);
  const auto value = data.values.find(key);
  if (value == data.values.end()) defect_of_ours(data, key, "is left out; ask has() first");
  const T* content = std::get_if<T>(&value->second.content);
  if (content == nullptr) defect_of_ours(data, key, "is read as another type than the table's");
  return *content;
}

}  // namespace

std::string Place::text() const {
  return line > 0 ? fmt::format("{}:{}:{}", file, line, column) : file;
}

std::string join_path(std::string_view parent, std::string_view key) {
  if (parent.empty()) return std::string(key);
  if (key.empty()) return std::string(parent);
  return fmt::format("{}.{}", parent, key);
}

std::string defect_line(const Defect& defect) {
  if (defect.key.empty()) return fmt::format("{}: {}", defect.place.text(), defect.text);
  return fmt::format("{}: {}: {}", defect.place.text(), defect.key, defect.text);
}

DefectError::DefectError(Defect defect)
    : Error(ErrorKind::Usage, defect_line(defect)), defect_(std::move(defect)) {}

bool Node::has(std::string_view key) const {
  (void)row_of(*data_, key);
  return data_->values.contains(key);
}

double Node::real(std::string_view key) const { return content_of<double>(*data_, key); }

std::int64_t Node::integer(std::string_view key) const {
  return content_of<std::int64_t>(*data_, key);
}

bool Node::boolean(std::string_view key) const { return content_of<bool>(*data_, key); }

std::string Node::text(std::string_view key) const { return content_of<std::string>(*data_, key); }

std::filesystem::path Node::path(std::string_view key) const {
  if (row_of(*data_, key).type != Type::Path) defect_of_ours(*data_, key, "is not a path");
  return content_of<std::string>(*data_, key);
}

std::filesystem::path Node::input_file(std::string_view key) const {
  std::filesystem::path file = path(key);
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(file, error);
  if (!std::filesystem::exists(status) || access(file.c_str(), R_OK) != 0) {
    const int reason = std::filesystem::exists(status) ? errno : error.value();
    fail(key, fmt::format("'{}' cannot be read: {}. A relative path begins at the scenario's "
                          "folder.",
                          file.string(), std::generic_category().message(reason)));
  }
  if (!std::filesystem::is_regular_file(status)) {
    fail(key, fmt::format("'{}' is {}, not a file. Give a file: it is read more than once.",
                          file.string(),
                          std::filesystem::is_directory(status) ? "a folder" : "a pipe or device"));
  }
  return file;
}

std::vector<double> Node::reals(std::string_view key) const {
  return content_of<std::vector<double>>(*data_, key);
}

std::vector<std::string> Node::names(std::string_view key) const {
  return content_of<std::vector<std::string>>(*data_, key);
}

Eigen::Vector3d Node::vector3(std::string_view key) const {
  const auto& values = content_of<std::vector<double>>(*data_, key);
  if (values.size() != 3) defect_of_ours(*data_, key, "needs .count(3) in the table");
  return {values[0], values[1], values[2]};
}

Eigen::Quaterniond Node::quaternion_wxyz(std::string_view key) const {
  const auto& values = content_of<std::vector<double>>(*data_, key);
  if (values.size() != 4) defect_of_ours(*data_, key, "needs .count(4) in the table");
  const Eigen::Quaterniond q(values[0], values[1], values[2], values[3]);
  if (std::abs(q.norm() - 1.0) > 1e-3) {
    fail(key,
         fmt::format("has the norm {:.6g}. A quaternion [w, x, y, z] needs the norm 1.", q.norm()));
  }
  return q.normalized();
}

bool Node::holds_list(std::string_view key) const {
  (void)row_of(*data_, key);
  const auto value = data_->values.find(key);
  return value != data_->values.end() &&
         std::holds_alternative<std::vector<DataPtr>>(value->second.content);
}

Node Node::section(std::string_view key) const { return Node(content_of<DataPtr>(*data_, key)); }

std::vector<Node> Node::list(std::string_view key) const {
  std::vector<Node> nodes;
  for (const DataPtr& entry : content_of<std::vector<DataPtr>>(*data_, key)) {
    nodes.emplace_back(entry);
  }
  return nodes;
}

std::string Node::path_name(std::string_view key) const { return join_path(data_->path_name, key); }

Place Node::place(std::string_view key) const {
  const auto value = data_->values.find(key);
  return value == data_->values.end() ? data_->place : value->second.place;
}

void Node::fail(std::string_view key, const std::string& text) const {
  throw DefectError({place(key), path_name(key), text});
}

}  // namespace tandem::scenario
