// SPDX-License-Identifier: Apache-2.0

// The first call of a process that takes a device, by eight threads at once: each has the answer of a later call.
#include <gtest/gtest.h>
#include <tactel/live.h>
#include <tactel/pad_step.h>
#include <tactel/simulate.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <latch>
#include <string>
#include <thread>
#include <vector>

#include "test_paths.h"

namespace first_use_test {

using namespace tactel;
using Numbers = std::vector<float>;

Numbers numbers(const auto& from) { return {from.begin(), from.end()}; }
std::string example(const std::string& name) { return TACTEL_SOURCE_DIR "/examples/" + name; }
PadScene pad() { return read_pad_scene(example("pad.toml")); }

struct FirstCall {
  const char* name;
  Numbers (*call)();
};
class FirstUse : public testing::TestWithParam<FirstCall> {};

/// Ends the process with 0 where eight threads and a later call have one answer.
[[noreturn]] void by_eight_threads(Numbers (*call)()) {
  std::vector<Numbers> answers(8);
  {
    std::latch together(8);
    std::vector<std::jthread> threads;
    for (Numbers& answer : answers)
      threads.emplace_back([&] {
        together.arrive_and_wait();
        answer = call();
      });
  }
  const Numbers later = call();
  const auto same = std::ranges::count(answers, later);
  std::fprintf(stderr, "%d of 8 threads have the answer of a later call\n", static_cast<int>(same));
  std::exit(same == 8 && !later.empty() ? 0 : 1);
}

TEST_P(FirstUse, ByEightThreads) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");  // a new process: the device is not known there
  EXPECT_EXIT(by_eight_threads(GetParam().call), testing::ExitedWithCode(0), "8 of 8");
}

INSTANTIATE_TEST_SUITE_P(
    Of, FirstUse,
    testing::Values(FirstCall{"devices", [] { return Numbers{static_cast<float>(devices().size())}; }},
                    FirstCall{"solve",
                              [] {
                                Numbers all;
                                for (const Step& step : solve(read_scene(example("parabola.toml"))).steps)
                                  all.push_back(static_cast<float>(step.slip_index));
                                return all;
                              }},
                    FirstCall{"solve_pad",
                              [] {
                                Numbers all;
                                for (const PadStep& step : solve(pad()).steps)
                                  all.push_back(static_cast<float>(step.P));
                                return all;
                              }},
                    FirstCall{
                        "solve_many",
                        [] { return numbers(solve_many(std::vector(20, read_scene(example("parabola.toml")))).P); }},
                    FirstCall{"solve_many_pads", [] { return numbers(solve_many(std::vector(20, pad())).P); }},
                    FirstCall{"generate", [] { return Sweep(example("learning_mix.toml")).generate(20).frames; }},
                    FirstCall{"generate_pads",
                              [] { return Sweep(example("pad_sweep.toml")).generate(20, {.rung = "pad-8"}).frames; }},
                    FirstCall{"generate_grips",
                              [] { return Sweep(example("uskin_grips.toml")).generate(2, {.rung = "pad-8"}).frames; }},
                    FirstCall{"steps",
                              [] {
                                PadStepper steps(pad().sensor, 1, std::array{0.5}, {.cells = 8});
                                steps.set_shapes(std::array{PadIndenter{.shape = Sphere{.radius = 8}}});
                                return steps.press(std::array{0.5, 0.1, 0.0, 0.0}).force;
                              }},
                    FirstCall{"live",
                              [] {
                                LiveEstimator live({Network::load("uskin-4x4")}, "cpu");
                                std::vector<Answer> answers(1);
                                live.estimate(Numbers(48, -0.1f), answers);
                                return Numbers{answers[0].slip_index};
                              }}),
    [](const auto& info) { return std::string(info.param.name); });

}  // namespace first_use_test
