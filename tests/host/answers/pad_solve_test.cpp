// SPDX-License-Identifier: Apache-2.0

// One contact on a pad, from its file to the answer: named scenes, solvers, symmetry, edges of the pad, rungs.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <tuple>

#include "host/answers/answer_forms.h"
#include "host/answers/solve.h"
#include "host/answers/warnings.h"
#include "host/contact/limits.h"
#include "host/contact/pads/pad_stream.h"
#include "host/scenes/scene_file.h"
#include "host/support/errors.h"
#include "tests/fem/pad/named_pad_scenes.h"
#include "tests/scratch.h"
#include "tests/thrown_message.h"

namespace tactel::host::pad_solve_test {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

fem::PadScene read_text(const std::string& text) {
  const ScratchFolder folder;
  return std::get<fem::PadScene>(read_any_scene(folder.write("scene.toml", text)));
}

/// A table of a scene's JSON as TOML, whose numbers, words and arrays look alike.
std::string table(const std::string& name, const nlohmann::ordered_json& json) {
  std::string text = "[" + name + "]\n";
  for (const auto& [key, value] : json.items()) text += key + " = " + value.dump() + "\n";
  return text;
}

std::string file_of(const fem::PadScene& scene) {
  const auto json = to_json(scene);
  return table("sensor", json["sensor"]) + table("indenter", json["indenter"]) + table("contact", json["contact"]) +
         table("load", json["load"]);
}

fem::PadScene dragged(double x = 0, double y = 0, double yaw = 0) {
  fem::PadScene scene;
  scene.sensor = {.tactels = {4, 4}, .pitch = {2, 2}, .thickness = 2, .young = 1, .poisson = 0.45};
  scene.indenter = {.shape = fem::Paraboloid{{12, 6}}, .position = {x, y}, .yaw = yaw};
  scene.load = {.indentation = {0.2}, .drags = {{0.05, 0.02, 0.02}, {0.1, 0.1, 0.03}}};
  return scene;
}

// The program lays cells of its own and presses in six increments, where the named scenes state cells and press in two.
// Both differ from the limit of small cells and increments: S by 0.009 and 0.02 (95 % of scenes at 16 cells with six
// increments, at 12 with two), and P of thin_twist, where nu is 1/2 and mu 0.8, by 2 and 7 %.
TEST(PadSolve, NamedScenesFromFiles) {
  for (const fem::NamedScene& named : fem::named_scenes()) {
    const fem::PadScene scene = read_text(file_of(named.scene));
    const PadOutcome outcome = solve(scene, {.rung = "pad-16", .precision = "fp32"});
    ASSERT_EQ(outcome.solution.steps.size(), named.steps.size());
    for (std::size_t k = 0; k < named.steps.size(); ++k) {
      const auto& [P, Qx, Qy, M, S, stick, touch] = named.steps[k];
      if (P == 0) continue;  // not stated
      const fem::PadStep& step = outcome.solution.steps[k];
      const double most = scene.friction * P;
      EXPECT_TRUE(step.converged) << named.name << k;
      EXPECT_NEAR(step.P, P, 0.06 * P) << named.name << k;
      EXPECT_NEAR(step.Q[0], Qx, 0.03 * most) << named.name << k;  // theirs take one increment also where they turn
      EXPECT_NEAR(step.Q[1], Qy, 0.03 * most) << named.name << k;
      EXPECT_NEAR(step.M, M, 0.02 * most * named.x) << named.name << k;
      EXPECT_NEAR(*step.slip_index, S, 0.02) << named.name << k;
    }
  }
}

TEST(PadSolve, ASceneReadsBackFromItsJson) {
  fem::PadScene scene = dragged(1, -0.5, 30);
  scene.sensor.length = 30, scene.sensor.width = 20, scene.sensor.axes = 1, scene.sensor.tactel_size = 0.5;
  for (const fem::PadShape& shape :
       {fem::PadShape(fem::Sphere{3}), fem::PadShape(fem::Paraboloid{{3, 4}}), fem::PadShape(fem::LyingCylinder{3, 4}),
        fem::PadShape(fem::Punch{3, 1}), fem::PadShape(fem::Box{{3, 4}, 1}), fem::PadShape(fem::Cone{80})}) {
    scene.indenter.shape = shape;
    scene.indenter.tilt = std::holds_alternative<fem::Punch>(shape) ? 2 : 0;
    const auto json = to_json(scene);
    EXPECT_EQ(to_json(read_text(file_of(scene))).dump(), json.dump());
    const std::string name = fem::shape_name(shape);
    EXPECT_EQ(json["indenter"]["shape"], name);
  }
}

// The twin shares no code with the kernel. Both to 1e-7 in fp64: sweeps leave twenty times that of the largest.
TEST(PadSolve, TheTwinAgrees) {
  const fem::PadScene scene = dragged(0.3, 0.2, 20);
  const fem::PadSolution twin = solve(scene, {.rung = "pad-8", .solver = "twin"}).solution;
  const PadOutcome outcome = solve(scene, {.rung = "pad-8"});
  const double near = outcome.precision == "fp64" ? 5e-6 : 5e-3;
  ASSERT_EQ(twin.steps.size(), 3u);
  for (std::size_t k = 0; k < twin.steps.size(); ++k) {
    const fem::PadStep &a = outcome.solution.steps[k], &b = twin.steps[k];
    EXPECT_NEAR(a.P, b.P, near * b.P);
    EXPECT_NEAR((a.Q - b.Q).norm(), 0, near * b.P);
    EXPECT_NEAR(a.M, b.M, near * b.P);
    EXPECT_NEAR(*a.slip_index, *b.slip_index, 1e-3);                       // four rounds of the margin in the kernel
    EXPECT_NEAR(a.slip_distance, b.slip_distance, near * 0.2) << k;        // of the depth
    EXPECT_NEAR((a.stress - b.stress).norm(), 0, 1e-3 * b.stress.norm());  // quadratics in the kernel
  }
  EXPECT_GT(twin.steps.back().slip_distance, 0.01);
}

// Turned by 90 degrees about the middle of the pad, position, yaw and drags alike: x' = -y, y' = x. The cells lie in
// the indenter's frame, so that only rounding differs.
TEST(PadSolve, ATurnedSceneHasTheTurnedAnswer) {
  fem::PadScene turned = dragged(-0.5, 1, 120);
  for (auto& [x, y, twist] : turned.load.drags) std::tie(x, y) = std::pair(-y, x);
  const SolveOptions options{.rung = "pad-8", .solver = "twin"};
  const PadOutcome a = solve(dragged(1, 0.5, 30), options), b = solve(turned, options);
  for (std::size_t k = 0; k < 3; ++k) {
    const fem::PadStep &p = a.solution.steps[k], &q = b.solution.steps[k];
    EXPECT_NEAR(q.P, p.P, 1e-9);
    EXPECT_NEAR(q.Q[0], -p.Q[1], 1e-9);
    EXPECT_NEAR(q.Q[1], p.Q[0], 1e-9);
    EXPECT_NEAR(q.M, p.M, 1e-9);
    EXPECT_NEAR(*q.slip_index, *p.slip_index, 1e-9);
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) {  // tactel (i, j) of the first lies at (3 - j, i) of the other
        const auto from = p.stress.row(4 * j + i), to = q.stress.row(4 * i + 3 - j);
        EXPECT_NEAR(to[0], from[0], 1e-9);
        EXPECT_NEAR(to[1], -from[2], 1e-9);
        EXPECT_NEAR(to[2], from[1], 1e-9);
      }
  }
}

