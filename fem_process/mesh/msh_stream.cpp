#include "fem_process/mesh/msh_stream.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

namespace tandem::fem {

template <class T>
T MshStream::raw(std::string_view what) {
  std::array<char, sizeof(T)> bytes{};
  std::memcpy(bytes.data(), text_.bytes(what, sizeof(T)).data(), sizeof(T));
  if (swapped_) std::reverse(bytes.begin(), bytes.end());
  return std::bit_cast<T>(bytes);
}

std::string MshStream::conversion() const {
  const std::string name = file_.filename().string();
  return " Convert it: gmsh " + name + " -save -format msh41 -o " + file_.stem().string() +
         "_41.msh";
}

void MshStream::refuse_format() const {
  const std::string name = file_.filename().string();
  TextScanner again(file_);
  const std::string first(again.word("$MeshFormat"));
  if (first == "$NOD") fail("MSH version 1 is not read, 2 to 4.1 are." + conversion());
  if (first.front() == '*') {
    fail(
        "this is a deck of Abaqus' or CalculiX' keywords (CGX writes such .msh files), not a "
        "Gmsh mesh. Name it " +
        file_.stem().string() + ".inp.");
  }
  fail(
      "this is not a Gmsh mesh: it does not begin with $MeshFormat. Write it with Gmsh, or give "
      "an Abaqus .inp.");
}

void MshStream::read_format() {
  if (text_.word("$MeshFormat") != "$MeshFormat") refuse_format();
  const std::string version(text_.word("the format version"));
  if (version == "4.1" || version == "4" || version == "4.0") {
    version_ = version == "4.1" ? 41 : 40;
  } else if (version == "2" || version == "2.0" || version == "2.1" || version == "2.2") {
    version_ = 20;
  } else {
    fail("MSH version " + version + " is not read, 2 to 4.1 are." + conversion());
  }
  binary_ = text_.integer("the file type") != 0;
  const std::int64_t size = text_.integer("the data size");
  if (binary_) {
    if (size != 8)
      fail("binary MSH with numbers of another size than 8 is not read." + conversion());
    read_byte_order();
  }
  const std::string found(text_.word("$EndMeshFormat"));
  if (found != "$EndMeshFormat") {
    fail(in_quotes(found) + " where $EndMeshFormat should be. Write the mesh again.");
  }
}

void MshStream::read_byte_order() {
  begin_numbers();
  const auto one = raw<std::int32_t>("the byte order");
  if (one == 1) return;
  swapped_ = true;
  if (one == (1 << 24)) return;
  fail(
      "the byte order is neither this machine's nor the other. The file is damaged: write it "
      "again.");
}

void MshStream::begin_numbers() {
  if (binary_) text_.rest_of_line();
}

std::int64_t MshStream::integer(std::string_view what) {
  return binary_ ? raw<std::int32_t>(what) : text_.integer(what);
}

std::int64_t MshStream::size(std::string_view what) {
  return binary_ ? raw<std::int64_t>(what) : text_.integer(what);
}

double MshStream::real(std::string_view what) {
  if (!binary_) return text_.real(what);
  const auto value = raw<double>(what);
  if (!std::isfinite(value)) {
    fail(std::string(what) + " is not finite. Write the mesh again.");
  }
  return value;
}

std::size_t MshStream::checked(std::string_view what, std::int64_t value,
                               std::size_t bytes_each) const {
  if (value < 0 || static_cast<std::uint64_t>(value) > text_.bytes_left() / bytes_each) {
    fail(std::string(what) + " is " + std::to_string(value) + ", but only " +
         std::to_string(text_.bytes_left()) +
         " bytes follow. The file is truncated or damaged: write it again.");
  }
  return static_cast<std::size_t>(value);
}

std::size_t MshStream::count(std::string_view what, std::size_t text_bytes,
                             std::size_t binary_bytes) {
  return checked(what, size(what), binary_ ? binary_bytes : text_bytes);
}

std::size_t MshStream::text_count(std::string_view what, std::size_t text_bytes,
                                  std::size_t binary_bytes) {
  const std::int64_t value = text_.integer(what);
  begin_numbers();
  return checked(what, value, binary_ ? binary_bytes : text_bytes);
}

}  // namespace tandem::fem
