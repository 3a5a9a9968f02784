// The field inside the block and its VTK file.
#include "host/stress_field.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <sstream>

#include "fem/gap_reference.h"

namespace tactel::host {
namespace {

fem::Scene small_scene(fem::Element element) {
  fem::Scene scene;
  scene.sensor.columns = 21;
  scene.sensor.rows = 5;
  scene.sensor.element = element;
  scene.indenter.shape = fem::Parabola{.radius = 10.0};
  scene.load.indentation = {0.15};
  return scene;
}

TEST(StressMeasures, VonMisesByHand) {
  EXPECT_DOUBLE_EQ(von_mises({3.0, 0.0, 0.0, 0.0}), 3.0);             // one-axial: the stress itself
  EXPECT_DOUBLE_EQ(von_mises({-2.0, -2.0, 0.0, -2.0}), 0.0);          // pressure alone
  EXPECT_DOUBLE_EQ(von_mises({0.0, 0.0, 1.0, 0.0}), std::sqrt(3.0));  // pure shear
}

TEST(StressMeasures, PrincipalStrainByHand) {
  EXPECT_DOUBLE_EQ(largest_principal_strain({0.2, 0.0, 0.0, 0.0}, 2.0, 0.3), 0.1);   // sigma / E along x
  EXPECT_DOUBLE_EQ(largest_principal_strain({0.0, -0.4, 0.0, 0.0}, 2.0, 0.3), 0.2);  // compression counts by size
  EXPECT_DOUBLE_EQ(largest_principal_strain({0.0, 0.0, 0.1, 0.0}, 2.0, 0.25),
                   0.0625);  // shear: gamma / 2 = (1 + nu) tau / E
}

class FieldOf : public testing::TestWithParam<fem::Element> {};

TEST_P(FieldOf, TouchingNodesLieOnTheIndenter) {
  const fem::Scene scene = small_scene(GetParam());
  const fem::ContactSolution solution = fem::solve_gap_reference(scene);
  const fem::ContactStep& step = solution.steps.back();
  const StressField field = stress_field(scene.sensor, step);
  int touching = 0;
  for (std::size_t i = 0; i < step.status.size(); ++i) {
    if (step.status[i] == fem::GapStatus::open) continue;
    ++touching;
    const double x = solution.surface_x[static_cast<Eigen::Index>(i)];
    // the closed gap: u_y = profile - depth; fp64 forces of a block with condition below 1e6
    EXPECT_NEAR(field.displacement(1, field.mesh.surface[i]), x * x / 20.0 - 0.15, 1e-10);
  }
  EXPECT_GE(touching, 3);
  for (const int node : field.mesh.base) EXPECT_EQ(field.displacement.col(node).norm(), 0.0);
}

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

TEST_P(FieldOf, VtuHoldsEveryNodeAndCell) {
  const fem::Scene scene = small_scene(GetParam());
  const StressField field = stress_field(scene.sensor, fem::solve_gap_reference(scene).steps.back());
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

INSTANTIATE_TEST_SUITE_P(Elements, FieldOf, testing::Values(fem::Element::bbar, fem::Element::q4i, fem::Element::q8),
                         [](const auto& info) { return fem::name(info.param); });

TEST(StressField, UniformPressureOnAWideBlock) {
  // A flat indenter wider than a long block without friction, nu = 0: every column is compressed by itself, sigma_y =
  // -E depth / thickness.
  fem::Scene scene = small_scene(fem::Element::q4);
  scene.sensor.poisson = 0.0;
  scene.indenter.shape = fem::Flat{};
  scene.friction = 0.0;
  scene.load.indentation = {0.03};
  const StressField field = stress_field(scene.sensor, fem::solve_gap_reference(scene).steps.back());
  const double stress = -2.0 * 0.03 / 1.5;
  EXPECT_LT((field.stress.row(1).array() - stress).abs().maxCoeff(), 1e-12);  // exact but for rounding
  EXPECT_LT(field.stress.row(0).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LT((field.strain.array() - 0.02).abs().maxCoeff(), 1e-12);
}

}  // namespace
}  // namespace tactel::host
