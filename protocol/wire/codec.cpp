#include "protocol/wire/codec.h"

namespace tandem::wire::codec {
namespace {

void put(double (&to)[3], const Eigen::Vector3d& from) {
  for (int i = 0; i < 3; ++i) to[i] = from[i];
}
Eigen::Vector3d vector(const double (&from)[3]) { return {from[0], from[1], from[2]}; }

}  // namespace

bool size_fits(ByteView message, std::int64_t fixed_bytes,
               std::initializer_list<std::int64_t> element_bytes) {
  std::int64_t total = fixed_bytes;
  std::size_t at = kHeaderEnd;
  if (message.size() < kHeaderEnd + 4 * element_bytes.size()) return false;
  for (const std::int64_t bytes : element_bytes) {
    std::uint32_t number = 0;
    for (int i = 0; i < 4; ++i) number = (number << 8U) | message[at++];
    const auto elements = static_cast<std::int32_t>(number);
    if (elements < 0) return false;
    total += elements * bytes;
  }
  return total == static_cast<std::int64_t>(message.size());
}

tandem_wire::header_t pack(const Header& header) {
  tandem_wire::header_t packed;
  packed.checksum = 0;  // written by seal()
  packed.run_id = static_cast<std::int64_t>(header.run_id);
  packed.sequence = header.sequence;
  packed.macro_step = header.macro_step;
  packed.iteration = header.iteration;
  packed.kind = static_cast<std::int32_t>(header.kind);
  packed.attempt = header.attempt;
  packed.sender = static_cast<std::int32_t>(header.sender);
  packed.time_us = header.time_us;
  return packed;
}

Header unpack(const tandem_wire::header_t& packed) {
  Header header;
  header.checksum = static_cast<std::uint32_t>(packed.checksum);
  header.run_id = static_cast<std::uint64_t>(packed.run_id);
  header.sequence = packed.sequence;
  header.macro_step = packed.macro_step;
  header.iteration = packed.iteration;
  header.kind = static_cast<Kind>(packed.kind);
  header.attempt = packed.attempt;
  header.sender = static_cast<Process>(packed.sender);
  header.time_us = packed.time_us;
  return header;
}

std::vector<tandem_wire::motion_t> pack(const MotionSet& motions) {
  std::vector<tandem_wire::motion_t> packed(motions.size());
  for (std::size_t i = 0; i < motions.size(); ++i) {
    const Motion& motion = motions[i];
    put(packed[i].p_WP_m, motion.p_WP);
    packed[i].q_WP_wxyz[0] = motion.q_WP.w();
    packed[i].q_WP_wxyz[1] = motion.q_WP.x();
    packed[i].q_WP_wxyz[2] = motion.q_WP.y();
    packed[i].q_WP_wxyz[3] = motion.q_WP.z();
    put(packed[i].v_WP_m_per_s, motion.v_WP);
    put(packed[i].w_WP_rad_per_s, motion.w_WP);
  }
  return packed;
}

std::vector<tandem_wire::wrench_t> pack(const WrenchSet& wrenches) {
  std::vector<tandem_wire::wrench_t> packed(wrenches.size());
  for (std::size_t i = 0; i < wrenches.size(); ++i) {
    put(packed[i].f_P_W_N, wrenches[i].f_P_W);
    put(packed[i].t_P_W_Nm, wrenches[i].t_P_W);
  }
  return packed;
}

MotionSet unpack(const std::vector<tandem_wire::motion_t>& packed) {
  MotionSet motions(packed.size());
  for (std::size_t i = 0; i < packed.size(); ++i) {
    const double(&q)[4] = packed[i].q_WP_wxyz;
    motions[i].p_WP = vector(packed[i].p_WP_m);
    motions[i].q_WP = Eigen::Quaterniond(q[0], q[1], q[2], q[3]);
    motions[i].v_WP = vector(packed[i].v_WP_m_per_s);
    motions[i].w_WP = vector(packed[i].w_WP_rad_per_s);
  }
  return motions;
}

WrenchSet unpack(const std::vector<tandem_wire::wrench_t>& packed) {
  WrenchSet wrenches(packed.size());
  for (std::size_t i = 0; i < packed.size(); ++i) {
    wrenches[i].f_P_W = vector(packed[i].f_P_W_N);
    wrenches[i].t_P_W = vector(packed[i].t_P_W_Nm);
  }
  return wrenches;
}

}  // namespace tandem::wire::codec
