// SPDX-License-Identifier: Apache-2.0

// A contact on a pad as pages, plots and ParaView show it. How pages draw it is tested in a browser (check_page.py),
// the VTU file by an XML reader (check_vtu.py).
#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

#include "host/figures/contact_figure.h"
#include "host/figures/contact_view.h"
#include "host/figures/page.h"

namespace tactel::host::pad_view_test {

using Json = nlohmann::ordered_json;
using fem::GapStatus;
using testing::HasSubstr;

/// A turned ellipsoid away from the middle: not touching, pressed, dragged to +x, twisted.
fem::PadScene scene() {
  return {.sensor = {.tactels = {3, 2}, .pitch = {2, 3}},
          .indenter = {.shape = fem::Paraboloid{{8, 4}}, .position = {1, 0.5}, .yaw = 30},
          .load = {.indentation = {0, 0.2}, .drags = {{0.05, 0, 0}, {0.1, 0, 0}, {0.1, 0, 0.1}}}};
}

fem::PadSolution solved(const fem::PadScene& scene, int cells = 8) {
  return fem::PadSolver(fem::PadLayer(scene.sensor.poisson), {.cells = cells}).solve(scene);
}

// The page has five digits.
TEST(PadView, HoldsTheSolutionsNumbers) {
  const fem::PadScene asked = scene();
  const fem::PadSolution solution = solved(asked);
  const Json data = contact_view(asked, solution, 2).data;
  const double area = data["cells"]["sides"][0].get<double>() * data["cells"]["sides"][1].get<double>();
  EXPECT_EQ(data["shown"], 2);
  ASSERT_EQ(data["steps"].size(), 5u);
  for (std::size_t k = 0; k < 5; ++k) {
    const Json& step = data["steps"][k];
    const fem::PadStep& answer = solution.steps[k];
    const auto near = [](const Json& value, double expected) {
      EXPECT_NEAR(value.get<double>(), expected, 6e-5 * std::abs(expected));
    };
    near(step["P"], answer.P), near(step["Q"][0], answer.Q[0]), near(step["Q"][1], answer.Q[1]);
    near(step["M"], answer.M), near(step["indentation"], answer.indentation), near(step["drag"][0], answer.x);
    near(step["twist"], answer.twist * 180 / std::numbers::pi);
    EXPECT_EQ(step["S"].is_null(), !answer.slip_index);
    if (answer.slip_index) near(step["S"], *answer.slip_index), near(step["ratio"], *answer.force_ratio);
    for (std::size_t i = 0; i < answer.status.size(); ++i) {
      const auto cell = static_cast<Eigen::Index>(i);
      EXPECT_EQ(step["status"].get<std::string>()[i], "otl"[static_cast<int>(answer.status[i])]);
      near(step["p"][i], answer.normal_force[cell] / area);
      near(step["tx"][i], answer.tangential_force(cell, 0) / area);
      near(step["ty"][i], answer.tangential_force(cell, 1) / area);
    }
    for (std::size_t i = 0; i < 6; ++i) {
      near(step["sigma"][i], answer.stress(static_cast<Eigen::Index>(i), 0));
      near(step["tau_x"][i], answer.stress(static_cast<Eigen::Index>(i), 1));
      near(step["tau_y"][i], answer.stress(static_cast<Eigen::Index>(i), 2));
    }
    near(data["path"]["P"][k], answer.P), near(data["path"]["Qy"][k], answer.Q[1]);
  }
  EXPECT_TRUE(data["path"]["stick"][0].is_null());  // nothing touches
  EXPECT_TRUE(data["path"]["S"][0].is_null());
  EXPECT_EQ(data["path"]["stick"][1], solution.steps[1].stick_fraction);
  EXPECT_EQ(data["steps"][0]["status"], std::string(64, 'o'));
}

// A cell of the own frame at (u, v) lies at position + (u cos 30 - v sin 30, u sin 30 + v cos 30).
TEST(PadView, CornersSurroundThePlacesOfTheCells) {
  const fem::PadScene asked = scene();
  const fem::PadSolution solution = solved(asked, 4);
  const Eigen::MatrixX2d corners = cell_corners(asked.indenter, solution.cells);
  const Eigen::MatrixXi of_cell = corners_of_cells(4);
  for (Eigen::Index k = 0; k < 16; ++k) {
    const Eigen::MatrixX2d four = corners(of_cell.row(k), Eigen::all);
    EXPECT_LT((four.colwise().mean() - solution.places.row(k)).norm(), 1e-12);
    const Eigen::RowVector2d first = four.row(1) - four.row(0), second = four.row(2) - four.row(1);
    EXPECT_NEAR(first[0] * second[1] - first[1] * second[0], solution.cells.area(), 1e-12);  // counter-clockwise
    EXPECT_NEAR(std::atan2(first[1], first[0]), std::numbers::pi / 6, 1e-12);                // along its own x
  }
  EXPECT_NEAR(solution.places.col(0).mean(), 1, 1e-9);
  EXPECT_NEAR(solution.places.col(1).mean(), 0.5, 1e-9);
}

TEST(PadView, OutlinesAreSectionsOfTheIndenter) {
  const auto radii = [](const fem::PadShape& shape, double depth) {
    return section_outline({.shape = shape}, depth).rowwise().norm().eval();
  };
  const double r = std::sqrt(2 * 8 * 0.3 - 0.3 * 0.3);  // of a sphere of 8 mm, 0.3 mm deep
  EXPECT_LT((radii(fem::Sphere{8}, 0.3).array() - r).abs().maxCoeff(), 1e-9);
  EXPECT_LT((radii(fem::Cone{60}, 0.3).array() - 0.3 * std::sqrt(3)).abs().maxCoeff(), 1e-9);
  EXPECT_LT((radii(fem::Punch{2, 0}, 0.1).array() - 2).abs().maxCoeff(), 1e-9);
  const Eigen::MatrixX2d box = section_outline({.shape = fem::Box{{2, 1}, 0}}, 0.1);
  EXPECT_NEAR(box.rowwise().norm().maxCoeff(), std::sqrt(5), 1e-9);  // its corners are there
  for (const auto& point : box.rowwise()) EXPECT_NEAR(std::max(std::abs(point[0]) / 2, std::abs(point[1])), 1, 1e-9);
  EXPECT_EQ(section_outline({.shape = fem::Sphere{8}}, 0).rows(), 0);
  // A tilted punch touches on the side that lies low, -x here.
  const fem::PadIndenter tilted{.shape = fem::Punch{2, 0}, .tilt = 5, .tilt_direction = 0};
  const double depth = 0.1, edge = 2 - depth / std::tan(5 * std::numbers::pi / 180);
  const Eigen::MatrixX2d part = section_outline(tilted, depth);
  EXPECT_NEAR(part.col(0).maxCoeff(), -edge, 1e-6);
  EXPECT_NEAR(part.col(0).minCoeff(), -2, 0.01);  // a ray meets the rim beside its end
}

TEST(PadView, OwnPlacesAreTurnedAndMoved) {
  const Eigen::MatrixX2d there = on_pad({.position = {2, 3}, .yaw = 90}, Eigen::RowVector2d(1, 0));
  EXPECT_NEAR(there(0, 0), 2, 1e-12);
  EXPECT_NEAR(there(0, 1), 4, 1e-12);
}

TEST(PadView, LongPathsStayBelowTheLargestPage) {
  fem::PadScene asked = scene();
  asked.load.drags.clear();
  for (int k = 0; k < 60; ++k) asked.load.drags.push_back({0.002 * k, 0, 0});
  const fem::PadSolution solution = solved(asked, 24);
  Page page("t", "s");
  page.contact(asked, solution, 17);
  EXPECT_LT(page.html().size(), largest_page);
  EXPECT_THAT(page.html(), HasSubstr("of 62 load steps are shown"));
  const Json data = contact_view(asked, solution, 17).data;
  EXPECT_EQ(data["steps"][data["shown"].get<std::size_t>()]["number"], 18);
  EXPECT_EQ(data["path"]["P"].size(), 62u);
}

TEST(PadView, TellingStepIsTheLastThatPartlySlips) {
  fem::PadSolution solution;
  solution.steps.resize(4);
  for (const auto& [k, P, stick] : {std::tuple(0, 1.0, 1.0), {1, 1.0, 0.5}, {2, 1.0, 0.0}, {3, 0.0, 0.0}})
    solution.steps[static_cast<std::size_t>(k)].P = P,
    solution.steps[static_cast<std::size_t>(k)].stick_fraction = stick;
  EXPECT_EQ(telling_step(solution), 1u);
  solution.steps[1].stick_fraction = 1;
  EXPECT_EQ(telling_step(solution), 3u);
}

/// Middle of the tiles, weighted by their values.
Eigen::Vector2d middle_of(const Mosaic& mosaic) {
  Eigen::Vector2d sum(0, 0);
  double weight = 0;
  for (std::size_t tile = 0; tile < mosaic.values.size(); ++tile)
    for (std::size_t corner = 4 * tile; corner < 4 * tile + 4; ++corner) {
      sum += mosaic.values[tile] * Eigen::Vector2d(mosaic.x[corner], mosaic.y[corner]);
      weight += mosaic.values[tile];
    }
  return sum / weight;
}

TEST(PadFigure, ShowsThePlacesAndWaysOfTheSolution) {
  const fem::PadScene asked = scene();
  const fem::PadSolution solution = solved(asked);
  const fem::PadStep& step = solution.steps[3];
  const Figure figure = contact_figure(asked, solution, 3);
  ASSERT_EQ(figure.panels.size(), 4u);
  const Panel &surface = figure.panels[0], &tactels = figure.panels[1], &path = figure.panels[3];
  // The middle of the pressure is that of the forces, up and to the right of the pad's.
  const Eigen::Vector2d force_middle = solution.places.transpose() * step.normal_force / step.P;
  EXPECT_LT((middle_of(*surface.mosaic) - force_middle).norm(), 1e-9);
  EXPECT_GT(force_middle.minCoeff(), 0.3);
  std::size_t touching = 0;
  for (const GapStatus status : step.status) touching += status != GapStatus::open;
  EXPECT_EQ(surface.mosaic->values.size(), touching);
  EXPECT_EQ(surface.series[2].x.size() + surface.series[3].x.size(), touching);
  EXPECT_EQ(surface.series[2].label, "stick");
  EXPECT_EQ(surface.series[2].x.size(), static_cast<std::size_t>(std::ranges::count(step.status, GapStatus::stick)));
  EXPECT_EQ(std::vector(tactels.mosaic->values), std::vector(step.stress.col(0).begin(), step.stress.col(0).end()));
  // Dragged to +x: arrows, each from a place to its tip and back from its barbs, point to the right.
  const Series& arrows = surface.series[0];
  double right = 0;
  for (std::size_t k = 0; k + 5 < arrows.x.size(); k += 6) right += arrows.x[k + 1] - arrows.x[k];
  EXPECT_GT(right, 0);
  EXPECT_EQ(path.series[2].y[3], *step.slip_index);
  EXPECT_TRUE(std::isnan(path.series[2].y[0]));
  // A millimetre is as long along x as along y.
  for (const Panel* map : {&surface, &tactels}) {
    const auto long_as = [](std::pair<double, double> range) { return range.second - range.first; };
    const auto [width, height] = axes_size(figure, *map);
    EXPECT_NEAR(long_as(*map->x_range) / long_as(*map->y_range), width / height, 1e-9);
  }
}

TEST(PadFigure, DrawsEmptyAndSingleSteps) {
  fem::PadScene asked = scene();
  EXPECT_THAT(render_svg(contact_figure(asked, solved(asked), 0)), HasSubstr("Along the path"));  // nothing touches
  asked.load = {.indentation = {0.2}};
  asked.sensor.axes = 1;
  asked.sensor.length = 10, asked.sensor.width = 8;
  const Figure one = contact_figure(asked, solved(asked), 0);
  EXPECT_EQ(one.panels.size(), 3u);            // no path
  EXPECT_EQ(one.panels[1].series.size(), 2u);  // outlines of indenter and pad; one axis: no arrows
  EXPECT_THAT(render_svg(one), HasSubstr("<svg"));
}

}  // namespace tactel::host::pad_view_test
