// SPDX-License-Identifier: Apache-2.0

// Floors of problems whose Bayes risk is known.
#include "host/studies/floor/floor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>
#include <regex>

#include "tests/host/networks/network_cases.h"
#include "tests/host/support/run_tactel.h"

namespace tactel::host {
namespace {

using tactel::testing::executor;

const std::vector<ClassFamily> one_family = {{"all", {"one"}}};

/// Rows drawn by draw(random, frame) -> S.
FrameBank bank_of(std::size_t rows, int inputs, unsigned seed, const auto& draw) {
  std::mt19937 random(seed);
  FrameBank bank{.frames = nn::RowMatrix<float>(rows, inputs), .slip_index = {}, .class_of = {{}}};
  for (std::size_t row = 0; row < rows; ++row) {
    bank.slip_index.push_back(static_cast<float>(draw(random, bank.frames.row(static_cast<Eigen::Index>(row)))));
    bank.class_of[0].push_back(0);
  }
  return bank;
}

TEST(WeightedMedian, IsWhereHalfOfTheWeightLies) {
  const std::vector<float> values = {1, 2, 3, 4};
  EXPECT_EQ(weighted_median(values, std::vector<float>{1, 1, 1, 1}), 2);
  EXPECT_EQ(weighted_median(values, std::vector<float>{1, 1, 1, 4}), 4);
  EXPECT_EQ(weighted_median(values, std::vector<float>{0, 0, 1, 0}), 3);
}

// S is a normal number of deviation 0.2, and the frame is (1, S) read with noise 0.1: the posterior of S is Gaussian
// with the variance 1 / (1 / 0.2^2 + 1 / 0.1^2) = 0.008, and the mean of |error| is sqrt(2 / pi) sqrt(0.008) = 0.07136.
TEST(Floor, OfALinearGaussianProblemIsItsPosterior) {
  const auto draw = [](std::mt19937& random, auto frame) {
    const double s = std::normal_distribution<double>(0, 0.2)(random);
    frame << 1, static_cast<float>(s);
    return s;
  };
  const nn::ReadingModel model{.inputs = 2, .history = 1, .noise = 0.1, .gain = 0};
  FloorOptions options{.noise = 0.1, .readings = 3000};
  const auto floor =
      floor_of(executor(), bank_of(5000, 2, 1, draw), bank_of(6000, 2, 2, draw), model, one_family, {}, options);
  ASSERT_TRUE(floor);
  const double exact = std::sqrt(2 / std::numbers::pi) * std::sqrt(0.008);
  // Of 5000 rows in one dimension some 2000 lie within the noise: the numbers differ by the readings' scatter alone.
  EXPECT_NEAR(floor->all.lower.mean, exact, 4 * floor->all.lower.standard_error);
  EXPECT_NEAR(floor->all.upper.mean, exact, 4 * floor->all.upper.standard_error);
  EXPECT_LT(floor->all.lower.standard_error, 0.02 * exact);
  EXPECT_EQ(floor->spread, 1);
  ASSERT_EQ(floor->convergence.size(), 3u);
  EXPECT_EQ(floor->convergence[0].bank, 312u);
}

// The same S, read in two more frames of which it is twice and half: 1 / (1 / 0.2^2 + (1 + 4 + 1 / 4) / 0.1^2). The
// noise is over a stress of 2 MPa, that of the contact. The rows of a contact before its first frame have zeros there.
TEST(Floor, OfALinearGaussianHistoryIsItsPosterior) {
  for (const bool begun : {false, true}) {
    const auto draw = [&](std::mt19937& random, auto frame) {
      const double s = std::normal_distribution<double>(0, 0.2)(random);
      const auto f = static_cast<float>(s);
      frame << 1, f, begun ? 1 : 0, begun ? 2 * f : 0, 1, f / 2;
      return s;
    };
    const nn::ReadingModel model{.inputs = 2, .history = 3, .noise = 0.05, .gain = 0};
    FloorOptions options{.noise = 0.05, .noise_of_contact = true, .history = {.frames = 3}, .readings = 1000};
    FrameBank bank = bank_of(3000, 6, 1, draw), outside = bank_of(2000, 6, 2, draw);
    bank.largest.assign(3000, 2), outside.largest.assign(2000, 2);
    const auto floor = floor_of(executor(), bank, outside, model, one_family, {}, options);
    ASSERT_TRUE(floor);
    const double told = begun ? 5.25 : 1.25;
    const double exact = std::sqrt(2 / std::numbers::pi / (25 + told * 100));
    // Of 3000 rows in one dimension some 500 lie within the noise: the numbers differ by the readings' scatter alone.
    EXPECT_NEAR(floor->all.lower.mean, exact, 4 * floor->all.lower.standard_error) << begun;
    EXPECT_NEAR(floor->all.upper.mean, exact, 4 * floor->all.upper.standard_error) << begun;
  }
}

// One element touches: r = Q / P is read without error, S = r / mu, and mu is uniform in 0.1 ... 1, S in 0 ... 1. Given
// r, mu has the density 1 / mu (dS = dr / mu) from max(r, 0.1) to 1, and S = r / mu is log-uniform from r to min(1, 10
// r): its median is the geometric mean of the ends a, b, and its mean absolute deviation (sqrt b - sqrt a)^2 / ln(b /
// a). Over r, whose density is ln(b / a) / 0.9, the floor is the integral of (sqrt b - sqrt a)^2 / 0.9: with (sqrt 10 -
// 1)^2 r up to 0.1, then (1 - sqrt r)^2 = 1 - 2 sqrt r + r.
TEST(Floor, OfOneElementHasAClosedForm) {
  const double k = std::sqrt(10.0) - 1;
  const auto tail = [](double r) { return r - 4.0 / 3 * std::pow(r, 1.5) + r * r / 2; };
  const double exact = (k * k * 0.005 + tail(1) - tail(0.1)) / 0.9;
  EXPECT_NEAR(exact, 0.135, 0.01);
  const auto draw = [](std::mt19937& random, auto frame) {
    const double mu = std::uniform_real_distribution<double>(0.1, 1)(random);
    const double s = std::uniform_real_distribution<double>(0, 1)(random);
    frame << -1, static_cast<float>(mu * s);
    return s;
  };
  const nn::ReadingModel model{.inputs = 2, .history = 1, .noise = 0.001, .gain = 0};
  FloorOptions options{.noise = 0.001, .readings = 3000};
  const auto floor =
      floor_of(executor(), bank_of(30000, 2, 1, draw), bank_of(6000, 2, 2, draw), model, one_family, {}, options);
  ASSERT_TRUE(floor);
  // Some 60 rows lie within the noise of a reading: the posterior's median is off by 1 / (4 60) of its spread squared,
  // some 2 % of the error, and the readings scatter.
  EXPECT_NEAR(floor->all.lower.mean, exact, 4 * floor->all.lower.standard_error + 0.02 * exact);
  EXPECT_NEAR(floor->all.upper.mean, exact, 4 * floor->all.upper.standard_error + 0.02 * exact);
}

// In 20 dimensions a bank of 16 000 rows is thin: the numbers stand apart, and more rows bring them together.
TEST(Floor, ABiggerBankNarrowsTheGap) {
  const auto draw = [](std::mt19937& random, auto frame) {
    std::normal_distribution<float> normal;
    for (Eigen::Index k = 0; k < frame.size(); ++k) frame(k) = 1 + 0.3f * normal(random);
    return 0.5 + 0.1 * (frame(1) - 1) / 0.3;
  };
  const nn::ReadingModel model{.inputs = 20, .history = 1, .noise = 0.05, .gain = 0};
  const FloorOptions options{.noise = 0.05, .readings = 500};
  const auto floor =
      floor_of(executor(), bank_of(16000, 20, 1, draw), bank_of(1000, 20, 2, draw), model, one_family, {}, options);
  ASSERT_TRUE(floor);
  const auto& steps = floor->convergence;
  for (std::size_t i = 0; i < steps.size(); ++i) EXPECT_LT(steps[i].lower, steps[i].upper) << i;
  for (std::size_t i = 1; i < steps.size(); ++i) {
    EXPECT_GE(steps[i].lower, 0.9 * steps[i - 1].lower) << i;
    EXPECT_LT(steps[i].upper, steps[i - 1].upper) << i;
  }
}

TEST(FloorCommand, GivesNumbersBelowAndAbove) {
  const ScratchFolder folder;
  const std::string json = folder / "floor.json";
  const ChildResult result = run_tactel({"floor", source_file("examples/random_sweep.toml"), "--noise", "0.02",
                                         "--bank", "4000", "--readings", "200", "--quiet", "--json", json});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out.find("rows of the bank"), std::string::npos);
  const auto floor = nlohmann::json::parse(text_of(json));
  EXPECT_LT(floor["all"]["lower"]["mean"], floor["all"]["upper"]["mean"]);
  EXPECT_GT(floor["all"]["estimate"]["mean"], 0);
  EXPECT_GE(floor["bank_rows"], 4000);
  EXPECT_EQ(floor["convergence"].size(), 3u);
  const ChildResult listed = run_tactel({"floor", source_file("examples/paper_learning.toml")});
  EXPECT_EQ(listed.exit_code, 2);
  EXPECT_NE(listed.err.find("sweep.set"), std::string::npos) << listed.err;
}

// Where no load changes by more than the largest stress, no second frame is kept: four frames are one and zeros, with
// the estimate of one frame. Where every frame is kept they tell more.
TEST(FloorCommand, TakesTheFramesOfANetworksInput) {
  const ScratchFolder folder;
  const std::string sweep = folder / "short.toml", json = folder / "floor.json";
  // Presses of 0.1 mm in one to three steps, then one stroke of four steps.
  std::ofstream(sweep) << "[sweep]\ncontacts = 100\nseed = 3\npress_rows = true\n"
                          "[contact]\nfriction = { uniform = [0.1, 1.0] }\n"
                          "[indenter]\nshape = \"parabola\"\nradius = { log_uniform = [5, 50] }\n"
                          "[load]\nindentation = 0.1\n[load.irregular]\npress_steps = { uniform = [1, 3] }\n"
                          "stroke = { uniform = [0.05, 0.2] }\nstroke_steps = 4\n";
  const auto estimate = [&](std::vector<std::string> history) {
    std::vector<std::string> words = {"floor", sweep, "--bank", "500", "--readings", "10", "--quiet", "--json", json};
    words.insert(words.end(), history.begin(), history.end());
    const ChildResult result = run_tactel(words);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return nlohmann::json::parse(text_of(json))["all"]["estimate"]["mean"].get<double>();
  };
  const double one = estimate({});
  EXPECT_NEAR(estimate({"--history", "4", "--history-change", "1"}), one, 1e-9 * one);
  EXPECT_LT(estimate({"--history", "4", "--history-change", "0"}), 0.9 * one);
  EXPECT_NE(estimate({"--noise-of", "contact"}), one);  // the first steps of a press are below the contact's largest
  const ChildResult wrong = run_tactel({"floor", sweep, "--history", "0"});
  EXPECT_EQ(wrong.exit_code, 2);
  EXPECT_NE(wrong.err.find("--history"), std::string::npos) << wrong.err;
  EXPECT_EQ(run_tactel({"floor", sweep, "--history-change", "0.2"}).exit_code, 2);  // one frame has no change
}

// A line of the table is the floor of a file with that sensor.
TEST(FloorCommand, ComparesSkins) {
  const ScratchFolder folder;
  const std::string table = folder / "table.json", alone = folder / "alone.json", file = folder / "eight.toml";
  const std::string sweep = text_of(source_file("examples/random_sweep.toml"));
  const auto floor_of_sweep = [&](const std::string& path, const std::string& json, std::vector<std::string> more) {
    std::vector<std::string> words = {"floor",   path,  "--bank",  "4000",   "--readings", "20",
                                      "--noise", "0.1", "--quiet", "--json", json};
    words.insert(words.end(), more.begin(), more.end());
    return run_tactel(words);
  };
  const ChildResult two = floor_of_sweep(source_file("examples/random_sweep.toml"), table,
                                         {"--tactels", "8", "--tactels", "21", "--thickness", "3"});
  ASSERT_EQ(two.exit_code, 0) << two.err;
  EXPECT_NE(two.out.find("      8   2.86           3"), std::string::npos) << two.out;
  auto skins = nlohmann::json::parse(text_of(table))["skins"];
  ASSERT_EQ(skins.size(), 2u);
  EXPECT_EQ(skins[1]["tactels"], 21);
  EXPECT_DOUBLE_EQ(skins[0]["pitch"], 20.0 / 7);
  std::ofstream(file) << std::regex_replace(sweep, std::regex("\\[sensor\\]"), "[sensor]\ntactels = 8\nthickness = 3");
  ASSERT_EQ(floor_of_sweep(file, alone, {}).exit_code, 0);
  EXPECT_EQ(skins[0]["all"], nlohmann::json::parse(text_of(alone))["all"]);
  const ChildResult thin = floor_of_sweep(file, alone, {"--thickness", "1e-9"});
  EXPECT_EQ(thin.exit_code, 2);
  EXPECT_NE(thin.err.find("thickness"), std::string::npos) << thin.err;
}

}  // namespace
}  // namespace tactel::host
