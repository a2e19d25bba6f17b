// What fails leaves nothing open: a program that tries again for hours would run out of files.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/socket.h>

#include <filesystem>
#include <functional>
#include <string>

#include "orchestrator/bench/ping_pong.h"
#include "orchestrator/files/run_directory.h"
#include "orchestrator/files/text_file.h"
#include "protocol/contract/error.h"
#include "protocol/contract/whole_file.h"
#include "protocol/wire/bus.h"
#include "protocol/wire/event_log.h"
#include "tests/support/tandem_process.h"

namespace tandem::test {
namespace {

// More than the tests open.
constexpr int kMostFiles = 1024;

bool is_open(int fd) { return fcntl(fd, F_GETFD) >= 0; }

int open_files() {
  int count = 0;
  for (int fd = 0; fd < kMostFiles; ++fd) count += is_open(fd) ? 1 : 0;
  return count;
}

/// Whether `act` threw an Error; nothing of it may stay open in either case.
bool fails(const std::string& what, const std::function<void()>& act) {
  const int before = open_files();
  bool failed = false;
  try {
    act();
  } catch (const Error&) {
    failed = true;
  }
  EXPECT_EQ(open_files(), before) << what;
  return failed;
}

/// For its life the process may open `more` files beyond those that it has.
class FewFiles {
 public:
  explicit FewFiles(int more) {
    getrlimit(RLIMIT_NOFILE, &before_);
    // The limit is one of numbers, and a new file takes the lowest that is free.
    int limit = 0;
    for (int room = 0; room < more || is_open(limit); ++limit) room += is_open(limit) ? 0 : 1;
    const rlimit few{static_cast<rlim_t>(limit), before_.rlim_max};
    setrlimit(RLIMIT_NOFILE, &few);
  }
  ~FewFiles() { setrlimit(RLIMIT_NOFILE, &before_); }
  FewFiles(const FewFiles&) = delete;
  FewFiles& operator=(const FewFiles&) = delete;

 private:
  rlimit before_{};
};

TEST(Descriptors, AnOpenFileIsCounted) {
  const int before = open_files();
  const std::ifstream file("/dev/null");
  EXPECT_EQ(open_files(), before + 1);
}

TEST(Descriptors, ARefusedPingClosesItsSockets) {
  const orchestrator::PingPongSockets sockets;
  shutdown(sockets.tcp_listener(), SHUT_RDWR);  // nobody accepts
  EXPECT_TRUE(fails("ping", [&] { const orchestrator::PingPong ping(sockets, {8, 8}); }));
}

TEST(Descriptors, SocketsOfWhichTheSecondFindsNoRoom) {
  for (const int room : {0, 1, 2}) {
    const bool failed = fails("sockets", [&] {
      const FewFiles few(room);
      const orchestrator::PingPongSockets sockets;
    });
    EXPECT_EQ(failed, room < 2) << room;
  }
}

TEST(Descriptors, FilesThatCannotBeWritten) {
  EXPECT_TRUE(fails("whole file", [] { write_whole_file("/dev/full", "text"); }));
  EXPECT_TRUE(fails("text file", [] {
    orchestrator::TextFile file("/dev/full");
    file.write("text");
    file.flush();
  }));
  EXPECT_TRUE(fails("log", [] { wire::LogWriter log("/dev/full", 1, {"scenario", "versions"}); }));
}

TEST(Descriptors, LogsThatCannotBeRead) {
  const TemporaryFolder folder;
  write_file(folder / "exchange.lcm", "no log");
  EXPECT_TRUE(fails("log", [&] { wire::LogReader log(folder / "exchange.lcm"); }));
}

TEST(Descriptors, AFolderThatAnotherCommandHolds) {
  const TemporaryFolder folder;
  const auto held = orchestrator::RunDirectory::create(folder / "run", "scenario");
  EXPECT_TRUE(fails("folder", [&] {
    static_cast<void>(orchestrator::RunDirectory::create(folder / "run", "scenario"));
  }));
}

TEST(Descriptors, ABusLeavesNothingOpen) {
  const wire::BusOptions options{.run_id = 1, .port = wire::free_port()};
  const auto open = [&] { const wire::Bus bus(options); };
  open();  // what liblcm keeps for the process
  EXPECT_FALSE(fails("bus", open));
  EXPECT_TRUE(fails("bus of no port", [] { const wire::Bus bus({.run_id = 1, .port = 0}); }));
  try {
    const FewFiles few(0);
    const wire::Bus bus(options);
    ADD_FAILURE() << "opened";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("cannot open a socket"), std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace tandem::test
