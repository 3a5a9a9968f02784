// SPDX-License-Identifier: Apache-2.0

// The stream of contacts on pads: every scene once, in place or solved again, with the numbers of its solution.
#include "host/contact/pads/pad_stream.h"

#include <gtest/gtest.h>

#include <cmath>

#include "fem/pad/pad_mix.h"
#include "kernels/shared/pad_layout.h"
#include "tests/host/device/test_device.h"

namespace tactel::host::pad_stream_test {

/// Scenes of two Poisson's ratios, some with their own, two arrays of tactels and any thickness and E; some by force.
std::vector<fem::PadScene> pad_scenes(std::size_t count) {
  fem::PadMix draw(11);
  std::vector<fem::PadScene> scenes(count);
  for (std::size_t i = 0; i < count; ++i) {
    fem::PadScene& scene = scenes[i] = draw();
    scene.sensor.young = 1 + 0.1 * static_cast<double>(i % 7);
    scene.sensor.poisson = i % 7 == 6 ? 0.25 + 0.001 * static_cast<double>(i) : i % 2 ? 0.3 : 0.48;
    scene.sensor.pitch = {2, 2};
    if (i % 3 == 0) scene.sensor.tactels = {3, 6};
    if (i % 3 == 1) scene.sensor.tactel_size = 1.5;  // more points where H is small
    scene.load.drags.resize(i % 4);
    if (i % 5 == 4) {
      scene.load.indentation.clear();
      scene.load.normal_force = {0.05 * scene.sensor.young * std::pow(scene.sensor.thickness, 2)};
    }
  }
  return scenes;
}

/// What the sinks took.
struct Taken {
  std::vector<int> in_place, again;  ///< [scenes] times
  std::vector<std::vector<double>> numbers;

