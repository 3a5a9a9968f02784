// SPDX-License-Identifier: Apache-2.0

// Steps on grids that are not square, on pads whose sides end, and what flags say of where an object lies.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "fem/numbers/value_error.h"
#include "fem/pad/pad_layers.h"
#include "fem/pad/pad_markers.h"
#include "fem/pad/pad_step.h"
#include "tests/host/contact/stepped.h"
#include "tests/thrown_message.h"

namespace tactel::host::pad_step_grid_test {

using Pose = std::array<double, 4>;

template <class Real>
int flags(const PadStepper<Real>& steps) {
  return static_cast<int>(number(steps, 0, STEP_RESULT_FLAGS));
}

template <class Real>
void put(PadStepper<Real>& steps, const fem::PadSensor& pad, const fem::PadIndenter& object,
         std::array<double, 2> place) {
  steps.set_surface(0, fem::pad_surface(steps.cells(), object, place, 0, fem::has_free_sides(pad)),
                    fem::height_beyond(steps.cells(), object, place, 0, fem::rubber_of(pad)));
  steps.set_axes(place);
}

const StepOptions oblong{
    .cells = {6, 9}, .cell = {0.42, 0.26}, .tolerance = 1e-8, .force_tolerance = 1e-6, .most_sweeps = 2000};

/// Frames are those of the tractions by the layer's kernels.
void expect_frames_of_tractions(PadStepper<double>& steps, const fem::PadSensor& pad) {
  const fem::PadCells& cells = steps.cells();
  const Eigen::MatrixXd base = fem::base_stress_of_cells(fem::pad_layer(fem::rubber(pad)), {.sensor = pad}, cells);
  const std::vector<double> tractions = steps.tractions();
  const Eigen::VectorXd expected = base * Eigen::Map<const Eigen::VectorXd>(tractions.data(), 3 * cells.count());
  for (Eigen::Index r = 0; r < expected.size(); ++r)
    EXPECT_NEAR(steps.frames()[static_cast<std::size_t>(r)], expected[r], 1e-9 * expected.cwiseAbs().maxCoeff());
}

TEST(PadStepGrid, MarkersAreMovedByTractions) {
  StepOptions options = oblong;
  options.markers = Markers{.counts = {4, 3}, .pitch = {0.6, 0.5}, .depth = 0.3};
  fem::PadScene scene;
  scene.sensor = rubber;
  constexpr std::size_t count = 5;
  PadStepper<double> steps(executor(), rubber, count, std::array{0.5}, options);
  PadStepper<float> single(executor(), rubber, count, std::array{0.5}, options);
  const auto step = [&](auto& of, double drag) {
    std::vector<double> poses;
    for (std::size_t c = 0; c < count; ++c) {
      of.set_surface(c, fem::pad_surface(of.cells(), {.shape = fem::Sphere{6}}, {0, 0}, 0));
      poses.insert(poses.end(), {0.03 * static_cast<double>(c), drag, 0.5 * drag, 0});
    }
    of.move(poses);
  };
  const Eigen::MatrixXd rows = fem::marker_rows(*options.markers, scene, steps.cells());
  for (const double drag : {0.0, 0.04}) {
    step(steps, drag), step(single, drag);
    const std::vector<double> tractions = steps.tractions();
    ASSERT_EQ(steps.markers().size(), count * 36);
    for (std::size_t c = 0; c < count; ++c) {
      const Eigen::Index cells = 3 * steps.cells().count();
      const Eigen::VectorXd expected =
          rows * Eigen::Map<const Eigen::VectorXd>(&tractions[c * static_cast<std::size_t>(cells)], cells);
      EXPECT_EQ(expected.isZero(0), c == 0);  // the first does not touch
      for (std::size_t r = 0; r < 36; ++r) {
        EXPECT_NEAR(steps.markers()[36 * c + r], expected[static_cast<Eigen::Index>(r)], 1e-12);
        EXPECT_NEAR(single.markers()[36 * c + r], expected[static_cast<Eigen::Index>(r)], 2e-4 * 0.12);  // of the depth
      }
    }
  }
  EXPECT_TRUE(PadStepper<double>(executor(), rubber, 1, std::array{0.5}, oblong).markers().empty());
  options.markers->depth = rubber.thickness;
  EXPECT_THROW(PadStepper<float>(executor(), rubber, 1, std::array{0.5}, options), ValueError);
  options.markers.reset(), options.camera.emplace();
  EXPECT_THROW(PadStepper<float>(executor(), rubber, 1, std::array{0.5}, options), ValueError);
}

TEST(PadStepGrid, AgreesWithItsTwin) {
  PadStepper<double> steps(executor(), rubber, 1, std::array{0.5}, oblong);
  const fem::PadCells& cells = steps.cells();
  ASSERT_EQ(cells.count(), 54);
  fem::SteppedContact twin(fem::pad_layer(rubber.poisson), rubber, cells, 0.5,
                           {.cells = 6, .tolerance = 1e-8, .accept = 1e-6});
  const fem::PadSurface surface =
      fem::pad_surface(cells, {.shape = fem::Box{.half_widths = {0.7, 0.5}}}, {0.1, -0.05}, 20);
  steps.set_surface(0, surface), steps.set_axes(std::array{0.1, -0.05});
  twin.set_surface(surface, {0.1, -0.05});
  for (int k = 1; k <= 8; ++k) {
    const Pose to{std::min(0.03 * k, 0.12), 0.02 * std::max(k - 4, 0), 0.01 * std::max(k - 4, 0),
                  0.01 * std::max(k - 4, 0)};
    steps.move(to);
    const fem::SteppedState state = twin.move(to[0], {to[1], to[2], to[3]});
    for (int row = 0; row < 4; ++row)
      EXPECT_NEAR(number(steps, 0, STEP_RESULT_P + row), state.force[row], 1e-5 * state.force[0]);  // of 1000 sweeps
    EXPECT_NEAR(number(steps, 0, STEP_RESULT_S), state.slip_index, 1e-3);                           // four rounds
    EXPECT_EQ(number(steps, 0, STEP_RESULT_TOUCH), state.touching);
  }
  expect_frames_of_tractions(steps, rubber);
}

TEST(PadStepGrid, SoftObjectsAgreeWithTheTwin) {
  StepOptions options = oblong;
  options.object_young = 0.4 * rubber.young, options.object_poisson = 0.3;
  PadStepper<double> steps(executor(), rubber, 1, std::array{0.5}, options);
  const fem::PadCells& cells = steps.cells();
  const fem::PadLayer layer = fem::pad_layer(rubber.poisson).beside({2.5, 0.3});
  fem::SteppedContact twin(layer, rubber, cells, 0.5, {.cells = 6, .tolerance = 1e-8, .accept = 1e-6}),
      rigid(fem::pad_layer(rubber.poisson), rubber, cells, 0.5, {.cells = 6, .tolerance = 1e-8, .accept = 1e-6});
  const fem::PadSurface surface = fem::pad_surface(cells, {.shape = fem::Sphere{2}}, {0.1, -0.05}, 0);
  steps.set_surface(0, surface), steps.set_axes(std::array{0.1, -0.05});
  twin.set_surface(surface, {0.1, -0.05}), rigid.set_surface(surface, {0.1, -0.05});
  for (int k = 1; k <= 4; ++k) {
    const double depth = std::min(0.05 * k, 0.1), x = 0.02 * std::max(k - 2, 0);
    steps.move(Pose{depth, x, 0, 0});
    const fem::SteppedState state = twin.move(depth, {x, 0, 0});
    for (int row = 0; row < 4; ++row)
      EXPECT_NEAR(number(steps, 0, STEP_RESULT_P + row), state.force[row], 1e-5 * state.force[0]);
    EXPECT_LT(2 * state.force[0], rigid.move(depth, {x, 0, 0}).force[0]);
  }
  steps.press(Pose{number(steps, 0, STEP_RESULT_P), 0, 0, 0});
  EXPECT_EQ(flags(steps) & STEP_UNMET, 0);
  PadStepper<double> others(executor(), rubber, 1, std::array{0.5}, oblong);
  const std::vector<double> state = steps.state();
  EXPECT_EQ(state.size(), others.state_rows() + 2);
  EXPECT_THROW(others.set_state(state), ValueError);
  EXPECT_NO_THROW(steps.set_state(state));
  EXPECT_THROW(steps.set_state(others.state()), ValueError);
}

TEST(PadStepGrid, LayersAgreeWithTheTwin) {
  fem::PadSensor covered{.tactels = rubber.tactels, .pitch = rubber.pitch};
  covered.layers = {{1.8, 1, 0.48}, {0.2, 10, 0.45}};
  covered = with_layers(covered);
  PadStepper<double> steps(executor(), covered, 1, std::array{0.5}, oblong);
  const fem::PadCells& cells = steps.cells();
  fem::SteppedContact twin(fem::pad_layer(fem::rubber(covered)), covered, cells, 0.5,
                           {.cells = 6, .tolerance = 1e-8, .accept = 1e-6});
  const fem::PadSurface surface = fem::pad_surface(cells, {.shape = fem::Sphere{2}}, {0.1, -0.05}, 0);
  steps.set_surface(0, surface), steps.set_axes(std::array{0.1, -0.05});
  twin.set_surface(surface, {0.1, -0.05});
  for (int k = 1; k <= 4; ++k) {
    const double depth = std::min(0.05 * k, 0.1), x = 0.02 * std::max(k - 2, 0);
    steps.move(Pose{depth, x, 0, 0});
    const fem::SteppedState state = twin.move(depth, {x, 0, 0});
    for (int row = 0; row < 4; ++row)
      EXPECT_NEAR(number(steps, 0, STEP_RESULT_P + row), state.force[row], 1e-5 * state.force[0]);
  }
  expect_frames_of_tractions(steps, covered);
  const std::vector<double> state = steps.state();
  PadStepper<double> others(executor(), rubber, 1, std::array{0.5}, oblong);
  EXPECT_EQ(state.size(), others.state_rows() + 2 + 6);
  EXPECT_THROW(others.set_state(state), ValueError);
  EXPECT_NO_THROW(steps.set_state(state));
  fem::PadSensor harder = covered;
  harder.layers[0].young = 2;
  PadStepper<double> harder_steps(executor(), harder, 1, std::array{0.5}, oblong);
  EXPECT_THROW(harder_steps.set_state(state), ValueError);
}

/// A quarter turn of pad, grid, object and way turns forces and frames.
TEST(PadStepGrid, TurnsWithItsPad) {
  const fem::PadSensor turned{.tactels = {3, 4}, .pitch = {1.2, 1.5}, .thickness = 2, .young = 1, .poisson = 0.48};
  fem::PadSensor pad = turned;
  std::swap(pad.tactels[0], pad.tactels[1]), std::swap(pad.pitch[0], pad.pitch[1]);
  pad.length = 6, pad.width = 4;
  fem::PadSensor across = turned;
  across.length = 4, across.width = 6;
  const StepOptions fine{.cells = {9, 6}, .tolerance = 1e-6};
  PadStepper<double> steps(executor(), pad, 1, std::array{0.5}, fine),
      others(executor(), across, 1, std::array{0.5}, {.cells = {6, 9}, .tolerance = 1e-6});
  EXPECT_EQ(steps.options().cell.x, 6.0 / 9);
  EXPECT_EQ(steps.options().cell.y, 4.0 / 6);
  put(steps, pad, {.shape = fem::Paraboloid{.radii = {6, 9}}}, {1.1, 0.4});
  put(others, across, {.shape = fem::Paraboloid{.radii = {9, 6}}}, {-0.4, 1.1});
  for (int k = 1; k <= 6; ++k) {
    const double d = std::min(0.08 * k, 0.24), x = 0.04 * std::max(k - 3, 0), y = 0.02 * std::max(k - 3, 0);
    steps.move(Pose{d, x, y, 0.5 * y}), others.move(Pose{d, -y, x, 0.5 * y});
    const auto row = [&](auto& of, int k) { return number(of, 0, STEP_RESULT_P + k); };
    const double near = 1e-4 * row(steps, 0);  // tolerances of sweeps in another order
    EXPECT_NEAR(row(others, 0), row(steps, 0), near);
    EXPECT_NEAR(row(others, 1), -row(steps, 2), near);
    EXPECT_NEAR(row(others, 2), row(steps, 1), near);
    EXPECT_NEAR(row(others, 3), row(steps, 3), 3 * near);
    EXPECT_NEAR(number(others, 0, STEP_RESULT_S), number(steps, 0, STEP_RESULT_S), 2e-3);  // four rounds
  }
}

/// The press, and each drag, in `parts` steps.
void expect_scene(const fem::PadSensor& pad, double mu, const fem::PadIndenter& box, std::span<const Pose> way,
                  int parts, const std::array<std::array<double, 5>, 4>& expected, double lever) {
  PadStepper<float> steps(executor(), pad, 1, std::array{mu}, {.tolerance = 1e-4});
  put(steps, pad, box, box.position);
  Pose at{};
  for (std::size_t k = 0; k < way.size(); ++k) {
    const Pose from = at;
    for (int part = 1; part <= parts; ++part) {
      for (std::size_t i = 0; i < 4; ++i) at[i] = from[i] + (way[k][i] - from[i]) * part / parts;
      steps.move(at);
      EXPECT_EQ(flags(steps) & ~STEP_SLIDES, 0);
    }
    const auto& [P, Qx, Qy, M, S] = expected[k];
    EXPECT_NEAR(number(steps, 0, STEP_RESULT_P) / P, 1, 0.02) << k;
    EXPECT_NEAR(number(steps, 0, STEP_RESULT_QX), Qx, 0.02 * P) << k;
    EXPECT_NEAR(number(steps, 0, STEP_RESULT_QY), Qy, 0.02 * P) << k;
    EXPECT_NEAR(number(steps, 0, STEP_RESULT_M), M, 0.02 * P * lever) << k;
    EXPECT_NEAR(number(steps, 0, STEP_RESULT_S), S, 0.02) << k;
  }
}

// Of an independent program: bricks of 27 nodes with linear pressure of their own, dense compliance of the nodes that
// touch, drags extrapolated to many increments; P there is right to 1.6 % and to 0.2 %.
TEST(PadStepGrid, AFaceOverAPadThatIsNotSquare) {
  const fem::PadSensor pad{.tactels = {4, 4},
                           .pitch = {6.96, 3.48},
                           .thickness = 3,
                           .young = 1,
                           .poisson = 0.499,
                           .length = 24,
                           .width = 12};
  constexpr std::array<Pose, 4> way{
      {{0.1, 0, 0, 0}, {0.1, 0.0885098, 0, 0}, {0.1, 0.17702, 0, 0}, {0.1, 0.295033, 0, 0}}};
  expect_scene(pad, 0.3, {.shape = fem::Box{.half_widths = {40, 40}}}, way, 8,
               {{{29.584, 0, 0, 0, 0},
                 {28.093, 2.556, 0, 0, 0.3033},
                 {25.036, 4.706, 0, 0, 0.6265},
                 {21.202, 6.080, 0, 0, 0.9558}}},
               12);
}

TEST(PadStepGrid, ABoxOverTheEdgeOfAStrip) {
  const fem::PadSensor pad{
      .tactels = {4, 4}, .pitch = {8.7, 1.74}, .thickness = 3, .young = 1, .poisson = 0.49, .length = 30, .width = 6};
  constexpr std::array<Pose, 4> way{
      {{0.12, 0, 0, 0}, {0.12, 0, 0.133229, 0}, {0.12, 0, 0.266458, 0}, {0.12, 0, 0.444096, 0}}};
  expect_scene(pad, 0.5, {.shape = fem::Box{.half_widths = {8, 20}}, .position = {11, 0}}, way, 8,
               {{{6.0213, -0.2321, 0, 0, 0.0771},
                 {5.9091, -0.2214, 1.0319, -2.8230, 0.3598},
                 {5.6094, -0.2047, 1.9650, -5.2367, 0.7068},
                 {5.1664, -0.1468, 2.5598, -6.7128, 0.9929}}},
               6);
}

TEST(PadStepGrid, SaysWhereTheObjectReaches) {
  fem::PadSensor pad{.tactels = {2, 2}, .pitch = {0.5, 0.5}, .thickness = 2, .young = 1, .poisson = 0.45};
  const fem::PadIndenter ball{.shape = fem::Sphere{.radius = 4}}, box{.shape = fem::Box{.half_widths = {1, 1}}},
      face{.shape = fem::Box{.half_widths = {9, 9}}};
  const auto said = [&](const fem::PadIndenter& object, std::array<double, 2> place, double depth,
                        StepOptions options) {
    options.cells = 8, options.cell = options.cell.given ? options.cell : 0.25;
    PadStepper<float> steps(executor(), pad, 1, std::array{0.5}, options);
    put(steps, pad, object, place);
    steps.move(Pose{depth, 0, 0, 0});
    return flags(steps);
  };
  EXPECT_EQ(said(ball, {0, 0}, 0.05, {}), 0);
  EXPECT_EQ(said(ball, {0.6, 0}, 0.05, {}), STEP_EDGE | STEP_REACH);
  EXPECT_EQ(said(ball, {3, 0}, 0.05, {}), STEP_OPEN | STEP_REACH);  // all of it beyond the grid
  EXPECT_EQ(said(ball, {0, 0}, -0.05, {}), STEP_OPEN);
  EXPECT_EQ(said(ball, {3, 0}, -0.05, {}), STEP_OPEN);
  EXPECT_EQ(said(box, {0, 0}, 0.05, {}), 0);  // the grid ends where it ends
  EXPECT_EQ(said(face, {0, 0}, 0.05, {}), STEP_EDGE | STEP_REACH);
  pad.length = 3, pad.width = 2;  // beside the grid there is rubber along x alone
  EXPECT_EQ(said(face, {0, 0}, 0.05, {}), STEP_EDGE | STEP_REACH);
  EXPECT_EQ(said(ball, {0, 0.8}, 0.05, {}), 0);
  EXPECT_EQ(said(ball, {0.8, 0}, 0.05, {}), STEP_EDGE | STEP_REACH);
  EXPECT_EQ(said(face, {0, 0}, 0.05, {.cell = {0.375, 0.25}}), 0);  // over all of it
}

TEST(PadStepGrid, SaysWhatIsTooDeep) {
  const fem::PadSensor pad{.thickness = 2, .young = 1, .poisson = 0.45};
  const auto deep = [&](const fem::PadIndenter& object, double depth) {
    PadStepper<float> steps(executor(), pad, 1, std::array{0.5}, {.cells = 16, .cell = 0.3});
    put(steps, pad, object, {0, 0});
    steps.move(Pose{depth, 0, 0, 0});
    return flags(steps) & (STEP_DEEP | STEP_INVALID);
  };
  const fem::PadIndenter box{.shape = fem::Box{.half_widths = {1.5, 1.5}}}, ball{.shape = fem::Sphere{.radius = 5}},
      rod{.shape = fem::LyingCylinder{.radius = 3, .half_length = 2}};
  EXPECT_EQ(deep(box, 0.09), 0);
  EXPECT_EQ(deep(box, 0.1), STEP_DEEP);  // 5 % of the thickness
  EXPECT_EQ(deep(ball, 0.4), 0);         // 20 %
  EXPECT_EQ(deep(rod, 0.4), 0);
  EXPECT_EQ(deep(ball, 0.6), STEP_DEEP);  // 30 %
  EXPECT_EQ(deep(rod, 0.6), STEP_DEEP);
  EXPECT_EQ(deep(ball, 2.1), STEP_DEEP | STEP_INVALID);
}

/// A block stands for a pad longer than 12 H, whose own ends are none of the pad's.
TEST(PadStepGrid, KeepsOffTheEndsOfABlock) {
  fem::PadSensor pad{.tactels = {2, 2}, .pitch = {0.5, 0.5}, .thickness = 2, .young = 1, .poisson = 0.45};
  pad.length = 60, pad.width = 8;
  const PadStepper<float> steps(executor(), pad, 1, std::array{0.5}, {});
  EXPECT_NEAR(steps.cells().n * steps.cells().hx, 16, 1e-9);
  EXPECT_NEAR(steps.cells().ny() * steps.cells().hy, 8, 1e-9);
  EXPECT_EQ(thrown_message<ValueError>([&] {
              PadStepper<float>(executor(), pad, 1, std::array{0.5}, {.cells = 10, .cell = {1.7, 0.8}});
            }),
            "cell = 1.7: must be 1.6 mm at most, as 10 cells lie within 8 thicknesses of a pad longer than 12");
}

/// Numbers that no contact has leave the next step what it would have been.
TEST(PadStepGrid, IsNotHurtByNumbersThatNoContactHas) {
  const Bowls all(2, 9);
  PadStepper<float> steps = all.steps(executor()), others = all.steps(executor());
  pressed(steps, all), pressed(others, all);
  const auto invalid = [&](bool by_wrench, std::size_t row, double number, int more) {
    std::vector<double> to = by_wrench ? all.wrench(3, std::array{0.1, 0.1}, 0.5) : all.pose(4);
    const std::vector<float> before = steps.state(std::array<std::size_t, 1>{1});
    to[4 + row] = number;
    by_wrench ? steps.press(to) : steps.move(to);
    by_wrench ? others.press(to) : others.move(to);
    EXPECT_EQ(flags_of(steps, 1) & (STEP_INVALID | STEP_DEEP), STEP_INVALID | more) << row << " " << number;
    EXPECT_EQ(steps.state(std::array<std::size_t, 1>{1}), before) << row << " " << number;
  };
  invalid(false, 0, 1e30, STEP_DEEP);
  for (const std::size_t row : {1u, 2u, 3u}) invalid(false, row, 1e20, 0), invalid(false, row, -1e20, 0);
  for (const std::size_t row : {0u, 1u, 2u, 3u}) invalid(true, row, 1e30, 0);
  steps.move(all.pose(5)), others.move(all.pose(5));
  for (std::size_t c = 0; c < 2; ++c) EXPECT_EQ(rows_of(steps, c), rows_of(others, c));
  // An object that is parked far away is open, and comes back.
  std::vector<double> away = all.pose(5);
  away[4] = -1e12;
  steps.move(away);
  EXPECT_EQ(flags_of(steps, 1), STEP_OPEN);
  steps.move(all.pose(5));
  EXPECT_NEAR(number(steps, 1, STEP_RESULT_P), number(others, 1, STEP_RESULT_P),
              0.1 * number(others, 1, STEP_RESULT_P));
}

/// More force than the rubber bears within its thickness is said, and leaves a contact that goes on.
TEST(PadStepGrid, EndsTheSearchForADepthAtTheBase) {
  const Bowls all(1, 9);
  PadStepper<float> steps = all.steps(executor());
  const double P = pressed(steps, all)[0];
  steps.press(std::array{1e5 * P, 0.0, 0.0, 0.0});
  EXPECT_EQ(flags_of(steps, 0) & (STEP_UNMET | STEP_DEEP), STEP_UNMET | STEP_DEEP);
  EXPECT_LE(number(steps, 0, STEP_RESULT_DEPTH), 1.0 + 0.1);  // H; the lowest cell lies below that
  for (int k = 0; k < 3; ++k) steps.press(std::array{P, 0.0, 0.0, 0.0});
  EXPECT_EQ(flags_of(steps, 0), 0);
  EXPECT_NEAR(number(steps, 0, STEP_RESULT_P), P, 2.1e-3 * P);
}

TEST(PadStepGrid, TakesNoStateOfOthers) {
  const Bowls all(2, 9);
  PadStepper<float> steps = all.steps(executor());
  PadStepper<float> others(executor(), all.pad, 2, all.friction, {.cells = 8, .cell = {0.14, 0.07}});
  pressed(steps, all);
  std::vector<float> state = steps.state();
  const auto message = [&](auto& to) { return thrown_message<ValueError>([&] { to.set_state(state); }); };
  EXPECT_EQ(
      message(others),
      "state = one of 8 x 8 cells of 0.14 x 0.14 H, nu 0.45: must be one of 8 x 8 cells of 0.14 x 0.07 H, nu 0.45");
  EXPECT_EQ(message(steps), "no error");
  std::vector<float> before = steps.state();
  state.back() = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(message(steps), "state = nan: must be finite numbers");
  EXPECT_EQ(steps.state(), before);  // of the other contact, too
  state.pop_back();
  EXPECT_NE(message(steps), "no error");
}

TEST(PadStepGrid, SaysHowManyContactsADeviceHolds) {
  const auto made = [](std::size_t count) { PadStepper<float>(executor(), rubber, count, std::array{0.5}, {}); };
  EXPECT_THAT(thrown_message<ValueError>([&] { made(std::size_t{1} << 31); }),
              ::testing::MatchesRegex(
                  "count = 2147483648: must be [0-9]+ at most, as each takes [0-9]+ bytes of the device's memory"));
  EXPECT_EQ(thrown_message<ValueError>([&] { made(0); }), "count = 0: must be 1 or more");
}

/// The slip index is at most 1 while all slides, in the last digit, too.
TEST(PadStepGrid, HasASlipIndexOfOneAtMost) {
  const Bowls all(200, 9);
  PadStepper<float> steps = all.steps(executor());
  pressed(steps, all);
  std::vector<double> to = all.pose(3);
  double most = 0;
  for (int k = 0; k < 4; ++k) {
    for (std::size_t c = 0; c < all.count; ++c) to[4 * c + 1] += 0.3, to[4 * c + 2] += 0.01 * static_cast<double>(c);
    steps.move(to);
    for (std::size_t c = 0; c < all.count; ++c) most = std::max(most, number(steps, c, STEP_RESULT_S));
  }
  EXPECT_EQ(most, 1);
}

}  // namespace tactel::host::pad_step_grid_test
