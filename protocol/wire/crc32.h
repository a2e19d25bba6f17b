#pragma once

#include <cstddef>
#include <cstdint>

#include "protocol/wire/seal.h"

namespace tandem::wire {

/// CRC-32 as zlib's crc32(): polynomial 0x04C11DB7, reflected, continued from `crc` (0 = start).
/// Folds 64 or 256 bytes at a time by carry-less multiplication where the processor has it [Gopal
/// et al., Fast CRC computation for generic polynomials using PCLMULQDQ, Intel 2009].
[[nodiscard]] std::uint32_t crc32(std::uint32_t crc, ByteView bytes);

/// CRC-32 of a ‖ b from those of a and b.
[[nodiscard]] std::uint32_t crc32_joined(std::uint32_t crc_a, std::uint32_t crc_b,
                                         std::size_t size_b);

}  // namespace tandem::wire
