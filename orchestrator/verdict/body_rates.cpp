#include "orchestrator/verdict/body_rates.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <string_view>

namespace tandem::orchestrator {
namespace {

std::vector<std::string_view> cells_of(std::string_view line) {
  std::vector<std::string_view> cells;
  for (;;) {
    const std::size_t comma = line.find(',');
    cells.push_back(line.substr(0, comma));
    if (comma == std::string_view::npos) return cells;
    line.remove_prefix(comma + 1);
  }
}

double number_of(std::string_view cell) {
  double value = 0.0;
  std::from_chars(cell.data(), cell.data() + cell.size(), value);
  return value;
}

/// A body and the first of its three columns of w.
struct Watched {
  std::string body;
  std::size_t column = 0;
};

std::vector<Watched> watched_in(const std::string& header,
                                const std::vector<std::string>& passed_over) {
  constexpr std::string_view kSuffix = ".w_x_rad_per_s";
  std::vector<Watched> watched;
  const std::vector<std::string_view> names = cells_of(header);
  for (std::size_t i = 0; i + 2 < names.size(); ++i) {
    if (!names[i].ends_with(kSuffix)) continue;
    std::string body(names[i].substr(0, names[i].size() - kSuffix.size()));
    if (std::find(passed_over.begin(), passed_over.end(), body) != passed_over.end()) continue;
    watched.push_back({std::move(body), i});
  }
  return watched;
}

}  // namespace

BodyTurn fastest_body(const std::filesystem::path& file,
                      const std::vector<std::string>& passed_over) {
  BodyTurn found;
  std::ifstream stream(file);
  std::string line;
  if (!std::getline(stream, line)) return found;
  const std::vector<Watched> watched = watched_in(line, passed_over);
  if (watched.empty()) return found;
  const std::size_t columns = cells_of(line).size();
  double before_s = 0.0;
  while (std::getline(stream, line) && !stream.eof()) {
    const std::vector<std::string_view> cells = cells_of(line);
    if (cells.size() != columns) break;
    const double t_s = number_of(cells[0]);
    for (const Watched& w : watched) {
      const double rate = std::hypot(number_of(cells[w.column]), number_of(cells[w.column + 1]),
                                     number_of(cells[w.column + 2]));
      found.turn_between_rows_rad = std::max(found.turn_between_rows_rad, rate * (t_s - before_s));
      if (!(rate > found.rate_rad_per_s)) continue;
      found.rate_rad_per_s = rate;
      found.body = w.body;
    }
    before_s = t_s;
  }
  return found;
}

}  // namespace tandem::orchestrator
