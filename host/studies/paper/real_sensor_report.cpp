// SPDX-License-Identifier: Apache-2.0
#include "host/studies/paper/real_sensor_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "host/studies/paper/inverse_problem_report.h"
#include "host/studies/paper/real_sensor_figures.h"

namespace tactel::host {
namespace {

using Reports = std::vector<nn::ErrorReport>;

std::string spread_text(const Spread& s) { return fmt::format("{:.3f} [{:.3f}, {:.3f}]", s.median, s.low, s.high); }

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
  for (const RealSensorResult* result : with_25(study))
    table.head.push_back(fmt::format("{}, by {}", name(result->what.data), nn::name(result->what.scaling)));
  for (std::uint16_t i = 0; i < real_indenters().size(); ++i) {
    std::vector<Cell> row{real_indenters()[i].name, fmt::format("{:.2f} %", 100 * friction_shows(study, i))};
    for (const RealSensorResult* result : with_25(study)) row.push_back(spread_text(of_indenter(*result, i)));
    table.add(std::move(row));
  }
  page.table(table);
}

void report_errors_table(Page& page, const RealSensorStudy& study) {
  PageTable table{.caption = "25 examples: errors of S, median over draws and seeds [5 %, 95 %]",
                  .head = {"learning set", "scaled by", "learning: largest", "mean", "11 recalled: largest", "mean",
                           "all outside the learning set: mean"}};
  for (const RealSensorResult* result : with_25(study))
    table.add({name(result->what.data), nn::name(result->what.scaling),
               spread_text(spread(result->learning, max_error)), spread_text(spread(result->learning, mean_error)),
               spread_text(spread(result->recalling, max_error)), spread_text(spread(result->recalling, mean_error)),
               spread_text(spread(result->unseen, mean_error))});
  const std::vector<double> by_angle = errors_by_angle_alone(study.contacts);
  const double of_all = nn::summarize(by_angle).mean;
  table.add({"the angle alone", "", "", "", spread_text(spread(study.angle_alone, max_error)),
             spread_text(spread(study.angle_alone, mean_error)), fmt::format("{:.3f}", of_all)});
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
    for (const RealSensorResult* result : with_25(study))
      if (result->what.data == data && result->what.scaling == nn::ScalingKind::set)
        return spread(result->recalling, mean_error).median;
    return NAN;
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
                     {"examples", result.what.examples},
                     {"networks", result.learning.size()},
                     {"learnt", result.learnt},
                     {"learning", errors_json(result.learning)},
                     {"recalling", errors_json(result.recalling)},
                     {"unseen", errors_json(result.unseen)}});
    if (result.what.examples == paper_examples) cases.back()["unseen_by_indenter"] = by_indenter_json(result);
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
  page.figure(
      error_figure(study),
      fmt::format("Errors of S over draws and initial weights; the networks of a draw are adjacent. Dashed: an "
                  "estimator with a perfect force angle but no knowledge of friction. The upper panel has {} draws, "
                  "the middle one the first {} of them.",
                  study.options.draws, study.options.other_draws));
  report_by_indenter(page, study);
  page.note(
      "At 0 and 30 degrees S follows from the angle; at 15 degrees it is 0.343 or 0.575, depending on friction. Where "
      "normal and tangential force grow together below the friction angle, a smooth contact slips little or not at all "
      "(Mindlin and Deresiewicz 1953; Johnson 1985, section 7.3). Its frame then hardly depends on friction, as the "
      "second column of the table shows. The edges of flats slip, so their frames depend on friction.");
}

}  // namespace tactel::host
