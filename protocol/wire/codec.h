#pragma once

// Shared by the encode units alone: includes generated LCM headers.

#include <initializer_list>
#include <optional>
#include <string>
#include <tandem_wire/header_t.hpp>
#include <tandem_wire/motion_t.hpp>
#include <tandem_wire/wrench_t.hpp>
#include <vector>

#include "protocol/contract/port.h"
#include "protocol/wire/seal.h"

namespace tandem::wire::codec {

inline constexpr std::int64_t kMotionBytes = 13 * 8;
inline constexpr std::int64_t kWrenchBytes = 6 * 8;

/// Bytes of a message: counts follow the header directly, so the exact size is known before any
/// memory is taken: fixed part + Σ count_i × element_bytes_i.
bool size_fits(ByteView message, std::int64_t fixed_bytes,
               std::initializer_list<std::int64_t> element_bytes);

inline constexpr std::size_t kMaxMessageBytes = 64U << 20U;

template <class T>
Bytes to_bytes(const T& value) {
  Bytes bytes(static_cast<std::size_t>(value.getEncodedSize()));
  value.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

template <class T>
std::optional<T> from_bytes(ByteView message, const T& empty,
                            std::initializer_list<std::int64_t> element_bytes) {
  if (message.size() > kMaxMessageBytes) return std::nullopt;
  if (!size_fits(message, empty.getEncodedSize(), element_bytes)) return std::nullopt;
  T value = empty;
  const int size = static_cast<int>(message.size());
  if (value.decode(message.data(), 0, size) != size) return std::nullopt;
  return value;
}

tandem_wire::header_t pack(const Header& header);
Header unpack(const tandem_wire::header_t& packed);
std::vector<tandem_wire::motion_t> pack(const MotionSet& motions);
std::vector<tandem_wire::wrench_t> pack(const WrenchSet& wrenches);
MotionSet unpack(const std::vector<tandem_wire::motion_t>& packed);
WrenchSet unpack(const std::vector<tandem_wire::wrench_t>& packed);

inline std::vector<std::uint8_t> pack(const std::string& text) {
  return {text.begin(), text.end()};
}
inline std::string unpack(const std::vector<std::uint8_t>& text) {
  return {text.begin(), text.end()};
}

template <class Container>
std::int32_t count(const Container& container) {
  return static_cast<std::int32_t>(container.size());
}

}  // namespace tandem::wire::codec
