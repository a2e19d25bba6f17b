#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace tandem::orchestrator {

struct ReportPage {
  std::string html;
  std::vector<std::string> remarks;  ///< what is missing of runs that were killed
};

/// One self-contained HTML page (no scripts, no links to anything outside) about one or several run
/// folders: how each ended, where its time went, and curves over simulated time of port motion,
/// port force, evaluations per macro step and interface energy defect, all runs in the same plots.
/// A run that was killed is shown as far as its tables go. Throws a Usage error for a folder that
/// is no run.
[[nodiscard]] ReportPage report_page(const std::vector<std::filesystem::path>& runs);

}  // namespace tandem::orchestrator
