#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "fem_process/mesh/text_scanner.h"

namespace tandem::fem {

/// Numbers of a Gmsh file, written as text or as bytes of either order. In binary sections errors
/// name the line at which the section begins.
class MshStream {
 public:
  explicit MshStream(const std::filesystem::path& file) : text_(file), file_(file) {}

  /// Reads $MeshFormat up to and with $EndMeshFormat. Versions 2 to 2.2, 4 and 4.1 are read.
  void read_format();
  [[nodiscard]] int version() const { return version_; }  ///< 20, 40 or 41
  [[nodiscard]] bool binary() const { return binary_; }

  /// What is text in every file: names of sections, physical names, counts of version 2.
  [[nodiscard]] TextScanner& text() { return text_; }
  /// Numbers as bytes begin behind the line that is being read.
  void begin_numbers();

  std::int64_t integer(std::string_view what);  ///< 32 bits in binary files
  std::int64_t size(std::string_view what);     ///< 64 bits in binary files
  double real(std::string_view what);
  /// A count of items, refused where the rest of the file cannot hold them; `text_bytes` and
  /// `binary_bytes`: the least that an item takes.
  std::size_t count(std::string_view what, std::size_t text_bytes, std::size_t binary_bytes);
  /// In version 2 the same, but as text in binary files, too.
  std::size_t text_count(std::string_view what, std::size_t text_bytes, std::size_t binary_bytes);
  /// A number of 32 bits as such a count.
  std::size_t checked(std::string_view what, std::int64_t value, std::size_t bytes_each) const;

  [[nodiscard]] int line() const { return text_.line(); }
  [[noreturn]] void fail(const std::string& text) const { text_.fail(text); }

 private:
  template <class T>
  T raw(std::string_view what);
  [[noreturn]] void refuse_format() const;
  [[nodiscard]] std::string conversion() const;
  void read_byte_order();

  TextScanner text_;
  std::filesystem::path file_;
  int version_ = 41;
  bool binary_ = false;
  bool swapped_ = false;
};

}  // namespace tandem::fem
