// SPDX-License-Identifier: Apache-2.0
#include "fem/mesh/mesh.h"

#include <gmock/gmock.h>

#include "fem/mesh/block.h"
#include "sensors.h"

namespace tactel::fem::mesh_test {

using testing::ElementsAre;

Sensor small(Element element = Element::q4) {
  return {.length = 4, .thickness = 7, .columns = 3, .rows = 4, .grading = 4, .element = element};
}

TEST(Mesh, RowsFallGeometricallyFromTheBase) {
  // Heights 4, 2, 1: ratio 1/2, bottom over top 4, sum 7.
  const Mesh mesh = make_mesh(small());
  EXPECT_DOUBLE_EQ(mesh.node(1, 0), 0);
  EXPECT_DOUBLE_EQ(mesh.node(1, 3), 4);
  EXPECT_DOUBLE_EQ(mesh.node(1, 6), 6);
  EXPECT_EQ(mesh.node(1, 9), 7);  // exactly the thickness
}

TEST(Mesh, BottomOverTopIsTheGradingExactly) {
  for (double grading : {0.5, 1.0, 2.75, 4.0, 100.0}) {
    Sensor sensor = mesh_a();
    sensor.grading = grading;
    const Mesh mesh = make_mesh(sensor);
    const auto y = [&](int row) { return mesh.node(1, row * sensor.columns); };
    // Top rows are differences of numbers near 1.5: 2e-16 over a height of 0.002 to 0.05.
    EXPECT_NEAR((y(1) - y(0)) / (y(32) - y(31)), grading, 1e-12 * grading);
  }
}

TEST(Mesh, OneRowIsTheWholeThickness) {
  Sensor sensor = small();
  sensor.rows = 2;
  const Mesh mesh = make_mesh(sensor);
  EXPECT_EQ(mesh.node(1, 0), 0);
  EXPECT_EQ(mesh.node(1, 3), 7);
}

// Even rows lie 0.1 mm apart: that at 0.9 moves to 0.88, that at 0.4 to 0.44, or to 0.402; thin layers take a row each.
TEST(Mesh, RowsMeetTheInterfacesOfLayers) {
  const auto heights = [](std::vector<RubberLayer> layers) {
    Sensor sensor{.length = 2, .columns = 3, .rows = 11, .grading = 1, .tactels = 3, .layers = std::move(layers)};
    const Mesh mesh = make_mesh(with_layers(sensor));
    std::vector<double> y;
    for (int j = 0; j < 11; ++j) y.push_back(mesh.node(1, 3 * j));
    return y;
  };
  const auto near = [](std::vector<double> y) { return testing::Pointwise(testing::DoubleNear(1e-12), y); };
  EXPECT_THAT(heights({{0.44, 1}, {0.44, 2}, {0.12, 3}}),
              near({0, 0.11, 0.22, 0.33, 0.44, 0.528, 0.616, 0.704, 0.792, 0.88, 1}));
  EXPECT_THAT(heights({{0.4, 1}, {0.002, 2}, {0.598, 3}}),
              near({0, 0.1, 0.2, 0.3, 0.4, 0.402, 0.5216, 0.6412, 0.7608, 0.8804, 1}));
  EXPECT_THAT(heights({{0.98, 1}, {0.008, 2}, {0.004, 3}, {0.008, 2}}),
              near({0, 0.14, 0.28, 0.42, 0.56, 0.7, 0.84, 0.98, 0.988, 0.992, 1}));
}

TEST(Mesh, ColumnsAreEquallySpacedAndMirrored) {
  const Eigen::VectorXd x = surface_positions(mesh_a());
  EXPECT_EQ(x[0], -10);
  EXPECT_EQ(x[122], 10);
  for (int i = 0; i < 123; ++i) {
    EXPECT_EQ(x[i], -x[122 - i]);
    EXPECT_NEAR(x[i], -10 + 20.0 * i / 122, 1e-14);  // two roundings of numbers up to 20
  }
}

TEST(Mesh, CellsAreCounterClockwiseFromTheLowerLeft) {
  const Mesh mesh = make_mesh(small());
  ASSERT_EQ(mesh.cell.rows(), 6);
  EXPECT_EQ(mesh.cell.row(0), Eigen::RowVector4i(0, 1, 4, 3));
  EXPECT_EQ(mesh.cell.row(5), Eigen::RowVector4i(7, 8, 11, 10));
  EXPECT_THAT(mesh.base, ElementsAre(0, 1, 2));
  EXPECT_THAT(mesh.surface, ElementsAre(9, 10, 11));
}

TEST(Mesh, MidSideNodesStandInTheMiddles) {
  const Mesh mesh = make_mesh(small(Element::q8));
  ASSERT_EQ(mesh.node.cols(), 12 + 2 * 4 + 3 * 3);
  EXPECT_THAT(mesh.surface, ElementsAre(9, 10, 11));  // corners only: these carry gap elements
  EXPECT_EQ(mesh.base.size(), 5u);
  for (std::size_t k = 0; k < 5; ++k) EXPECT_EQ(mesh.node.col(mesh.base[k]), Eigen::Vector2d(-2.0 + double(k), 0));
  for (const auto& cell : mesh.cell.rowwise())
    for (int side = 0; side < 4; ++side)
      EXPECT_EQ(mesh.node.col(cell[4 + side]), (mesh.node.col(cell[side]) + mesh.node.col(cell[(side + 1) % 4])) / 2);
}

TEST(Mesh, TactelsStandFromEndToEnd) {
  const Eigen::VectorXd x = tactel_positions(mesh_b());
  ASSERT_EQ(x.size(), 21);
  for (int t = 0; t < 21; ++t) EXPECT_DOUBLE_EQ(x[t], -10.0 + t);
}

}  // namespace tactel::fem::mesh_test
