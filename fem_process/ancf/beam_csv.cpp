#include "fem_process/ancf/beam_csv.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <iterator>
#include <utility>

#include "protocol/contract/error.h"

namespace tandem::fem::ancf {

BeamCsv::BeamCsv(std::filesystem::path file, const std::vector<WatchPoint>& watch)
    : file_(std::move(file)), stream_(file_) {
  std::string header =
      "t_s,kinetic_J,elastic_J,potential_J,ground_f_x_N,ground_f_y_N,ground_f_z_N,wheel_depth_m,"
      "ground_depth_m,seated_pins,newton_iterations";
  for (const WatchPoint& point : watch) {
    for (const char* column :
         {"p_x_m", "p_y_m", "p_z_m", "v_x_m_per_s", "v_y_m_per_s", "v_z_m_per_s"}) {
      fmt::format_to(std::back_inserter(header), ",{}.{}", point.name, column);
    }
  }
  stream_ << header << '\n';
  finish();
}

void BeamCsv::write(const BeamBody& body) {
  const BeamState& state = body.state();
  if (state.time == last_) return;
  last_ = state.time;
  const ContactSums& sums = body.sums();
  std::string row = fmt::format("{},{},{},{},{},{},{},{},{},{},{}", to_seconds(last_),
                                body.system().kinetic_J(state.v), body.system().elastic_J(state.q),
                                body.system().potential_J(state.q), sums.ground.x(),
                                sums.ground.y(), sums.ground.z(), sums.depth_m, sums.ground_depth_m,
                                sums.seated_pins, body.effort().iterations);
  for (const WatchPoint& point : body.params().watch) {
    const BeamBody::PointMotion motion = body.motion_of(point);
    for (const Eigen::Vector3d& values : {motion.r, motion.v}) {
      for (double x : values) fmt::format_to(std::back_inserter(row), ",{}", x);
    }
  }
  stream_ << row << '\n';
}

void BeamCsv::finish() {
  stream_.flush();
  if (!stream_) {
    throw Error(ErrorKind::System,
                fmt::format("fem: cannot write {}: {}. Check the folder and the free space.",
                            file_.string(), std::strerror(errno)));
  }
}

}  // namespace tandem::fem::ancf