// A ball that slides as a whole: fp32 rounds its margin to 1.0000002.
TEST(PadSolve, SIsOneAtMost) {
  fem::PadScene scene;
  scene.sensor = {.thickness = 4, .young = 1, .poisson = 0.45};
  scene.indenter.shape = fem::Sphere{12};
  scene.load = {.indentation = {0.32}, .drags = {{0.96, 0, 0}}};
  const double S = solve(scene, {.rung = "pad-8", .precision = "fp32"}).solution.steps.back().slip_index.value();
  EXPECT_LE(S, 1);
  EXPECT_GT(S, 0.999);
}

// Mirrored at y = 0: rows are swept in another order, so that the answers differ by what the sweeps leave.
TEST(PadSolve, AMirroredSceneHasTheMirroredAnswer) {
  fem::PadScene mirrored = dragged(1, -0.5, -30);
  for (auto& [x, y, twist] : mirrored.load.drags) y = -y, twist = -twist;
  const SolveOptions options{.rung = "pad-8", .solver = "twin"};
  const PadOutcome a = solve(dragged(1, 0.5, 30), options), b = solve(mirrored, options);
  for (std::size_t k = 0; k < 3; ++k) {
    const fem::PadStep &p = a.solution.steps[k], &q = b.solution.steps[k];
    EXPECT_NEAR(q.P, p.P, 5e-6 * p.P);
    EXPECT_NEAR(q.Q[0], p.Q[0], 5e-6 * p.P);
    EXPECT_NEAR(q.Q[1], -p.Q[1], 5e-6 * p.P);
    EXPECT_NEAR(q.M, -p.M, 5e-6 * p.P);
    EXPECT_NEAR(*q.slip_index, *p.slip_index, 5e-5);
  }
}

