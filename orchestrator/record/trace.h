#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "orchestrator/files/run_directory.h"

namespace tandem::orchestrator {

/// Macro steps first … last.
struct StepWindow {
  std::int64_t first = 0;
  std::int64_t last = 0;
};

/// Macro steps that a trace holds unless it is told which: some megabytes, which viewers open at
/// once.
inline constexpr std::int64_t kTracedSteps = 1000;

/// "a:b" with a ≤ b, "a:" or ":b"; throws a Usage error.
[[nodiscard]] StepWindow window_of(const std::string& text);

/// Writes the macro steps of the window as Chrome trace events, and gives back a summary of all:
/// the critical path, who waited for whom, what to speed up first, how exactly the clocks of the
/// processes are known. All from exchange.lcm. Throws a Usage error when that holds no call times.
[[nodiscard]] std::string trace(const RunDirectory& run, const std::filesystem::path& file,
                                const StepWindow& window);

}  // namespace tandem::orchestrator
