#pragma once

#include <filesystem>
#include <string_view>
#include <system_error>

#include "protocol/contract/error.h"

namespace tandem {

/// Whose fault it is that something cannot be made there: a place where nothing can be is the
/// user's (2), a disk that refuses is the machine's (4).
[[nodiscard]] ErrorKind kind_of_output_fault(const std::error_code& error);

/// The error of a file that cannot be written, with its remedy.
[[nodiscard]] Error cannot_write(const std::filesystem::path& file, const std::error_code& error);

/// Who may read a file.
enum class Readers { All, Owner };

/// Writes a file whole: beside its place, then renamed into it. Whoever reads it meanwhile, and
/// whoever finds it after a full disk or a kill, has the old file or the new one, never a part.
/// What is no regular file (/dev/stdout, a pipe) is written where it is, and so is a file in a
/// folder in which no other can be made. Throws an error that names the file when it cannot be
/// written.
void write_whole_file(const std::filesystem::path& file, std::string_view text,
                      Readers readers = Readers::All);

}  // namespace tandem
