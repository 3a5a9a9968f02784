// SPDX-License-Identifier: Apache-2.0
#include "host/scenes/distribution.h"

#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "host/support/nearest_word.h"

namespace tactel::host {
namespace {

constexpr std::uint32_t most_attempts = 4096;
constexpr double default_deviations = 4;

double unit(std::uint32_t high, std::uint32_t low) {
  return static_cast<double>((std::uint64_t{high} << 21) ^ (low >> 11)) * 0x1p-53;
}

double number_of(const UniformDraw& d, const DrawKey& key) { return std::lerp(d.from, d.to, uniform_number(key)); }

double number_of(const LogUniformDraw& d, const DrawKey& key) {
  return std::clamp(std::exp(std::lerp(std::log(d.from), std::log(d.to), uniform_number(key))), d.from, d.to);
}

/// The number below which a share `quantile` of the distribution lies, by bisection.
double quantile_of(const NormalDraw& d, double quantile) {
  const auto below = [&](double value) {
    return 0.5 * std::erfc((d.mean - value) / (d.deviation * std::numbers::sqrt2));
  };
  const double share = std::lerp(below(d.min), below(d.max), quantile);
  double low = d.min, high = d.max;
  for (int k = 0; k < 60; ++k) {
    const double middle = std::midpoint(low, high);
    (below(middle) < share ? low : high) = middle;
  }
  return low;
}

/// Box and Muller (1958).
double number_of(const NormalDraw& d, const DrawKey& key) {
  if (key.quantiles) return quantile_of(d, uniform_number(key));
  for (std::uint32_t attempt = 0; attempt < most_attempts; ++attempt) {
    const nn::PhiloxCounter words = random_words(key, attempt);
    const double radius = std::sqrt(-2 * std::log(1 - unit(words[0], words[1])));
    const double value = d.mean + d.deviation * radius * std::cos(2 * std::numbers::pi * unit(words[2], words[3]));
    if (value >= d.min && value <= d.max) return value;
  }
  return std::clamp(d.mean, d.min, d.max);
}

double number_of(const ChoiceDraw& d, const DrawKey& key) { return d.values[draw_weighted(d.weights, key)]; }

std::pair<double, double> ends_of(const UniformDraw& d) { return {d.from, d.to}; }
std::pair<double, double> ends_of(const LogUniformDraw& d) { return {d.from, d.to}; }
std::pair<double, double> ends_of(const NormalDraw& d) { return {d.min, d.max}; }
std::pair<double, double> ends_of(const ChoiceDraw& d) {
  const auto [least, most] = std::ranges::minmax(d.values);
  return {least, most};
}

/// Reads the numbers of one distribution, with errors about the whole of it.
class Reader {
 public:
  Reader(const TomlFile& file, std::string key, const toml::table& table)
      : file_(file), key_(std::move(key)), table_(table) {}

  [[noreturn]] void refuse(const std::string& allowed) const { throw file_.error(key_, &table_, allowed); }

  std::vector<double> numbers(const char* name) const {
    std::vector<double> values;
    const toml::array* array = table_[name].as_array();
    if (array == nullptr) refuse(std::string(name) + " = an array of numbers");
    for (const toml::node& node : *array) {
      const auto value = toml_number(node);
      if (!value || !std::isfinite(*value)) refuse(std::string(name) + " = an array of finite numbers");
      values.push_back(*value);
    }
    return values;
  }
  std::pair<double, double> two(const char* name, const char* what) const {
    const std::vector<double> values = numbers(name);
    if (values.size() != 2) refuse(std::string("{ ") + name + " = " + what + " }");
    return {values[0], values[1]};
  }
  double number(const char* name, double otherwise) const {
    if (!table_.contains(name)) return otherwise;
    const auto value = toml_number(*table_.get(name));
    if (!value || !std::isfinite(*value)) refuse(std::string(name) + " = a finite number");
    return *value;
  }
  /// No key but these.
  void only(std::initializer_list<const char*> known) const {
    for (const auto& [name, node] : table_)
      if (std::ranges::none_of(known, [&, &name = name](const char* k) { return name.str() == k; }))
        refuse("a distribution without the key " + std::string(name.str()));
  }

