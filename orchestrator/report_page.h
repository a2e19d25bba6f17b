#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace tandem::orchestrator {

/// One self-contained HTML page (no scripts, no links to anything outside) about one or several run
/// folders: how each ended, where its time went, and curves over simulated time of port motion,
/// port force, evaluations per macro step and interface energy defect, all runs in the same plots.
/// Throws a Usage error for a folder that is no run.
[[nodiscard]] std::string report_page(const std::vector<std::filesystem::path>& runs);

}  // namespace tandem::orchestrator
