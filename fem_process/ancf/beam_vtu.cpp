#include "fem_process/ancf/beam_vtu.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "fem_process/output/vtk_xml.h"

namespace tandem::fem::ancf {
namespace {

constexpr std::uint8_t kVtkHexahedron = 12;

struct Solid {
  std::vector<double> points, velocities, strain, pressure;
  std::vector<std::int32_t> element, connectivity, offsets;
};

void append(const Eigen::Vector3d& v, std::vector<double>& out) {
  out.insert(out.end(), v.data(), v.data() + 3);
}

void add_element(const BeamBody& body, int e, int slices, double pressure, Solid& solid) {
  const BeamMesh& mesh = body.system().mesh();
  const BeamSection& section = body.params().model.section;
  const double length = mesh.elements[static_cast<std::size_t>(e)].length_m;
  const BeamVectors r = mesh.gather(e, body.state().q);
  const BeamVectors v = mesh.gather(e, body.state().v);
  const double y = 0.5 * section.width_m;
  const double z = 0.5 * section.height_m;
  const std::array<std::pair<double, double>, 4> corners{{{-y, -z}, {y, -z}, {y, z}, {-y, z}}};
  const auto first = static_cast<std::int32_t>(solid.points.size() / 3);
  for (int k = 0; k <= slices; ++k) {
    const double xi = static_cast<double>(k) / slices;
    for (const auto& [cy, cz] : corners) {
      const auto s = shape_values(length, xi, cy, cz);
      append(r * s, solid.points);
      append(v * s, solid.velocities);
    }
    if (k == slices) break;
    const auto gradient = shape_gradients(length, (k + 0.5) / slices, 0.0, 0.0);
    solid.strain.push_back((r * gradient.col(0)).norm() - 1.0);
    solid.pressure.push_back(pressure);
    solid.element.push_back(e);
    for (std::int32_t n = 0; n < 8; ++n) solid.connectivity.push_back(first + 4 * k + n);
    solid.offsets.push_back(static_cast<std::int32_t>(solid.connectivity.size()));
  }
}

std::string doubles(const char* name, int components, const std::vector<double>& values) {
  return data_array<double>(name, "Float64", components, values);
}

std::string integers(const char* name, const std::vector<std::int32_t>& values) {
  return data_array<std::int32_t>(name, "Int32", 1, values);
}

}  // namespace

std::string vtu_text(const BeamBody& body, int slices) {
  Solid solid;
  const std::vector<double> pressure =
      body.contact().pressures(body.state().q, body.state().v, body.motions());
  for (int e = 0; e < static_cast<int>(pressure.size()); ++e) {
    add_element(body, e, slices, pressure[static_cast<std::size_t>(e)], solid);
  }
  const std::vector<std::uint8_t> types(solid.offsets.size(), kVtkHexahedron);
  return "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"0.1\" "
         "byte_order=\"LittleEndian\" header_type=\"UInt32\">\n<UnstructuredGrid>\n"
         "<Piece NumberOfPoints=\"" +
         std::to_string(solid.points.size() / 3) + "\" NumberOfCells=\"" +
         std::to_string(solid.offsets.size()) + "\">\n<PointData Vectors=\"velocity_m_per_s\">\n" +
         doubles("velocity_m_per_s", 3, solid.velocities) +
         "</PointData>\n<CellData Scalars=\"axial_strain\">\n" +
         doubles("axial_strain", 1, solid.strain) +
         doubles("contact_pressure_Pa", 1, solid.pressure) + integers("element", solid.element) +
         "</CellData>\n<Points>\n" + doubles("position_m", 3, solid.points) +
         "</Points>\n<Cells>\n" + integers("connectivity", solid.connectivity) +
         integers("offsets", solid.offsets) + data_array<std::uint8_t>("types", "UInt8", 1, types) +
         "</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
}

}  // namespace tandem::fem::ancf
