// SPDX-License-Identifier: Apache-2.0
#include "host/studies/paper/real_sensor_figures.h"

#include <fmt/format.h>

#include <algorithm>

namespace tactel::host {
namespace {

constexpr Ink data_inks[] = {Ink::blue, Ink::orange};

using Reports = std::vector<nn::ErrorReport>;

/// One kind of data as the paper scales it, by the number of examples.
std::vector<const RealSensorResult*> by_examples(const RealSensorStudy& study, RealData data) {
  std::vector<const RealSensorResult*> results;
  for (const RealSensorResult& result : study.results)
    if (result.what.data == data && result.what.scaling == nn::ScalingKind::set) results.push_back(&result);
  std::ranges::sort(results, {}, [](const RealSensorResult* r) { return r->what.examples; });
  return results;
}

// ---- a record, and what is taken from it

/// The contacts of the paper's Fig. 7: indenter 4 pushed at 15 degrees, and 7 without tangential load; here over the
/// centre.
constexpr RealContact fourth{3, 0, 38, 15}, seventh{6, 0, 38, 0};

std::span<const float> record_of(const RealSensorStudy& study, std::size_t contact) {
  const std::size_t length = study.records.size() / study.contacts.size();
  return std::span(study.records).subspan(contact * length, length);
}

Panel record_panel(const RealSensorStudy& study, std::size_t contact) {
  const std::span<const float> record = record_of(study, contact);
  const auto channels = static_cast<std::size_t>(study.ideal.frames.cols());
  Panel panel{.title = "a record: " + real_indenters()[study.contacts[contact].indenter].name + ", 15°",
              .x_label = "time (s)",
              .y_label = "reading (MPa)",
              .zero_line = true};
  const std::size_t sample = highest_normal_sample(record, channels);
  for (std::size_t channel : {channels / 2 - 4, channels - 4}) {  // the two films of one beside the centre
    const bool normal = channel < channels / 2;
    Series series{.label = normal ? "σ_y, tactel 5" : "τ_{xy}, tactel 5", .mark = Mark::thin};
    series.ink = normal ? Ink::blue : Ink::orange;
    for (std::size_t k = 0; k < record.size() / channels; ++k) {
      series.x.push_back(static_cast<double>(k) / study.choice.record.rate);
      series.y.push_back(static_cast<double>(record[k * channels + channel]));
    }
    Series taken{.label = normal ? "" : "the sample taken",
                 .x = {series.x[sample]},
                 .y = {series.y[sample]},
                 .mark = Mark::circles,
                 .ink = Ink::black};
    panel.series.push_back(std::move(series));
    panel.series.push_back(std::move(taken));
  }
  return panel;
}

Panel frame_panel(const RealSensorStudy& study, std::size_t contact) {
  const std::span<const float> record = record_of(study, contact);
  const auto tactels = study.ideal.frames.cols() / 2;
  const auto channels = static_cast<std::size_t>(2 * tactels);
  const std::size_t sample = highest_normal_sample(record, channels);
  const RealContact& what = study.contacts[contact];
  Panel panel{.title = fmt::format("{}, {:.0f}°", real_indenters()[what.indenter].name, what.angle),
              .x_label = "tactel",
              .y_label = "MPa",
              .x_range = std::pair{0.5, static_cast<double>(tactels) + 0.5},
              .zero_line = true};
  for (bool normal : {true, false}) {
    const Ink ink = normal ? Ink::blue : Ink::orange;
    Series felt{.label = normal ? "σ_y" : "τ_{xy}", .mark = Mark::line, .ink = ink};
    Series read{.label = normal ? "σ_y, read" : "τ_{xy}, read", .mark = Mark::crosses, .ink = ink};
    for (Eigen::Index k = 0; k < tactels; ++k) {
      const Eigen::Index channel = normal ? k : tactels + k;
      felt.x.push_back(static_cast<double>(k + 1)), read.x.push_back(static_cast<double>(k + 1));
      felt.y.push_back(static_cast<double>(study.ideal.frames(static_cast<Eigen::Index>(contact), channel)));
      read.y.push_back(static_cast<double>(record[sample * channels + static_cast<std::size_t>(channel)]));
    }
    panel.series.push_back(std::move(felt));
    panel.series.push_back(std::move(read));
  }
  return panel;
}

// ---- errors

void add_whisker(Series& series, double x, const Spread& s) {
  series.x.push_back(x), series.y.push_back(s.median);
  series.low.push_back(s.low), series.high.push_back(s.high);
}

/// What reading the angle alone reaches, as a line over the panel.
Series angle_line(double from, double to, double error) {
  return {.label = "angle alone", .x = {from, to}, .y = {error, error}, .mark = Mark::dashed, .ink = Ink::red};
}

Panel distribution_panel(const RealSensorStudy& study) {
  Panel panel{.title = "11 recalled", .y_label = "mean error of S", .x_range = std::pair{0.4, 4.6}};
  Series each{.label = "one network", .mark = Mark::dots, .ink = Ink::grey};
  Series medians{.label = "median, 5 to 95 %", .mark = Mark::whiskers, .ink = Ink::blue};
  int place = 0;
  for (const RealSensorResult* result : with_25(study)) {
    ++place;
    const std::size_t count = result->recalling.size();
    for (std::size_t i = 0; i < count; ++i) {
      each.x.push_back(place + 0.6 * (static_cast<double>(i) / static_cast<double>(count) - 0.5));
      each.y.push_back(mean_error(result->recalling[i]));
    }
    add_whisker(medians, place, spread(result->recalling, mean_error));
    panel.x_ticks.push_back({place, fmt::format("{}, by {}", name(result->what.data), nn::name(result->what.scaling))});
  }
  panel.series = {each, medians, angle_line(0.4, 4.6, spread(study.angle_alone, mean_error).median)};
  return panel;
}

Panel indenter_panel(const RealSensorStudy& study) {
  Panel panel{.title = "by indenter, all outside the learning set", .y_label = "mean error of S"};
  const auto indenters = static_cast<int>(real_indenters().size());
  for (RealData data : {RealData::stresses, RealData::records}) {
    const int place = static_cast<int>(data);
    Series series{.label = name(data), .mark = Mark::whiskers, .ink = data_inks[place]};
    for (const RealSensorResult* result : with_25(study))
      if (result->what.data == data && result->what.scaling == nn::ScalingKind::set)
        for (int i = 0; i < indenters; ++i) add_whisker(series, i + 0.2 * place, of_indenter(*result, i));
    panel.series.push_back(std::move(series));
  }
  for (int i = 0; i < indenters; ++i)
    panel.x_ticks.push_back({i + 0.1, real_indenters()[static_cast<std::size_t>(i)].name});
  panel.x_range = {{-0.6, indenters - 0.2}};
  panel.y_range = {
      {0, 1.05 * std::max(std::ranges::max(panel.series[0].high), std::ranges::max(panel.series[1].high))}};
  return panel;
}

/// Of a case with more draws than the others: the draws that all cases have.
Reports on_shared_draws(const RealSensorStudy& study, const Reports& reports, std::size_t seeds) {
  const std::size_t shared = std::min(study.options.draws, study.options.other_draws) * seeds;
  return {reports.begin(), reports.begin() + static_cast<std::ptrdiff_t>(shared)};
}

Panel examples_panel(const RealSensorStudy& study) {
  Panel panel{
      .title = "fewer and more examples, 11 recalled", .x_label = "learning examples", .y_label = "mean error of S"};
  for (RealData data : {RealData::stresses, RealData::records}) {
    const int place = static_cast<int>(data);
    Series series{.label = name(data), .mark = Mark::whiskers, .ink = data_inks[place]};
    for (const RealSensorResult* result : by_examples(study, data))
      add_whisker(series, static_cast<double>(result->what.examples) + place,
                  spread(on_shared_draws(study, result->recalling, study.options.seeds), mean_error));
    panel.series.push_back(std::move(series));
  }
  const Reports by_angle = on_shared_draws(study, study.angle_alone, 1);
  panel.series.push_back(angle_line(5, 100, spread(by_angle, mean_error).median));
  panel.x_range = {{5, 100}};
  return panel;
}

}  // namespace

std::vector<const RealSensorResult*> with_25(const RealSensorStudy& study) {
  std::vector<const RealSensorResult*> results;
  for (const RealSensorResult& result : study.results)
    if (result.what.examples == paper_examples) results.push_back(&result);
  return results;
}

Spread of_indenter(const RealSensorResult& result, int indenter) {
  return spread(result.unseen, [=](const nn::ErrorReport& r) { return r.by_class.at(indenter).mean; });
}

std::size_t place_of(const RealSensorStudy& study, const RealContact& contact) {
  return static_cast<std::size_t>(std::ranges::find(study.contacts, contact) - study.contacts.begin());
}

Figure record_figure(const RealSensorStudy& study) {
  return {.panels = {record_panel(study, place_of(study, fourth))}, .panel_height = 260};
}

Figure frame_figure(const RealSensorStudy& study) {
  return {.panels = {frame_panel(study, place_of(study, fourth)), frame_panel(study, place_of(study, seventh))},
          .columns = 2};
}

Figure error_figure(const RealSensorStudy& study) {
  return {.panels = {distribution_panel(study), examples_panel(study), indenter_panel(study)},
          .columns = 1,
          .panel_height = 270};
}

}  // namespace tactel::host
