// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "host/commands/add_option.h"
#include "host/commands/network_parts.h"
#include "host/commands/shared_options.h"
#include "host/support/errors.h"
#include "host/support/host_limits.h"
#include "host/support/interrupt.h"
#include "host/support/progress_line.h"
#include "host/support/terminal.h"
#include "host/training/training.h"

namespace tactel::host {
namespace {

std::string how_to_go_on(const TrainRequest& request, const TrainingOutcome& outcome) {
  if (outcome.checkpoint.empty()) return "stopped; the same command with --resume and as many processes continues\n";
  return fmt::format("stopped after {:.1f} % of the {} at most; the same command with --resume continues from {}\n",
                     100 * outcome.share, request.streams() ? "rows" : "cycles", outcome.checkpoint.string());
}

/// Says how a training ended, and turns it into an exit code.
int say(const TrainRequest& request, const TrainingOutcome& outcome) {
  const bool quiet = request.quiet;
  if (outcome.end == TrainingEnd::stopped) {
    if (!quiet) fmt::print(stderr, "{}", how_to_go_on(request, outcome));
    return interrupted;
  }
  if (outcome.end == TrainingEnd::done_before) {
    if (!quiet) fmt::print("{}: this training is complete\n", request.output);
    return done;
  }
  if (!quiet) {
    fmt::print("{}", outcome.summary);
    for (const std::string& table : outcome.tables) fmt::print("\n{}", table);
  }
  if (!quiet && !outcome.undrawn.empty())
    print_warning(fmt::format("learning_curves.svg is not drawn; training.json has its numbers: {}", outcome.undrawn));
  if (outcome.diverged == 0) return done;
  if (!quiet)
    print_warning(fmt::format("{} of {} networks diverged and have no file: a smaller --learning-rate may help",
                              outcome.diverged, outcome.networks));
  return not_converged;
}

/// Trains under Ctrl-C, with a line of progress; the first of several processes alone reports.
int train_as_asked(const TrainRequest& request, const Ranks& ranks) {
  if (request.set.empty() == request.stream.empty())
    throw ConfigError("command line", "SET.h5", request.set.empty() ? "(missing)" : request.set,
                      request.set.empty() ? "given, or --stream SWEEP.toml instead of it" : "left out with --stream");
  if (!request.stream.empty()) keep_freed_memory(1 << 30);
  const bool silent = request.quiet || ranks.count() > 1;
  std::optional<Interrupt> interrupt;
  std::optional<StageLine> stage;
  std::optional<ProgressLine> line;
  TrainingWatch watch;
  watch.stage = [&](const std::string& text) {
    stage.reset();
    if (!text.empty()) return static_cast<void>(stage.emplace(text, silent));
    interrupt.emplace();
    line.emplace("training", "weight updates", silent);
  };
  watch.progress = [&](std::size_t done, std::size_t all, double pace) {
    if (line) line->show(done, all, pace > 0 ? with_prefix(pace) + " patterns/s" : "");
    return !interrupt || !interrupt->requested();
  };
  watch.log = [&](LogLevel level, std::string_view message) {
    if (level == LogLevel::warning && !request.quiet) print_warning(message);
  };
  const TrainingOutcome outcome = train(request, ranks, watch);
  line.reset();
  if (ranks.first()) return say(request, outcome);
  return outcome.end == TrainingEnd::stopped ? interrupted : outcome.diverged > 0 ? not_converged : done;
}

int run_train(const TrainRequest& request) {
  if (!request.bound_set.empty()) read_columns(request.bound_set);  // not after hours
  const Ranks ranks;
  const int code = train_as_asked(request, ranks);
  if (code == done && !request.bound_set.empty() && ranks.first()) {
    std::vector<NamedNetwork> networks = read_networks(request.output);
    for (NamedNetwork& network : networks) network.file = std::filesystem::path(request.output) / network.file;
    calibrate_bounds(networks, request.bound_set, request.level.value_or(0.95),
                     {request.device, request.precision, request.quiet});
  }
  return code;
}

}  // namespace

void add_train_command(CLI::App& app, Action& action) {
  const auto [command, request] =
      add_command(app, action, "Learn", "train",
                  "train networks that estimate S from the stresses, with learning curves", run_train);
  add_option(command, "set", request.set, "learning set (HDF5), see tactel generate", {.type = "SET.h5"});
  add_option(command, "--output", request.output, "directory for the networks, their report and figure",
             {.type = "DIR"})
      ->required();
  add_options(command, request, train_options);
  command.get_option("--bound-set")->needs("--bound");
  add_option(command, "--recall", request.recall_set, "second set to judge the networks by", {.type = "SET.h5"});
  add_option(command, "--checkpoint-seconds", request.checkpoint_seconds,
             "interval between two writings of DIR/checkpoint, s")
      ->check(CLI::NonNegativeNumber);
  add_option(command, "--resume", request.resume, "resume from DIR/checkpoint, if it exists");
  add_option(command, "--force", request.force, "train anew and overwrite the files in DIR")->excludes("--resume");
  add_network_options(command, request.device, request.precision, request.quiet);
}

}  // namespace tactel::host