/// A sharp box, 4 mm wide, at x: its cells reach 0.15 of 4 / 11.7 mm beyond its edge.
fem::PadScene box_at(double x, double yaw = 0) {
  fem::PadScene scene;
  scene.sensor = {.tactels = {4, 4}, .pitch = {2, 2}, .thickness = 2};
  scene.sensor.length = 20;
  scene.indenter = {.shape = fem::Box{{2, 2}, 0}, .position = {x, 0}, .yaw = yaw};
  scene.load.indentation = {0.1};
  return scene;
}
constexpr double overhang = 0.15 * 4 / 11.7;

TEST(PadEdges, AreWarnedOfAndRefused) {
  const auto at = [](double x, double yaw = 0) { return solve(box_at(x, yaw), {.precision = "fp32"}); };
  EXPECT_NEAR(*distance_to_edge(box_at(0), at(0).solution), 8 - overhang, 1e-5);
  EXPECT_NEAR(*distance_to_edge(box_at(-3, 90), at(-3, 90).solution), 5 - overhang, 1e-5);
  EXPECT_NEAR(*distance_to_edge(box_at(0, 45), at(0, 45).solution), 10 - std::sqrt(2.0) * (2 + overhang), 1e-5);
  EXPECT_THAT(warnings(at(3.9)), IsEmpty());  // 2.03 thicknesses
  // Lines measured at 1.4 thicknesses: 0.016 to 0.049. Between 0.7 and 2.1: sqrt(0.06 0.005), sqrt(0.12 0.018).
  EXPECT_THAT(warnings(at(10 - 2 - overhang - 2.8)), ElementsAre(AllOf(HasSubstr("within 2.8 mm (1.4 thicknesses)"),
                                                                       HasSubstr("S of lines off by 0.017 to 0.046"))));
  EXPECT_THAT(thrown_message<ValueError>([&] { at(6.1); }),
              AllOf(HasSubstr("indenter.position = [6.1, 0]"), HasSubstr("stays 2 mm (the thickness)"),
                    HasSubstr("not 1.85 mm"), HasSubstr("off by 0.035 to 0.08 at one")));
  EXPECT_THAT(thrown_message<ValueError>([&] { at(30); }), HasSubstr("not -22.1 mm"));  // beside the pad
  fem::PadScene free = box_at(30);
  free.sensor.length.reset();
  EXPECT_EQ(distance_to_edge(free, solve(free, {.precision = "fp32"}).solution), std::nullopt);
}

