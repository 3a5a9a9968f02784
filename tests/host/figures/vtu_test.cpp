// SPDX-License-Identifier: Apache-2.0

// The VTK file of the field inside the block.
#include "host/figures/vtu.h"

#include <gtest/gtest.h>

#include <map>
#include <sstream>

#include "fem/gap/gap_reference.h"

namespace tactel::host::vtu_test {

fem::Scene small_scene(fem::Element element) {
  return {.sensor = {.columns = 21, .rows = 5, .element = element},
          .indenter = {.shape = fem::Parabola{.radius = 10.0}},
          .load = {.indentation = {0.15}}};
}

class Vtu : public testing::TestWithParam<fem::Element> {};

/// Number of numbers in each DataArray of a VTK file, by name.
std::map<std::string, std::size_t> counts_in(const std::string& vtu) {
  std::map<std::string, std::size_t> counts;
  for (std::size_t at = vtu.find("<DataArray"); at != std::string::npos; at = vtu.find("<DataArray", at + 1)) {
    const std::size_t name = vtu.find("Name=\"", at) + 6, open = vtu.find('>', at) + 1;
    std::istringstream numbers(vtu.substr(open, vtu.find("</DataArray>", open) - open));
    std::size_t& count = counts[vtu.substr(name, vtu.find('"', name) - name)];
    for (double value = 0; numbers >> value;) ++count;
  }
  return counts;
}

TEST_P(Vtu, HoldsEveryNodeAndCell) {
  const fem::Scene scene = small_scene(GetParam());
  const fem::StressField field = fem::stress_field(scene.sensor, fem::solve_gap_reference(scene).steps.back());
  const std::string vtu = to_vtu(field);
  const auto nodes = static_cast<std::size_t>(field.mesh.node.cols()),
             cells = static_cast<std::size_t>(field.mesh.cell.rows());
  EXPECT_EQ(cells, 20u * 4u);
  std::map<std::string, std::size_t> counts = counts_in(vtu);
  for (const char* name : {"sigma_x", "sigma_y", "tau_xy", "sigma_z", "von_mises", "strain", "beyond_linear"})
    EXPECT_EQ(counts[name], nodes) << name;
  EXPECT_EQ(counts["displacement"], 3 * nodes);
  EXPECT_EQ(counts["Points"], 3 * nodes);
  EXPECT_EQ(counts["connectivity"], cells * static_cast<std::size_t>(field.mesh.cell.cols()));
  EXPECT_EQ(counts["offsets"], cells);
  EXPECT_EQ(counts["types"], cells);
  EXPECT_NE(vtu.find("NumberOfPoints=\"" + std::to_string(nodes) + "\""), std::string::npos);
}

// The rubber of a pad: each number at each point, the first at the base, the last at the surface.
TEST(Vts, HoldsEveryPointOfTheRubber) {
  const fem::PadScene scene{.load = {.indentation = {0.2}}};
  const fem::PadLayer layer(scene.sensor.poisson);
  const fem::PadField field = fem::pad_field(scene, fem::PadSolver(layer, {.cells = 8}).solve(scene), 0);
  const auto points = static_cast<std::size_t>(field.place.cols());
  EXPECT_EQ(points, static_cast<std::size_t>(field.points[0] * field.points[1] * field.points[2]));
  std::map<std::string, std::size_t> counts = counts_in(to_vts(field));
  for (const char* name : {"sigma_x", "sigma_y", "sigma_z", "tau_xy", "tau_yz", "tau_xz"})
    EXPECT_EQ(counts[name], points) << name;
  EXPECT_EQ(counts["displacement"], 3 * points);
  EXPECT_EQ(counts["Points"], 3 * points);
  EXPECT_EQ(field.place(2, 0), 0);
  EXPECT_DOUBLE_EQ(field.place(2, field.place.cols() - 1), scene.sensor.thickness);
}

INSTANTIATE_TEST_SUITE_P(Elements, Vtu, testing::Values(fem::Element::bbar, fem::Element::q4i, fem::Element::q8),
                         [](const auto& info) { return fem::name(info.param); });

}  // namespace tactel::host::vtu_test
