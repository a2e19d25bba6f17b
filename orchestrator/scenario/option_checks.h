#pragma once

#include <cstdint>

namespace CLI {
class Validator;
}

namespace tandem::orchestrator {

/// Checks of numbers on the command line. What they refuse is said in one short line with what
/// would be right, e.g. "'abc' is not a number above 0". Never infinite, never "nan".
[[nodiscard]] CLI::Validator number_above_zero();
[[nodiscard]] CLI::Validator number_from_zero();
[[nodiscard]] CLI::Validator number_between(double low, double high);
[[nodiscard]] CLI::Validator whole_number_between(std::int64_t low, std::int64_t high);

}  // namespace tandem::orchestrator
