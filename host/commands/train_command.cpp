// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "host/commands/calibrate_bounds.h"
#include "host/commands/shared_options.h"
#include "host/support/errors.h"
#include "host/support/freed_memory.h"
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
  const bool quiet = request.shared.quiet;
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
  const bool silent = request.shared.quiet || ranks.count() > 1;
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
    if (level == LogLevel::warning && !request.shared.quiet) print_warning(message);
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
    calibrate_bounds(networks, request.bound_set, request.level.value_or(0.95), request.shared);
  }
  return code;
}

void add_training_options(CLI::App& command, TrainRequest& request) {
  command
      .add_option("--schedule", request.schedule,
                  "online: pattern by pattern (the paper's); batch: mini-batches, for large sets; cosine: mini-batches "
                  "at a learning rate that warms up and falls to 0 as a cosine (default: online; with --stream and "
                  "--block batch)")
      ->check(CLI::IsMember({"online", "batch", "cosine"}));
  command.add_option(
      "--cycles,--epochs", request.cycles,
      "most passes over the set (default: 10000, 15000 with two hidden layers, 1000 with --schedule batch)");
  command.add_option("--learning-rate", request.rate,
                     "learning rate, no unit (default: 0.1, for adam 0.001, of cosine 0.002)");
  command.add_option("--warm-up", request.warm_up,
                     "with --schedule cosine: share of the training in which the learning rate rises from 0 to its "
                     "largest (default: 0.02)");
  command.add_option("--momentum", request.momentum,
                     "share of the last step in the next one, 0 to 1 (default: 0.9); not for adam");
  command.add_option(
      "--stop-error", request.stop_error,
      "a network stops when every |error| of S in a cycle is below this, no unit; 0: never (default: 0.01)");
  command.add_option("--order", request.order, "order of the rows in a cycle")
      ->check(CLI::IsMember({"permuted", "sequential"}))
      ->capture_default_str();
  command.add_option("--batch", request.batch,
                     "rows that a change of the weights learns from, in mini-batches (default: 64)");
  command
      .add_option("--optimizer", request.optimizer,
                  "of mini-batches: delta (the delta rule with momentum) or adam (default: adam)")
      ->check(CLI::IsMember({"delta", "adam"}));
  command
      .add_option("--loss", request.loss,
                  "of mini-batches: squared or absolute error of S, whose mean becomes small (default: squared); "
                  "quantiles have their own")
      ->check(CLI::IsMember({"squared", "absolute"}));
  command.add_option("--average", request.average,
                     "of mini-batches: decay, in a change of the weights, of their exponential mean, which is the "
                     "network; 0: none (default: 0; 0.9995 takes the mean of some 2000)");
  command
      .add_option("--validation", request.validation_set,
                  "of mini-batches: set that judges the networks after each cycle or block; a network keeps the "
                  "weights of the smallest mean error")
      ->type_name("SET.h5");
  command.add_option("--patience", request.patience,
                     "with --validation: a network stops after so many cycles or blocks without a smaller error "
                     "(default: never)");
  command
      .add_option("--activation", request.activation,
                  "of mini-batches: function of the hidden neurons, logistic (the paper's) or leaky-relu, which "
                  "learns large sets better (default: logistic)")
      ->check(CLI::IsMember({"logistic", "leaky-relu"}));
  command.add_flag("--bound", request.bound,
                   "of mini-batches: three outputs, S and two quantiles, for an upper bound of S; it holds after "
                   "--bound-set or tactel calibrate bound");
  command
      .add_option("--bound-set", request.bound_set,
                  "with --bound: set of another seed, by whose rows the bound becomes conformal at the end")
      ->type_name("SET.h5")
      ->needs("--bound");
  command.add_option("--level", request.level, "with --bound: level of the upper quantile (default: 0.95)");
}

}  // namespace

