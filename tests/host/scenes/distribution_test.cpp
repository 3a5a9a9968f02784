// SPDX-License-Identifier: Apache-2.0

// Numbers that a sweep draws: their distribution, and what they depend on.
#include "host/scenes/distribution.h"

#include <gtest/gtest.h>
#include <toml++/toml.h>

#include <cmath>
#include <functional>

#include "tests/host/support/run_tactel.h"
#include "tests/thrown_message.h"

namespace tactel::host::distribution_test {

constexpr int count = 20000;

std::vector<double> numbers(const Distribution& distribution) {
  std::vector<double> all;
  for (std::uint64_t k = 0; k < count; ++k) all.push_back(draw(distribution, {.seed = 5, .item = k, .draw = 3}));
  return all;
}

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

double variance(const std::vector<double>& values) {
  double sum = 0;
  for (double value : values) sum += (value - mean(values)) * (value - mean(values));
  return sum / static_cast<double>(values.size());
}

double largest_kolmogorov_distance(std::vector<double> values, const std::function<double(double)>& distribution) {
  std::sort(values.begin(), values.end());
  double largest = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double expected = distribution(values[i]), n = static_cast<double>(values.size());
    largest = std::max({largest, std::abs(expected - static_cast<double>(i) / n), std::abs(expected - (i + 1.0) / n)});
  }
  return largest;
}

// Kolmogorov and Smirnov: the distance exceeds 1.95 / sqrt(n) with a probability of 0.001. Seeds are fixed.
const double allowed = 1.95 / std::sqrt(count);

TEST(Distribution, UniformIsUniform) {
  EXPECT_LT(largest_kolmogorov_distance(numbers(UniformDraw{2, 5}), [](double x) { return (x - 2) / 3; }), allowed);
}

TEST(Distribution, LogUniformIsUniformInItsLogarithm) {
  EXPECT_LT(largest_kolmogorov_distance(numbers(LogUniformDraw{1, 100}),
                                        [](double x) { return std::log(x) / std::log(100); }),
            allowed);
}

TEST(Distribution, NormalIsNormalBetweenItsBounds) {
  const auto below = [](double x) { return 0.5 * std::erfc(-(x - 3) / (2 * std::sqrt(2.0))); };  // mean 3, deviation 2
  const double cut = below(1), all = below(6) - cut;
  const auto values = numbers(NormalDraw{3, 2, 1, 6});
  EXPECT_LT(largest_kolmogorov_distance(values, [&](double x) { return (below(x) - cut) / all; }), allowed);
  EXPECT_GE(*std::min_element(values.begin(), values.end()), 1);
  EXPECT_LE(*std::max_element(values.begin(), values.end()), 6);
}

// Shares of n draws spread by sqrt(p (1 - p) / n) <= 0.0035: four of these.
TEST(Distribution, ChoiceFollowsItsWeights) {
  const auto values = numbers(ChoiceDraw{{10, 20, 30}, {1, 0, 3}});
  EXPECT_NEAR(std::count(values.begin(), values.end(), 10) / double(count), 0.25, 0.014);
  EXPECT_EQ(std::count(values.begin(), values.end(), 20), 0);
}

TEST(Distribution, DrawsDoNotKnowEachOther) {
  std::vector<double> product;
  for (std::uint64_t k = 0; k < count; ++k) {
    const double a = uniform_number({.seed = 1, .item = k, .draw = 0}),
                 b = uniform_number({.seed = 1, .item = k, .draw = 1});
    const double next = uniform_number({.seed = 1, .item = k + 1, .draw = 0});
    product.push_back((a - 0.5) * (b - 0.5) + (a - 0.5) * (next - 0.5));
  }
  // The mean of n products of standard deviation sqrt(2) / 12.
  EXPECT_NEAR(mean(product), 0, 4 * std::sqrt(2.0) / 12 / std::sqrt(count));
  EXPECT_GT(variance(product), 0);
}

std::string message_of(const std::string& text) {
  const ScratchFolder folder;
  const TomlFile file(folder.write("s.toml", "[contact]\nfriction = " + text + "\n"));
  return thrown_message<ConfigError>(
      [&] { read_distribution(file, "contact.friction", *file.root().at_path("contact.friction").node()); });
}

TEST(Distribution, RefusesWhatIsNone) {
  for (const auto& [text, said] :
       std::vector<std::pair<std::string, std::string>>{{"{ uniform = [1] }", "[smallest, largest]"},
                                                        {"{ uniform = [2, 1] }", "in this order"},
                                                        {"{ uniform = 3 }", "an array of numbers"},
                                                        {"{ uniform = [0, inf] }", "finite"},
                                                        {"{ log_uniform = [0, 1] }", "above 0"},
                                                        {"{ normal = [1, 0] }", "deviation above 0"},
                                                        {"{ normal = [1, 1], min = 9, max = 10 }", "cut away"},
                                                        {"{ choice = [] }", "at least one"},
                                                        {"{ choice = [1, 2], weights = [1] }", "as many weights"},
                                                        {"{ choice = [1, 2], weights = [0, 0] }", "not all 0"},
                                                        {"{ unifrom = [1, 2] }", "did you mean uniform?"},
                                                        {"{ uniform = [1, 2], mean = 3 }", "without the key mean"}}) {
    EXPECT_NE(message_of(text).find(said), std::string::npos) << text << ": " << message_of(text);
    EXPECT_NE(message_of(text).find("s.toml:2: contact.friction"), std::string::npos) << message_of(text);
  }
}

}  // namespace tactel::host::distribution_test
