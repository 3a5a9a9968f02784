// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "host/scenes/toml_table.h"
#include "nn/philox.h"

namespace tactel::host {

/// Origin of the random numbers of one draw: they are a function of these numbers alone.
struct DrawKey {
  std::uint64_t seed = 0;
  nn::RandomStream stream = nn::RandomStream::contact;
  std::uint64_t item = 0;  ///< contact or sensor
  std::uint32_t draw = 0;  ///< index of the number
  /// Quantiles [draws] in [0, 1) of the numbers, in place of random ones; null: they are drawn.
  const double* quantiles = nullptr;
};

/// Returns four random words. `attempt` counts the attempts of one draw. Below 2^20 draws, 2^12 attempts.
nn::PhiloxCounter random_words(const DrawKey& key, std::uint32_t attempt = 0);
/// Returns the quantile of the key, or a number in [0, 1) with 53 random bits.
double uniform_number(const DrawKey& key);

/// A number of a sweep file that differs between contacts.
struct UniformDraw {
  double from = 0, to = 1;
};
struct LogUniformDraw {
  double from = 1, to = 10;
};
/// Normal, drawn again until it lies within [min, max].
struct NormalDraw {
  double mean = 0, deviation = 1;
  double min = 0, max = 1;
};
struct ChoiceDraw {
  std::vector<double> values, weights;
};
using Distribution = std::variant<UniformDraw, LogUniformDraw, NormalDraw, ChoiceDraw>;

double draw(const Distribution& distribution, const DrawKey& key);
/// Returns the smallest and the largest possible number.
std::pair<double, double> ends(const Distribution& distribution);
/// Returns whether the number grows steadily with its quantile: a choice does not.
bool continuous(const Distribution& distribution);
/// Returns the index of one of several weights, drawn in proportion to them.
std::size_t draw_weighted(const std::vector<double>& weights, const DrawKey& key);

/// Reads { uniform = [a, b] }, { log_uniform = [a, b] }, { normal = [mean, sd], min = a, max = b } (defaults to 4
/// sd about the mean) or { choice = [a, b, ...], weights = [...] } (defaults to equal weights). Returns none
/// where the node is no table. Throws ConfigError for a table that is no distribution. `key` is the full key.
std::optional<Distribution> read_distribution(const TomlFile& file, const std::string& key, const toml::node& node);

}  // namespace tactel::host
