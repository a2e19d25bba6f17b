#include "protocol/wire/arrays.h"

#include <algorithm>
#include <bit>
#include <cstring>

namespace tandem::wire {
namespace {

std::uint64_t swapped(std::uint64_t word) {
  if constexpr (std::endian::native == std::endian::big) return word;
  return __builtin_bswap64(word);
}

std::uint8_t* put(std::uint8_t* at, const double* values, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint64_t word = swapped(std::bit_cast<std::uint64_t>(values[i]));
    std::memcpy(at + 8 * i, &word, 8);
  }
  return at + 8 * count;
}

const std::uint8_t* get(const std::uint8_t* at, double* values, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    std::uint64_t word = 0;
    std::memcpy(&word, at + 8 * i, 8);
    values[i] = std::bit_cast<double>(swapped(word));
  }
  return at + 8 * count;
}

/// Zero when these bits stand there.
template <std::size_t kCount>
std::uint64_t differing_bits(const std::uint8_t* at, const double* values) {
  std::uint64_t bits = 0;
  for (std::size_t i = 0; i < kCount; ++i) {
    std::uint64_t word = 0;
    std::memcpy(&word, at + 8 * i, 8);
    bits |= swapped(word) ^ std::bit_cast<std::uint64_t>(values[i]);
  }
  return bits;
}

std::uint64_t differing_bits(const std::uint8_t* at, const Motion& motion) {
  const Eigen::Vector4d& xyzw = motion.q_WP.coeffs();
  return differing_bits<3>(at, motion.p_WP.data()) | differing_bits<1>(at + 24, xyzw.data() + 3) |
         differing_bits<3>(at + 32, xyzw.data()) | differing_bits<3>(at + 56, motion.v_WP.data()) |
         differing_bits<3>(at + 80, motion.w_WP.data());
}

std::uint64_t differing_bits(const std::uint8_t* at, const Wrench& wrench) {
  return differing_bits<3>(at, wrench.f_P_W.data()) |
         differing_bits<3>(at + 24, wrench.t_P_W.data());
}

/// Ends at the first element that differs.
template <std::size_t kSize, class Element>
bool same(std::span<const Element> elements, ByteView written) {
  if (written.size() != kSize * elements.size()) return false;
  const std::uint8_t* at = written.data();
  for (const Element& element : elements) {
    if (differing_bits(at, element) != 0) return false;
    at += kSize;
  }
  return true;
}

}  // namespace

ArrayWriter& ArrayWriter::add(std::span<const Motion> motions) {
  for (const Motion& motion : motions) {
    at_ = put(at_, motion.p_WP.data(), 3);
    const Eigen::Vector4d& xyzw = motion.q_WP.coeffs();
    const double wxyz[4] = {xyzw[3], xyzw[0], xyzw[1], xyzw[2]};
    at_ = put(at_, wxyz, 4);
    at_ = put(at_, motion.v_WP.data(), 3);
    at_ = put(at_, motion.w_WP.data(), 3);
  }
  return *this;
}

ArrayWriter& ArrayWriter::add(std::span<const Wrench> wrenches) {
  for (const Wrench& wrench : wrenches) {
    at_ = put(at_, wrench.f_P_W.data(), 3);
    at_ = put(at_, wrench.t_P_W.data(), 3);
  }
  return *this;
}

ArrayWriter& ArrayWriter::add(std::span<const double> values) {
  at_ = put(at_, values.data(), values.size());
  return *this;
}

ArrayWriter& ArrayWriter::add(std::span<const char> text) {
  at_ = std::copy(text.begin(), text.end(), at_);
  return *this;
}

ArrayReader& ArrayReader::take(std::size_t count, MotionSet& motions) {
  motions.resize(count);
  for (Motion& motion : motions) {
    double wxyz[4];
    at_ = get(at_, motion.p_WP.data(), 3);
    at_ = get(at_, wxyz, 4);
    motion.q_WP = Eigen::Quaterniond(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
    at_ = get(at_, motion.v_WP.data(), 3);
    at_ = get(at_, motion.w_WP.data(), 3);
  }
  return *this;
}

ArrayReader& ArrayReader::take(std::size_t count, WrenchSet& wrenches) {
  wrenches.resize(count);
  for (Wrench& wrench : wrenches) {
    at_ = get(at_, wrench.f_P_W.data(), 3);
    at_ = get(at_, wrench.t_P_W.data(), 3);
  }
  return *this;
}

ArrayReader& ArrayReader::take(std::span<double> values) {
  at_ = get(at_, values.data(), values.size());
  return *this;
}

ArrayReader& ArrayReader::take(std::size_t count, std::string& text) {
  text.assign(reinterpret_cast<const char*>(at_), count);
  at_ += count;
  return *this;
}

bool same_bits(std::span<const Motion> motions, ByteView written) {
  return same<kMotionBytes>(motions, written);
}

bool same_bits(std::span<const Wrench> wrenches, ByteView written) {
  return same<kWrenchBytes>(wrenches, written);
}

}  // namespace tandem::wire
