// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "host/commands/command.h"
#include "host/studies/tradeoff/paper_labels.h"
#include "host/studies/tradeoff/tradeoff_report.h"
#include "host/support/durable_file.h"
#include "host/support/errors.h"
#include "host/support/interrupt.h"
#include "host/support/json_text.h"
#include "host/support/progress_line.h"

namespace tactel::host {
namespace {

struct TradeoffRequest {
  std::string output = "tradeoff", device, planner_source, html;
  std::size_t scenes = 288, verify = 0;
  std::uint64_t seed = 1998;
  std::vector<double> accuracies = {0.1, 0.05, 0.02, 0.01};
  bool labels = false, quiet = false;
};

std::filesystem::path output_directory(const TradeoffRequest& request) {
  std::error_code error;
  std::filesystem::create_directories(request.output, error);
  if (error)
    throw ConfigError("command line", "--output", request.output,
                      "a directory that can be made (" + error.message() + ")");
  check_writable("--output", std::filesystem::path(request.output) / "tradeoff.json");
  return request.output;
}

int measure(const TradeoffRequest& request, Executor& executor, const TradeoffOptions& options, ProgressLine& line) {
  const std::filesystem::path directory = output_directory(request);
  if (!request.html.empty()) check_writable("--html", request.html);
  const Tradeoff tradeoff = measure_tradeoff(executor, options);
  line.clear();
  write_file("--output", directory / "tradeoff.json", json_text(to_json(tradeoff)));
  const std::string page = tradeoff_page(tradeoff);
  write_file("--output", directory / "index.html", page);
  if (!request.html.empty()) write_file("--html", request.html, page);
  write_figure("--output", directory / "tradeoff.svg", tradeoff_figure(tradeoff));
  write_figure("--output", directory / "sources.svg", sources_figure(tradeoff));
  if (!request.planner_source.empty())
    write_file("--planner-source", request.planner_source,
               planner_source(tradeoff, fmt::format("tactel tradeoff --scenes {} --seed {} --planner-source FILE",
                                                    request.scenes, request.seed)));
  fmt::print("{}", tradeoff_table(tradeoff));
  if (!request.quiet)
    fmt::print("report: {}\n", std::filesystem::absolute(directory / "index.html").lexically_normal().string());
  return done;
}

/// Done if the promise holds in 95 % of the scenes at every accuracy.
int verify(const TradeoffRequest& request, Executor& executor, const TradeoffOptions& options, ProgressLine& line) {
  const std::filesystem::path directory = output_directory(request);
  const auto promises = verify_planner(executor, options, request.accuracies);
  line.clear();
  write_file("--output", directory / "promises.json", json_text(to_json(promises)));
  fmt::print("{}", promise_table(promises));
  const bool held = std::ranges::all_of(promises, [](const Promise& p) {
    const bool one_class = p.what != "the mix" && !p.what.starts_with("all");
    return one_class || static_cast<double>(p.kept) >= 0.95 * static_cast<double>(p.scenes);
  });
  return held ? done : not_converged;
}

int judge_labels(const TradeoffRequest& request, Executor& executor, const TradeoffOptions& options,
                 ProgressLine& line) {
  const std::filesystem::path directory = output_directory(request);
  const PaperLabels labels = measure_paper_labels(
      executor, [&](std::size_t done, std::size_t total) { return options.progress("", done, total); });
  line.clear();
  write_file("--output", directory / "labels.json", json_text(to_json(labels)));
  write_figure("--output", directory / "labels.svg", labels_figure(labels));
  fmt::print("{}", labels_table(labels));
  return done;
}

int run_tradeoff(const TradeoffRequest& request) {
  Executor executor{Device(request.device)};
  ProgressLine line("tradeoff", "models", request.quiet);
  const Interrupt interrupt;
  // Scenes that the planner was measured on prove nothing: another seed.
  TradeoffOptions options{.scenes = request.verify ? request.verify : request.scenes,
                          .seed = request.verify ? request.seed + 1 : request.seed};
  options.progress = [&](const std::string&, std::size_t done, std::size_t total) {
    line.show(done, total);
    return !interrupt.requested();
  };
  if (request.labels) return judge_labels(request, executor, options, line);
  return request.verify ? verify(request, executor, options, line) : measure(request, executor, options, line);
}

}  // namespace

void add_tradeoff_command(CLI::App& app, Action& action) {
  auto request = std::make_shared<TradeoffRequest>();
  CLI::App* command = app.add_subcommand("tradeoff", "measure error against speed over the ladder of models");
  command->group("Verify");
  command->add_option("--output", request->output, "directory of report, JSON and plots")
      ->type_name("DIR")
      ->capture_default_str();
  command->add_option("--html", request->html, "write the report to this file, too")->type_name("FILE.html");
  command
      ->add_option("--scenes", request->scenes,
                   "contacts of the mix that patches are judged on; meshes are on a third of them")
      ->check(CLI::Range(8, 100000))
      ->capture_default_str();
  command->add_option("--seed", request->seed, "seed of the mix")->capture_default_str();
  command
      ->add_option(
          "--verify", request->verify,
          "instead: judge the planner on N contacts of another seed, and on N unlike the mix; exit code 4 where it "
          "keeps the accuracy in fewer than 95 %")
      ->type_name("N")
      ->check(CLI::Range(1, 100000));
  command
      ->add_flag("--labels", request->labels,
                 "instead: judge the labels of the paper's learning and recall sets, as its mesh gives them")
      ->excludes("--verify");
  command
      ->add_option("--accuracy", request->accuracies,
                   "errors in S that --verify requests (default: 0.1, 0.05, 0.02, 0.01)")
      ->check(CLI::PositiveNumber);
  command
      ->add_option("--planner-source", request->planner_source,
                   "also write the measurements of the planner, as host/contact/measured_ladder.cpp")
      ->type_name("FILE");
  command->add_option("--device", request->device, "OpenCL device: a part of its name or its index")
      ->type_name("NAME|INDEX");
  command->add_flag("--quiet", request->quiet, "no progress on stderr");
  command->callback([request, &action] { action = [request] { return run_tradeoff(*request); }; });
}

}  // namespace tactel::host
