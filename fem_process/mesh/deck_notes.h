#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "fem_process/mesh/source_lines.h"

namespace tandem::fem {

/// What a deck's reader passed over or took for something else: one note for each kind.
class DeckNotes {
 public:
  void passed_over(const std::string& keyword, int line, bool connects);
  /// One element of a type that is no tetrahedron.
  void element(const std::string& type, int line, bool surface);
  /// Says something about a line once.
  void once(const std::string& text, int line);
  /// Where the first *STEP stands; zero: there is none.
  void step(int line) { step_ = line; }

  [[nodiscard]] std::vector<std::string> lines(const SourceLines& source) const;

 private:
  struct Counted {
    int line = 0;
    std::size_t count = 0;
    bool surface = false;
  };
  std::map<std::string, Counted> keywords_, connecting_, elements_;
  std::map<std::string, int> once_;
  int step_ = 0;
};

}  // namespace tandem::fem
