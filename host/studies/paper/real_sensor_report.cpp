// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "host/studies/paper/real_sensor_study.h"

namespace tactel::host {
namespace {

/// "records, by frame".
std::string text_of(const RealSensorCase& what) {
  return fmt::format("{}, by {}", name(what.data), nn::name(what.scaling));
}

/// The result of data that are scaled as the paper scales them.
const RealSensorResult& scaled_by_set(const RealSensorStudy& study, RealData data) {
  return *std::ranges::find_if(study.results, [data](const RealSensorResult& result) {
    return result.what.data == data && result.what.scaling == nn::ScalingKind::set;
  });
}

/// The mean error by indenter on the 80 contacts outside of the 25 learned ones. They include some of each indenter's
/// 15.
Spread of_indenter(const RealSensorResult& result, int indenter) {
  return spread(result.unseen, [=](const nn::ErrorReport& r) { return r.by_class.at(indenter).mean; });
}

std::size_t place_of(const RealSensorStudy& study, const RealContact& contact) {
  return static_cast<std::size_t>(std::ranges::find(study.contacts, contact) - study.contacts.begin());
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

/// What reading the angle alone reaches, as a line over the panel.
Series angle_line(double from, double to, double error) {
  return {.label = "angle alone", .x = {from, to}, .y = {error, error}, .mark = Mark::dashed, .ink = Ink::red};
}

Panel distribution_panel(const RealSensorStudy& study) {
  Panel panel{.title = "11 recalled", .y_label = "mean error of S", .x_range = std::pair{0.4, 4.6}};
  Series each{.label = "one network", .mark = Mark::dots, .ink = Ink::grey};
  Series medians{.label = "median, 5 to 95 %", .mark = Mark::whiskers, .ink = Ink::blue};
  int place = 0;
  for (const RealSensorResult& result : study.results) {
    add_networks(each, medians, ++place, 0.6, result.recalling);
    panel.x_ticks.push_back({place, text_of(result.what)});
  }
  panel.series = {each, medians, angle_line(0.4, 4.6, spread(study.angle_alone, mean_error).median)};
  return panel;
}

/// The two films of a tactel over a record, with the selected sample.
Figure record_figure(const RealSensorStudy& study) {
  return {.panels = {record_panel(study, place_of(study, fourth))}, .panel_height = 260};
}

/// As the paper's Fig. 7: the stresses at the tactels of two contacts, and the selected sample.
Figure frame_figure(const RealSensorStudy& study) {
  return {.panels = {frame_panel(study, place_of(study, fourth)), frame_panel(study, place_of(study, seventh))},
          .columns = 2};
}

Figure sensor_error_figure(const RealSensorStudy& study) {
  return {.panels = {distribution_panel(study)}, .panel_height = 270};
}

// ---- tables and texts

double deepest(const RealSensorStudy& study) {
  double most = 0;
  for (const fem::ContactSolution& solution : study.solutions) most = std::max(most, solution.steps.back().indentation);
  return most;
}

nlohmann::ordered_json by_indenter_json(const RealSensorResult& result) {
  nlohmann::ordered_json json;
  for (std::size_t i = 0; i < real_indenters().size(); ++i) {
    const Spread s = of_indenter(result, static_cast<int>(i));
    json[real_indenters()[i].name] = {{"mean", s.median}, {"low", s.low}, {"high", s.high}};
  }
  return json;
}

/// How much of friction a frame of an indenter shows: the largest difference that it makes at 15 degrees to any tactel,
/// over the largest stress of all.
double friction_shows(const RealSensorStudy& study, std::uint16_t indenter) {
  const auto frame_of = [&](double position, double limit) {
    return study.ideal.frames.row(static_cast<Eigen::Index>(place_of(study, {indenter, position, limit, 15})));
  };
  float most = 0;
  for (double position : {-2.5, 0.0, 2.5})
    most = std::max(most, (frame_of(position, 25) - frame_of(position, 38)).cwiseAbs().maxCoeff());
  return static_cast<double>(most / study.ideal.largest_stress());
}

void report_by_indenter(Page& page, const RealSensorStudy& study) {
  PageTable table{
      .caption = "By indenter, on the 80 contacts outside the learning set: mean errors, median [5 %, 95 %]",
      .head = {"indenter", "effect of friction at 15°, of the largest stress"}};
  for (const RealSensorResult& result : study.results) table.head.push_back(text_of(result.what));
  const auto indenters = static_cast<std::uint16_t>(real_indenters().size());
  for (std::uint16_t i = 0; i < indenters; ++i) {
    std::vector<Cell> row{real_indenters()[i].name, fmt::format("{:.2f} %", 100 * friction_shows(study, i))};
    for (const RealSensorResult& result : study.results) row.push_back(text_of(of_indenter(result, i)));
    table.add(std::move(row));
  }
  page.table(table);
}

void report_errors_table(Page& page, const RealSensorStudy& study) {
  PageTable table{.caption = "25 examples: errors of S, median over draws and seeds [5 %, 95 %]",
                  .head = {"learning set", "scaled by", "learning: largest", "mean", "11 recalled: largest", "mean",
                           "all outside the learning set: mean"}};
  for (const RealSensorResult& result : study.results)
    table.add({name(result.what.data), nn::name(result.what.scaling), text_of(spread(result.learning, max_error)),
               text_of(spread(result.learning, mean_error)), text_of(spread(result.recalling, max_error)),
               text_of(spread(result.recalling, mean_error)), text_of(spread(result.unseen, mean_error))});
  const std::vector<double> by_angle = errors_by_angle_alone(study.contacts);
  const double of_all = nn::summarize(by_angle).mean;
  table.add({"the angle alone", "", "", "", text_of(spread(study.angle_alone, max_error)),
             text_of(spread(study.angle_alone, mean_error)), fmt::format("{:.3f}", of_all)});
  page.table(table);
}

void report_sensor_choices(Page& page, const RealSensorStudy& study) {
  const RealSensorChoice& choice = study.choice;
  page.paragraph(
      fmt::format("Seven indenters at three places are loaded at 0, 15 and 30 degrees with friction of 25 and 38 "
                  "degrees (30 only with 38): {} contacts. The paper used 36 of them and does not name these. Here {} "
                  "draws contain 25 learning contacts and 11 others to recall. The network {} is trained on each draw "
                  "from {} initial weights, by the rule of section V. S = tan θ / tan θ_L takes four values: 0, 0.343, "
                  "0.575 and 0.739.",
                  study.contacts.size(), study.options.draws, real_topology().text(), study.options.seeds));
  page.paragraph(fmt::format(
      "The paper prints neither force nor pitch. Each contact carries {} N/mm; normal and tangential force grow "
      "together. The sharpest edge goes {:.2f} mm deep, within 20 % of the thickness. The eight tactels of {} mm (two "
      "films of 1 mm) are {} mm apart.",
      choice.normal_force, deepest(study), choice.sensor.tactel_width,
      choice.sensor.span() / (choice.sensor.tactels - 1)));
  page.paragraph(fmt::format(
      "Records last {} s at {} Hz. The hand starts after 2 to 5 s, presses within 0.5 to 1.5 s, holds for 1 to 2 s and "
      "lifts; each time is random. The gains of the transducers spread by {:.0f} % and differ between draws. The "
      "charge "
      "amplifiers have a time constant of {} s; the converter has {} bits over ±{} MPa, with noise of {} MPa. The "
      "sample of a record is the one with the highest compression at any transducer.",
      choice.record.seconds, choice.record.rate, 100 * choice.chain.gain_spread, choice.chain.time_constant,
      choice.chain.bits, choice.chain.range, choice.chain.noise));
  std::size_t networks = 0;
  for (const RealSensorResult& result : study.results) networks += result.learning.size();
  page.paragraph(
      fmt::format("{} networks were trained in {:.0f} s, contacts and records included.", networks, study.seconds));
  page.note(
      "The paper gives the errors of this network in a part of its section VII that was not available. The report "
      "therefore contains no comparison with them.");
}

void report_sensor_verdict(Page& page, const RealSensorStudy& study) {
  const auto error_of = [&](RealData data) -> double {
    return spread(scaled_by_set(study, data).recalling, mean_error).median;
  };
  const double stresses = error_of(RealData::stresses), records = error_of(RealData::records),
               angle = spread(study.angle_alone, mean_error).median;
  page.finding(
      std::max(stresses, records) < angle ? Tone::good : Tone::fair, "section VI",
      fmt::format("The network of the real sensor has a mean recall error of {:.3f} on stresses and {:.3f} on "
                  "records; an estimator with a perfect force angle but no knowledge of friction has {:.3f}. The "
                  "paper's numbers were not available.",
                  stresses, records, angle));
}

nlohmann::ordered_json chain_json(const RealSensorChoice& choice) {
  const nn::Transducer& chain = choice.chain;
  return {{"gain_spread", chain.gain_spread},
          {"time_constant", chain.time_constant},
          {"noise", chain.noise},
          {"range", chain.range},
          {"bits", chain.bits},
          {"rate", choice.record.rate},
          {"seconds", choice.record.seconds}};
}

}  // namespace

nlohmann::ordered_json real_sensor_json(const RealSensorStudy& study) {
  nlohmann::ordered_json cases = nlohmann::ordered_json::array();
  for (const RealSensorResult& result : study.results) {
    cases.push_back({{"data", name(result.what.data)},
                     {"scaling", nn::name(result.what.scaling)},
                     {"examples", paper_examples},
                     {"networks", result.learning.size()},
                     {"learnt", result.learnt},
                     {"learning", errors_json(result.learning)},
                     {"recalling", errors_json(result.recalling)},
                     {"unseen", errors_json(result.unseen)},
                     {"unseen_by_indenter", by_indenter_json(result)}});
  }
  return {{"network", real_topology().text()},
          {"contacts", study.contacts.size()},
          {"recalled", paper_recalls},
          {"draws", study.options.draws},
          {"seeds", study.options.seeds},
          {"normal_force", study.choice.normal_force},
          {"deepest", deepest(study)},
          {"chain", chain_json(study.choice)},
          {"angle_alone", errors_json(study.angle_alone)},
          {"cases", std::move(cases)}};
}

void report_real_sensor(Page& page, const RealSensorStudy& study) {
  page.section("A network for the real sensor (section VI)");
  report_sensor_choices(page, study);
  report_sensor_verdict(page, study);
  page.figure(record_figure(study), "A record of the two films of a tactel, with the selected sample.");
  page.figure(
      frame_figure(study),
      "The two contacts of the paper's Fig. 7: stresses at the tactels (lines) and the selected sample (crosses).");
  report_errors_table(page, study);
  page.figure(sensor_error_figure(study),
              fmt::format("Errors of S over draws and initial weights; the networks of a draw are adjacent. Dashed: an "
                          "estimator with a perfect force angle but no knowledge of friction. {} draws.",
                          study.options.draws));
  report_by_indenter(page, study);
  page.note(
      "At 0 and 30 degrees S follows from the angle; at 15 degrees it is 0.343 or 0.575, depending on friction. Where "
      "normal and tangential force grow together below the friction angle, a smooth contact slips little or not at all "
      "(Mindlin and Deresiewicz 1953; Johnson 1985, section 7.3). Its frame then hardly depends on friction, as the "
      "second column of the table shows. The edges of flats slip, so their frames depend on friction.");
}

}  // namespace tactel::host
