// SPDX-License-Identifier: Apache-2.0

// tau_xy at the base from nodal reactions, beside the closed form: near nu = 1/2 it alternates from node to node, and
// a tactel that is two columns wide does not see that. docs/notebook/2026-11-23-accuracy.md has the
// printed table.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "fem/layer/layer_table.h"
#include "fem/layer/long_layer.h"
#include "fem/mesh/condensation.h"

namespace tactel::fem::base_reactions_test {

struct MeshSize {
  int columns, rows;
};

/// tau_xy at the base by tangential forces on the surface, 1/mm, on a mesh of the endless layer and in closed form. A
/// tactel is a point, or two columns wide.
class BaseShear {
 public:
  BaseShear(const Sensor& sensor, int columns)
      : h_(sensor.thickness), mesh_(long_layer(sensor, columns)), exact_(sensor.poisson) {}

  double spacing() const { return mesh_.spacing; }
  double on_mesh(int k, bool wide) const {
    const auto node = [&](int j) { return mesh_.tau_by_x[std::abs(j)]; };
    return wide ? (node(k - 1) + 2 * node(k) + node(k + 1)) / 4 : node(k);
  }
  double exact(int k, bool wide) const {
    const double x = k * spacing() / h_, half = spacing() / h_;
    if (!wide) return exact_.base(x).tau_by_x / h_;
    return (exact_.base_integral(x + half).tau_by_x - exact_.base_integral(x - half).tau_by_x) / (2 * spacing());
  }

  /// Largest error within 6 mm, over the largest stress, by forces [2 n + 1] on a node and n nodes on either side.
  double error(const std::vector<double>& force, bool wide) const {
    const int within = static_cast<int>(std::lround(6 / spacing())), n = static_cast<int>(force.size()) / 2;
    double error = 0, largest = 0;
    for (int k = -within; k <= within; ++k) {
      double mesh = 0, exact = 0;
      for (int j = -n; j <= n; ++j) {
        mesh += force[static_cast<std::size_t>(j + n)] * on_mesh(k - j, wide);
        exact += force[static_cast<std::size_t>(j + n)] * this->exact(k - j, wide);
      }
      error = std::max(error, std::abs(mesh - exact));
      largest = std::max(largest, std::abs(exact));
    }
    return error / largest;
  }

 private:
  double h_;
  LongLayer mesh_;
  LayerTable exact_;
};

/// Traction of a sliding parabola that touches on 2 mm, as forces on nodes.
std::vector<double> sliding_parabola(double spacing) {
  const int n = static_cast<int>(std::lround(1 / spacing));
  std::vector<double> force;
  for (int j = -n; j <= n; ++j) force.push_back(std::sqrt(std::max(0.0, 1 - std::pow(j * spacing, 2))));
  return force;
}

class BaseReactions : public testing::TestWithParam<MeshSize> {};

TEST_P(BaseReactions, AreExactUnderATactelOfTwoColumns) {
  const auto [columns, rows] = GetParam();
  for (const double poisson : {0.3, 0.45, 0.49, 0.499}) {
    SCOPED_TRACE(poisson);
    const Sensor sensor{.poisson = poisson, .columns = columns, .rows = rows};
    const BaseShear shear(sensor, columns);
    const std::vector<double> smooth = sliding_parabola(shear.spacing());
    const double point = shear.error({1}, false), wide = shear.error({1}, true);
    const double smooth_point = shear.error(smooth, false), smooth_wide = shear.error(smooth, true);
    std::printf("%d x %-3d nu %-6g one node: %8.4f, two columns wide %7.4f; on 2 mm: %7.4f, two columns wide %7.4f\n",
                columns, rows, poisson, point, wide, smooth_point, smooth_wide);
    // The error of the mesh: 0.06 with 41 columns, of an order between 1 and 2, down to what 25 rows resolve. At most a
    // hundredth of the checkerboard remains.
    const double limit = std::max(0.06 * std::pow(41.0 / columns, 1.25), 0.008);
    EXPECT_LT(wide, std::max(limit, point / 100));
    EXPECT_LT(smooth_wide, limit / 2);
    if (poisson <= 0.45) {
      EXPECT_LT(point, limit);
    }
  }
}
INSTANTIATE_TEST_SUITE_P(Meshes, BaseReactions,
                         testing::Values(MeshSize{41, 11}, MeshSize{81, 17}, MeshSize{161, 25}, MeshSize{321, 25},
                                         MeshSize{321, 49}, MeshSize{641, 25}),
                         [](const auto& info) {
                           return "Of" + std::to_string(info.param.columns) + "x" + std::to_string(info.param.rows);
                         });

// If the checkerboard goes, so does the advice in docs/accuracy.md.
TEST(BaseReactions, AlternateNearOneHalfWhereRowsAreTallerThanColumns) {
  Sensor sensor{.poisson = 0.499, .columns = 321, .rows = 25};
  EXPECT_GT(BaseShear(sensor, 321).error({1}, false), 1);
  sensor.rows = 49;
  EXPECT_LT(BaseShear(sensor, 321).error({1}, false), 0.02);
}

TEST(BaseReactions, OfATactelOfTwoColumnsAreThreeNodes) {
  Sensor point{.poisson = 0.499};
  Sensor wide = point;
  wide.tactels = 11;  // every second node but those at the ends
  wide.tactel_width = 1;
  wide.tactel_span = 10;
  point.tactels = 41;
  const Eigen::MatrixXd nodes = condense(point).tactel_stress, mean = condense(wide).tactel_stress;
  for (int t = 0; t < 11; ++t)
    for (const int component : {0, 1}) {
      const int node = 41 * component + 10 + 2 * t;
      const Eigen::RowVectorXd three = (nodes.row(node - 1) + 2 * nodes.row(node) + nodes.row(node + 1)) / 4;
      EXPECT_LT((mean.row(11 * component + t) - three).cwiseAbs().maxCoeff(), 1e-12);
    }
}

}  // namespace tactel::fem::base_reactions_test
