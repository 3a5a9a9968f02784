#include "host/real_sensor_report.h"

#include <fmt/format.h>

#include <algorithm>

#include "host/inverse_problem_report.h"

namespace tactel::host {
namespace {

constexpr int figure_width = 900;  // pixels
constexpr Ink data_inks[] = {Ink::blue, Ink::orange};

using Reports = std::vector<nn::ErrorReport>;

double max_error(const nn::ErrorReport& r) { return r.all.max; }
double mean_error(const nn::ErrorReport& r) { return r.all.mean; }

std::string text_of(const Spread& s) { return fmt::format("{:.3f} [{:.3f}, {:.3f}]", s.median, s.low, s.high); }

std::vector<const RealSensorResult*> with_25(const RealSensorStudy& study) {
  std::vector<const RealSensorResult*> results;
  for (const RealSensorResult& result : study.results)
    if (result.what.examples == paper_examples) results.push_back(&result);
  return results;
}

/// One kind of data as the paper scales it, by the number of examples.
std::vector<const RealSensorResult*> by_examples(const RealSensorStudy& study, RealData data) {
  std::vector<const RealSensorResult*> results;
  for (const RealSensorResult& result : study.results)
    if (result.what.data == data && result.what.scaling == nn::ScalingKind::set) results.push_back(&result);
  std::ranges::sort(results, {}, [](const RealSensorResult* r) { return r->what.examples; });
  return results;
}

double deepest(const RealSensorStudy& study) {
  double most = 0;
  for (const fem::ContactSolution& solution : study.solutions) most = std::max(most, solution.steps.back().indentation);
  return most;
}

/// Mean error by indenter on the 80 contacts that were not learnt of 25: some of each indenter's 15 are among them.
Spread of_indenter(const RealSensorResult& result, int indenter) {
  return spread(result.unseen, [=](const nn::ErrorReport& r) { return r.by_class.at(indenter).mean; });
}

nlohmann::ordered_json by_indenter_json(const RealSensorResult& result) {
  nlohmann::ordered_json json;
  for (std::size_t i = 0; i < real_indenters().size(); ++i) {
    const Spread s = of_indenter(result, static_cast<int>(i));
    json[real_indenters()[i].name] = {{"mean", s.median}, {"low", s.low}, {"high", s.high}};
  }
  return json;
}

// ---- a record, and what is taken from it

/// The paper's Fig. 7: indenter 4 pushed at 15 degrees, and 7 without tangential load; here over the centre.
std::size_t contact_of(const RealSensorStudy& study, std::uint16_t indenter, double angle) {
  const auto found = std::ranges::find_if(study.contacts, [=](const RealContact& c) {
    return c.indenter == indenter && c.position == 0 && c.limit_angle == 38 && c.angle == angle;
  });
  return static_cast<std::size_t>(found - study.contacts.begin());
}

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
  for (std::size_t channel : {channels / 2 - 4, channels - 4}) {  // one over the centre, its two films
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

Figure record_figure(const RealSensorStudy& study) {
  return {.panels = {record_panel(study, contact_of(study, 3, 15))}, .width = figure_width, .panel_height = 260};
}

Figure frame_figure(const RealSensorStudy& study) {
  return {.panels = {frame_panel(study, contact_of(study, 3, 15)), frame_panel(study, contact_of(study, 6, 0))},
          .columns = 2,
          .width = figure_width};
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
  Panel panel{.title = "by indenter, all that were not learnt", .y_label = "mean error of S"};
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
      .title = "fewer and more examples, 11 recalled", .x_label = "examples learnt", .y_label = "mean error of S"};
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

Figure error_figure(const RealSensorStudy& study) {
  return {.panels = {distribution_panel(study), examples_panel(study), indenter_panel(study)},
          .columns = 1,
          .width = figure_width,
          .panel_height = 270};
}

/// How much of friction a frame of an indenter shows: the largest difference that it makes at 15 degrees to any tactel,
/// over the largest stress of all.
double friction_shows(const RealSensorStudy& study, std::uint16_t indenter) {
  const auto frame_of = [&](double position, double limit) {
    const auto found = std::ranges::find_if(study.contacts, [=](const RealContact& c) {
      return c.indenter == indenter && c.position == position && c.limit_angle == limit && c.angle == 15;
    });
    return study.ideal.frames.row(found - study.contacts.begin());
  };
  float most = 0;
  for (double position : {-2.5, 0.0, 2.5})
    most = std::max(most, (frame_of(position, 25) - frame_of(position, 38)).cwiseAbs().maxCoeff());
  return static_cast<double>(most / study.ideal.largest_stress());
}

void report_by_indenter(ReportPage& page, const RealSensorStudy& study) {
  ReportTable table{.caption = "By indenter, on the 80 contacts that were not learnt: mean errors, median [5 %, 95 %]",
                    .head = {"indenter", "friction shows at 15°, of the largest stress"}};
  for (const RealSensorResult* result : with_25(study))
    table.head.push_back(fmt::format("{}, by {}", name(result->what.data), nn::name(result->what.scaling)));
  for (std::uint16_t i = 0; i < real_indenters().size(); ++i) {
    std::vector<std::string> row{real_indenters()[i].name, fmt::format("{:.2f} %", 100 * friction_shows(study, i))};
    for (const RealSensorResult* result : with_25(study)) row.push_back(text_of(of_indenter(*result, i)));
    table.rows.push_back(std::move(row));
  }
  page.table(table);
}

void report_errors_table(ReportPage& page, const RealSensorStudy& study) {
  ReportTable table{.caption = "25 examples: errors of S, median over draws and seeds [5 %, 95 %]",
                    .head = {"learnt from", "scaled by", "learning: largest", "mean", "11 recalled: largest", "mean",
                             "all not learnt: mean"}};
  for (const RealSensorResult* result : with_25(study))
    table.rows.push_back({name(result->what.data), nn::name(result->what.scaling),
                          text_of(spread(result->learning, max_error)), text_of(spread(result->learning, mean_error)),
                          text_of(spread(result->recalling, max_error)), text_of(spread(result->recalling, mean_error)),
                          text_of(spread(result->unseen, mean_error))});
  const std::vector<double> by_angle = errors_by_angle_alone(study.contacts);
  const double of_all = nn::summarize(by_angle).mean;
  table.rows.push_back({"the angle alone", "", "", "", text_of(spread(study.angle_alone, max_error)),
                        text_of(spread(study.angle_alone, mean_error)), fmt::format("{:.3f}", of_all)});
  page.table(table);
}

void report_choices(ReportPage& page, const RealSensorStudy& study) {
  const RealSensorChoice& choice = study.choice;
  page.paragraph(fmt::format(
      "Seven indenters at three places, pushed at 0, 15 and 30 degrees with friction of 25 and 38 degrees (30 only "
      "with "
      "38): {} contacts, of which the paper took 36 and does not say which. Here {} draws of 25 to learn and 11 others "
      "to "
      "recall, each learnt by a network {} from {} initial weights, by the rule of section V. S = tan θ / tan θ_L "
      "takes four values: 0, 0.343, 0.575 and 0.739.",
      study.contacts.size(), study.options.draws, real_topology().text(), study.options.seeds));
  page.paragraph(fmt::format(
      "The paper prints neither force nor pitch. All contacts carry {} N/mm, normal and tangential force growing "
      "together; the sharpest edge goes {:.2f} mm deep, within 20 % of the thickness. Eight tactels of {} mm (two "
      "shavings of film of 1 mm) stand {} mm apart.",
      choice.normal_force, deepest(study), choice.sensor.tactel_width,
      choice.sensor.span() / (choice.sensor.tactels - 1)));
  page.paragraph(fmt::format(
      "Records last {} s at {} Hz. The hand begins after 2 to 5 s, presses within 0.5 to 1.5 s, holds for 1 to 2 s and "
      "lifts, each drawn anew. The transducers' gains spread by {:.0f} %, others for each draw; charge amplifiers "
      "forget "
      "within {} s; {} bits over ±{} MPa, with noise of {} MPa. Of each record the sample is taken in which any one "
      "transducer reads the highest compression.",
      choice.record.seconds, choice.record.rate, 100 * choice.chain.gain_spread, choice.chain.time_constant,
      choice.chain.bits, choice.chain.range, choice.chain.noise));
  std::size_t networks = 0;
  for (const RealSensorResult& result : study.results) networks += result.learning.size();
  page.paragraph(
      fmt::format("{} networks learnt in {:.0f} s, contacts and records included.", networks, study.seconds));
  page.note(
      "The paper gives the errors of this network in a part of its section VII that this report had no copy of: no "
      "figure of it stands beside ours.");
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

void report_real_sensor(ReportPage& page, const RealSensorStudy& study) {
  page.section("A network for the real sensor (section VI)");
  report_choices(page, study);
  page.figure(record_figure(study), "A record of the two films of a tactel, with the sample that is taken.");
  page.figure(frame_figure(study),
              "The two contacts of the paper's Fig. 7: what the tactels feel (lines) and the sample taken (crosses).");
  report_errors_table(page, study);
  page.figure(
      error_figure(study),
      fmt::format("Errors of S over draws and initial weights; the networks of a draw stand together. Dashed: "
                  "who reads the angle of the force perfectly and knows nothing of friction. {} draws above, the "
                  "first {} of them in the middle.",
                  study.options.draws, study.options.other_draws));
  report_by_indenter(page, study);
  page.note(
      "Of contacts at 0 and 30 degrees S follows from the angle; of those at 15 it is 0.343 or 0.575, as friction is. "
      "Where normal and tangential force grow together below the friction angle, a smooth contact slips little or not "
      "at "
      "all (Mindlin and Deresiewicz 1953; Johnson 1985, section 7.3), so that its frame is the same whatever the "
      "friction: what the table's second column says. The edges of flats slip and show it.");
}

}  // namespace tactel::host
