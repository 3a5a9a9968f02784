// SPDX-License-Identifier: Apache-2.0

// The endless finite element layer against a long block and the closed kernels; free sides at low rank against the
// dense difference; patches with sides against the whole mesh.
#include "fem/layer/free_sides.h"

#include <gtest/gtest.h>

#include <cmath>

#include "../sensors.h"
#include "fem/gap/gap_condensed.h"
#include "fem/layer/element_compliance.h"
#include "fem/layer/long_layer.h"
#include "fem/layer/patch_solver.h"
#include "fem/numbers/cache_directory.h"
#include "fem/numbers/value_error.h"

namespace tactel::fem::free_sides_test {

Sensor with_poisson(double poisson) { return {.poisson = poisson}; }

TEST(LongLayer, IsTheMiddleOfALongBlock) {
  // 40 thicknesses long: what the ends change in the middle, 20 h there and back at e^(-0.75 x / h), is e^-30.
  for (const Element element : {Element::bbar, Element::q4i}) {
    Sensor block = with_poisson(0.45);
    block.element = element;
    block.length = 60;
    block.columns = 241;
    block.rows = 7;
    const Condensation c = condense(block);
    const LongLayer layer = long_layer(block, 20);
    constexpr int middle = 120;
    EXPECT_EQ(layer.spacing, 0.25);
    for (int k = 0; k <= 20; ++k) {
      SCOPED_TRACE(k);
      const int i = 2 * (middle + k), j = 2 * middle;
      EXPECT_NEAR(layer.xx[k], c.compliance(i, j), 1e-9);
      EXPECT_NEAR(layer.yy[k], c.compliance(i + 1, j + 1), 1e-9);
      EXPECT_NEAR(layer.xy[k], c.compliance(i, j + 1), 1e-9);
      EXPECT_NEAR(-layer.xy[k], c.compliance(i + 1, j), 1e-9);
    }
    // Tactels lie on nodes, 3 mm apart: k = 0, 12. Their stress is that of the base nodes.
    for (int t = 0; t < 2; ++t) {
      const int tactel = 10 + t, k = 12 * t, j = 2 * middle;
      EXPECT_NEAR(layer.sigma_by_y[k], c.tactel_stress(tactel, j + 1), 1e-8);
      EXPECT_NEAR(layer.sigma_by_x[k], c.tactel_stress(tactel, j), 1e-8);
      EXPECT_NEAR(layer.tau_by_y[k], c.tactel_stress(21 + tactel, j + 1), 1e-8);
      EXPECT_NEAR(layer.tau_by_x[k], c.tactel_stress(21 + tactel, j), 1e-8);
    }
  }
}

TEST(LongLayer, ConvergesToTheKernels) {
  // One column wide forces, 1 mm away; the mesh's error falls with the spacing.
  const LayerKernels kernels(0.3);
  double before = 1;
  for (const int rows : {7, 13, 25}) {
    Sensor block = with_poisson(0.3);
    block.columns = 20 * (rows - 1) / 3 + 1;
    block.rows = rows;
    const LongLayer layer = long_layer(block, (rows - 1) / 3);
    const int k = (rows - 1) / 3;
    EXPECT_NEAR(k * layer.spacing, 1, 1e-12);
    const double error = std::abs(layer.yy[k] - kernels.displacement_yy(1 / 1.5)) +
                         std::abs(layer.xx[k] - kernels.displacement_xx(1 / 1.5)) +
                         std::abs(layer.xy[k] - kernels.displacement_xy(1 / 1.5));
    EXPECT_LT(error, 0.6 * before);
    before = error;
  }
  EXPECT_LT(before, 4e-3);
}

class Sides : public testing::TestWithParam<double> {
 protected:
  Sensor sensor = with_poisson(GetParam());
  SideDifference difference = side_difference(side_block(sensor), default_cache_directory());
};

TEST_P(Sides, DifferenceFallsWithTheDistanceFromTheEnds) {
  // In units of the compliance of a force on half a column, G_yy(dx/2).
  const double unit = LayerKernels(GetParam()).displacement_yy(1.0 / 24);
  const auto largest_within = [&](double limit) {
    double largest = 0;
    for (Eigen::Index i = 0; i < difference.x.size(); ++i)
      if (std::abs(difference.x[i]) <= limit)
        largest = std::max({largest, std::abs(difference.compliance(2 * i, 2 * i)),
                            std::abs(difference.compliance(2 * i + 1, 2 * i + 1))});
    return largest / unit;
  };
  EXPECT_LT(largest_within(8), 0.18);
  EXPECT_LT(largest_within(6), 0.025);
  EXPECT_LT(largest_within(4), 0.004);
  EXPECT_GT(largest_within(9.5), 0.5);
  EXPECT_NEAR((difference.compliance - difference.compliance.transpose()).cwiseAbs().maxCoeff(), 0, 1e-9);
}

TEST_P(Sides, LowRankIsNearTheDenseDifference) {
  const FreeSides sides(difference, sensor.length);
  const double unit = LayerKernels(GetParam()).displacement_yy(1.0 / 24);
  const auto error_within = [&](double limit) {
    double error = 0;
    for (Eigen::Index i = 0; i < difference.x.size(); ++i)
      for (Eigen::Index j = 0; j < difference.x.size(); ++j) {
        if (std::max(std::abs(difference.x[i]), std::abs(difference.x[j])) > limit) continue;
        const FreeSides::At at = sides.at(difference.x[i]), by = sides.at(difference.x[j]);
        const auto off = [&](const FreeSides::Modes& to, const FreeSides::Modes& from, Eigen::Index a, Eigen::Index b) {
          return std::abs(sides.between(to, from) - difference.compliance(2 * i + a, 2 * j + b));
        };
        error = std::max(
            {error, off(at.x, by.x, 0, 0), off(at.x, by.y, 0, 1), off(at.y, by.x, 1, 0), off(at.y, by.y, 1, 1)});
      }
    return error / unit;
  };
  // A tenth of a per cent is far below what 12 elements resolve.
  EXPECT_LT(error_within(9.5), 0.01);
  EXPECT_LT(error_within(9), 0.002);
  EXPECT_LT(error_within(8), 2e-4);
}

TEST_P(Sides, BaseStressIsThatOfAnotherMesh) {
  // A mesh with other columns and rows, tactels 1 mm wide; those at the corners, which are singular, left out.
  sensor.tactel_width = 0.9;
  sensor.columns = 201;
  sensor.rows = 21;
  const Condensation mesh = condense_cached(sensor, default_cache_directory());
  const LayerModel model = layer_model(sensor);
  const int n = sensor.tactels;
  for (const double x : {0.0, 6.0, 8.5}) {
    const auto node = static_cast<Eigen::Index>(std::lround((x + 10) / 0.1));
    // Three nodes, (1, 2, 1)/4: the mesh's own reactions wiggle.
    const auto by = [&](int component, int row) {
      const auto column = [&](Eigen::Index k) { return mesh.tactel_stress(row, 2 * k + component); };
      return (column(node - 1) + 2 * column(node) + column(node + 1)) / 4;
    };
    const Eigen::RowVectorXd row = model.base.at(x);
    for (int k = 1; k + 1 < n; ++k) {
      SCOPED_TRACE(testing::Message() << "x " << x << " tactel " << k);
      EXPECT_NEAR(row[k], -by(1, k), 4e-3);
      EXPECT_NEAR(row[n + k], by(0, k), 4e-3);
      EXPECT_NEAR(row[2 * n + k], -by(1, n + k), 4e-3);
      EXPECT_NEAR(row[3 * n + k], by(0, n + k), 4e-3);
    }
  }
}

// Tactels that tile the base measure the whole force. Bounds: what the mesh of the free sides leaves of the endless
// layer beyond the ends, 0.26 % at most within 2 mm of an end.
TEST_P(Sides, BaseStressBalancesTheForce) {
  sensor.tactels = 200;
  sensor.tactel_width = sensor.length / sensor.tactels;
  const LayerModel model = layer_model(sensor);
  const auto total = [&](double x, BaseStressTable::Quantity quantity) {
    return model.base.at(x).segment(quantity * sensor.tactels, sensor.tactels).sum() * sensor.tactel_width;
  };
  for (const double x : {0.0, 5.0, 7.0, 8.0, 9.0, 9.75}) {
    const double near = x < 6 ? 3e-4 : x < 7.5 ? 1e-3 : 3e-3;
    EXPECT_NEAR(total(x, BaseStressTable::sigma_by_pressure), -1, near) << x;
    EXPECT_NEAR(total(x, BaseStressTable::tau_by_traction), 1, near) << x;
  }
}

TEST_P(Sides, PatchAgreesWithTheWholeMesh) {
  // A parabola on more than 4 mm, at the middle and near an end: the same increments, exactly solved, on the mesh of
  // 161 columns and on the patch.
  const LayerModel model = layer_model(sensor);
  Sensor fine = sensor;
  fine.columns = 161;
  fine.rows = 25;
  const Condensation mesh = condense_cached(fine, default_cache_directory());
  for (const double position : {0.0, 6.0}) {
    Scene scene{"", sensor, {Parabola{20}, position}, 0.4, {}};
    scene.load.indentation = {0.15};
    scene.load.indentation_steps = 4;
    scene.load.tangential = {0.05, 0.12, 0.05};
    const Patch patch = find_patch(scene, model.table, 64).patch;
    const ContactSolution found = GapCondensed(patch_condensation(model, patch)).solve(scene);
    Scene on_mesh = scene;
    on_mesh.sensor = fine;
    const ContactSolution truth = GapCondensed(mesh).solve(on_mesh);
    for (std::size_t k = 3; k < truth.steps.size(); ++k) {
      SCOPED_TRACE(testing::Message() << "x " << position << " step " << k);
      EXPECT_TRUE(truth.steps[k].converged && found.steps[k].converged);
      EXPECT_NEAR(*found.steps[k].slip_index, *truth.steps[k].slip_index, 1.5e-3);
      EXPECT_NEAR(found.steps[k].P / truth.steps[k].P, 1, 4e-3);
    }
  }
}
INSTANTIATE_TEST_SUITE_P(Poisson, Sides, testing::Values(0.3, 0.45, 0.499), [](const auto& info) {
  return "nu" + std::to_string(static_cast<int>(1000 * info.param + 0.5));
});

TEST(FreeSides, OfALongSensorAreThoseOfItsEnds) {
  // 60 mm, 40 thicknesses: the block ends at 36 mm. Near an end both have the same sides; in the middle there are none.
  Sensor sensor = with_poisson(0.45), longer = sensor;
  longer.length = 60;
  const LayerModel a = layer_model(sensor), b = layer_model(longer);
  EXPECT_EQ(side_block(longer).length, 36);
  const auto by = [](const LayerModel& model, double to, double from) {
    const FreeSides::At at = model.sides.at(to), source = model.sides.at(from);
    return model.sides.between(at.y, source.x);
  };
  EXPECT_NEAR(by(a, 8.4, 8), by(b, 28.4, 28), 2e-3);
  EXPECT_NEAR(by(a, -8.4, -7), by(b, -28.4, -27), 2e-3);
  EXPECT_NEAR(by(b, 28, -28), 0, 1e-4);
  EXPECT_EQ(by(b, 3, 2), 0);
  const Eigen::RowVectorXd row = b.base.at(28);
  EXPECT_TRUE(row.allFinite());
  // Tactels 3 mm apart, the last but one 3 mm from the end as tactel 17 of the shorter sensor is.
  const Eigen::RowVectorXd shorter = a.base.at(8);
  EXPECT_NEAR(row[19], shorter[17], 1e-4);
  EXPECT_NEAR(row[21 + 19], shorter[21 + 17], 1e-4);
}

TEST(LayerModel, IncompressibleRubberIsTheLimit) {
  // The layer's formulas hold at 1/2; the sides come from 0.49999. S approaches its limit linearly in 1/2 - nu: the
  // change from 0.4999 is a tenth of that from 0.499.
  const auto S = [](double poisson, double position) {
    const LayerModel model = layer_model(with_poisson(poisson));
    Scene scene{"", model.sensor, {Parabola{10}, position}, 0.4, {}, SurfaceModel::patch};
    scene.load.indentation = {0.15};
    scene.load.tangential = {0.03, 0.08};
    const PatchSolver solver(model, {.elements = 24, .tolerance = 1e-9, .most_sweeps = 20000});
    const Patch patch = find_patch(scene, layer_model(with_poisson(0.5)).table, 24).patch;
    const ContactSolution solution = solver.solve_on(patch, scene);
    EXPECT_TRUE(solution.steps.back().converged);
    return *solution.steps[1].slip_index;
  };
  for (const double position : {0.0, 8.0, 9.5}) {
    const double limit = S(0.5, position), far = S(0.499, position) - limit, near = S(0.4999, position) - limit;
    EXPECT_LT(std::abs(far), 5e-3) << position;
    EXPECT_NEAR(near, 0.1 * far, 2e-4) << position;
  }
  Scene scene{"", with_poisson(0.5), {Parabola{10}, 0}, 0.4, {}};
  EXPECT_THROW(scene.validate(), ValueError);  // on a mesh
  EXPECT_THROW(condense_cached(with_poisson(0.5), default_cache_directory()), ValueError);
}

TEST(LayerModel, RefusesSensorsThatAreTooLong) {
  const Sensor sensor{.length = 400};
  EXPECT_THROW(endless_layer(sensor), std::exception);
}

}  // namespace tactel::fem::free_sides_test
