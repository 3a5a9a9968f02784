// SPDX-License-Identifier: Apache-2.0

// The stream on a model made up here, whose answers are known, and on contacts of the line.
#include "host/contact/lines/contact_stream.h"

#include <gtest/gtest.h>

#include <atomic>
#include <map>

#include "host/contact/lines/contact_fallback.h"
#include "kernels/shared/contact_layout.h"
#include "tests/host/contact/contact_cases.h"
#include "tests/host/device/test_device.h"

namespace tactel::host::contact_stream_test {

/// A model without a kernel: a lane "answers" with as many steps as its scene's value. Multiples of three do not hold,
/// and are solved again: to ten times the value, which `finish` makes one more for values above a hundred. Steps 0 and
/// 2 of the values 5, 65, 125, ... are solved alone.
struct Counting {
  struct Scene {
    int sensor = 0, value = 0;
    void validate() const {
      if (value < 0) throw std::invalid_argument("value");
    }
  };
  struct Path {
    std::vector<int> steps;
  };
  struct Key {
    int sensor = 0;
    auto operator<=>(const Key&) const = default;
  };
  using Sensor = int;
  using Solution = int;
  using Model = std::map<int, int>*;  ///< launches of each sensor

  class Launch final : public ContactLaunch<Counting> {
   public:
    void add(const Scene& scene, const Path&) override { values_.push_back(scene.value); }
    void lay_out() override {}
    void run(const RunOptions&) override { ran_ = true; }
    void open() override { EXPECT_TRUE(ran_); }
    LaneAnswer answer(std::size_t i) const override {
      LaneAnswer answer;
      answer.steps = values_[i];
      return answer;
    }
    std::span<const std::size_t> by_lane() const override { return {}; }
    std::size_t steps() const override { return values_.size(); }
    double seconds() const override { return 0.5; }

   private:
    std::vector<int> values_;
    bool ran_ = false;
  };
  class Solver final : public SensorSolver<Counting> {
   public:
    Solver(int sensor, Model launches) : sensor_(sensor), launches_(launches) {}
    std::unique_ptr<ContactLaunch<Counting>> launch() const override {
      ++(*launches_)[sensor_];
      return std::make_unique<Launch>();
    }
    bool holds(const LaneAnswer& answer) const override { return answer.steps % 3 != 0; }
    std::vector<int> solve(std::span<const Scene> scenes, std::span<const LaneAnswer> known) const override {
      std::vector<int> solutions;
      for (std::size_t k = 0; k < scenes.size(); ++k) {
        EXPECT_EQ(scenes[k].sensor, sensor_);
        if (!known.empty()) {
          EXPECT_EQ(known[k].steps, scenes[k].value);
        }
        solutions.push_back(10 * scenes[k].value);
      }
      return solutions;
    }

   private:
    int sensor_;
    Model launches_;
  };