TEST(PadWarnings, DepthSlipPitchAndScenesThatWereNotMeasured) {
  const auto of = [](const fem::PadScene& scene) {
    return warnings(solve(scene, {.rung = "pad-8", .precision = "fp32"}));
  };
  EXPECT_THAT(of(dragged()), IsEmpty());
  fem::PadScene scene = dragged();
  scene.load = {.indentation = {0.5}};
  EXPECT_THAT(of(scene), ElementsAre(HasSubstr("0.5 mm deep, 25 % of the thickness"),
                                     HasSubstr("depth over thickness 0.25 (measured 0.01 to 0.2)")));
  scene = dragged();
  scene.load.drags = {{2, 0, 0}};
  EXPECT_THAT(of(scene), ElementsAre(HasSubstr("mm over the rubber, more than 0.")));
  scene = dragged();
  scene.sensor.pitch = {6, 6};  // the contact lies 4.2 mm from the tactels at (+-3, +-3), and reaches some 2 mm
  EXPECT_THAT(of(scene), ElementsAre(HasSubstr("with a pitch of 6 mm the tactels hardly see it")));
  scene.indenter.position = {3, 3};
  EXPECT_THAT(of(scene), IsEmpty());
  scene = dragged();
  scene.friction = 0.02;
  scene.load.drags.clear();
  EXPECT_THAT(of(scene), ElementsAre(HasSubstr("friction 0.02 (measured 0.05 to 1.5)")));
  scene = dragged();
  scene.sensor.young = 2e6;
  EXPECT_THAT(of(scene), ElementsAre(HasSubstr("check the unit")));
}

TEST(PadSolve, ShapesThatAreNoContact) {
  fem::PadScene scene = dragged();
  for (const fem::PadShape& shape : {fem::PadShape(fem::Cone{1e-9}), fem::PadShape(fem::Cone{89.99999}),
                                     fem::PadShape(fem::Paraboloid{{1e6, 1e-6}}), fem::PadShape(fem::Sphere{1e-6})}) {
    scene.indenter.shape = shape;
    EXPECT_THAT(thrown_message<ValueError>([&] { solve(scene, {.rung = "pad-8"}); }), HasSubstr("indenter.shape = "));
  }
}

// Each once took minutes, or had no end.
TEST(PadSolve, ScenesWithoutAnEndAreRefusedAtOnce) {
  const auto refused = [](const fem::PadScene& scene) { return thrown_message<ValueError>([&] { solve(scene, {}); }); };
  fem::PadScene scene = dragged();
  scene.sensor.thickness = 1e-6;
  EXPECT_THAT(refused(scene), HasSubstr("indenter.shape = paraboloid: must be one whose contact measures"));
  scene = dragged();
  scene.indenter.shape = fem::Cone{89.99};
  EXPECT_THAT(refused(scene), HasSubstr("indenter.shape = cone"));
  scene = dragged();
  scene.sensor.thickness = 0.01, scene.sensor.tactel_size = 2, scene.load.indentation = {1e-4};
  scene.load.drags.clear();
  EXPECT_THAT(refused(scene), HasSubstr("sensor.tactel_size = 2: must be a side of fewer thicknesses (0.01 mm)"));
}

// The same in a set, where each contact has its own: unsolved, not endless.
TEST(PadSolve, ScenesWithoutAnEndAreUnsolvedInABatch) {
  fem::PadScene scene = dragged();
  scene.sensor.thickness = 1e-6;
  Executor executor{Device("")};
  const std::vector<fem::PadScene> scenes{dragged(), scene};
  const auto solutions = PadStream(executor, model_of(rung_named<PadRung>("pad-8"))).solve(scenes);
  EXPECT_TRUE(every_step_converged(solutions[0]));
  for (const fem::PadStep& step : solutions[1].steps) EXPECT_TRUE(!step.converged && step.P == 0);
}

// P = 2 E' d^2 tan(angle) / pi (Sneddon). Depths of 0 and of less than a cell's least side once were refused.
TEST(PadSolve, ConesAreSolvedAtAnyDepth) {
  fem::PadScene scene = dragged();
  scene.indenter.shape = fem::Cone{30};
  for (const double depth : {0.0, 2e-5, 1e-3}) {
    scene.load = {.indentation = {depth}};
    const PadOutcome outcome = solve(scene, {});
    const double P = 2 * scene.sensor.young * depth * depth * std::tan(std::numbers::pi / 6) /
                     (std::numbers::pi * (1 - std::pow(scene.sensor.poisson, 2)));
    EXPECT_NEAR(outcome.solution.steps.front().P, P, 0.015 * P) << depth;
    EXPECT_EQ(outcome.error.has_value(), depth > 0);
  }
}

