#include "fem_process/mesh/deck_lexer.h"

#include <algorithm>
#include <cctype>
#include <limits>
#include <system_error>
#include <utility>

#include "fem_process/mesh/text_scanner.h"
#include "protocol/contract/error.h"

namespace tandem::fem {
namespace {

constexpr std::size_t kMostNested = 20;
constexpr std::size_t kMostIncluded = 1000;

bool blank(char c) { return std::isspace(static_cast<unsigned char>(c)) != 0; }

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && blank(text.back())) text.remove_suffix(1);
  return text;
}

std::string_view unquoted(std::string_view text) {
  if (text.size() < 2 || text.front() != '"' || text.back() != '"') return text;
  return trimmed(text.substr(1, text.size() - 2));
}

/// Position of the first such character outside double quotes.
std::size_t find_outside_quotes(std::string_view text, char wanted) {
  bool inside = false;
  for (std::size_t k = 0; k < text.size(); ++k) {
    if (text[k] == '"') inside = !inside;
    if (text[k] == wanted && !inside) return k;
  }
  return std::string_view::npos;
}

std::vector<std::string_view> parts_of(std::string_view text) {
  std::vector<std::string_view> parts;
  while (true) {
    const std::size_t comma = find_outside_quotes(text, ',');
    parts.push_back(trimmed(text.substr(0, comma)));
    if (comma == std::string_view::npos) break;
    text.remove_prefix(comma + 1);
  }
  while (!parts.empty() && parts.back().empty()) parts.pop_back();
  return parts;
}

/// Upper case with one blank between words.
std::string title_of(std::string_view text) {
  std::string title;
  for (char c : trimmed(text)) {
    if (!blank(c)) {
      title += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    } else if (title.back() != ' ') {
      title += ' ';
    }
  }
  return title;
}

DeckLine::Parameter parameter_of(std::string_view part) {
  const std::size_t equals = part.find('=');
  if (equals == std::string_view::npos) return {deck_key(part), ""};
  return {deck_key(part.substr(0, equals)),
          std::string(unquoted(trimmed(part.substr(equals + 1))))};
}

/// A keyword line that ends with a comma goes on in the next line if that holds parameters: some
/// programs end every line so.
bool holds_parameters(std::string_view line) {
  if (line.empty() || line.front() == '*') return false;
  const std::vector<std::string_view> parts = parts_of(line);
  double number = 0.0;
  return !parts.empty() && !deck_real(parts.front(), number);
}

}  // namespace

std::string deck_key(std::string_view text) {
  std::string key;
  for (char c : text) {
    if (!blank(c)) key += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  }
  return key;
}

std::vector<std::string_view> deck_fields(std::string_view text) {
  std::vector<std::string_view> fields = parts_of(text);
  for (std::string_view& field : fields) field = unquoted(field);
  return fields;
}

bool deck_real(std::string_view text, double& value) {
  const std::size_t exponent = text.find_first_of("dD");
  if (exponent == std::string_view::npos || text.size() > 64) return parse(text, value);
  std::string number(text);
  number[exponent] = 'e';
  return parse(number, value);
}

DeckLexer::DeckLexer(const std::filesystem::path& file) {
  auto main = std::make_unique<Open>();
  main->file = file;
  main->text = read_whole(file, "Check the path in fem.mesh.file.");
  open_.push_back(std::move(main));
  lines_.begin(1, file);
}

void DeckLexer::fail(int line, const std::string& text) const {
  throw Error(ErrorKind::Usage, lines_.where(line) + ": " + text);
}

bool DeckLexer::take(std::string_view& line) {
  Open& file = *open_.back();
  while (file.at < file.text.size()) {
    const std::size_t end = std::min(file.text.find('\n', file.at), file.text.size());
    line = trimmed(std::string_view(file.text).substr(file.at, end - file.at));
    file.at = end + 1;
    ++file.line;
    if (number_ == std::numeric_limits<int>::max() - 1) fail(number_, "the deck is too long.");
    ++number_;
    if (!line.empty() && line.substr(0, 2) != "**") return true;
  }
  return false;
}

