#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "orchestrator/commands/commands.h"
#include "orchestrator/page/report_page.h"
#include "protocol/contract/whole_file.h"

namespace tandem::orchestrator {

void add_report(CLI::App& app) {
  auto runs = std::make_shared<std::vector<std::string>>();
  auto out = std::make_shared<std::string>();
  CLI::App* sub = app.add_subcommand(
      "report", "One self-contained HTML page with plots of one or several runs");
  sub->add_option("RUN", *runs, "Run folders")->required();
  sub->add_option("--out", *out, "HTML file [report.html in the first run folder]");
  sub->callback([runs, out] {
    const std::vector<std::filesystem::path> folders(runs->begin(), runs->end());
    const ReportPage page = report_page(folders);
    const std::filesystem::path file =
        out->empty() ? folders.front() / "report.html" : std::filesystem::path(*out);
    write_whole_file(file, page.html);
    for (const std::string& remark : page.remarks) {
      std::fprintf(stderr, "note: %s\n", remark.c_str());
    }
    std::printf("%s\n", file.c_str());
  });
}

}  // namespace tandem::orchestrator
