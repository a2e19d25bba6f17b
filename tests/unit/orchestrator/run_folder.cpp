#include <gtest/gtest.h>

#include <barrier>
#include <functional>
#include <mutex>
#include <set>
#include <thread>
#include <vector>

#include "orchestrator/files/run_directory.h"
#include "protocol/contract/error.h"
#include "tests/support/tandem_process.h"

// Commands that start at the same instant: here threads, behind a barrier. Each opens the folder
// anew, and so is to the kernel what a process is.
namespace tandem::orchestrator {
namespace {

constexpr int kTogether = 8;

/// The folders that `make` gave to eight callers at once; those that were refused have none.
std::vector<RunDirectory> at_once(const std::function<RunDirectory()>& make) {
  std::vector<RunDirectory> given;
  std::mutex mutex;
  std::barrier start(kTogether);
  std::vector<std::thread> threads;
  for (int i = 0; i < kTogether; ++i) {
    threads.emplace_back([&] {
      start.arrive_and_wait();
      try {
        RunDirectory directory = make();
        const std::lock_guard lock(mutex);
        given.push_back(std::move(directory));
      } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::Usage) << error.what();
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  return given;
}

class RunFolder : public testing::Test {
 protected:
  RunFolder() { std::filesystem::current_path(folder.path()); }
  ~RunFolder() override { std::filesystem::current_path(before); }

  std::filesystem::path before = std::filesystem::current_path();
  test::TemporaryFolder folder;
};

std::size_t different(const std::vector<RunDirectory>& directories) {
  std::set<std::filesystem::path> paths;
  for (const RunDirectory& directory : directories) paths.insert(directory.path());
  return paths.size();
}

TEST_F(RunFolder, IsAnotherOneForEachOfEightRunsAtOnce) {
  for (int round = 0; round < 20; ++round) {
    EXPECT_EQ(different(at_once([] { return RunDirectory::create({}, "lug"); })), kTogether);
  }
}

TEST_F(RunFolder, IsAnotherOneForEachOfEightComparisonsAtOnce) {
  for (int round = 0; round < 20; ++round) {
    const auto given = at_once([] { return RunDirectory::create_group({}, "lug", "compare"); });
    EXPECT_EQ(different(given), kTogether);
  }
}

TEST_F(RunFolder, OneThatIsNamedIsGivenOnce) {
  for (const bool is_there : {false, true}) {
    const auto path = folder / (is_there ? "old" : "new");
    if (is_there) std::filesystem::create_directory(path);
    EXPECT_EQ(at_once([&] { return RunDirectory::create(path, "lug"); }).size(), 1U);
    EXPECT_EQ(at_once([&] { return RunDirectory::create_group(path, "lug", "advise"); }).size(),
              1U);
  }
}

TEST_F(RunFolder, IsFreeAgainWhenItsRunLeftNothing) {
  { const RunDirectory first = RunDirectory::create(folder / "run", "lug"); }
  EXPECT_NO_THROW(RunDirectory::create(folder / "run", "lug"));
}

}  // namespace
}  // namespace tandem::orchestrator
