#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "protocol/contract/sim_time.h"

namespace tandem::fem {

/// A DataArray in VTK's inline binary form: byte count (UInt32) and values, base64 together.
[[nodiscard]] std::string data_array_of_bytes(const std::string& name, const char* type,
                                              int components, std::span<const std::byte> values);

/// The same of numbers whose VTK type is `type`: Float64, Int32, UInt8.
template <class T>
[[nodiscard]] std::string data_array(const std::string& name, const char* type, int components,
                                     std::span<const T> values) {
  return data_array_of_bytes(name, type, components, std::as_bytes(values));
}

/// Writes every n-th state it is shown as NAME_<step>.vtu and keeps NAME.pvd, the ParaView
/// collection with their times, up to date.
class VtuSeries {
 public:
  /// Creates the folder.
  VtuSeries(std::filesystem::path folder, std::string name, std::int64_t every_steps);

  /// Whether the state that comes now is one to be written. Call once per state, the first
  /// included.
  [[nodiscard]] bool wants_next();
  /// Writes the text of the state that was wanted.
  void write(SimTime time, const std::string& vtu);

 private:
  void write_pvd() const;

  std::filesystem::path folder_;
  std::string name_;
  std::int64_t every_steps_;
  std::int64_t seen_ = 0;
  std::vector<std::pair<double, std::string>> written_;  // time (s), file name
};

}  // namespace tandem::fem