TEST(PadWarnings, StepsThatTouchNothing) {
  fem::PadScene scene = dragged();
  scene.load = {.indentation = {0, 0.2}, .moves = {{0, 0.1, 0, 0}, {0, 0, 0, 0}}};
  const PadOutcome outcome = solve(scene, {.rung = "pad-8", .precision = "fp32"});
  EXPECT_THAT(warnings(outcome), Contains("the indenter touches nothing in load steps 1, 3 to 4"));
  EXPECT_THAT(to_json(outcome)["warnings"].dump(), HasSubstr("touches nothing"));
  EXPECT_THAT(answer_page(outcome, 0).html(), HasSubstr("touches nothing in load steps 1, 3 to 4"));
  // Two tips far apart, each smaller than a cell: they are touched, and no cell is.
  fem::HeightMap map{.pitch = 0.1, .heights = Eigen::MatrixXd::Constant(81, 81, 0.5)};
  map.heights(1, 1) = map.heights(79, 79) = 0;
  scene.indenter = {.shape = map};
  scene.load = {.indentation = {0.01}};
  EXPECT_THAT(warnings(solve(scene, {.rung = "pad-8", .precision = "fp32"})),
              Contains(AllOf(HasSubstr("touches nothing in load step 1"), HasSubstr("in all of them it should"))));
}

// Released to a fifth of its depth, the cone keeps the cells of the deepest step, for they hold its drag.
TEST(PadWarnings, StepsOnFewCells) {
  fem::PadScene scene = dragged();
  scene.indenter.shape = fem::Cone{80};
  scene.load = {.indentation = {0.02, 0.1}, .moves = {{0.1, 0.01, 0, 0}, {0.02, 0.01, 0, 0}}};
  const PadOutcome outcome = solve(scene, {.precision = "fp32"});
  EXPECT_THAT(warnings(outcome), Contains(AllOf(HasSubstr("in load step 4 the contact extends over "),
                                                HasSubstr(" of 12 cells"), HasSubstr("P there may be off by"))));
}

TEST(PadSolve, WithoutContactNothingIsToExpect) {
  fem::PadScene scene = dragged();
  scene.load.indentation = {0};
  const PadOutcome outcome = solve(scene, {.precision = "fp32"});
  EXPECT_FALSE(outcome.error);
  const auto json = to_json(outcome);
  EXPECT_TRUE(json["steps"][0]["slip_index"].is_null());
  EXPECT_TRUE(json["steps"][0]["force_ratio"].is_null());
  EXPECT_EQ(json["steps"][0]["P"], 0);
  EXPECT_THAT(answer_table(outcome), HasSubstr(" - "));
}

TEST(PadRungs, AreChosenByNameOrAccuracy) {
  const fem::PadScene scene = dragged();
  for (const auto& [rung, cells] : {std::pair{"pad-8", 8}, {"pad-12", 12}, {"pad-16", 16}, {"pad-24", 24}}) {
    const PadOutcome outcome = solve(scene, {.rung = rung, .precision = "fp32"});
    EXPECT_EQ(outcome.solution.cells.n, cells);
    EXPECT_EQ(outcome.rung.name, rung);
  }
  EXPECT_EQ(solve(scene, {.precision = "fp32"}).rung.name, "pad-12");
  // The cheapest whose error is small enough: that of pad-8 is what an accuracy tells of it.
  const double here = solve(scene, {.accuracy = 0.5}).error->expected.S;
  const PadOutcome enough = solve(scene, {.accuracy = here}), finer = solve(scene, {.accuracy = 0.99 * here});
  EXPECT_EQ(enough.rung.name, "pad-8");
  EXPECT_NE(finer.rung.name, "pad-8");
  EXPECT_LE(finer.error->expected.S, 0.99 * here);
  EXPECT_TRUE(enough.kept() && finer.kept());
}

