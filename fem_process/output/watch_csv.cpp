#include "fem_process/output/watch_csv.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <iterator>
#include <utility>

#include "protocol/contract/error.h"

namespace tandem::fem {
namespace {

/// A column's name, in double quotes where a set's name would break the row [RFC 4180].
std::string column_name(const std::string& set, const char* column) {
  std::string name = fmt::format("{}.{}", set, column);
  if (name.find_first_of(",\"\n\r") == std::string::npos) return name;
  for (std::size_t at = 0; (at = name.find('"', at)) != std::string::npos; at += 2) {
    name.insert(at, 1, '"');
  }
  return '"' + name + '"';
}

}  // namespace

WatchCsv::WatchCsv(std::filesystem::path file, std::vector<std::string> node_sets)
    : file_(std::move(file)), node_sets_(std::move(node_sets)), stream_(file_) {
  std::string header = "t_s";
  for (const std::string& set : node_sets_) {
    for (const char* column : {"p_x_m", "p_y_m", "p_z_m", "u_x_m", "u_y_m", "u_z_m", "v_x_m_per_s",
                               "v_y_m_per_s", "v_z_m_per_s"}) {
      header += ',' + column_name(set, column);
    }
  }
  stream_ << header << '\n';
  finish();
}

void WatchCsv::write(const Model& model, const State& state) {
  if (state.time == last_) return;
  last_ = state.time;
  std::string row = fmt::format("{}", to_seconds(last_));
  for (const std::string& set : node_sets_) {
    const MeanMotion mean = mean_motion(model, state, set);
    for (const Eigen::Vector3d& values :
         {mean.position_m, mean.displacement_m, mean.velocity_m_per_s}) {
      for (double x : values) fmt::format_to(std::back_inserter(row), ",{}", x);
    }
  }
  stream_ << row << '\n';
}

void WatchCsv::finish() {
  stream_.flush();
  if (!stream_) {
    throw Error(ErrorKind::System,
                fmt::format("fem: cannot write {}: {}. Check the folder and the free space.",
                            file_.string(), std::strerror(errno)));
  }
}

}  // namespace tandem::fem
