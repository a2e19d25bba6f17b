#include "fem_process/mesh/deck_notes.h"

#include <algorithm>
#include <utility>

namespace tandem::fem {
namespace {

template <class Counted>
std::vector<std::pair<std::string, Counted>> by_line(const std::map<std::string, Counted>& all) {
  std::vector<std::pair<std::string, Counted>> sorted(all.begin(), all.end());
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const auto& a, const auto& b) { return a.second.line < b.second.line; });
  return sorted;
}

template <class Counted>
std::string keywords_of(const std::map<std::string, Counted>& all, const SourceLines& source) {
  std::string text;
  for (const auto& [keyword, counted] : by_line(all)) {
    text += (text.empty() ? "*" : ", *") + keyword + " (" + source.named(counted.line) +
            (counted.count > 1 ? ", " + std::to_string(counted.count) + " times)" : ")");
  }
  return text;
}

}  // namespace

void DeckNotes::passed_over(const std::string& keyword, int line, bool connects) {
  Counted& counted = (connects ? connecting_ : keywords_)[keyword];
  if (counted.count++ == 0) counted.line = line;
}

void DeckNotes::element(const std::string& type, int line, bool surface) {
  Counted& counted = elements_[type];
  if (counted.count++ == 0) counted.line = line;
  counted.surface = surface;
}

void DeckNotes::once(const std::string& text, int line) { once_.emplace(text, line); }

std::vector<std::string> DeckNotes::lines(const SourceLines& source) const {
  std::vector<std::string> notes;
  if (!keywords_.empty()) {
    notes.push_back("passed over, for they leave the mesh alone: " +
                    keywords_of(keywords_, source));
  }
  if (!connecting_.empty()) {
    notes.push_back("passed over: " + keywords_of(connecting_, source) +
                    "; what they connect stays apart here");
  }
  std::string types;
  for (const auto& [type, counted] : by_line(elements_)) {
    types += (types.empty() ? "" : ", ") + std::to_string(counted.count) + " " + type + " (" +
             source.named(counted.line) + (counted.surface ? ", surfaces in their sets)" : ")");
  }
  if (!types.empty()) notes.push_back("elements beside the tetrahedra were passed over: " + types);
  std::vector<std::pair<std::string, int>> said(once_.begin(), once_.end());
  std::stable_sort(said.begin(), said.end(),
                   [](const auto& a, const auto& b) { return a.second < b.second; });
  for (const auto& [text, line] : said) notes.push_back(source.named(line) + ": " + text);
  if (step_ > 0) {
    notes.push_back(source.named(step_) + ": all from the first *STEP on was passed over");
  }
  return notes;
}

}  // namespace tandem::fem
