// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/calibration_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/calibration/median.h"
#include "host/figures/plot.h"

namespace tactel::host {
namespace {

using Eigen::Index;

constexpr std::size_t most_named = 12;  ///< presses whose names fit below an axis

struct Kind {
  std::string name;
  Index first;  ///< place of its first transducer in a frame
  Mark mark;
  Ink ink;
};

Index channels(const SensorCalibration& found) { return static_cast<Index>(found.gain.size()); }

std::vector<Kind> kinds(const SensorCalibration& found) {
  constexpr std::pair<Mark, Ink> looks[] = {
      {Mark::circles, Ink::blue}, {Mark::triangles, Ink::orange}, {Mark::diamonds, Ink::green}};
  std::vector<Kind> all;
  for (std::string& name : stress_names(channels(found), found.tactels)) {
    const auto k = static_cast<Index>(all.size());
    all.push_back({std::move(name), k * found.tactels, looks[k].first, looks[k].second});
  }
  return all;
}

/// Relative deviations of gains; NaN where a transducer was left out.
std::vector<double> gain_deviations(const SensorCalibration& found) {
  std::vector<double> all;
  for (const Fitted& gain : found.gain) all.push_back(std::abs(gain.deviation / gain.value));
  return all;
}

std::string percent(double share) { return std::isfinite(share) ? fmt::format("{:.2g} %", 100 * share) : "-"; }

void add_press_axis(Panel& panel, const std::vector<KnownPress>& presses) {
  if (presses.size() > most_named) return;
  for (std::size_t i = 0; i < presses.size(); ++i)
    panel.x_ticks.push_back({static_cast<double>(i + 1), plain(presses[i].name)});
}

Figure gain_figure(const SensorCalibration& found) {
  Figure figure{.columns = 2, .panel_height = 280};
  for (const Kind& kind : kinds(found)) {
    Series series{.mark = Mark::whiskers, .ink = kind.ink};
    const Index tactels = found.tactels;
    for (Index i = 0; i < tactels; ++i) {
      const Fitted& gain = found.gain[static_cast<std::size_t>(kind.first + i)];
      if (!std::isfinite(gain.value)) continue;
      series.x.push_back(static_cast<double>(i));
      series.y.push_back(gain.value);
      series.low.push_back(gain.value - 2 * gain.deviation);
      series.high.push_back(gain.value + 2 * gain.deviation);
    }
    figure.panels.push_back({.title = kind.name,
                             .x_label = "tactel",
                             .y_label = "gain (MPa by the device's unit)",
                             .series = {std::move(series)},
                             .x_range = std::pair{-0.5, static_cast<double>(tactels) - 0.5}});
  }
  return figure;
}

/// Mean residual of each press and tactel, in colours.
Figure residual_map(const SensorCalibration& found, const std::vector<KnownPress>& presses) {
  Figure figure{.columns = 2, .panel_height = 320};
  const Index tactels = found.tactels;
  for (const Kind& kind : kinds(found)) {
    Raster raster{.rows = static_cast<int>(presses.size()),
                  .columns = static_cast<int>(tactels),
                  .x_range = {-0.5, static_cast<double>(tactels) - 0.5},
                  .y_range = {0.5, static_cast<double>(presses.size()) + 0.5},
                  .unit = "residual over noise",
                  .palette = Palette::diverging};
    for (const Eigen::MatrixXd& residuals : found.residuals)
      for (Index i = 0; i < tactels; ++i) {
        const auto column = residuals.col(kind.first + i).array();
        const auto finite = column.isFinite();
        raster.values.push_back(finite.any() ? finite.select(column, 0).sum() / static_cast<double>(finite.count())
                                             : NAN);
      }
    figure.panels.push_back({.title = kind.name, .x_label = "tactel", .y_label = "press", .raster = std::move(raster)});
  }
  return figure;
}

PageTable number_table(const SensorCalibration& found) {
  PageTable table{.caption = "Numbers of the sensor", .head = {"number", "value", "standard deviation", "unit"}};
  for (const PressNumber number : numbers_of(found)) {
    const auto& [value, deviation] = found.*found_numbers[number];
    table.add({sensor_table[number].label, fmt::format("{:.5g}", value),
               deviation > 0 ? fmt::format("{:.2g}", deviation) : "held", sensor_table[number].unit});
  }
  return table;
}

PageTable friction_table(const SensorCalibration& found, const std::vector<KnownPress>& presses) {
  PageTable table{.caption = "Friction of each press", .head = {"press", "scene", "found", "standard deviation"}};
  for (std::size_t i = 0; i < presses.size(); ++i)
    if (found.friction[i].deviation > 0)
      table.add({presses[i].name, fmt::format("{:.3g}", friction_of(presses[i].scene)),
                 fmt::format("{:.3g}", found.friction[i].value), fmt::format("{:.2g}", found.friction[i].deviation)});
  return table;
}

PageTable gain_table(const SensorCalibration& found) {
  PageTable table{.caption = "Gains and offsets, noise of the residuals in the device's unit",
                  .head = {"transducer", "gain", "standard deviation", "offset", "standard deviation", "noise"}};
  const Index tactels = found.tactels;
  for (std::size_t c = 0; c < found.gain.size(); ++c) {
    const std::string name = transducer_name(static_cast<Index>(c), channels(found), tactels);
    const Fitted &gain = found.gain[c], &offset = found.offset[c];
    if (!std::isfinite(gain.value)) {
      table.add({name, {"left out", Tone::poor}, "", "", "", ""}, true);
      continue;
    }
    const double deviation = std::abs(gain.deviation / gain.value);
    table.add({name,
               fmt::format("{:.4g}", gain.value),
               {percent(deviation), deviation < 0.05  ? Tone::plain
                                    : deviation < 0.2 ? Tone::fair
                                                      : Tone::poor},
               fmt::format("{:.5g}", offset.value),
               fmt::format("{:.2g}", offset.deviation),
               fmt::format("{:.2g}", found.noise[c])});
  }
  return table;
}

void add_verdict(Page& page, const SensorCalibration& found) {
  const std::vector<double> deviations = gain_deviations(found);
  const auto found_gains = std::ranges::count_if(deviations, [](double d) { return std::isfinite(d); });
  const auto unsure = std::ranges::count_if(deviations, [](double d) { return d > 0.2; });
  page.verdict(found.converged ? fmt::format("Gains of {} of {} transducers are found, with a median deviation of {}.",
                                             found_gains, deviations.size(), percent(median(deviations)))
                               : std::string("The fit did not converge; its numbers say nothing."));
  page.finding(
      found.converged ? Tone::good : Tone::poor, "fit",
      fmt::format("{} after {} iterations.", found.converged ? "Converged" : "Not converged", found.iterations));
  if (found.young.deviation > 0)
    page.finding(Tone::fact, "E", fmt::format("{:.4g} ± {:.2g} MPa.", found.young.value, found.young.deviation));
  if (found.poisson.deviation > 0)
    page.finding(Tone::fact, "ν", fmt::format("{:.4g} ± {:.2g}.", found.poisson.value, found.poisson.deviation));
  if (unsure > 0)
    page.finding(Tone::fair, "uncertain",
                 fmt::format("{} gains have deviations above 20 %: press and drag over these tactels.", unsure));
  if (found.faults.empty()) page.finding(Tone::good, "faults", "None is found.");
  for (const CalibrationFault& fault : found.faults) page.finding(Tone::poor, "fault", fault.text + ".");
}

}  // namespace

Figure residual_figure(const SensorCalibration& found, const std::vector<KnownPress>& presses) {
  Panel by_press{.title = "by press", .x_label = "press", .y_label = "residual over noise, rms", .zero_line = true};
  Panel by_tactel{.title = "by tactel", .x_label = "tactel", .y_label = "residual, rms (kPa)", .zero_line = true};
  const Index tactels = found.tactels;
  by_press.x_range = {0.5, static_cast<double>(presses.size()) + 0.5};
  by_tactel.x_range = {-0.5, static_cast<double>(tactels) - 0.5};
  add_press_axis(by_press, presses);
  for (const Kind& kind : kinds(found)) {
    const Series empty{.label = kind.name, .mark = kind.mark, .ink = kind.ink};
    Series press = empty, tactel = empty;
    for (std::size_t i = 0; i < presses.size(); ++i) {
      press.x.push_back(static_cast<double>(i + 1));
      press.y.push_back(rms(found.residuals[i].middleCols(kind.first, tactels)));
      if (by_press.x_ticks.empty()) press.names.push_back(presses[i].name);
    }
    for (Index c = 0; c < tactels; ++c) {
      double sum = 0, n = 0;
      for (const Eigen::MatrixXd& residuals : found.residuals)
        for (const double r : residuals.col(kind.first + c))
          if (std::isfinite(r)) sum += r * r, n += 1;
      tactel.x.push_back(static_cast<double>(c));
      const auto i = static_cast<std::size_t>(kind.first + c);
      const double kPa = 1000 * found.noise[i] * std::abs(found.gain[i].value);
      tactel.y.push_back(n > 0 ? std::sqrt(sum / n) * kPa : NAN);
    }
    by_press.series.push_back(std::move(press)), by_tactel.series.push_back(std::move(tactel));
  }
  for (Panel* panel : {&by_press, &by_tactel}) {
    double most = 0;
    for (const Series& series : panel->series)
      for (const double y : series.y) most = std::max(most, std::isnan(y) ? 0 : y);
    panel->y_range = {0, most > 0 ? 1.1 * most : 1};
  }
  return {.title = "Residuals of the calibration", .panels = {by_press, by_tactel}, .columns = 2, .width = 900};
}

Page calibration_page(const SensorCalibration& found, const std::vector<KnownPress>& presses,
                      const std::string& recordings, const std::string& profile) {
  Page page("tactel: a sensor calibrated by known presses",
            fmt::format("{} press{} of {}, profile {}, by tactel {}", presses.size(), presses.size() == 1 ? "" : "es",
                        recordings, profile, TACTEL_VERSION));
  add_verdict(page, found);
  page.section("Sensor");
  page.table(number_table(found));
  const PageTable friction = friction_table(found, presses);
  if (!friction.rows.empty()) page.table(friction);
  if (!found.held.empty()) page.paragraph("What is held fixed, and what is not told apart:");
  for (const std::string& sentence : found.held) page.note(sentence + ".");
  page.section("Gains");
  page.figure(gain_figure(found),
              "Gains with two standard deviations on both sides. A transducer that was left out has no mark.");
  page.section("Residuals");
  page.figure(
      residual_figure(found, presses),
      "Size of reading less model: by press over the noise of the transducers, by tactel as a stress. A press far "
      "above the others has another indenter, depth or place; a press without a mark was left out.");
  page.figure(residual_map(found, presses),
              "Mean residual of each press at each tactel. Neighbouring tactels of one colour show a press at another "
              "place or depth than its scene says.");
  page.section("All transducers");
  page.table(gain_table(found));
  return page;
}

}  // namespace tactel::host
