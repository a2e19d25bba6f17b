#include "protocol/contract/whole_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <string>

namespace tandem {
namespace {

namespace fs = std::filesystem;

/// Writes all of it and closes `fd`; 0, or the error number.
int write_and_close(int fd, std::string_view text) {
  int error = 0;
  while (!text.empty() && error == 0) {
    const ssize_t written = write(fd, text.data(), text.size());
    if (written >= 0) {
      text.remove_prefix(static_cast<std::size_t>(written));
    } else if (errno != EINTR) {
      error = errno;
    }
  }
  // Some file systems say only here that the disk is full.
  if (close(fd) != 0 && error == 0) error = errno;
  return error;
}

void throw_unless_zero(int error, const fs::path& file) {
  if (error != 0) throw cannot_write(file, {error, std::generic_category()});
}

/// The file that is to be replaced; empty where it must be written in place.
fs::path replaced(const fs::path& file) {
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (status.type() == fs::file_type::not_found) return fs::is_symlink(file, error) ? "" : file;
  if (status.type() != fs::file_type::regular) return {};
  return fs::is_symlink(file, error) ? fs::canonical(file, error) : file;
}

/// Short: the longest name that a file may have is not too long for this.
fs::path name_aside(const fs::path& file) {
  static std::atomic<unsigned> number{0};
  return file.parent_path() /
         (".tandem-" + std::to_string(getpid()) + "-" + std::to_string(++number));
}

}  // namespace

ErrorKind kind_of_output_fault(const std::error_code& error) {
  constexpr std::array kUsersFaults = {
      std::errc::not_a_directory,   std::errc::is_a_directory,
      std::errc::file_exists,       std::errc::filename_too_long,
      std::errc::invalid_argument,  std::errc::no_such_file_or_directory,
      std::errc::permission_denied, std::errc::operation_not_permitted};
  const bool users = std::any_of(kUsersFaults.begin(), kUsersFaults.end(),
                                 [&](std::errc fault) { return error == fault; });
  return users ? ErrorKind::Usage : ErrorKind::System;
}

Error cannot_write(const fs::path& file, const std::error_code& error) {
  const ErrorKind kind = kind_of_output_fault(error);
  return {kind, "cannot write '" + file.string() + "': " + error.message() + ". " +
                    (kind == ErrorKind::Usage ? "Choose another place."
                                              : "Free some space or choose another --out.")};
}

void write_whole_file(const fs::path& file, std::string_view text, Readers readers) {
  const mode_t mode = readers == Readers::All ? 0666 : 0600;  // less what the umask takes
  const fs::path target = replaced(file);
  if (!target.empty()) {
    const fs::path aside = name_aside(target);
    const int fd = open(aside.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
    if (fd >= 0) {
      int error = write_and_close(fd, text);
      if (error == 0 && rename(aside.c_str(), target.c_str()) != 0) error = errno;
      if (error != 0) unlink(aside.c_str());
      return throw_unless_zero(error, file);
    }
  }
  const int fd = open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, mode);
  throw_unless_zero(fd < 0 ? errno : write_and_close(fd, text), file);
}

}  // namespace tandem
