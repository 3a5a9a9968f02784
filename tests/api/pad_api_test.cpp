// SPDX-License-Identifier: Apache-2.0

// Pads in tactel::simulate beside the rooms that it hides: the same bits.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tactel/simulate.h>

#include <cmath>

#include "host/answers/solve.h"
#include "host/answers/warnings.h"
#include "host/scenes/scene_file.h"
#include "tests/scratch.h"
#include "tests/thrown_message.h"

namespace pad_api_test {

using namespace tactel;
using ::testing::DoubleNear;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

const char* const twisted_box =
    "title = \"t\"\n[sensor]\nkind = \"pad\"\ntactels = [3, 2]\npitch = [2.5, 3]\ntactel_size = 1\nthickness = 2.5\n"
    "young = 1.5\npoisson = 0.5\nlength = 40\nwidth = 30\n[indenter]\nshape = \"box\"\nhalf_widths = [2, 1.5]\n"
    "edge = 0.8\nposition = [0.5, -0.25]\nyaw = 30\ntilt = 1\ntilt_direction = 45\n[contact]\nfriction = 0.7\n"
    "[load]\nindentation = [0.1, 0.2]\ntangential_step = [0.03, 0.01]\ntwist_step = 0.1\ntangential_steps = 3\n";
const char* const mapped =
    "[sensor]\nkind = \"pad\"\nthickness = 2\n[indenter]\nshape = \"heightmap\"\nfile = \"map.csv\"\npitch = 1\n"
    "[load]\nnormal_force = 0.5\n";
const char* const map_csv = "1.5,1.25,1.5,1.75\n1.3,1,1.3,1.6\n1.7,1.5,1.75,2\n";  // three rows along y

const auto message_of = [](const auto& call) { return thrown_message<InputError>(call); };

PadScene sphere_drag() {
  PadScene scene;
  scene.sensor = {.tactels = {3, 3}, .pitch = {1, 0.5}, .thickness = 2, .young = 1};
  scene.load = press_pad(0.25, 2).drag_to({{.05, .02}, {.1, .04}, {.1, .1}},
                                          {.01 * 180 / M_PI, .03 * 180 / M_PI, .05 * 180 / M_PI});
  return scene;
}

template <class Numbers>
void expect_same(const std::vector<double>& a, const Numbers& b) {
  ASSERT_EQ(a.size(), static_cast<std::size_t>(b.size()));
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_EQ(a[i], b[static_cast<Eigen::Index>(i)]) << i;
}

void expect_same(const PadPath& path, const host::PadOutcome& outcome) {
  ASSERT_EQ(path.steps.size(), outcome.solution.steps.size());
  for (std::size_t k = 0; k < path.steps.size(); ++k) {
    const PadStep& step = path.steps[k];
    const fem::PadStep& twin = outcome.solution.steps[k];
    EXPECT_EQ(step.P, twin.P);
    EXPECT_EQ(step.Q[0], twin.Q[0]);
    EXPECT_EQ(step.Q[1], twin.Q[1]);
    EXPECT_EQ(step.M, twin.M);
    EXPECT_EQ(step.slip_index, twin.slip_index.value());
    EXPECT_EQ(step.force_ratio, twin.force_ratio.value());
    EXPECT_EQ(step.stick_fraction, twin.stick_fraction);
    EXPECT_EQ(step.slip_distance, twin.slip_distance);
    EXPECT_EQ(step.converged, twin.converged);
    expect_same(step.sigma_z, twin.stress.col(0));
    expect_same(step.tau_x, twin.stress.col(1));
    expect_same(step.tau_y, twin.stress.col(2));
    expect_same(step.normal_force, twin.normal_force);
    ASSERT_EQ(step.tangential_force.size(), step.normal_force.size());
    EXPECT_EQ(step.tangential_force[5][1], twin.tangential_force(5, 1));
    EXPECT_EQ(step.status.size(), twin.status.size());
  }
  expect_same(path.cell_x, outcome.solution.places.col(0));
  EXPECT_EQ(path.cell_width[1], outcome.solution.cells.hy);
  EXPECT_EQ(path.model, host::model_name(outcome));
  EXPECT_EQ(path.rung, outcome.rung.name);
  const auto& e = outcome.error.value().expected;
  const PadError& error = path.error.value();
  EXPECT_EQ((std::array{error.S, error.P, error.Q, error.M, error.sigma, error.tau, error.markers}),
            (std::array{e.S, e.P, e.Q, e.M, e.sigma, e.tau, e.markers}));
  EXPECT_EQ(error.strain, outcome.error->strain);
  EXPECT_EQ(error.from, "24 x 24 cells");
  EXPECT_EQ(path.warnings, host::warnings(outcome));
}

host::PadOutcome by_the_program(const std::string& file, const host::SolveOptions& options) {
  return host::solve(std::get<fem::PadScene>(host::read_any_scene(file)), options);
}

TEST(PadSceneApi, ReadsScenesAsTheProgramDoes) {
  const ScratchFolder folder;
  const PadScene scene = read_pad_scene(folder.write("box.toml", twisted_box));
  EXPECT_EQ(scene.title, "t");
  EXPECT_EQ(scene.sensor.tactels, (std::array{3, 2}));
  EXPECT_EQ(scene.sensor.pitch, (std::array{2.5, 3.0}));
  EXPECT_EQ(scene.sensor.width, 30);
  EXPECT_EQ(std::get<Box>(scene.indenter.shape).edge, 0.8);
  EXPECT_EQ(scene.indenter.position, (std::array{0.5, -0.25}));
  EXPECT_EQ(scene.indenter.tilt_direction, 45);
  EXPECT_EQ(scene.friction, 0.7);
  EXPECT_EQ(scene.load.indentation, (std::vector{0.1, 0.2}));
  EXPECT_EQ(scene.load.tangential[1], (std::array{2 * 0.03, 0.02}));
  EXPECT_THAT(scene.load.twist, ElementsAre(0.1, 0.2, DoubleNear(0.3, 1e-16)));
  EXPECT_EQ(message_of([&] { validate(scene); }), "no error");

  folder.write("map.csv", map_csv);
  const PadScene grid = read_pad_scene(folder.write("map.toml", mapped));
  const auto& map = std::get<HeightMap>(grid.indenter.shape);
  EXPECT_EQ(map.columns, 4u);
  ASSERT_EQ(map.heights.size(), 12u);
  EXPECT_EQ(map.heights[4 + 1], 0);      // the lowest
  EXPECT_EQ(map.heights[2 * 4 + 3], 1);  // last row along y, last place along x
  EXPECT_TRUE(grid.load.indentation.empty());
}

TEST(PadSceneApi, ReadsEitherKindAndRefusesTheOther) {
  const ScratchFolder folder;
  const std::string pad = folder.write("box.toml", twisted_box);
  const std::string line =
      folder.write("line.toml", "[indenter]\nshape = \"parabola\"\nradius = 3\n[load]\nindentation = 0.1\n");
  EXPECT_TRUE(std::holds_alternative<PadScene>(read_any_scene(pad)));
  EXPECT_TRUE(std::holds_alternative<Scene>(read_any_scene(line)));
  EXPECT_EQ(message_of([&] { read_scene(pad); }),
            pad + ": sensor.kind: \"pad\"; must be \"line\", or read by read_pad_scene");
  EXPECT_EQ(message_of([&] { read_pad_scene(line); }),
            line + ": sensor.kind: \"line\"; must be \"pad\", or read by read_scene");
}

TEST(PadSceneApi, DragsAddUp) {
  const PadLoad load = press_pad_by_force(3).drag({0.1, 0}, 2).turn(4, 2).drag_to({{0, 0.5}}).drag({0, 0.5}, 1, -1);
  EXPECT_EQ(load.normal_force, std::vector{3.0});
  EXPECT_TRUE(load.indentation.empty());
  EXPECT_EQ(load.tangential,
            (std::vector<std::array<double, 2>>{{0.1, 0}, {0.2, 0}, {0.2, 0}, {0.2, 0}, {0, 0.5}, {0, 1}}));
  EXPECT_EQ(load.twist, (std::vector<double>{0, 0, 4, 8, 0, -1}));
}

TEST(PadSceneApi, NamesPlaceProblemAndFix) {
  PadScene scene = sphere_drag();
  scene.sensor.poisson = 0.6;
  EXPECT_EQ(message_of([&] { validate(scene); }),
            "sensor.poisson: 0.6; must be a Poisson's ratio, 0 <= poisson <= 0.5");
  scene = sphere_drag();
  scene.load.twist.pop_back();
  EXPECT_EQ(message_of([&] { validate(scene); }),
            "load.twist: 2 twists; must be as many as load.tangential has positions, 3, or empty");
  scene = sphere_drag();
  for (const std::vector<double>& wrong : {std::vector<double>{1, 2, 3}, {1, 2, 3, NAN}}) {
    scene.indenter.shape = HeightMap{.columns = 2, .heights = wrong};
    EXPECT_THAT(message_of([&] { validate(scene); }), HasSubstr("indenter.heights: ")) << wrong.size();
  }
}

TEST(PadSolveApi, GivesTheBitsOfTheProgram) {
  const ScratchFolder folder;
  folder.write("map.csv", map_csv);
  for (const auto& [text, rung, solver] :
       {std::tuple(twisted_box, "", "batched"), {mapped, "pad-8", "batched"}, {twisted_box, "pad-8", "twin"}}) {
    const std::string file = folder.write("scene.toml", text);
    expect_same(solve(read_pad_scene(file), {.rung = rung, .solver = solver}),
                by_the_program(file, {.rung = rung, .solver = solver}));
  }
}

// An independent program for frictional contact gives these totals on cells over 3.2 x 3.2 mm (tests/fem/pad), which
// end inside the contact: P is 1.5 % low there. The tangential numbers are relative to P.
TEST(PadSolveApi, DragsASphereAsAnIndependentProgramDoes) {
  const PadPath path = solve(sphere_drag(), {.rung = "pad-16"});
  ASSERT_EQ(path.steps.size(), 5u);
  const double expected[][5] = {{1.56745, .21032, .08429, .08244, .3163},
                                {1.56503, .38148, .15408, .19007, .6008},
                                {1.56332, .34231, .35608, .25751, .7429}};
  for (std::size_t k = 0; k < 3; ++k) {
    const PadStep& step = path.steps[2 + k];
    const auto& [P, Qx, Qy, M, S] = expected[k];
    EXPECT_NEAR(step.P, P, 0.02 * P);
    EXPECT_NEAR(step.Q[0], Qx, 0.05 * Qx);
    EXPECT_NEAR(step.Q[1], Qy, 0.05 * Qy);
    EXPECT_NEAR(step.M, M, 0.08 * M);
    EXPECT_NEAR(step.slip_index, S, 0.01);
    EXPECT_DOUBLE_EQ(step.force_ratio, std::hypot(step.Q[0], step.Q[1]) / (0.5 * step.P));
  }
  EXPECT_EQ(path.tactel_x, (std::vector<double>{-1, 0, 1}));
  EXPECT_EQ(path.tactel_y, (std::vector<double>{-0.5, 0, 0.5}));
  // sigma_z, tau_x, tau_y at (0, 0) and (1, 0.5): x is fastest.
  const PadStep& last = path.steps.back();
  EXPECT_NEAR(last.sigma_z[4], -.14651, 0.003);
  EXPECT_NEAR(last.sigma_z[8], -.11374, 0.003);
  EXPECT_NEAR(last.tau_x[8], .04133, 0.002);
  EXPECT_NEAR(last.tau_y[8], .02584, 0.002);
}

TEST(PadSolveApi, RefusesOptionsThatCannotBe) {
  EXPECT_THAT(message_of([] { solve(sphere_drag(), {.rung = "patch-12"}); }),
              HasSubstr("rung: patch-12; must be a rung of pads"));
  EXPECT_THAT(message_of([] { solve(sphere_drag(), {.precision = "fp16"}); }), HasSubstr("precision: fp16"));
  const std::vector<PadScene> scenes = {sphere_drag()};
  EXPECT_THAT(message_of([&] { solve_many(scenes, {.rung = "reference"}); }), HasSubstr("rung: reference"));
  EXPECT_THAT(message_of([&] { solve_many(scenes, {.solver = "twin"}); }), HasSubstr("solver: twin"));
  EXPECT_THAT(message_of([&] { solve_many(scenes, {.tolerance = -1}); }), HasSubstr("tolerance"));
}

TEST(PadSolveApi, SolvesManyAsOneByOne) {
  std::vector<PadScene> scenes(4, sphere_drag());
  scenes[1].load = press_pad(0.1);
  scenes[2].sensor.thickness = 1.3;
  scenes[2].sensor.young = 3;
  scenes[2].indenter = {Cone{70}, {0.3, 0}, 20};
  scenes[3].friction = 0;
  const PadPaths all = solve_many(scenes);
  ASSERT_EQ(all.scenes, 4u);
  ASSERT_EQ(all.steps, 5u);
  EXPECT_EQ(all.tactels, (std::array<std::size_t, 2>{3, 3}));
  EXPECT_EQ(all.steps_made, (std::vector<std::uint32_t>{5, 1, 5, 5}));
  EXPECT_EQ(all.rung, "pad-12");
  EXPECT_EQ(all.precision, "fp32");
  for (std::size_t i = 0; i < 3; ++i) {
    const PadPath one = solve(scenes[i], {.precision = "fp32"});
    for (std::size_t k = 0; k < one.steps.size(); ++k) {
      const PadStep& step = one.steps[k];
      const std::size_t at = i * 5 + k;
      EXPECT_EQ(all.P[at], step.P) << i;
      EXPECT_EQ(all.Q[2 * at + 1], step.Q[1]) << i;
      EXPECT_EQ(all.M[at], step.M) << i;
      EXPECT_EQ(all.slip_index[at], step.slip_index) << i;
      EXPECT_EQ(all.force_ratio[at], step.force_ratio) << i;
      EXPECT_EQ(all.stick_fraction[at], step.stick_fraction) << i;
      EXPECT_EQ(all.indentation[at], step.indentation) << i;
      EXPECT_EQ(all.tangential[2 * at], step.tangential[0]) << i;
      EXPECT_EQ(all.twist[at], step.twist) << i;
      for (std::size_t t = 0; t < 9; ++t) {
        EXPECT_EQ(all.sigma_z[at * 9 + t], step.sigma_z[t]) << i;
        EXPECT_EQ(all.tau_x[at * 9 + t], step.tau_x[t]) << i;
        EXPECT_EQ(all.tau_y[at * 9 + t], step.tau_y[t]) << i;
      }
      EXPECT_EQ(all.converged[at], 1);
    }
  }
  EXPECT_TRUE(std::isnan(all.P[5 + 1]) && std::isnan(all.tangential[2 * 6]) && std::isnan(all.sigma_z[6 * 9]));
  EXPECT_TRUE(std::isnan(all.slip_index[3 * 5 + 4]) && std::isnan(all.force_ratio[3 * 5 + 4]));  // mu P = 0
  EXPECT_EQ(solve_many(std::span<const PadScene>()).steps, 0u);
}

TEST(PadSolveApi, NamesTheSceneOfMany) {
  std::vector<PadScene> scenes(3, sphere_drag());
  scenes[2].friction = -1;
  EXPECT_THAT(message_of([&] { solve_many(scenes); }), HasSubstr("scenes[2].contact.friction: -1"));
  scenes[2] = sphere_drag(), scenes[1].sensor.axes = 1;
  EXPECT_EQ(message_of([&] { solve_many(scenes); }),
            "scenes[1].sensor.tactels: 3 x 3 of 1 axes; must be those of scenes[0], 3 x 3 of 3 axes");
  scenes[1] = sphere_drag(), scenes[1].sensor.young = 2e6;
  EXPECT_THAT(solve_many(scenes).warnings, ElementsAre(HasSubstr("scenes[1]: sensor.young = 2e+06 MPa")));
  scenes[1] = sphere_drag();
  EXPECT_THROW(solve_many(scenes, {}, [](std::uint64_t, std::uint64_t) { return false; }), Cancelled);
}

// An accuracy takes the cheapest rung whose errors by class keep it on all scenes.
TEST(PadSolveApi, AnAccuracyTakesTheRungThatKeepsIt) {
  std::vector<PadScene> scenes(2, sphere_drag());
  scenes[1].load = press_pad_by_force(1);
  const double kept = host::measured_pads()[0].of[0].most95.S;  // of spheres
  EXPECT_EQ(solve_many(scenes, {.accuracy = kept}).rung, "pad-8");
  EXPECT_EQ(solve_many(scenes, {.accuracy = 0.99 * kept}).rung, "pad-12");
  scenes[1].friction = 2;  // beyond the scenes that were measured: three times the error
  EXPECT_NE(solve_many(scenes, {.accuracy = kept}).rung, "pad-8");
}

// The cylinder's end lies 3 mm from its axis, and the contact stays 2 mm from the edges: of 20 mm along y the axis may
// reach 10 - 2 - 3 = 5 mm, one and many alike. A cell reaches 0.15 of its side beyond the end.
TEST(PadSolveApi, RefusesContactsAtTheEdgeOfThePad) {
  std::vector<PadScene> scenes(3, sphere_drag());
  for (PadScene& scene : scenes) {
    scene.sensor.width = 20;
    scene.indenter.shape = LyingCylinder{.radius = 4, .half_length = 3};
    scene.load = press_pad(0.2);
  }
  scenes[1].indenter.position = {0, 4.8};
  EXPECT_EQ(message_of([&] { solve_many(scenes); }), "no error");
  EXPECT_EQ(message_of([&] { solve(scenes[1]); }), "no error");
  scenes[2].indenter.position = {0, -5.1};
  EXPECT_THAT(message_of([&] { solve_many(scenes); }),
              HasSubstr("scenes[2].indenter.position: [0, -5.1]; must be a place"));
  EXPECT_THAT(message_of([&] { solve(scenes[2]); }), HasSubstr("indenter.position: [0, -5.1]; must be a place"));
}

}  // namespace pad_api_test
