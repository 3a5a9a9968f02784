// SPDX-License-Identifier: Apache-2.0

// Displacements within the rubber. Expected numbers are of an independent program, whose rest is a cubic spline through
// Hankel sums and whose cells take 8 x 8 points; beside the surface's influence, waves, and what a camera must see.
#include "fem/pad/pad_markers.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "fem/numbers/value_error.h"
#include "fem/pad/pad_field.h"
#include "fem/pad/pad_layers.h"
#include "tests/fem/pad/named_pad_scenes.h"

namespace tactel::fem::pad_markers_test {

TEST(PadMarkers, CellsMoveThemAsAnIndependentProgramSays) {
  const struct {
    double nu, z, hx, hy, x, y, zz, xz, yz, zx, zy, xx, yy, xy;
  } cases[] = {{.45, .75, .25, .25, .25, .5, .00657183939, -.00401951876, -.00805374051, -.00272897035, -.00547430162,
                .01567127802, .02638287277, .00712976931},
               {0, .9, .3, .2, 0, 0, .1556584074, 0, 0, 0, 0, .10717936351, .10217547475, 0},
               {.3, .5, .5, .25, 1.2, -.7, -.0001932449, -.00210805873, .0012678061, -.0011810934, .00072168809,
                .00932261876, .00497918111, -.00399754986},
               {.4999, .95, .2, .6, .1, .3, .08363870836, -.01777770869, -.02454409918, -.01509498827, -.01678285416,
                .1194579507, .15827868124, .0295881543},
               {.5, .05, .25, .25, -.4, .8, -1.976938e-05, .00058362354, -.00116744022, 1.066128e-05, -2.134339e-05,
                .00035558104, .00118064852, -.0005500154},
               {.3, .99, .1, .1, 3, 2, -1.58424e-06, -1.066508e-05, -7.11006e-06, 1.041496e-05, 6.9433e-06,
                6.298222e-05, 2.392282e-05, 4.687127e-05}};
  for (const auto& c : cases) {
    const Eigen::Matrix3d found = LayerAtDepth(c.nu, 1 - c.z, 5).displacement(c.hx, c.hy, c.x, c.y);
    Eigen::Matrix3d expected;
    expected << c.xx, c.xy, c.xz, c.xy, c.yy, c.yz, c.zx, c.zy, c.zz;
    EXPECT_LT((found - expected).cwiseAbs().maxCoeff(), 1e-9) << c.nu << "\n" << found << "\n" << expected;
  }
}

TEST(PadMarkers, AtTheSurfaceTheyHaveItsInfluence) {
  for (const double nu : {0.0, 0.3, 0.48, 0.5}) {
    const LayerAtDepth surface(nu, 0, 4);
    const PadLayer layer(nu);
    for (const auto& [x, y] : {std::pair{0.0, 0.0}, {0.3, 0.0}, {0.6, -0.4}, {-2.1, 1.0}}) {
      const Eigen::Matrix3d found = surface.displacement(0.3, 0.2, x, y);
      const CellInfluence c = layer.influence(1, 0.3, 0.2, x, y);
      Eigen::Matrix3d expected;
      expected << c.xx, c.xy, c.xz, c.xy, c.yy, c.yz, -c.xz, -c.yz, c.zz;
      EXPECT_LT((found - expected).cwiseAbs().maxCoeff(), 2e-9) << nu << " " << x << " " << y;
    }
  }
}

/// Markers of a scene on the cells that are stated.
PadSolution seen(const NamedScene& named, const Markers& markers, const PadOptions& options) {
  PadScene scene = named.scene;
  scene.markers = markers;
  const PadLayer layer(scene.sensor.poisson);
  PadSolution solution = PadSolver(layer, options).solve_on(named.cells(), scene);
  see_markers(scene, solution);
  return solution;
}

// The indenter sticks to the middle: there markers of the surface move with it.
TEST(PadMarkers, FollowASphereThatDrags) {
  using Numbers = std::array<std::array<double, 3>, 3>;  // [markers][x, y, z]
  const struct {
    double depth;
    std::array<Numbers, 3> steps;  // pressed, first drag, last
  } cases[] = {
      {.1,
       {{{{{0, 0, -.24233309}, {.01524166, .00754147, -.16494217}, {-.02367812, .01188242, -.00155534}}},
         {{{.04607866, .01841936, -.24233547}, {.05598918, .03465576, -.1649866}, {-.00516267, .00909189, -.00270242}}},
         {{{.09148405, .09137582, -.24232984},
           {.08099331, .13691719, -.16616244},
           {-.00122802, .01365728, -.00325941}}}}}},
      {.5,
       {{{{{0, 0, -.19287583}, {.04709396, .02316197, -.12551789}, {-.03932111, .01931515, -.00205314}}},
         {{{.03154494, .01257, -.19284336}, {.07360255, .04037539, -.1269384}, {-.02366474, .01693086, -.00103434}}},
         {{{.06035594, .06003353, -.19243401},
           {.08982333, .09744001, -.13119501},
           {-.0196506, .02079672, -.0012627}}}}}},
      {0,
       {{{{{0, 0, -.24994177}, {.00023662, .0002226, -.1714494}, {-.01921378, .00981444, -.00290321}}},
         {{{.05000572, .02000235, -.24994197}, {.0452495, .03023852, -.17144405}, {-.00069978, .00698646, -.00483482}}},
         {{{.10001883, .10001895, -.24994382},
           {.07503051, .15010596, -.17139863},
           {.00314351, .0114563, -.00537919}}}}}}};
  const NamedScene named = named_scenes().front();
  constexpr std::array asked{1, 2, 4};
  for (const auto& c : cases) {
    const PadSolution solution =
        seen(named, {.depth = c.depth, .places = {{0, 0}, {1, .5}, {-2, 1}}},
             {.cells = 16, .tolerance = 1e-10, .pressing_increments = 2, .limit_increments = 0});
    for (std::size_t k = 0; k < 3; ++k)
      for (Eigen::Index m = 0; m < 3; ++m)
        for (Eigen::Index axis = 0; axis < 3; ++axis)
          EXPECT_NEAR(solution.steps[asked[k]].markers(m, axis), c.steps[k][m][axis], 2e-7)
              << c.depth << " " << k << " " << m << " " << axis;
  }
}

// Waves in a wide period, means over half a cell: another way to the same displacements, also of a shape that is
// turned.
TEST(PadMarkers, AreWhereWavesPutThem) {
  PadScene scene = scene_of(Paraboloid{{8, 6}}, 0.3, 2.5, 0.45, 0.5, {{0.05, 0.03, 0.02}});
  scene.indenter.yaw = 30, scene.indenter.position = {0.4, -0.2};
  const PadLayer layer(scene.sensor.poisson);
  const PadSolution solved = PadSolver(layer, {.cells = 12}).solve_on({.n = 12, .hx = 0.35, .hy = 0.31}, scene);
  const PadField field = pad_field(scene, solved, 2);
  const double largest = field.displacement.cwiseAbs().maxCoeff();
  for (const Eigen::Index level : {3, 6, 9}) {
    const Eigen::Index plane = Eigen::Index(field.points[0]) * field.points[1], first = level * plane;
    Markers markers{.depth = 2.5 - field.place(2, first)};
    for (Eigen::Index i = 7; i < plane; i += 61)
      markers.places.push_back({field.place(0, first + i), field.place(1, first + i)});
    scene.markers = markers;
    PadSolution solution = solved;
    see_markers(scene, solution);
    for (Eigen::Index k = 0; k < solution.steps[2].markers.rows(); ++k)
      for (const int axis : {0, 1, 2})
        EXPECT_NEAR(solution.steps[2].markers(k, axis), field.displacement(axis, first + 7 + 61 * k), 4e-3 * largest)
            << level << " " << k << " " << axis;
  }
}

// Tractions of wide cells are smooth below the markers, too.
TEST(PadMarkers, OfWideCellsHaveTheInfluenceOfTheSurface) {
  PadScene scene;
  scene.sensor = {.thickness = 2, .young = 3, .poisson = 0.48};
  const PadCells cells{.n = 5, .hx = 1.9, .hy = 2.6};
  const PadInfluence influence(pad_layer(0.48), 2, cells.hx, cells.hy, cells.n);
  Markers middles{.depth = 0};
  for (int i = 0; i < cells.count(); ++i) middles.places.push_back({cells.x(i / 5), cells.y(i % 5)});
  const Eigen::MatrixXd rows = marker_rows(middles, scene, cells);
  for (int to = 0; to < cells.count(); ++to)
    for (int by = 0; by < cells.count(); ++by) {
      const Eigen::Index at = influence.at(by / 5 - to / 5, by % 5 - to % 5);
      const double expected[3][3] = {{-influence.xz[at], influence.xx[at], influence.xy[at]},
                                     {-influence.yz[at], influence.xy[at], influence.yy[at]},
                                     {-influence.zz[at], -influence.xz[at], -influence.yz[at]}};
      for (int axis = 0; axis < 3; ++axis)
        for (int part = 0; part < 3; ++part)
          EXPECT_NEAR(3 * rows(3 * to + axis, part * cells.count() + by), expected[axis][part], 1e-7)
              << to << " " << by << " " << axis << " " << part;
    }
}

// At the base nothing moves; at the extremes of rubber and depth all is finite, and deeper markers move less.
TEST(PadMarkers, RestAtTheBase) {
  for (const double nu : {0.0, 0.3, 0.4999, 0.5}) {
    double last = std::numeric_limits<double>::infinity();
    for (const double depth : {0.0, 1e-9, 0.1, 0.5, 0.9, 0.999, 0.999999}) {
      const double moves = LayerAtDepth(nu, depth, 2).displacement(0.3, 0.3, 0.01, 0).col(0).norm();
      EXPECT_LE(moves, last * (1 + 1e-6)) << nu << " " << depth;
      last = moves;
    }
    EXPECT_LT(last, 1e-6) << nu;
  }
}

// A punch that leans along its own tilt_direction leans as one that is turned.
TEST(PadMarkers, FollowAPunchThatLeans) {
  const auto moved = [](double yaw, double direction) {
    PadScene scene;
    scene.sensor.thickness = 2, scene.sensor.poisson = 0.45;
    scene.indenter.shape = Punch{.radius = 1.5, .edge = 1};
    scene.indenter.tilt = 2, scene.indenter.yaw = yaw, scene.indenter.tilt_direction = direction;
    scene.load.indentation = {0.1};
    scene.markers = Markers{.counts = {4, 3}, .pitch = {0.6, 0.7}, .depth = 0.3};
    PadSolution solution = PadSolver(PadLayer(0.45), {.cells = 8}).solve(scene);
    see_markers(scene, solution);
    return solution.steps.back().markers;
  };
  const Eigen::MatrixX3d turned = moved(70, 0);
  EXPECT_GT(turned.cwiseAbs().maxCoeff(), 0.05);
  EXPECT_LT((moved(0, 70) - turned).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(PadMarkers, EndWhereAsked) {
  struct Ended {};
  PadScene scene;
  scene.sensor.thickness = 2;
  PadCells cells;
  cells.n = 4, cells.hx = cells.hy = 0.2;
  const Markers markers{.counts = {5, 4}, .pitch = {0.3, 0.3}, .depth = 0.2};
  int calls = 0;
  (void)marker_rows(markers, scene, cells, [&] { ++calls; });
  EXPECT_GT(calls, 20 + 100);  // for every marker, and while the layer is made
  for (const int last : {1, 90, calls}) {
    calls = 0;
    EXPECT_THROW((void)marker_rows(markers, scene, cells,
                                   [&] {
                                     if (++calls == last) throw Ended();
                                   }),
                 Ended);
    EXPECT_EQ(calls, last);
  }
}

TEST(PadMarkers, ACameraSeesWhatComesNearerFartherOut) {
  const Markers markers{.counts = {2, 1}, .pitch = {4, 1}};
  Eigen::MatrixX3d u(2, 3);
  u << 0, 0, -0.1, 0.05, 0.02, 0.2;
  const Eigen::MatrixX2d pixels = pixels_of({.distance = 20, .pixels_per_mm = 10, .centre = {320, 240}}, markers, u);
  // -2 mm, nearer by .1 of 20 mm: -2.01 mm; 2.05 mm, farther by .2: 2.03 mm.
  Eigen::MatrixX2d expected(2, 2);
  expected << 320 - 20.1, 240, 320 + 20.3, 240.2;
  EXPECT_LT((pixels - expected).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(PadMarkers, RefusesWhatIsNone) {
  const auto key_of = [](const Markers& markers, const PadSensor& sensor = {}) -> std::string {
    try {
      validate(markers, sensor);
    } catch (const ValueError& error) {
      return error.key;
    }
    return "";
  };
  EXPECT_EQ(key_of({}), "");
  EXPECT_EQ(key_of({.depth = 2}), "markers.depth");
  EXPECT_EQ(key_of({.depth = -0.1}), "markers.depth");
  EXPECT_EQ(key_of({.depth = std::nan("")}), "markers.depth");
  EXPECT_EQ(key_of({.counts = {64, 65}}), "markers.counts");
  EXPECT_EQ(key_of({.counts = {0, 5}}), "markers.counts");
  EXPECT_EQ(key_of({.pitch = {0, 1}}), "markers.pitch");
  EXPECT_EQ(key_of({.places = {{0, std::nan("")}}}), "markers.places");
  EXPECT_EQ(key_of({}, {.length = 20, .width = 20}), "markers");
  EXPECT_EQ(key_of({}, with_layers({.layers = {{1, 1, .4}, {1, 2, .4}}})), "markers");
  PadScene scene;
  scene.camera.emplace();
  EXPECT_THROW(scene.validate(), ValueError);
  for (const double noise : {-0.1, std::nan(""), std::numeric_limits<double>::infinity()})
    EXPECT_THROW(validate(Camera{.noise_px = noise}), ValueError) << noise;
  validate(Camera{.noise_px = 0.5});
}

}  // namespace tactel::fem::pad_markers_test
