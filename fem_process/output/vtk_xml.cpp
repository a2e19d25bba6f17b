#include "fem_process/output/vtk_xml.h"

#include <algorithm>
#include <bit>
#include <cstdio>
#include <cstring>

#include "protocol/contract/error.h"
#include "protocol/contract/whole_file.h"

namespace tandem::fem {
namespace {

static_assert(std::endian::native == std::endian::little, "the files say LittleEndian");

std::string base64(const std::vector<unsigned char>& bytes) {
  static constexpr char kDigits[] =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve(4 * (bytes.size() / 3 + 1));
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t n = std::min<std::size_t>(3, bytes.size() - i);
    unsigned triple = 0;
    for (std::size_t k = 0; k < 3; ++k) triple = triple << 8 | (k < n ? bytes[i + k] : 0U);
    for (std::size_t k = 0; k < 4; ++k) {
      text += k <= n ? kDigits[triple >> (18 - 6 * k) & 63U] : '=';
    }
  }
  return text;
}

}  // namespace

std::string data_array_of_bytes(const std::string& name, const char* type, int components,
                                std::span<const std::byte> values) {
  const auto size = static_cast<std::uint32_t>(values.size_bytes());
  require(size == values.size_bytes(), "fem: an array of a .vtu file is larger than 4 GiB.");
  std::vector<unsigned char> bytes(sizeof size + values.size_bytes());
  std::memcpy(bytes.data(), &size, sizeof size);
  if (!values.empty()) std::memcpy(bytes.data() + sizeof size, values.data(), size);
  std::string text = "<DataArray type=\"";
  text += type;
  text += "\" Name=\"" + name + "\" NumberOfComponents=\"" + std::to_string(components) +
          "\" format=\"binary\">" + base64(bytes) + "</DataArray>\n";
  return text;
}

VtuSeries::VtuSeries(std::filesystem::path folder, std::string name, std::int64_t every_steps)
    : folder_(std::move(folder)), name_(std::move(name)), every_steps_(every_steps) {
  require(every_steps_ > 0, "fem: output.vtu_every_steps must be positive to write .vtu files.");
  std::error_code error;
  std::filesystem::create_directories(folder_, error);
  require(!error, "fem: cannot create the folder " + folder_.string() + ": " + error.message());
}

bool VtuSeries::wants_next() { return seen_++ % every_steps_ == 0; }

void VtuSeries::write(SimTime time, const std::string& vtu) {
  char number[24];
  std::snprintf(number, sizeof number, "_%06lld", static_cast<long long>(seen_ - 1));
  const std::string file = name_ + number + ".vtu";
  write_whole_file(folder_ / file, vtu);
  written_.emplace_back(to_seconds(time), file);
  write_pvd();
}

void VtuSeries::write_pvd() const {
  std::string text = "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n";
  text += "<Collection>\n";
  for (const auto& [time, file] : written_) {
    char value[40];
    std::snprintf(value, sizeof value, "%.17g", time);
    text += "<DataSet timestep=\"" + std::string(value) + "\" part=\"0\" file=\"" + file + "\"/>\n";
  }
  text += "</Collection>\n</VTKFile>\n";
  write_whole_file(folder_ / (name_ + ".pvd"), text);
}

}  // namespace tandem::fem
