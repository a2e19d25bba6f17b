#pragma once

#include <cstdlib>

namespace tandem::test {

/// Whether tests run over their whole length (./test.sh --long). The shorter ones hold the same
/// claims; rare drifts need the long ones.
inline bool long_tests() { return std::getenv("TANDEM_LONG") != nullptr; }

}  // namespace tandem::test
