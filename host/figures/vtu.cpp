// SPDX-License-Identifier: Apache-2.0
#include "host/figures/vtu.h"

#include <charconv>
#include <vector>

namespace tactel::host {
namespace {

/// One number as text that reads back to the same bits.
void append(std::string& out, double value) {
  char text[32];
  out.append(text, std::to_chars(text, text + sizeof text, value).ptr);
  out += ' ';
}

std::string data_array(const std::string& attributes, const auto& values) {
  std::string out = "        <DataArray " + attributes + " format=\"ascii\">\n";
  for (const auto value : values) append(out, static_cast<double>(value));
  return out + "\n        </DataArray>\n";
}

std::string scalars(const std::string& name, const auto& values) {
  return data_array("type=\"Float64\" Name=\"" + name + "\"", values);
}

/// [nodes, 3], with z = 0.
std::vector<double> in_space(const Eigen::Matrix2Xd& plane) {
  std::vector<double> out;
  for (Eigen::Index k = 0; k < plane.cols(); ++k) out.insert(out.end(), {plane(0, k), plane(1, k), 0.0});
  return out;
}

std::string cells(const fem::Mesh& mesh) {
  constexpr int vtk_quad = 9, vtk_quadratic_quad = 23;  // VTK's cell types; node order as in fem::Mesh
  const Eigen::Index count = mesh.cell.rows(), nodes = mesh.cell.cols();
  std::vector<Eigen::Index> offsets;
  for (Eigen::Index i = 1; i <= count; ++i) offsets.push_back(i * nodes);
  const std::vector<int> types(static_cast<std::size_t>(count), nodes == 8 ? vtk_quadratic_quad : vtk_quad);
  return "      <Cells>\n" + data_array("type=\"Int32\" Name=\"connectivity\"", mesh.cell.reshaped<Eigen::RowMajor>()) +
         data_array("type=\"Int32\" Name=\"offsets\"", offsets) + data_array("type=\"UInt8\" Name=\"types\"", types) +
         "      </Cells>\n";
}

std::string point_data(const fem::StressField& field) {
  const Eigen::VectorXi beyond = (field.strain.array() > fem::linear_strain_limit).cast<int>();
  return "      <PointData Vectors=\"displacement\" Scalars=\"sigma_y\">\n" +
         data_array("type=\"Float64\" Name=\"displacement\" NumberOfComponents=\"3\"", in_space(field.displacement)) +
         scalars("sigma_x", field.stress.row(0)) + scalars("sigma_y", field.stress.row(1)) +
         scalars("tau_xy", field.stress.row(2)) + scalars("sigma_z", field.stress.row(3)) +
         scalars("von_mises", field.von_mises) + scalars("strain", field.strain) +
         data_array("type=\"UInt8\" Name=\"beyond_linear\"", beyond) + "      </PointData>\n";
}

}  // namespace

std::string to_vtu(const fem::StressField& field) {
  return "<?xml version=\"1.0\"?>\n<!-- lengths in mm, stresses in MPa -->\n"
         "<VTKFile type=\"UnstructuredGrid\" version=\"0.1\" byte_order=\"LittleEndian\">\n  <UnstructuredGrid>\n"
         "    <Piece NumberOfPoints=\"" +
         std::to_string(field.mesh.node.cols()) + "\" NumberOfCells=\"" + std::to_string(field.mesh.cell.rows()) +
         "\">\n" + point_data(field) + "      <Points>\n" +
         data_array("type=\"Float64\" Name=\"Points\" NumberOfComponents=\"3\"", in_space(field.mesh.node)) +
         "      </Points>\n" + cells(field.mesh) + "    </Piece>\n  </UnstructuredGrid>\n</VTKFile>\n";
}

}  // namespace tactel::host
