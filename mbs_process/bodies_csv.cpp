#include "mbs_process/bodies_csv.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <iterator>
#include <utility>

#include "protocol/contract/error.h"

namespace tandem::mbs {
namespace {

std::string header_of(const std::vector<std::string>& names) {
  std::string header = "t_s";
  for (const std::string& name : names) {
    for (const char* column :
         {"p_x_m", "p_y_m", "p_z_m", "q_w", "q_x", "q_y", "q_z", "v_x_m_per_s", "v_y_m_per_s",
          "v_z_m_per_s", "w_x_rad_per_s", "w_y_rad_per_s", "w_z_rad_per_s"}) {
      fmt::format_to(std::back_inserter(header), ",{}.{}", name, column);
    }
  }
  return header;
}

void append_row(const State& state, std::string& row) {
  auto to = std::back_inserter(row);
  fmt::format_to(to, "{}", to_seconds(state.time));
  for (const BodyState& body : state.bodies) {
    const Eigen::Quaterniond& q = body.q_WB;
    for (double x : body.p_WB) fmt::format_to(to, ",{}", x);
    fmt::format_to(to, ",{},{},{},{}", q.w(), q.x(), q.y(), q.z());
    for (double x : body.v_WB) fmt::format_to(to, ",{}", x);
    for (double x : body.w_WB) fmt::format_to(to, ",{}", x);
  }
  row += '\n';
}

}  // namespace

BodiesCsv::BodiesCsv(std::filesystem::path file, std::vector<std::string> body_names,
                     std::int64_t every_steps)
    : file_(std::move(file)), stream_(file_), every_steps_(every_steps) {
  require(every_steps > 0, "mbs: rows of bodies.csv need a positive number of steps between them.");
  stream_ << header_of(body_names) << '\n';
  finish();
}

void BodiesCsv::write(const State& state) {
  if (last_time_ == state.time) return;
  last_time_ = state.time;
  if (accepted_++ % every_steps_ != 0) return;
  std::string row;
  append_row(state, row);
  stream_ << row;
  require_good();
}

void BodiesCsv::finish() {
  stream_.flush();
  require_good();
}

void BodiesCsv::require_good() {
  if (stream_.good()) return;
  throw Error(ErrorKind::System,
              fmt::format("mbs: cannot write {}: {}. Check the folder and the free space.",
                          file_.string(), std::strerror(errno)));
}

}  // namespace tandem::mbs
