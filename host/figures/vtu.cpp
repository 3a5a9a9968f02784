// SPDX-License-Identifier: Apache-2.0
#include "host/figures/vtu.h"

#include <array>
#include <charconv>
#include <concepts>
#include <type_traits>
#include <vector>

#include "host/figures/contact_view.h"

namespace tactel::host {
namespace {

/// One number as text that reads back to the same bits.
void append(std::string& out, std::floating_point auto value) {
  char text[32];
  out.append(text, std::to_chars(text, text + sizeof text, value).ptr);
  out += ' ';
}

std::string data_array(const std::string& attributes, const auto& values) {
  std::string out = "        <DataArray " + attributes + " format=\"ascii\">\n";
  for (const auto value : values)
    if constexpr (std::is_same_v<decltype(value), const float>)
      append(out, value);
    else
      append(out, static_cast<double>(value));
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

constexpr int vtk_quad = 9, vtk_quadratic_quad = 23;  // VTK's cell types; node order as in fem::Mesh

/// `nodes` [cells][nodes of a cell].
std::string cells(const Eigen::MatrixXi& nodes, int type) {
  std::vector<Eigen::Index> offsets;
  for (Eigen::Index i = 1; i <= nodes.rows(); ++i) offsets.push_back(i * nodes.cols());
  const std::vector<int> types(static_cast<std::size_t>(nodes.rows()), type);
  return "      <Cells>\n" + data_array("type=\"Int32\" Name=\"connectivity\"", nodes.reshaped<Eigen::RowMajor>()) +
         data_array("type=\"Int32\" Name=\"offsets\"", offsets) + data_array("type=\"UInt8\" Name=\"types\"", types) +
         "      </Cells>\n";
}

/// A file of one piece. `data`: PointData or CellData; `points` [points, 3] mm.
std::string document(const std::string& data, const std::vector<double>& points, const Eigen::MatrixXi& nodes,
                     int type) {
  return "<?xml version=\"1.0\"?>\n<!-- lengths in mm, stresses in MPa -->\n"
         "<VTKFile type=\"UnstructuredGrid\" version=\"0.1\" byte_order=\"LittleEndian\">\n  <UnstructuredGrid>\n"
         "    <Piece NumberOfPoints=\"" +
         std::to_string(points.size() / 3) + "\" NumberOfCells=\"" + std::to_string(nodes.rows()) + "\">\n" + data +
         "      <Points>\n" + data_array("type=\"Float64\" Name=\"Points\" NumberOfComponents=\"3\"", points) +
         "      </Points>\n" + cells(nodes, type) + "    </Piece>\n  </UnstructuredGrid>\n</VTKFile>\n";
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
  return document(point_data(field), in_space(field.mesh.node), field.mesh.cell,
                  field.mesh.cell.cols() == 8 ? vtk_quadratic_quad : vtk_quad);
}

std::string to_vtu(const fem::PadScene& scene, const fem::PadSolution& solution, std::size_t step) {
  const fem::PadCells& grid = solution.cells;
  const fem::PadStep& at = solution.steps[step];
  const Eigen::MatrixX2d corners = cell_corners(scene.indenter, grid);
  std::vector<double> points, shear;
  for (const auto& corner : corners.rowwise())
    points.insert(points.end(), {corner[0], corner[1], scene.sensor.thickness});
  for (const auto& force : at.tangential_force.rowwise())
    shear.insert(shear.end(), {force[0] / grid.area(), force[1] / grid.area(), 0.0});
  const std::string data = "      <CellData Vectors=\"tangential_traction\" Scalars=\"normal_traction\">\n" +
                           scalars("normal_traction", at.normal_force / grid.area()) +
                           data_array("type=\"Float64\" Name=\"tangential_traction\" NumberOfComponents=\"3\"", shear) +
                           data_array("type=\"UInt8\" Name=\"status\"", at.status) + "      </CellData>\n";
  return document(data, points, corners_of_cells(grid.n), vtk_quad);
}

std::string to_vts(const fem::PadField& field) {
  const auto& [nx, ny, nz] = field.points;
  const std::string extent =
      "0 " + std::to_string(nx - 1) + " 0 " + std::to_string(ny - 1) + " 0 " + std::to_string(nz - 1);
  std::string out =
      "<?xml version=\"1.0\"?>\n<!-- lengths in mm, stresses in MPa -->\n"
      "<VTKFile type=\"StructuredGrid\" version=\"0.1\" byte_order=\"LittleEndian\">\n  <StructuredGrid "
      "WholeExtent=\"" +
      extent + "\">\n    <Piece Extent=\"" + extent +
      "\">\n      <PointData Vectors=\"displacement\" Scalars=\"sigma_z\">\n" +
      data_array("type=\"Float32\" Name=\"displacement\" NumberOfComponents=\"3\"",
                 field.displacement.cast<float>().eval().reshaped());
  const std::array<const char*, 6> names{"sigma_x", "sigma_y", "sigma_z", "tau_xy", "tau_yz", "tau_xz"};
  for (std::size_t s = 0; s < names.size(); ++s)
    out += data_array("type=\"Float32\" Name=\"" + std::string(names[s]) + "\"",
                      field.stress.row(static_cast<Eigen::Index>(s)).cast<float>().eval());
  return out + "      </PointData>\n      <Points>\n" +
         data_array("type=\"Float32\" Name=\"Points\" NumberOfComponents=\"3\"",
                    field.place.cast<float>().eval().reshaped()) +
         "      </Points>\n    </Piece>\n  </StructuredGrid>\n</VTKFile>\n";
}

std::string field_of(const std::string& file, const fem::PadScene& scene, const fem::PadSolution& solution,
                     std::size_t step) {
  return file.ends_with(".vts") ? to_vts(fem::pad_field(scene, solution, step)) : to_vtu(scene, solution, step);
}

}  // namespace tactel::host