  explicit Taken(std::size_t count) : in_place(count), again(count), numbers(count) {}
  bool solve(
      const PadStream& stream, std::span<const fem::PadScene> scenes,
      const std::function<bool(std::size_t)>& progress = [](std::size_t) { return true; }) {
    return stream.solve(
        scenes,
        [&](std::size_t i, const LaneAnswer& answer, auto&&) {
          ++in_place[i];
          const std::array<int, 2> tactels = scenes[i].sensor.tactels;
          std::vector<double> stress(static_cast<std::size_t>(3 * tactels[0] * tactels[1]));
          for (int k = 0; k < answer.steps; ++k) {
            for (const int row :
                 {int{RESULT_P}, int{PAD_RESULT_QX}, int{PAD_RESULT_QY}, int{PAD_RESULT_M}, int{RESULT_DEPTH}})
              numbers[i].push_back(answer.result(k, row));
            answer.tactels(k, std::span(stress));
            numbers[i].insert(numbers[i].end(), stress.begin(), stress.end());
          }
        },
        [&](std::size_t i, fem::PadSolution&& solution) {
          ++again[i];
          numbers[i] = numbers_of(solution);
        },
        progress);
  }
  static std::vector<double> numbers_of(const fem::PadSolution& solution) {
    std::vector<double> all;
    for (const fem::PadStep& step : solution.steps) {
      for (const double number : {step.P, step.Q[0], step.Q[1], step.M, step.indentation}) all.push_back(number);
      all.insert(all.end(), step.stress.data(), step.stress.data() + step.stress.size());
    }
    return all;
  }
};

TEST(PadStream, LanesAndSolutionsHaveTheSameNumbers) {
  const auto scenes = pad_scenes(180);
  for (const Precision precision : {Precision::fp32, Precision::fp64}) {
    const PadStream stream(executor(), {.options = {.cells = 8}, .precision = precision});
    const auto solutions = stream.solve(scenes);
    Taken taken(scenes.size());
    EXPECT_TRUE(taken.solve(stream, scenes));
    for (std::size_t i = 0; i < scenes.size(); ++i) {
      EXPECT_TRUE(every_step_converged(solutions[i])) << i;
      EXPECT_EQ(solutions[i].steps.size(), fem::pad_targets(scenes[i].load).size()) << i;
      EXPECT_EQ(taken.in_place[i] + taken.again[i], 1) << i;
      if (taken.in_place[i]) {
        EXPECT_FALSE(solutions[i].fell_back) << i;
      }
      ASSERT_EQ(taken.numbers[i], Taken::numbers_of(solutions[i])) << i;
    }
    // Alone a scene has the same numbers.
    for (const std::size_t i : {0u, 44u, 101u})
      EXPECT_EQ(Taken::numbers_of(stream.solve(std::span(&scenes[i], 1))[0]), taken.numbers[i]) << i;
  }
}

fem::HeightMap measured_bowl() {
  fem::HeightMap map{.pitch = 0.05, .heights = Eigen::MatrixXd(9, 9)};
  for (Eigen::Index i = 0; i < 9; ++i)
    for (Eigen::Index j = 0; j < 9; ++j)
      map.heights(i, j) = 1e-4 * static_cast<double>((i - 4) * (i - 4) + (j - 4) * (j - 4));
  return map;
}

/// Cells from a millionth of the thickness to tens of it: sizes on the ladder, between its rungs, and of needles and
/// blades. Tables between rungs are right to 4e-3 for the widest cells. From 1e-5 H on more depth means more force.
TEST(PadStreamSlow, EveryShapeAtEveryDepth) {
  constexpr double depths[] = {0, 1e-5, 1e-3, 0.1, 1, 10};
  std::vector<fem::PadScene> scenes;
  for (const fem::PadShape& shape :
       {fem::PadShape(fem::Sphere{8}), fem::PadShape(fem::Sphere{0.05}), fem::PadShape(fem::Paraboloid{{3, 8}}),
        fem::PadShape(fem::LyingCylinder{5, 4}), fem::PadShape(fem::LyingCylinder{0.01, 4}),
        fem::PadShape(fem::Punch{2, 0}), fem::PadShape(fem::Punch{2, 0.3}), fem::PadShape(fem::Box{{1, 2}, 0}),
        fem::PadShape(fem::Box{{10, 0.01}, 0}), fem::PadShape(fem::Box{{1, 2}, 0.3}), fem::PadShape(fem::Cone{45}),
        fem::PadShape(fem::Cone{80}), fem::PadShape(measured_bowl())})
    for (const double depth : depths) {
      fem::PadScene& scene = scenes.emplace_back();
      scene.indenter.shape = shape;
      scene.load = {.indentation = {depth * scene.sensor.thickness}, .drags = {{0.05, 0, 0}}};
    }
  const auto stream = [](Precision precision) {
    return PadStream(executor(), {.options = {.cells = 8}, .precision = precision});
  };
  const auto exact = stream(Precision::fp64).solve(scenes), single = stream(Precision::fp32).solve(scenes);
  Taken taken(scenes.size());
  taken.solve(stream(Precision::fp32), scenes);
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    SCOPED_TRACE(testing::Message() << fem::shape_name(scenes[i].indenter.shape) << " "
                                    << scenes[i].load.indentation[0]);
    const fem::PadStep &a = single[i].steps.back(), &b = exact[i].steps.back();
    EXPECT_EQ(taken.numbers[i], Taken::numbers_of(single[i]));
    if (i % std::size(depths) == 0) {
      EXPECT_EQ(a.P, 0);
      EXPECT_FALSE(a.slip_index);
      EXPECT_EQ(b.P, 0);
      EXPECT_FALSE(b.slip_index);
    } else {
      EXPECT_TRUE(every_step_converged(single[i]) && every_step_converged(exact[i]))
          << a.residual.largest() << " " << b.residual.largest();
      EXPECT_NEAR(a.P / b.P, 1, 4e-3);
      EXPECT_GT(a.P, single[i - 1].steps.back().P);
    }
  }
}