 private:
  const TomlFile& file_;
  std::string key_;
  const toml::table& table_;
};

Distribution uniform(const Reader& in, const char* name) {
  in.only({name});
  const auto [from, to] = in.two(name, "[smallest, largest]");
  if (!(from <= to)) in.refuse(std::string("{ ") + name + " = [smallest, largest] }, in this order");
  if (name == std::string_view("uniform")) return UniformDraw{from, to};
  if (!(from > 0)) in.refuse("{ log_uniform = [smallest, largest] }, both above 0");
  return LogUniformDraw{from, to};
}

Distribution normal(const Reader& in) {
  in.only({"normal", "min", "max"});
  const auto [mean, deviation] = in.two("normal", "[mean, standard deviation]");
  if (!(deviation > 0)) in.refuse("{ normal = [mean, standard deviation] }, the deviation above 0");
  const NormalDraw draw{mean, deviation, in.number("min", mean - default_deviations * deviation),
                        in.number("max", mean + default_deviations * deviation)};
  if (!(draw.min < draw.max) || draw.min > mean + 3 * deviation || draw.max < mean - 3 * deviation)
    in.refuse(
        "a normal distribution with min below max, and not all of it cut away (min .. max must come within 3 "
        "standard deviations of the mean)");
  return draw;
}

Distribution choice(const Reader& in, bool weighted) {
  in.only({"choice", "weights"});
  ChoiceDraw draw{in.numbers("choice"), {}};
  if (draw.values.empty()) in.refuse("{ choice = [...] } of at least one number");
  draw.weights = weighted ? in.numbers("weights") : std::vector<double>(draw.values.size(), 1.0);
  const bool good = draw.weights.size() == draw.values.size() &&
                    std::ranges::all_of(draw.weights, [](double w) { return w >= 0; }) &&
                    std::accumulate(draw.weights.begin(), draw.weights.end(), 0.0) > 0;
  if (!good) in.refuse("{ choice = [...], weights = [...] }, as many weights as choices, none negative, not all 0");
  return draw;
}

}  // namespace

nn::PhiloxCounter random_words(const DrawKey& key, std::uint32_t attempt) {
  return nn::philox4x32({key.draw | attempt << 20, static_cast<std::uint32_t>(key.item),
                         static_cast<std::uint32_t>(key.stream), static_cast<std::uint32_t>(key.item >> 32)},
                        {static_cast<std::uint32_t>(key.seed), static_cast<std::uint32_t>(key.seed >> 32)});
}

double uniform_number(const DrawKey& key) {
  if (key.quantiles) return key.quantiles[key.draw];
  const nn::PhiloxCounter words = random_words(key);
  return unit(words[0], words[1]);
}

double draw(const Distribution& distribution, const DrawKey& key) {
  return std::visit([&](const auto& d) { return number_of(d, key); }, distribution);
}

std::pair<double, double> ends(const Distribution& distribution) {
  return std::visit([](const auto& d) { return ends_of(d); }, distribution);
}

bool continuous(const Distribution& distribution) { return !std::holds_alternative<ChoiceDraw>(distribution); }

std::size_t draw_weighted(const std::vector<double>& weights, const DrawKey& key) {
  double left = uniform_number(key) * std::accumulate(weights.begin(), weights.end(), 0.0);
  for (std::size_t i = 0; i + 1 < weights.size(); ++i)
    if ((left -= weights[i]) < 0) return i;
  return weights.size() - 1;
}

std::optional<Distribution> read_distribution(const TomlFile& file, const std::string& key, const toml::node& node) {
  const toml::table* table = node.as_table();
  if (table == nullptr) return std::nullopt;
  const Reader in(file, key, *table);
  if (table->contains("uniform")) return uniform(in, "uniform");
  if (table->contains("log_uniform")) return uniform(in, "log_uniform");
  if (table->contains("normal")) return normal(in);
  if (table->contains("choice")) return choice(in, table->contains("weights"));
  const std::vector<std::string> names = {"uniform", "log_uniform", "normal", "choice"};
  in.refuse(
      "a number, or a distribution: { uniform = [a, b] }, { log_uniform = [a, b] }, { normal = [mean, sd] } or "
      "{ choice = [...] }" +
      (table->empty() ? "" : did_you_mean(table->begin()->first.str(), names)));
}

}  // namespace tactel::host
