#pragma once

// Shared by the encode units alone: includes generated LCM headers.

#include <array>
#include <cstring>
#include <initializer_list>
#include <optional>
#include <string>
#include <tandem_wire/header_t.hpp>
#include <vector>

#include "protocol/wire/arrays.h"
#include "protocol/wire/seal.h"

namespace tandem::wire::codec {

inline constexpr std::size_t kMaxMessageBytes = 64U << 20U;

/// Bytes of a message: counts follow the header directly, so the exact size is known before any
/// memory is taken: fixed part + Σ count_i × element_bytes_i.
bool size_fits(ByteView message, std::size_t fixed_bytes,
               std::initializer_list<std::size_t> element_bytes);

/// One array of a message: how many elements of how many bytes.
struct Array {
  std::size_t count = 0;
  std::size_t element_bytes = 1;
};

/// 32 bits, big endian.
inline void write_word(std::size_t value, std::uint8_t* at) {
  for (unsigned i = 0; i < 4; ++i) at[i] = static_cast<std::uint8_t>(value >> (24U - 8U * i));
}
inline std::size_t read_word(const std::uint8_t* at) {
  std::uint32_t word = 0;
  for (int i = 0; i < 4; ++i) word = (word << 8U) | at[i];
  return word;
}

/// The counts stand directly behind the header.
inline void write_counts(std::initializer_list<Array> arrays, std::uint8_t* message) {
  std::uint8_t* at = message + kHeaderEnd;
  for (const Array& array : arrays) {
    write_word(array.count, at);
    at += 4;
  }
}

/// Writes the fixed part of a message through lcm-gen's code and the counts at offset `at`, and
/// makes room for the arrays, which all stand at the message's end; what was behind `at` is lost.
/// `fixed` has no arrays and counts of zero.
template <class T>
ArrayWriter begin(const T& fixed, std::initializer_list<Array> arrays, Bytes& to,
                  std::size_t at = 0) {
  const auto fixed_bytes = static_cast<std::size_t>(fixed.getEncodedSize());
  std::size_t size = fixed_bytes;
  for (const Array& array : arrays) size += array.count * array.element_bytes;
  to.resize(at + size);
  fixed.encode(to.data() + at, 0, static_cast<int>(fixed_bytes));
  write_counts(arrays, to.data() + at);
  return ArrayWriter(to.data() + at + fixed_bytes);
}

/// Reads the fixed part of a message whose arrays all stand at its end; nothing when it is of
/// another schema or its counts do not add up to its size.
template <class T>
std::optional<T> fixed_part(ByteView message, std::initializer_list<std::size_t> element_bytes) {
  T fixed{};
  std::array<std::uint8_t, 512> bytes{};
  const auto size = static_cast<std::size_t>(fixed.getEncodedSize());
  if (message.size() > kMaxMessageBytes || size > bytes.size() ||
      !size_fits(message, size, element_bytes)) {
    return std::nullopt;
  }
  std::memcpy(bytes.data(), message.data(), size);
  std::memset(bytes.data() + kHeaderEnd, 0, 4 * element_bytes.size());
  const int expected = static_cast<int>(size);
  if (fixed.decode(bytes.data(), 0, expected) != expected) return std::nullopt;
  return fixed;
}

/// The n-th count behind the header.
inline std::size_t count_at(ByteView message, std::size_t n) {
  return read_word(message.data() + kHeaderEnd + 4 * n);
}

/// Where the arrays begin.
template <class T>
ArrayReader arrays_of(ByteView message, const T& fixed) {
  return ArrayReader(message.data() + fixed.getEncodedSize());
}

template <class T>
Bytes to_bytes(const T& value) {
  Bytes bytes(static_cast<std::size_t>(value.getEncodedSize()));
  value.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

template <class T>
std::optional<T> from_bytes(ByteView message, const T& empty,
                            std::initializer_list<std::size_t> element_bytes) {
  if (message.size() > kMaxMessageBytes) return std::nullopt;
  if (!size_fits(message, static_cast<std::size_t>(empty.getEncodedSize()), element_bytes)) {
    return std::nullopt;
  }
  T value = empty;
  const int size = static_cast<int>(message.size());
  if (value.decode(message.data(), 0, size) != size) return std::nullopt;
  return value;
}

tandem_wire::header_t pack(const Header& header);
Header unpack(const tandem_wire::header_t& packed);

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
