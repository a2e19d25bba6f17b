#pragma once

#include <cstddef>
#include <memory>

namespace tandem::fem {

/// A few threads that share loops. Who computes which part of a loop is left to chance, so the
/// results must not depend on it: every part writes what belongs to it alone, sums are made per
/// part and added up in the order of the parts. Then the bits are the same for any number of
/// threads.
///
/// Helpers wait for the next loop by spinning for some tens of microseconds (the loops of a step
/// follow one another at once), then sleep. Not to be used by two callers at a time.
class ThreadTeam {
 public:
  /// The caller and threads − 1 helpers.
  explicit ThreadTeam(int threads = 1);
  ~ThreadTeam();
  ThreadTeam(const ThreadTeam&) = delete;
  ThreadTeam& operator=(const ThreadTeam&) = delete;

  [[nodiscard]] int threads() const;

  /// Calls work(k) once for each part k < parts, on any thread, and returns when all are done. Each
  /// thread begins with its own share of neighbouring parts and then helps the others.
  template <class Work>
  void run(int parts, const Work& work) {
    if (!helpers_ || parts < kWorthSharing) {
      for (int k = 0; k < parts; ++k) work(k);
      return;
    }
    share(
        parts, [](const void* self, int k) { (*static_cast<const Work*>(self))(k); }, &work);
  }

  /// Calls work(begin, end) for pieces of [0, count) of at most `grain`.
  template <class Work>
  void run_ranges(std::size_t count, std::size_t grain, const Work& work) {
    const auto parts = static_cast<int>((count + grain - 1) / grain);
    run(parts, [&](int k) {
      const std::size_t begin = static_cast<std::size_t>(k) * grain;
      work(begin, begin + grain < count ? begin + grain : count);
    });
  }

 private:
  /// Calling the helpers costs a microsecond or two: as much as a few parts.
  static constexpr int kWorthSharing = 4;
  using Call = void (*)(const void* work, int part);
  void share(int parts, Call call, const void* work);

  struct Helpers;
  std::unique_ptr<Helpers> helpers_;  ///< null: the caller alone
};

}  // namespace tandem::fem