std::string_view DeckLexer::ahead() const {
  const Open& file = *open_.back();
  for (std::size_t at = file.at; at < file.text.size();) {
    const std::size_t end = std::min(file.text.find('\n', at), file.text.size());
    const std::string_view line = trimmed(std::string_view(file.text).substr(at, end - at));
    if (!line.empty() && line.substr(0, 2) != "**") return line;
    at = end + 1;
  }
  return {};
}

bool DeckLexer::next(DeckLine& line) {
  std::string_view text;
  while (step_line_ == 0) {
    if (!take(text)) {
      if (open_.size() == 1) return false;
      open_.pop_back();
      lines_.begin(number_ + 1, open_.back()->file, open_.back()->line);
      continue;
    }
    line = {};
    line.line = number_;
    if (text.front() != '*') {
      line.fields = deck_fields(text);
      line.goes_on = text.back() == ',';
      return true;
    }
    keyword(text, line);
    if (line.keyword == "STEP") {
      step_line_ = line.line;
    } else if (line.keyword == "INCLUDE") {
      include_of(line);
    } else {
      return true;
    }
  }
  return false;
}

void DeckLexer::keyword(std::string_view text, DeckLine& line) {
  line.is_keyword = true;
  bool first = true;
  while (true) {
    for (std::string_view part : parts_of(text)) {
      if (first) {
        line.keyword = title_of(part.substr(1));
      } else if (!part.empty()) {
        line.parameters.push_back(parameter_of(part));
      }
      first = false;
    }
    if (text.back() != ',' || !holds_parameters(ahead())) return;
    take(text);
  }
}

void DeckLexer::include_of(const DeckLine& line) {
  std::string name;
  for (const DeckLine::Parameter& parameter : line.parameters) {
    if (parameter.key != "INPUT") {
      fail(line.line, "*INCLUDE with " + parameter.key +
                          " is not read, with INPUT= alone it is. Write the included text out.");
    }
    name = parameter.value;
  }
  if (name.empty()) fail(line.line, "*INCLUDE names no file. Write *INCLUDE, INPUT=FILE.");
  include(name, line.line);
}

void DeckLexer::include(const std::string& name, int line) {
  if (included_.size() >= kMostIncluded || open_.size() > kMostNested) {
    fail(line, "more than " + std::to_string(kMostIncluded) + " files are included, or more than " +
                   std::to_string(kMostNested) + " within one another. Write the text out.");
  }
  std::string slashes = name;
  std::replace(slashes.begin(), slashes.end(), '\\', '/');
  const std::filesystem::path folders[] = {open_.back()->file.parent_path(),
                                           open_.front()->file.parent_path()};
  std::filesystem::path file;
  for (const std::string& spelling : {name, slashes}) {
    for (const std::filesystem::path& folder : folders) {
      std::error_code ignored;
      if (file.empty() && std::filesystem::is_regular_file(folder / spelling, ignored)) {
        file = (folder / spelling).lexically_normal();
      }
    }
  }
  if (file.empty()) {
    fail(line, "the included file " + in_quotes(name) + " is not there: looked for as " +
                   (folders[0] / slashes).lexically_normal().string() +
                   ". Bring it, or correct the name.");
  }
  for (const auto& open : open_) {
    if (open->file.lexically_normal() == file) {
      fail(line, "the file " + in_quotes(name) + " includes itself. Correct the name.");
    }
  }
  auto opened = std::make_unique<Open>();
  opened->file = file;
  opened->text = read_whole(file, "Check the file's permissions.");
  open_.push_back(std::move(opened));
  included_.push_back(file);
  lines_.begin(number_ + 1, file);
}

}  // namespace tandem::fem