TEST(PadRungs, ClassesAndErrors) {
  fem::PadScene scene = dragged();
  const auto class_of = [&](const fem::PadShape& shape, double tilt = 0) {
    scene.indenter.shape = shape, scene.indenter.tilt = tilt;
    return pad_class(scene);
  };
  EXPECT_EQ(class_of(fem::Sphere{}), PadClass::smooth);
  EXPECT_EQ(class_of(fem::Punch{2, 0}), PadClass::sharp_edge);
  EXPECT_EQ(class_of(fem::LyingCylinder{}), PadClass::sharp_edge);
  EXPECT_EQ(class_of(fem::Box{{2, 2}, 0.2}), PadClass::rounded_edge);
  EXPECT_EQ(class_of(fem::Box{{2, 2}, 0.2}, 1), PadClass::tilted);
  EXPECT_EQ(class_of(fem::HeightMap{}), PadClass::height_map);
  scene = dragged();
  const PadRung& rung = rung_named<PadRung>("pad-12");
  const ExpectedError inside = expected_pad_error(rung, scene, 0.2);
  EXPECT_EQ(inside.expected.S, measured_pads()[1].of[0].most95.S);
  EXPECT_THAT(inside.outside, IsEmpty());
  scene.friction = 2;
  const ExpectedError outside = expected_pad_error(rung, scene, 0.2);
  EXPECT_DOUBLE_EQ(outside.expected.S, 3 * inside.expected.S);
  EXPECT_DOUBLE_EQ(outside.expected.P, 3 * inside.expected.P);
  EXPECT_THAT(outside.outside, ElementsAre("friction 2 (measured 0.1 to 1.5)"));
}

// With three times as many cells; between neighbours a class of some scenes need not show it.
TEST(PadRungs, MeasuredErrorsFallWithTheCells) {
  ASSERT_EQ(measured_pads().size() + 1, all_rungs<PadRung>().size());
  for (std::size_t r = 0; r < measured_pads().size(); ++r)
    for (int c = 0; c < pad_classes; ++c) {
      const PadErrors& e = measured_pads()[r].of[c];
      EXPECT_EQ(measured_pads()[r].name, all_rungs<PadRung>()[r].name);
      EXPECT_TRUE(0 < e.most95.S && e.most95.S <= e.largest);
      for (const auto member : std::span(fem::pad_error_members).first<6>())
        EXPECT_LT(measured_pads().back().of[c].most95.*member, measured_pads().front().of[c].most95.*member) << c;
    }
}

TEST(PadSolve, OptionsThatContradict) {
  const auto message = [](const SolveOptions& options) {
    return thrown_message<ConfigError>([&] { solve(dragged(), options); });
  };
  EXPECT_THAT(message({.rung = "patch-12"}),
              HasSubstr("--rung = patch-12: must be a rung of pads, one of pad-8, pad-12, pad-16, pad-24, reference"));
  EXPECT_THAT(message({.solver = "full-mesh"}), HasSubstr("batched or twin for a pad"));
  EXPECT_THAT(message({.solver = "twin", .precision = "fp32"}), HasSubstr("fp64 with --solver twin"));
  EXPECT_THAT(message({.solver = "twin", .device = "0"}), HasSubstr("--device = 0: must be left out"));
  EXPECT_THAT(message({.rung = "reference", .solver = "twin"}), HasSubstr("left out with --rung reference"));
  EXPECT_THAT(message({.accuracy = 0.1, .rung = "pad-8"}), HasSubstr("given without --rung"));
  EXPECT_THAT(message({.accuracy = -1}), HasSubstr("a number above 0"));
  const auto of_line = [](const SolveOptions& options) {
    return thrown_message<ConfigError>([&] { solve(fem::Scene{.indenter = {.shape = fem::Parabola{10}}}, options); });
  };
  EXPECT_THAT(of_line({.rung = "pad-12"}), HasSubstr("--rung = pad-12: must be a rung of lines, one of patch-8"));
  EXPECT_THAT(of_line({.solver = "twin"}), HasSubstr("batched or full-mesh for a line"));
}

}  // namespace tactel::host::pad_solve_test
