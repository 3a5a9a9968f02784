// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>

#include "host/commands/add_option.h"
#include "host/commands/command.h"
#include "host/commands/shared_options.h"
#include "host/networks/onnx_file.h"
#include "host/studies/paper/direct_problem.h"
#include "host/studies/paper/inverse_baselines.h"
#include "host/studies/paper/inverse_problem.h"
#include "host/studies/paper/real_sensor_study.h"
#include "host/support/durable_file.h"
#include "host/support/errors.h"
#include "host/support/interrupt.h"
#include "host/support/json_text.h"
#include "host/support/progress_line.h"
#include "host/support/terminal.h"

namespace tactel::host {
namespace {

struct ReproduceRequest {
  std::string output = "report", device;
  std::size_t seeds = 10;
  int cycles = 0, noise_cycles = enough_noise_cycles;
  bool quiet = false, force = false;

  std::filesystem::path checkpoint(double noise) const {
    return std::filesystem::path(output) / fmt::format("networks-{}.checkpoint", noise);
  }
  std::filesystem::path fresh_noise_checkpoint() const {
    return std::filesystem::path(output) / "networks-fresh-noise.checkpoint";
  }
};

void remove_checkpoints(const ReproduceRequest& request) {
  for (double noise : {0.0, paper_noise}) std::filesystem::remove(request.checkpoint(noise));
  std::filesystem::remove(request.fresh_noise_checkpoint());
}

/// Checks the checkpoints of both noise levels before hours of work on the first.
void expect_own_checkpoints(const ReproduceRequest& request, Executor& executor, const InverseChoice& clean,
                            const InverseChoice& noisy, const InverseSets& sets) try {
  expect_own_checkpoint(executor, clean, 0, request.seeds, sets, request.checkpoint(0));
  expect_own_checkpoint(executor, noisy, paper_noise, request.seeds, sets, request.checkpoint(paper_noise));
  expect_own_fresh_noise_checkpoint(executor, noisy, request.seeds, sets, request.fresh_noise_checkpoint());
} catch (const ConfigError& error) {
  throw ConfigError(
      error.file, error.key, error.value,
      "of this training: its --seeds, --cycles, --noise-cycles and device continue it; --force trains anew, "
      "another --output keeps it");
}

/// Calls train(options), with progress and checkpoint. False when Ctrl-C stopped it.
bool train_networks(const ReproduceRequest& request, const std::string& what, const std::filesystem::path& checkpoint,
                    const std::function<bool(const TrainingRunOptions&)>& train) {
  const Interrupt interrupt;
  ProgressLine line(fmt::format("Table II: networks {}, {} seeds each", what, request.seeds), "weight updates",
                    request.quiet);
  const auto progress = [&](std::size_t done, std::size_t total) {
    line.show(done, total);
    return !interrupt.requested();
  };
  const bool finished = train({.progress = progress, .checkpoint = checkpoint});
  line.clear();
  if (!finished) fmt::print(stderr, "stopped; the same command continues from {}\n", checkpoint.string());
  return finished;
}

/// Section VI. False when Ctrl-C stopped it.
bool reproduce_real_sensor(const ReproduceRequest& request, Executor& executor, Page& page) {
  const Interrupt interrupt;
  ProgressLine line("section VI: networks of the real sensor", "networks", request.quiet);
  RealSensorOptions options;
  options.training.cycle_limit = request.cycles;
  options.seeds = std::min(options.seeds, request.seeds);
  options.progress = [&](std::size_t done, std::size_t total) {
    line.show(done, total);
    return !interrupt.requested();
  };
  const auto study = study_real_sensor(executor, real_sensor_choice(), options);
  line.clear();
  if (!study) {
    fmt::print(stderr, "stopped; the same command continues after the networks of section V\n");
    return false;
  }
  report_real_sensor(page, *study);
  write_file("--output", std::filesystem::path(request.output) / "section6.json", json_text(real_sensor_json(*study)));
  return true;
}

/// Writes the sets and the networks of Table II: learning.h5, recall.h5, networks/*.onnx.
void keep_networks(const std::filesystem::path& directory, const InverseProblem& problem) {
  write_contact_set(directory / "learning.h5", problem.sets.learning_contacts);
  write_contact_set(directory / "recall.h5", problem.sets.recall_contacts);
  make_folder("--output", directory / "networks");
  for (const NetworkStudy& study : problem.studies)
    for (std::size_t i = 0; i < study.models.size(); ++i)
      if (study.networks[i].status != nn::TrainStatus::not_finite)
        write_onnx(directory / "networks" / network_file_name(study.topology, study.noise, study.networks[i].seed),
                   study.models[i]);
}

/// Section V. False when Ctrl-C stopped it.
bool reproduce_networks(const ReproduceRequest& request, Executor& executor, Executor& learning, Page& page) {
  const std::filesystem::path directory = request.output;
  InverseChoice choice = inverse_choice();
  choice.options.cycle_limit = request.cycles;
  InverseChoice noisy = choice;
  if (request.cycles == 0) noisy.options.cycle_limit = request.noise_cycles;
  InverseProblem problem;
  {
    const StageLine stage("learning and recall sets of section V", request.quiet);
    problem.sets = simulate_sets(executor, choice);
  }
  if (request.force) remove_checkpoints(request);
  expect_own_checkpoints(request, learning, choice, noisy, problem.sets);
  const auto train = [&](const InverseChoice& with, double noise, const std::string& what) {
    return train_networks(request, what, request.checkpoint(noise), [&](const TrainingRunOptions& options) {
      return train_and_recall(learning, with, noise, request.seeds, options, problem);
    });
  };
  if (!train(choice, 0, "without noise") || !train(noisy, paper_noise, "with noise")) return false;
  if (!train_networks(request, "with noise drawn anew", request.fresh_noise_checkpoint(),
                      [&](const TrainingRunOptions& options) {
                        return train_on_fresh_noise(learning, noisy, request.seeds, options, problem);
                      }))
    return false;
  keep_networks(directory, problem);
  const InverseBaselines baselines = inverse_baselines(executor, choice, problem.sets);
  report_inverse_problem(page, problem, choice, baselines);
  if (request.cycles > 0)
    page.finding(
        Tone::fair, "quick look",
        fmt::format("The networks were trained for {} cycles at most (--cycles), the paper's for 10 000 or 15 000.",
                    request.cycles));
  write_file("--output", directory / "table2.json", json_text(table_two_json(problem)));
  write_file("--output", directory / "estimators.json", json_text(baselines_json(baselines)));
  return true;
}

int run_reproduce(const ReproduceRequest& request) {
  const std::filesystem::path directory = request.output;
  make_folder("--output", directory);
  const FileLock lock = FileLock::of_folder("--output", directory, "a directory in which no other program is training");
  check_writable("--output", directory / "index.html");
  Executor executor{Device(request.device)};
  std::optional<Executor> other;  // where networks train elsewhere than contacts are solved
  if (executor.device().info().type == DeviceType::gpu) {
    other.emplace(executor.device().for_training());
    if (!request.quiet) print_warning("networks train on " + other->device().info().name);
  }
  Executor& learning = other ? *other : executor;
  Page page("tactel: the paper reproduced",
            "Detection of incipient object slippage by skin-like sensing and neural network processing (1998), "
            "computed by tactel " TACTEL_VERSION " on " +
                executor.device().info().name);
  const auto table_one = [&] {
    const StageLine stage("Table I and Figures 3 to 5: the direct problem", request.quiet);
    return report_direct_problem(executor, page);
  }();
  write_file("--output", directory / "table1.json", json_text(table_one));
  if (!reproduce_networks(request, executor, learning, page) || !reproduce_real_sensor(request, learning, page))
    return interrupted;
  write_report(request.output, page.html(), request.quiet);
  remove_checkpoints(request);
  return done;
}

}  // namespace

void add_reproduce_command(CLI::App& app, Action& action) {
  const auto [command, request] = add_command(
      app, action, "Verify", "reproduce",
      "reproduce the paper: Tables I and II, Figures 3 to 5 and section VI, as HTML and JSON", run_reproduce);
  add_option(command, "--output", request.output, "directory of the report", {.type = "DIR"});
  add_device_option(command, request.device);
  add_option(command, "--seeds", request.seeds,
             "number of initial weights of each network of Table II; 100 give the full statistics",
             {.least = 1, .most = 100000});
  add_option(command, "--cycles", request.cycles, "learning cycles, fewer for a quick look; 0: as many as the paper",
             {.most = 1000000});
  add_option(command, "--noise-cycles", request.noise_cycles, "learning cycles with noise; 0: as many as the paper",
             {.most = 1000000});
  add_option(command, "--force", request.force, "train anew, and discard an interrupted training in DIR");
  add_option(command, "--quiet", request.quiet, "print only errors");
}

}  // namespace tactel::host
