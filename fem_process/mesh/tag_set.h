#pragma once

#include <algorithm>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <set>
#include <vector>

namespace tandem::fem {

/// Numbers of nodes or elements, one by one and as ranges: of a row that is repeated, or of a set
/// that is put into itself, each is kept once, so that the memory stays that of what is there.
class TagSet {
 public:
  struct Range {
    std::int64_t first = 0, last = 0, step = 1;
    int line = 0;
    auto operator<=>(const Range&) const = default;
  };

  void add(std::int64_t tag) {
    tags_.push_back(tag);
    if (tags_.size() > kSome + 2 * apart_) keep_once();
  }
  void add(const Range& range) { ranges_.insert(range); }
  void add(const TagSet& other) {
    const std::vector<std::int64_t> tags = other.tags_;  // may be this one
    tags_.insert(tags_.end(), tags.begin(), tags.end());
    keep_once();
    if (&other != this) ranges_.insert(other.ranges_.begin(), other.ranges_.end());
  }

  [[nodiscard]] const std::vector<std::int64_t>& tags() const { return tags_; }
  [[nodiscard]] const std::set<Range>& ranges() const { return ranges_; }

 private:
  static constexpr std::size_t kSome = 1024;

  void keep_once() {
    std::sort(tags_.begin(), tags_.end());
    tags_.erase(std::unique(tags_.begin(), tags_.end()), tags_.end());
    apart_ = tags_.size();
  }

  std::vector<std::int64_t> tags_;
  std::set<Range> ranges_;
  std::size_t apart_ = 0;  ///< tags when they were last kept once
};

}  // namespace tandem::fem
