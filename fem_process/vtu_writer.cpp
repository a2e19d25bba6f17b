#include "fem_process/vtu_writer.h"

#include <algorithm>
#include <bit>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <span>
#include <utility>

#include "protocol/contract/error.h"

namespace tandem::fem {
namespace {

static_assert(std::endian::native == std::endian::little, "the files say LittleEndian");

constexpr std::uint8_t kVtkTetra = 10;
constexpr std::uint8_t kVtkQuadraticTetra = 24;  // its nodes in the order of TetMesh

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

/// A DataArray in VTK's inline binary form: byte count (UInt32) and values, base64 together.
template <class T>
std::string data_array(const std::string& name, const char* type, int components,
                       std::span<const T> values) {
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

std::string vectors(const std::string& name, const Eigen::VectorXd& values) {
  return data_array<double>(name, "Float64", 3,
                            {values.data(), static_cast<std::size_t>(values.size())});
}

std::string cells(const Model& model) {
  std::vector<std::int32_t> connectivity;
  std::vector<std::int32_t> offsets;
  for (std::size_t e = 0; e < model.mesh.tets.size(); ++e) {
    const std::vector<int> nodes = model.mesh.element(e);
    connectivity.insert(connectivity.end(), nodes.begin(), nodes.end());
    offsets.push_back(static_cast<std::int32_t>(connectivity.size()));
  }
  const std::vector<std::uint8_t> types(offsets.size(),
                                        model.mesh.second_order() ? kVtkQuadraticTetra : kVtkTetra);
  return "<Cells>\n" + data_array<std::int32_t>("connectivity", "Int32", 1, connectivity) +
         data_array<std::int32_t>("offsets", "Int32", 1, offsets) +
         data_array<std::uint8_t>("types", "UInt8", 1, types) + "</Cells>\n";
}

std::string cell_data(const Model& model, const State& state) {
  std::vector<double> stress;
  std::vector<double> angle;
  for (const ElementResult& element : model.formulation->element_results(state.x)) {
    stress.push_back(element.von_mises_Pa);
    angle.push_back(element.rotation_rad);
  }
  return "<CellData Scalars=\"von_mises_Pa\">\n" +
         data_array<double>("von_mises_Pa", "Float64", 1, stress) +
         data_array<double>("rotation_rad", "Float64", 1, angle) + "</CellData>\n";
}

void save(const std::filesystem::path& file, const std::string& text) {
  std::ofstream out(file, std::ios::binary);
  out << text;
  out.close();
  if (out.good()) return;
  throw Error(ErrorKind::System,
              "fem: cannot write " + file.string() + ". Check the folder and the free space.");
}

}  // namespace

std::string vtu_text(const Model& model, const State& state) {
  const Eigen::VectorXd displacement = state.x - model.reference();
  return "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"0.1\" "
         "byte_order=\"LittleEndian\" header_type=\"UInt32\">\n<UnstructuredGrid>\n"
         "<Piece NumberOfPoints=\"" +
         std::to_string(model.mesh.nodes()) + "\" NumberOfCells=\"" +
         std::to_string(model.mesh.tets.size()) + "\">\n<PointData Vectors=\"displacement_m\">\n" +
         vectors("displacement_m", displacement) + vectors("velocity_m_per_s", state.v) +
         "</PointData>\n" + cell_data(model, state) + "<Points>\n" +
         vectors("position_m", state.x) + "</Points>\n" + cells(model) +
         "</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
}

VtuWriter::VtuWriter(const Model& model, std::filesystem::path folder, std::string name,
                     std::int64_t every_steps)
    : model_(model), folder_(std::move(folder)), name_(std::move(name)), every_steps_(every_steps) {
  require(every_steps_ > 0, "fem: output.vtu_every_steps must be positive to write .vtu files.");
  std::error_code error;
  std::filesystem::create_directories(folder_, error);
  require(!error, "fem: cannot create the folder " + folder_.string() + ": " + error.message());
}

void VtuWriter::write(const State& state) {
  const std::int64_t step = seen_++;
  if (step % every_steps_ != 0) return;
  char number[24];
  std::snprintf(number, sizeof number, "_%06lld", static_cast<long long>(step));
  const std::string file = name_ + number + ".vtu";
  save(folder_ / file, vtu_text(model_, state));
  written_.emplace_back(to_seconds(state.time), file);
  write_pvd();
}

void VtuWriter::write_pvd() const {
  std::string text = "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n";
  text += "<Collection>\n";
  for (const auto& [time, file] : written_) {
    char value[40];
    std::snprintf(value, sizeof value, "%.17g", time);
    text += "<DataSet timestep=\"" + std::string(value) + "\" part=\"0\" file=\"" + file + "\"/>\n";
  }
  text += "</Collection>\n</VTKFile>\n";
  save(folder_ / (name_ + ".pvd"), text);
}

}  // namespace tandem::fem
