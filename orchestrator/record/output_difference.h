#pragma once

#include <string>
#include <vector>

#include "protocol/contract/port.h"

namespace tandem::orchestrator {

/// First component in which two outputs differ by more than tolerance · max(1, |logged|), as
/// "port 'eye', f_x_N: logged 1.25, replayed 1.26"; empty = none. Tolerance 0 compares bits, so
/// that −0 and NaN count too.
[[nodiscard]] std::string first_difference(const MotionSet& logged, const MotionSet& replayed,
                                           const std::vector<std::string>& ports, double tolerance);
[[nodiscard]] std::string first_difference(const WrenchSet& logged, const WrenchSet& replayed,
                                           const std::vector<std::string>& ports, double tolerance);

}  // namespace tandem::orchestrator