/// Contacts some thicknesses wide on nearly incompressible rubber, by depth and by force.
TEST(PadStream, WideContactsAreSolvedInLanes) {
  std::vector<fem::PadScene> scenes;
  for (const double nu : {0.48, 0.49, 0.5})
    for (const fem::PadShape& shape :
         {fem::PadShape(fem::Sphere{100}), fem::PadShape(fem::Paraboloid{{200, 200}}),
          fem::PadShape(fem::LyingCylinder{100, 8}), fem::PadShape(fem::Punch{8, 0}), fem::PadShape(fem::Punch{8, 0.5}),
          fem::PadShape(fem::Box{{8, 6}, 0}), fem::PadShape(fem::Box{{8, 8}, 0.5})})
      for (const bool force : {false, true}) {
        fem::PadScene& scene = scenes.emplace_back();
        scene.sensor.thickness = 2, scene.sensor.poisson = nu;
        scene.indenter.shape = shape, scene.friction = 0.5;
        scene.load.drags = {{0.02, 0, 0}, {0.2, 0, 0}, {0.6, 0, 0.02}};
        (force ? scene.load.normal_force : scene.load.indentation) = {force ? 20 : 0.16};
      }
  for (const Precision precision : {Precision::fp32, Precision::fp64}) {
    const auto solutions = PadStream(executor(), {.options = {.cells = 8}, .precision = precision}).solve(scenes);
    for (std::size_t i = 0; i < scenes.size(); ++i) {
      SCOPED_TRACE(testing::Message() << fem::shape_name(scenes[i].indenter.shape) << " " << i << " "
                                      << scenes[i].sensor.poisson << (precision == Precision::fp32 ? " fp32" : ""));
      EXPECT_FALSE(solutions[i].fell_back);
      for (const fem::PadStep& step : solutions[i].steps)
        EXPECT_TRUE(step.converged) << step.residual.largest() << " after " << step.iterations << " sweeps";
    }
  }
}

/// Such answers are rare: the search is generous. What becomes of them is a test of solve_pad_contact.
TEST(PadStream, AnswersOnCellsThatAreTooSmallDoNotHold) {
  std::vector<fem::PadScene> scenes(2);
  for (fem::PadScene& scene : scenes) scene.load.indentation = {0.25};
  const std::vector<fem::PadCells> cells{{.n = 8, .hx = 0.2, .hy = 0.25}, {.n = 8, .hx = 0.5, .hy = 0.5}};
  const fem::PadOptions options{.cells = 8};
  auto batch = PadContact<float>(executor(), options).prepare(scenes, cells);
  batch.run();
  const auto solver = PadContacts(executor(), {.options = options}).solver(scenes[0].sensor);
  const LaneView<float> view(batch);
  EXPECT_FALSE(solver->holds(view.answer(0)));
  EXPECT_TRUE(solver->holds(view.answer(1)));
}

TEST(PadStream, TheTwinSolvesWhatTheKernelDoesNot) {
  const auto scenes = pad_scenes(9);
  const PadStream stream(executor(), {.options = {.cells = 8, .most_sweeps = 1}});
  Taken taken(scenes.size());
  taken.solve(stream, scenes);
  EXPECT_EQ(taken.again, std::vector<int>(9, 1));
  const PadStream usual(executor(), {.options = {.cells = 8}});
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const fem::PadSolution twin = stream.solve(std::span(&scenes[i], 1))[0],
                           kernel = usual.solve(std::span(&scenes[i], 1))[0];
    EXPECT_TRUE(twin.fell_back && every_step_converged(twin)) << i;
    EXPECT_FALSE(kernel.fell_back) << i;
    EXPECT_NEAR(twin.steps.back().P / kernel.steps.back().P, 1, 2e-3) << i;  // the kernel's tolerance
  }
}

TEST(PadStream, PartsFollowEachOtherUntilProgressEndsThem) {
  auto few = pad_scenes(60);
  for (fem::PadScene& scene : few) scene.load.drags.clear();
  std::vector<fem::PadScene> scenes;
  while (scenes.size() < 8400) scenes.push_back(few[scenes.size() % few.size()]);
  const PadStream stream(executor(), {.options = {.cells = 8}});
  Taken all(scenes.size()), some(scenes.size());
  std::vector<std::size_t> progress;
  EXPECT_TRUE(all.solve(stream, scenes, [&](std::size_t done) { return progress.push_back(done), true; }));
  EXPECT_EQ(progress, (std::vector<std::size_t>{0, 8192}));
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    ASSERT_EQ(all.in_place[i] + all.again[i], 1) << i;
    ASSERT_EQ(all.numbers[i], all.numbers[i % few.size()]) << i;
  }
  EXPECT_FALSE(some.solve(stream, scenes, [](std::size_t done) { return done < 8192; }));
  std::size_t answers = 0;
  for (std::size_t i = 0; i < scenes.size(); ++i) answers += static_cast<std::size_t>(some.in_place[i] + some.again[i]);
  EXPECT_EQ(answers, 8192u);
}

}  // namespace tactel::host::pad_stream_test
