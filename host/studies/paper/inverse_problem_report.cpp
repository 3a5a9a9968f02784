// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "host/figures/error_panels.h"
#include "host/studies/paper/inverse_baselines.h"
#include "host/studies/paper/inverse_problem.h"

namespace tactel::host {
namespace {

constexpr double large_error = 0.1;  // the paper looked at the examples above it (section V.E)

std::vector<const NetworkStudy*> with_noise(const InverseProblem& problem, bool noisy) {
  std::vector<const NetworkStudy*> chosen;
  for (const NetworkStudy& study : problem.studies)
    if ((study.noise != 0) == noisy) chosen.push_back(&study);
  return chosen;
}

// ---- Table II

std::string network_name(const NetworkStudy& study) {
  return fmt::format("{} ({})", study.number, study.topology.text());
}

const nn::ErrorSummary& of_paper(const NetworkStudy& study, bool learning) {
  const TableTwoRow& row = paper_table_two(study.number);
  return learning ? row.learning : row.recalling;
}

const Reports& reports_of(const NetworkStudy& study, bool learning) {
  return learning ? study.learning : study.recalling;
}

/// Median of the mean errors over seeds, over the paper's.
double mean_over_paper(const NetworkStudy& study, bool learning) {
  return spread(reports_of(study, learning), mean_error).median / of_paper(study, learning).mean;
}

void report_table_two_without_noise(Page& page, const InverseProblem& problem, bool learning) {
  PageTable table{.caption = fmt::format("Table II of the paper, {}, without noise: median over seeds [5 %, 95 %], the "
                                         "paper's number and the difference of the median from it",
                                         learning ? "learning" : "recalling"),
                  .head = {"network", "largest error", "paper", "difference", "mean error", "paper", "difference",
                           "standard deviation", "paper", "difference"}};
  for (const NetworkStudy* study : with_noise(problem, false)) {
    std::vector<Cell> cells{network_name(*study)};
    const auto add = [&](double (*error)(const nn::ErrorReport&), double paper, int digits) {
      const Spread s = spread(reports_of(*study, learning), error);
      cells.push_back(text_of(s, digits));
      cells.push_back(fmt::format("{:.{}f}", paper, digits));
      cells.push_back(difference_cell(s.median, paper, true));
    };
    const nn::ErrorSummary& paper = of_paper(*study, learning);
    add(max_error, paper.max, 3), add(mean_error, paper.mean, 4), add(std_error, paper.std, 4);
    table.add(std::move(cells));
  }
  page.table(table);
}

void report_table_two_with_noise(Page& page, const InverseProblem& problem) {
  PageTable table{.caption =
                      "The same with 10 % noise in the learning sets: median over seeds [5 %, 95 %]. The paper "
                      "does not state which of its rows have noise",
                  .head = {"network", "learning: largest error", "mean error", "standard deviation",
                           "recalling: largest error", "mean error", "standard deviation"}};
  for (const NetworkStudy* study : with_noise(problem, true)) {
    std::vector<Cell> cells{network_name(*study)};
    for (bool learning : {true, false}) {
      const Reports& reports = reports_of(*study, learning);
      cells.push_back(text_of(spread(reports, max_error), 3));
      cells.push_back(text_of(spread(reports, mean_error), 4));
      cells.push_back(text_of(spread(reports, std_error), 4));
    }
    table.add(std::move(cells));
  }
  page.table(table);
}

/// Smallest and largest ratio of the median mean errors to the paper's, over the six networks without noise.
std::pair<double, double> over_paper(const InverseProblem& problem, bool learning) {
  std::pair<double, double> range{INFINITY, 0};
  for (const NetworkStudy* study : with_noise(problem, false)) {
    const double ratio = mean_over_paper(*study, learning);
    range = {std::min(range.first, ratio), std::max(range.second, ratio)};
  }
  return range;
}

/// Favourable and unfavourable numbers together.
void report_verdict(Page& page, const InverseProblem& problem) {
  const auto clean = with_noise(problem, false);
  const auto below =
      std::ranges::count_if(clean, [](const auto* study) { return mean_over_paper(*study, false) <= 1; });
  std::size_t seeds_below = 0, all = 0;
  for (const NetworkStudy* study : clean)
    for (const nn::ErrorReport& report : study->recalling)
      seeds_below += report.all.mean <= of_paper(*study, false).mean, ++all;
  const auto [recall_low, recall_high] = over_paper(problem, false);
  const auto [learn_low, learn_high] = over_paper(problem, true);
  page.verdict(
      fmt::format("The networks recall as well as the paper's or better in {} of 6 cases, but their errors on "
                  "their own learning set are {:.1f} to {:.1f} times the paper's.",
                  below, learn_low, learn_high));
  page.finding(
      below == 6   ? Tone::good
      : below >= 3 ? Tone::fair
                   : Tone::poor,
      "recalling",
      fmt::format("Mean errors are {:.2f} to {:.2f} times the paper's (medians over {} seeds, without noise); {} "
                  "of {} single trainings are at or below the paper's.",
                  recall_low, recall_high, clean.front()->recalling.size(), seeds_below, all));
  page.finding(
      learn_high <= 1.1   ? Tone::good
      : learn_high <= 1.5 ? Tone::fair
                          : Tone::poor,
      "learning",
      fmt::format("Mean errors are {:.1f} to {:.1f} times the paper's: the learning sets differ, for the paper "
                  "does not state its shapes' units, its friction or its seeds.",
                  learn_low, learn_high));
}

// ---- frame by frame

Figure predicted_figure(const InverseProblem& problem) {
  Figure figure{.columns = 3, .panel_height = 300};
  const nn::Vector<double> truth = problem.sets.recall.slip_index.cast<double>();
  for (const NetworkStudy* study : with_noise(problem, false))
    figure.panels.push_back(predicted_panel(std::span(truth.data(), static_cast<std::size_t>(truth.size())),
                                            study->slip_index, "network " + network_name(*study)));
  return figure;
}

Figure error_distribution_figure(const InverseProblem& problem) {
  constexpr double most = 0.25;
  Figure figure{.columns = 3, .panel_height = 250};
  for (const NetworkStudy* study : with_noise(problem, false)) {
    std::vector<double> errors;
    for (const auto& of_seed : study->recall_errors) errors.insert(errors.end(), of_seed.begin(), of_seed.end());
    figure.panels.push_back(error_histogram(errors, most, "network " + network_name(*study),
                                            {{"mean", nn::summarize(errors).mean, Ink::black},
                                             {"mean in the paper", of_paper(*study, false).mean, Ink::red}}));
  }
  return figure;
}

// ---- distributions over seeds

Panel distribution(const InverseProblem& problem, bool noisy, bool learning, const std::string& title) {
  Series seeds{.label = "one seed", .mark = Mark::dots, .ink = Ink::grey};
  Series median{.label = "median, 5 to 95 %", .mark = Mark::whiskers, .ink = Ink::blue};
  Series paper{.label = "the paper", .mark = Mark::diamonds, .ink = Ink::red};
  for (const NetworkStudy* study : with_noise(problem, noisy)) {
    const Reports& reports = reports_of(*study, learning);
    add_networks(seeds, median, study->number, 0.5, reports);
    paper.x.push_back(study->number), paper.y.push_back(of_paper(*study, learning).mean);
  }
  Panel panel{.title = title,
              .x_label = "network",
              .y_label = "mean error of S",
              .series = {seeds, median},
              .x_range = std::pair{0.4, 6.6},
              .log_y = true};
  if (!noisy) panel.series.push_back(paper);
  for (int number = 1; number <= 6; ++number) panel.x_ticks.push_back({number, std::to_string(number)});
  return panel;
}

Figure distribution_figure(const InverseProblem& problem) {
  return {.panels = {distribution(problem, false, true, "learning, without noise"),
                     distribution(problem, false, false, "recalling, without noise"),
                     distribution(problem, true, true, "learning, 10 % noise"),
                     distribution(problem, true, false, "recalling, 10 % noise")},
          .columns = 2,
          .panel_height = 340};
}

// ---- which examples go wrong

double percent(std::size_t part, std::size_t all) { return 100 * static_cast<double>(part) / static_cast<double>(all); }

/// Of the recall rows with a large error, over all seeds: how many are of which class, near slipping, on few nodes.
void report_large_errors(Page& page, const InverseProblem& problem) {
  const nn::FrameSet& recall = problem.sets.recall;
  std::vector<std::size_t> by_class(problem.sets.class_names.size()), rows_of_class(by_class.size());
  std::size_t large = 0, near_slip = 0, all = 0;
  for (const NetworkStudy* study : with_noise(problem, false)) {
    for (const auto& errors : study->recall_errors) {
      for (std::size_t row = 0; row < errors.size(); ++row) {
        ++all;
        if (!(errors[row] > large_error)) continue;
        ++large, ++by_class[recall.shape_class[row]];
        near_slip += recall.slip_index(static_cast<Eigen::Index>(row)) > 0.8;
      }
    }
  }
  for (const std::uint16_t kind : recall.shape_class) ++rows_of_class[kind];
  PageTable table{.caption = "Errors above 0.1 by class, networks without noise, all seeds",
                  .head = {"class", "rows of the recall set", "share of all errors above 0.1"}};
  for (std::size_t kind = 0; kind < by_class.size(); ++kind)
    table.add({problem.sets.class_names[kind], std::to_string(rows_of_class[kind]),
               large ? fmt::format("{:.1f} %", percent(by_class[kind], large)) : "-"});
  page.paragraph(fmt::format(
      "The paper found that all examples with an error over 10 % were sharp indenters near slipping. Here {:.2f} % of "
      "all recalled rows err by more; of these, {:.0f} % have S above 0.8.",
      percent(large, all), large ? percent(near_slip, large) : 0));
  page.table(table);
}

// ---- noise, and what the paper leaves open

void report_noise(Page& page, const InverseProblem& problem) {
  PageTable table{.caption = "Mean recall error, by noise of the learning set and of the recall set",
                  .head = {"network", "trained without, recalled without", "trained without, recalled with",
                           "trained with, recalled without", "trained with, recalled with"}};
  const auto clean = with_noise(problem, false), noisy = with_noise(problem, true);
  for (std::size_t i = 0; i < clean.size(); ++i) {
    std::vector<Cell> row{network_name(*clean[i])};
    for (const NetworkStudy* study : {clean[i], noisy[i]})
      for (const Reports* reports : {&study->recalling, &study->recalling_noisy})
        row.push_back(fmt::format("{:.3f}", spread(*reports, mean_error).median));
    table.add(std::move(row));
  }
  page.table(table);
}

void report_fresh_noise(Page& page, const InverseProblem& problem) {
  PageTable table{.caption =
                      "Mean recall error with noise of 10 % of each frame's own largest stress, drawn anew at each "
                      "showing: median over seeds [5 %, 95 %]",
                  .head = {"network", "recalled without noise", "recalled with such noise", "the paper, recalling"}};
  for (const FreshNoiseStudy& study : problem.fresh_noise)
    table.add({fmt::format("{} ({})", study.number, study.topology.text()),
               text_of(spread(study.recalling, mean_error), 4), text_of(spread(study.recalling_noisy, mean_error), 4),
               fmt::format("{:.4f}", paper_table_two(study.number).recalling.mean)});
  page.table(table);
  page.note(
      "Each network is shown up to 400 copies of the learning set, each with noise of its own, and then the same "
      "copies "
      "again. The paper states neither whether its noise was drawn once, nor of which stress it is 10 %. The two "
      "tables "
      "are the two readings; the second is nearer the paper's numbers.");
}

std::uint32_t most_cycles(const std::vector<const NetworkStudy*>& studies) {
  std::uint32_t most = 0;
  for (const NetworkStudy* study : studies)
    for (const TrainedNetwork& network : study->networks) most = std::max(most, network.cycles);
  return most;
}

/// Number of seeds from which the quantiles of Table II are meaningful.
constexpr std::size_t enough_seeds = 100;

void report_seeds(Page& page, const InverseProblem& problem) {
  const std::size_t seeds = problem.studies.front().networks.size();
  std::string text = fmt::format("Each network below is trained from {} seed{}.", seeds, seeds == 1 ? "" : "s");
  if (seeds < enough_seeds)
    text += fmt::format(" `tactel reproduce --seeds {}` gives the full statistics.", enough_seeds);
  page.note(text);
}

void report_network_choices(Page& page, const InverseProblem& problem, const InverseChoice& choice) {
  const nn::FrameSet &learning = problem.sets.learning, &recall = problem.sets.recall;
  page.paragraph(fmt::format(
      "32 Taylor shapes, all sums of x ... x^5, are pressed {} mm into the sensor of the preset `paper` and dragged by "
      "{} mm a step until the whole contact slides: {} rows to learn from, and {} of 7 x 4 common shapes to recall. "
      "The paper gives no units; with x and y in centimetres its sums apply unchanged. In millimetres every sum that "
      "contains x touches one or two nodes. Friction is {}, the preset's.",
      choice.base.load.indentation.front(), choice.base.load.tangential_step, learning.rows(), recall.rows(),
      choice.base.friction));
  page.paragraph(fmt::format(
      "The rule is the paper's: pattern by pattern, learning rate {}, momentum {}, at most 10 000 cycles (15 000 for "
      "networks 4 to 6), stopped when no error of a cycle reaches {}. Inputs are divided by the learning set's largest "
      "stress. Each network is trained from {} initial weights, without noise and with Gaussian noise of 10 % of the "
      "largest stress, drawn once for each seed (at most {} cycles, after which the networks fit the noise): {:.3g} "
      "pattern updates in {:.0f} s ({:.2f} million per second).",
      choice.options.rate, choice.options.momentum, choice.options.stop_error, problem.studies.front().networks.size(),
      most_cycles(with_noise(problem, true)), problem.patterns, problem.seconds,
      problem.patterns / problem.seconds / 1e6));
}

}  // namespace

nlohmann::ordered_json table_two_json(const InverseProblem& problem) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const NetworkStudy& study : problem.studies)
    json.push_back({{"network", study.number},
                    {"topology", study.topology.text()},
                    {"noise", study.noise},
                    {"seeds", study.networks.size()},
                    {"learning", errors_json(study.learning)},
                    {"recalling", errors_json(study.recalling)},
                    {"recalling_noisy", errors_json(study.recalling_noisy)}});
  return json;
}

