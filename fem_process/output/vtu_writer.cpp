#include "fem_process/output/vtu_writer.h"

#include <span>
#include <utility>

namespace tandem::fem {
namespace {

constexpr std::uint8_t kVtkTetra = 10;
constexpr std::uint8_t kVtkQuadraticTetra = 24;  // its nodes in the order of TetMesh

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
    : model_(model), series_(std::move(folder), std::move(name), every_steps) {}

void VtuWriter::write(const State& state) {
  if (series_.wants_next()) series_.write(state.time, vtu_text(model_, state));
}

}  // namespace tandem::fem
