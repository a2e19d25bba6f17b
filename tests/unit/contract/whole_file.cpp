#include "protocol/contract/whole_file.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <atomic>
#include <csignal>
#include <fstream>
#include <sstream>
#include <string>
#include <thread>

namespace tandem {
namespace {

namespace fs = std::filesystem;

class WholeFile : public testing::Test {
 protected:
  WholeFile() {
    std::string name = (fs::temp_directory_path() / "tandem_whole_XXXXXX").string();
    folder = mkdtemp(name.data());
  }
  ~WholeFile() override { fs::remove_all(folder); }

  [[nodiscard]] std::string content(const std::string& name) const {
    std::ostringstream text;
    text << std::ifstream(folder / name, std::ios::binary).rdbuf();
    return text.str();
  }
  [[nodiscard]] std::ptrdiff_t entries() const {
    return std::distance(fs::directory_iterator(folder), fs::directory_iterator());
  }

  fs::path folder;
};

/// Files of this process may not grow beyond so many bytes: writing fails in mid-file, as on a full
/// disk.
class FullDisk {
 public:
  explicit FullDisk(rlim_t bytes) {
    signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FullDisk() { setrlimit(RLIMIT_FSIZE, &before_); }

 private:
  rlimit before_{};
};

TEST_F(WholeFile, AFullDiskLeavesTheOldFileAndNoOther) {
  write_whole_file(folder / "summary.json", "old");
  {
    const FullDisk full(1000);
    try {
      write_whole_file(folder / "summary.json", std::string(5000, 'x'));
      ADD_FAILURE() << "written on a full disk";
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::System);
      EXPECT_NE(std::string(error.what()).find((folder / "summary.json").string()),
                std::string::npos);
    }
    EXPECT_THROW(write_whole_file(folder / "new.json", std::string(5000, 'x')), Error);
  }
  EXPECT_EQ(content("summary.json"), "old");
  EXPECT_EQ(entries(), 1);
}

TEST_F(WholeFile, AReaderSeesTheOldFileOrTheNewOne) {
  const std::string a(200'000, 'a');
  const std::string b(300'000, 'b');
  write_whole_file(folder / "body.pvd", a);
  std::atomic<bool> stop{false};
  std::thread writer([&] {
    for (int i = 0; !stop; ++i) write_whole_file(folder / "body.pvd", i % 2 == 0 ? b : a);
  });
  for (int i = 0; i < 300; ++i) {
    const std::string seen = content("body.pvd");
    EXPECT_TRUE(seen == a || seen == b) << seen.size();
  }
  stop = true;
  writer.join();
  EXPECT_EQ(entries(), 1);
}

TEST_F(WholeFile, WhatIsNoFileIsWrittenWhereItIs) {
  fs::create_symlink("/dev/full", folder / "full");
  try {
    write_whole_file(folder / "full", "text");
    ADD_FAILURE() << "/dev/full took it";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("No space left on device"), std::string::npos);
  }
  EXPECT_NO_THROW(write_whole_file("/dev/null", "text"));
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

TEST_F(WholeFile, ALinkStaysALink) {
  write_whole_file(folder / "target", "old");
  fs::create_symlink("target", folder / "link");
  write_whole_file(folder / "link", "new");
  EXPECT_TRUE(fs::is_symlink(folder / "link"));
  EXPECT_EQ(content("target"), "new");
}

TEST_F(WholeFile, OneForTheOwnerAloneCanBeReadByNobodyElse) {
  const mode_t before = umask(0);
  write_whole_file(folder / "bus.json", "{}", Readers::Owner);
  write_whole_file(folder / "summary.json", "{}");
  umask(before);
  struct stat status {};
  ASSERT_EQ(stat((folder / "bus.json").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777U, 0600U);
  ASSERT_EQ(stat((folder / "summary.json").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777U, 0666U);
}

TEST_F(WholeFile, APlaceThatIsNoneIsTheUsersFault) {
  for (const fs::path& file : {folder / "none" / "file", folder, folder / std::string(300, 'x')}) {
    try {
      write_whole_file(file, "text");
      ADD_FAILURE() << file;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::Usage) << error.what();
      EXPECT_NE(std::string(error.what()).find("Choose another place"), std::string::npos);
    }
  }
  EXPECT_NO_THROW(write_whole_file(folder / std::string(255, 'x'), "text"));
}

}  // namespace
}  // namespace tandem