  Counting(Executor&, Model launches) : launches(launches) {}
  static Key key(Sensor sensor, ContactKind) { return {sensor}; }
  static Key key(const Scene& scene) { return {scene.sensor}; }
  static Path path(const Scene&) { return {{1}}; }
  std::shared_ptr<const SensorSolver<Counting>> solver(Sensor sensor) const {
    return std::make_shared<Solver>(sensor, launches);
  }
  static void finish(std::span<const Scene> scenes, std::vector<int>& solutions) {
    for (std::size_t k = 0; k < scenes.size(); ++k) solutions[k] += scenes[k].value > 100;
  }
  static std::vector<std::size_t> coarse(const Scene& scene, const LaneAnswer& answer) {
    EXPECT_EQ(answer.steps, scene.value);
    if (scene.value % 60 == 5) return {0, 2};
    return {};
  }
  static Scene alone(const Scene& scene, std::size_t step) {
    return {scene.sensor, 3 * scene.value + static_cast<int>(step)};
  }
  Model launches;
};

std::vector<Counting::Scene> counting_scenes(int count) {
  std::vector<Counting::Scene> scenes;
  for (int k = 0; k < count; ++k) scenes.push_back({k % 2, k});
  return scenes;
}

int solution_of(int value) { return 10 * value + (value > 100); }

TEST(ContactStream, GivesEachSceneOnceInPlaceOrSolvedAgain) {
  std::map<int, int> launches;
  const StreamOf<Counting> stream(executor(), &launches);
  const auto scenes = counting_scenes(10000);
  std::vector<int> lane(scenes.size(), -1), solved(scenes.size(), -1);
  std::vector<std::size_t> progress;
  const bool all = stream.solve(
      scenes,
      [&](std::size_t i, const LaneAnswer& answer, StreamOf<Counting>::Alone&& alone) {
        EXPECT_EQ(lane[i], -1);
        lane[i] = answer.steps;
        StreamOf<Counting>::Alone expected;
        if (i % 60 == 5)
          for (const int step : {0, 2}) expected[step] = solution_of(3 * static_cast<int>(i) + step);
        EXPECT_EQ(alone, expected);
      },
      [&](std::size_t i, int&& solution) {
        EXPECT_EQ(solved[i], -1);
        solved[i] = solution;
      },
      [&](std::size_t done) { return progress.push_back(done), true; });
  EXPECT_TRUE(all);
  EXPECT_EQ(progress, (std::vector<std::size_t>{0, 8192}));
  for (int k = 0; k < 10000; ++k) {
    EXPECT_EQ(lane[k], k % 3 ? k : -1);
    EXPECT_EQ(solved[k], k % 3 ? -1 : solution_of(k));
  }
  // 5000 scenes of sensor 0, then those of sensor 1: the first part has 3192 of these
  EXPECT_EQ(launches, (std::map<int, int>{{0, 1}, {1, 2}}));
}

TEST(ContactStream, SolvesAllInTheirOrder) {
  std::map<int, int> launches;
  const StreamOf<Counting> stream(executor(), &launches);
  const auto scenes = counting_scenes(205);
  const std::vector<int> solutions = stream.solve(scenes);
  for (int k = 0; k < 205; ++k) EXPECT_EQ(solutions[k], solution_of(k));
  EXPECT_TRUE(launches.empty());
  EXPECT_THROW(stream.solve(std::vector<Counting::Scene>{{0, -1}}), std::invalid_argument);
}

TEST(ContactStream, EndsWhereProgressSaysSo) {
  std::map<int, int> launches;
  const StreamOf<Counting> stream(executor(), &launches);
  std::atomic<int> answers = 0;
  const auto scenes = counting_scenes(20000);
  EXPECT_FALSE(stream.solve(
      scenes, [&](std::size_t, const LaneAnswer&, auto&&) { ++answers; }, [&](std::size_t, int&&) { ++answers; },
      [](std::size_t done) { return done < 8192; }));
  EXPECT_EQ(answers, 8192);
}

// 132 compute units, which a launch of 8192 scenes would leave idle for the most part.
TEST(ContactStream, AGpuHasLongerLaunches) {
  std::map<int, int> launches;
  Executor posed(device("basic").as_gpu());
  const StreamOf<Counting> stream(posed, &launches);
  const auto scenes = counting_scenes(20000);
  std::vector<std::size_t> progress;
  EXPECT_TRUE(stream.solve(
      scenes, [](std::size_t, const LaneAnswer&, auto&&) {}, [](std::size_t, int&&) {},
      [&](std::size_t done) { return progress.push_back(done), true; }));
  EXPECT_EQ(progress, (std::vector<std::size_t>{0, 128 * 132}));
}

TEST(ContactStream, ALaunchIsNotLongerThanItsMemory) {
  std::map<int, int> launches;
  const StreamOf<Counting> stream(executor(), &launches);
  StreamOf<Counting>::Part part;
  const Counting::Path path{std::vector<int>(1 << 16, 1)};  // four of them fill a launch
  for (int k = 0; k < 9; ++k) stream.add(part, {k % 2, k}, path);
  EXPECT_EQ(launches, (std::map<int, int>{{0, 2}, {1, 1}}));
  EXPECT_EQ(part.size(), 9u);
}

/// Scenes of several sensors, by depth and force; flats on thin rubber need linear elements.
std::vector<fem::Scene> line_scenes() {
  auto scenes = tactel::tests::random_scenes(fem::Sensor(), 30, 8);
  for (const fem::Scene& scene : tactel::tests::random_force_scenes(fem::Sensor(), 10, 8)) scenes.push_back(scene);
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    scenes[i].sensor.young = 1 + 0.1 * static_cast<double>(i);
    if (i % 3 == 1) scenes[i].sensor.poisson = 0.3;
  }
  for (int k = 0; k < 3; ++k) {
    scenes.push_back(scenes[0]);
    scenes.back().indenter = {fem::Flat{6}, 0};
    scenes.back().sensor.thickness = 0.5, scenes.back().sensor.poisson = 0.499;
  }
  return scenes;
}

/// The answers of launches without forces are those of solutions, bit for bit, on patches and meshes; what does not
/// hold is solved to the same answer.
TEST(ContactStream, LanesAndSolutionsHaveTheSameNumbers) {
  const auto scenes = line_scenes();
  for (const ContactModel& model : {model_of(usual_patch()), ContactModel{MeshModel{}, Precision::fp64}}) {
    const ContactStream stream(executor(), model);
    const auto expected = stream.solve(scenes);
    std::size_t in_place = 0, again = 0;
    stream.solve(
        scenes,
        [&](std::size_t i, const LaneAnswer& answer, auto&&) {
          ++in_place;
          ASSERT_FALSE(expected[i].fell_back) << i;
          for (std::size_t k = 0; k < expected[i].steps.size(); ++k) {
            const fem::ContactStep& step = expected[i].steps[k];
            std::vector<double> stress(2 * static_cast<std::size_t>(step.sigma_y.size()));
            answer.tactels(static_cast<int>(k), std::span(stress));
            ASSERT_EQ(answer.result(static_cast<int>(k), RESULT_P), step.P) << i;
            ASSERT_EQ(stress.front(), step.sigma_y[0]) << i;
            ASSERT_EQ(stress.back(), step.tau_xy[step.tau_xy.size() - 1]) << i;
          }
        },
        [&](std::size_t i, fem::ContactSolution&& solution) {
          ++again;
          ASSERT_TRUE(every_step_converged(solution)) << i;
          for (std::size_t k = 0; k < expected[i].steps.size(); ++k)
            ASSERT_EQ(solution.steps[k].P, expected[i].steps[k].P) << i;
        },
        [](std::size_t) { return true; });
    EXPECT_EQ(in_place + again, scenes.size());
    EXPECT_GT(in_place, 20u);
    if (std::holds_alternative<PatchModel>(model.surface)) {
      EXPECT_GE(again, 3u);  // the flats
    }
  }
}

}  // namespace tactel::host::contact_stream_test