void report_inverse_problem(Page& page, const InverseProblem& problem, const InverseChoice& choice,
                            const InverseBaselines& baselines) {
  page.section("The inverse problem (section V)");
  report_seeds(page, problem);
  report_network_choices(page, problem, choice);
  report_verdict(page, problem);
  for (bool learning : {true, false}) report_table_two_without_noise(page, problem, learning);
  report_table_two_with_noise(page, problem);
  page.figure(predicted_figure(problem),
              "Predicted over true slippage index on the recall set: for each network the seed with the median mean "
              "error, trained without noise. A dot is a load step of a contact.");
  page.figure(
      error_distribution_figure(problem),
      "How the errors on the recall set are spread: all seeds together, trained without noise. Lines: the mean, "
      "and the mean that the paper gives.");
  page.figure(
      distribution_figure(problem),
      "Mean errors of every training. The paper's six rows are one training each; it does not state with which noise.");

  page.section("Without a network");
  report_baselines(page, baselines, problem);

  page.section("Difficult shapes");
  report_large_errors(page, problem);

  page.section("Noise");
  report_noise(page, problem);
  page.note(
      "Noise of 10 % of the largest stress of the set is as large as the whole stress of a blunt contact. In this "
      "table "
      "it is drawn once, as in the paper's noise-added learning sets; the networks fit it within a thousand cycles.");
  report_fresh_noise(page, problem);
}

}  // namespace tactel::host
