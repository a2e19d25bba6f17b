#include "orchestrator/process/log_tail.h"

#include <array>
#include <cstdio>

namespace tandem::orchestrator {

void LogTail::forward() {
  if (!file_.is_open()) file_.open(path_);
  file_.clear();  // the end that was met last time may have moved
  std::array<char, 4096> block{};
  while (file_.read(block.data(), block.size()) || file_.gcount() > 0) {
    partial_.append(block.data(), static_cast<std::size_t>(file_.gcount()));
  }
  for (std::size_t end = partial_.find('\n'); end != std::string::npos; end = partial_.find('\n')) {
    std::fprintf(stderr, "[%s] %.*s\n", label_.c_str(), static_cast<int>(end), partial_.c_str());
    partial_.erase(0, end + 1);
  }
}

std::string LogTail::last_line() const {
  std::ifstream file(path_);
  std::string last;
  for (std::string line; std::getline(file, line);) {
    if (!line.empty()) last = line;
  }
  return last;
}

}  // namespace tandem::orchestrator