void add_train_command(CLI::App& app, Action& action) {
  auto request = std::make_shared<TrainRequest>();
  CLI::App* command =
      app.add_subcommand("train", "train networks that estimate S from the stresses, with learning curves");
  command->group("Learn");
  command->add_option("set", request->set, "learning set (HDF5), see tactel generate")->type_name("SET.h5");
  command->add_option("--output", request->output, "directory for the networks, their report and figure")
      ->type_name("DIR")
      ->required();
  command
      ->add_option("--network", request->networks,
                   "1 to 6 of the paper, or widths such as 42-42-21-1; repeatable (default: all six)")
      ->type_name("N|WIDTHS")
      ->allow_extra_args(false);
  command->add_option("--seeds", request->seeds, "number of networks of each kind, with consecutive seeds")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command->add_option("--first-seed,--seed", request->first_seed, "first seed of initial weights, order and noise")
      ->capture_default_str();
  command
      ->add_option("--noise", request->noises,
                   "standard deviation of Gaussian noise on the learning set over its largest |stress|, 0.1 for 10 %; "
                   "repeatable (default: 0)")
      ->allow_extra_args(false);
  command
      ->add_option("--scaling", request->scaling,
                   "divisor of the stresses: set, the learning set's largest |stress|; frame, each frame's own largest "
                   "normal stress; rest, the normal force of the grip at rest, of differences to it")
      ->check(CLI::IsMember({"set", "frame", "rest"}))
      ->capture_default_str();
  command
      ->add_option("--history", request->history,
                   "number of frames in an input: the newest and earlier ones of its contact; with :STRIDE every "
                   "STRIDE-th of these (default: 1)")
      ->type_name("K[:STRIDE]");
  command->add_option("--history-change", request->history_change,
                      "with --history: a frame is kept that differs by more than this share of the contact's largest "
                      "stress from the last kept one, 0 to 1 (default: 0.1)");
  command->add_flag("--magnitude", request->magnitude, "learn |S|: for drags to both sides");
  command->add_flag(
      "--friction", request->friction,
      "networks take mu as far as it is known: a number and its relative spread, which `monitor --friction` "
      "and alarms tell; also nothing");
  command
      ->add_option(
          "--features", request->features,
          "fixed layer before the network, with --scaling frame or rest: line or pad, one of all mirror images of a "
          "frame and its sums; line learns |S|; frame: none")
      ->check(CLI::IsMember({"frame", "line", "pad"}))
      ->capture_default_str();
  command
      ->add_option(
          "--target", request->target,
          "column of the set to learn: slip_index, S; force_ratio, |Q| / (mu P) of pads; stick_fraction; slid, how far "
          "pads slid since rest as a whole; slip_path, how far their cells did")
      ->check(CLI::IsMember({"slip_index", "force_ratio", "stick_fraction", "slid", "slip_path"}))
      ->capture_default_str();
  command
      ->add_option("--alarm-at", request->alarm_at,
                   "with --target slid or slip_path: threshold of `tactel monitor --alarm` that the network's file "
                   "holds, above 0 and "
                   "below 1 (default: none)")
      ->check(CLI::Range(1e-3, 0.999))
      ->type_name("FLOAT");
  add_training_options(*command, *request);
  command
      ->add_option("--stream", request->stream,
                   "instead of a set: contacts of this sweep file, simulated on demand and never stored")
      ->type_name("SWEEP.toml");
  command->add_option("--rung", request->rung, "with --stream: model of its contacts, as `tactel generate` takes it")
      ->type_name("NAME");
  command
      ->add_option("--rows", request->rows, "number of rows of --stream or --block to learn from (default: 10000000)")
      ->check(CLI::PositiveNumber);
  command
      ->add_option("--block", request->block, "read the set in blocks of this many rows: for sets larger than memory")
      ->check(CLI::Range(1, 100'000'000))
      ->type_name("ROWS");
  command->add_option("--recall", request->recall_set, "second set to judge the networks by")->type_name("SET.h5");
  command
      ->add_option("--checkpoint-seconds", request->checkpoint_seconds,
                   "interval between two writings of DIR/checkpoint, s")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  CLI::Option* resume = command->add_flag("--resume", request->resume, "resume from DIR/checkpoint, if it exists");
  command->add_flag("--force", request->force, "train anew and overwrite the files in DIR")->excludes(resume);
  add_network_options(*command, request->shared);
  command->callback([request, &action] { action = [request] { return run_train(*request); }; });
}

}  // namespace tactel::host
