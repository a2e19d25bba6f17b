#include "protocol/scenario/suggest.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cctype>

#include "protocol/scenario/node.h"

namespace tandem::scenario {
namespace {

std::string lower(std::string_view text) {
  std::string out(text);
  std::ranges::transform(out, out.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return out;
}

/// Optimal string alignment distance: insertions, deletions, substitutions and swaps of neighbours.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) d[i][0] = i;
  for (std::size_t j = 0; j <= b.size(); ++j) d[0][j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t change = a[i - 1] == b[j - 1] ? 0 : 1;
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + change});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
      }
    }
  }
  return d[a.size()][b.size()];
}

bool is_unit_part(std::string_view word) {
  static constexpr std::array<std::string_view, 38> kUnits = {
      "s",  "ms", "us", "ns", "h",   "m",   "mm",  "cm",   "km",  "um",  "kg",  "g",   "t",
      "lb", "n",  "kn", "nm", "nmm", "nms", "pa",  "kpa",  "mpa", "gpa", "bar", "j",   "mj",
      "kj", "w",  "kw", "hz", "khz", "rpm", "rad", "mrad", "deg", "per", "k",   "degc"};
  std::string letters = lower(word);
  while (!letters.empty() && std::isdigit(static_cast<unsigned char>(letters.back())) != 0) {
    letters.pop_back();
  }
  return std::ranges::find(kUnits, letters) != kUnits.end();
}

}  // namespace

std::string without_unit(std::string_view key) {
  for (auto cut = key.rfind('_'); cut != std::string_view::npos && cut > 0; cut = key.rfind('_')) {
    if (!is_unit_part(key.substr(cut + 1))) break;
    key = key.substr(0, cut);
  }
  return std::string(key);
}

std::optional<std::string> nearest(std::string_view given, const std::vector<std::string>& known) {
  const std::string wanted = lower(given);
  std::optional<std::string> best;
  std::size_t best_distance = 0;
  for (const std::string& name : known) {
    const std::string candidate = lower(name);
    const std::size_t shorter = std::min(wanted.size(), candidate.size());
    const std::size_t longer = std::max(wanted.size(), candidate.size());
    const bool begins = wanted.size() >= 3 && candidate.starts_with(wanted);
    const std::size_t distance =
        std::min(edit_distance(wanted, candidate), begins ? std::size_t{1} : longer);
    const bool near = distance <= std::max<std::size_t>(1, longer / 3) && distance < shorter;
    if ((near || distance == 0) && (!best || distance < best_distance)) {
      best = name;
      best_distance = distance;
    }
  }
  return best;
}

std::string did_you_mean(std::string_view given, const std::vector<std::string>& known) {
  const auto name = nearest(given, known);
  return name ? fmt::format(" Did you mean '{}'?", *name) : "";
}

const Key* nearest_key(std::string_view given, const std::vector<Key>& keys) {
  const std::string stem = lower(without_unit(given));
  std::vector<std::string> known;
  for (const Key& key : keys) {
    if (lower(without_unit(key.name)) == stem) return &key;
    known.push_back(key.name);
  }
  const auto name = nearest(given, known);
  if (!name) return nullptr;
  return &*std::ranges::find(keys, *name, &Key::name);
}

std::string key_remedy(std::string_view given, const std::vector<Key>& keys) {
  if (const Key* key = nearest_key(given, keys)) {
    const std::string unit = key->unit.empty() ? "" : fmt::format(" ({})", key->unit);
    return fmt::format(" Did you mean '{}'{}?", key->name, unit);
  }
  std::vector<std::string> known;
  for (const Key& key : keys) known.push_back(key.name);
  return fmt::format(" Keys here: {}.", fmt::join(known, ", "));
}

}  // namespace tandem::scenario
