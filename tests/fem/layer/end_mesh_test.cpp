// SPDX-License-Identifier: Apache-2.0

// The mesh graded towards a contact near an end; the contacts on it stand in tests/host/answers/over_end_test.cpp.
#include "fem/layer/end_mesh.h"

#include <gtest/gtest.h>

#include "fem/mesh/mesh.h"

namespace tactel::fem::end_mesh_test {

TEST(EndMesh, IsWithinHalfAThicknessOfAnEnd) {
  const Sensor sensor;  // 20 mm long, 1.5 mm thick
  EXPECT_FALSE(near_end(sensor, {-9.24, 9.24}));
  EXPECT_TRUE(near_end(sensor, {-9.26, 0}));
  EXPECT_TRUE(near_end(sensor, {9, 9.26}));
}

TEST(EndMesh, ColumnsHoldTheContactAndWidenBeyondIt) {
  const Sensor sensor;
  const Eigen::VectorXd nodes = Eigen::VectorXd::LinSpaced(11, 9, 10), x = graded_columns(sensor, nodes);
  EXPECT_DOUBLE_EQ(x[0], -10);
  EXPECT_EQ(x.tail(11), nodes);
  const Eigen::VectorXd width = x.tail(x.size() - 1) - x.head(x.size() - 1);
  EXPECT_GT(width.minCoeff(), 0.09);
  EXPECT_LE(width.maxCoeff(), 1.5 / 12 + 1e-12);
}

// With all nodes of a uniform mesh as the contact, the mesh is that of the sensor.
TEST(EndMesh, OfAllNodesIsTheMeshOfTheSensor) {
  const Sensor sensor{.length = 6, .columns = 31, .rows = 33, .grading = 64};
  const LayerModel model = endless_layer(sensor);
  const Condensation found = end_condensation(model, surface_positions(sensor)), mesh = condense(sensor);
  EXPECT_LT((found.compliance - mesh.compliance).cwiseAbs().maxCoeff(), 1e-12 * mesh.compliance.maxCoeff());
}

}  // namespace tactel::fem::end_mesh_test
