#include "host/command.h"
#include "host/errors.h"
#include "host/plot.h"
#include "host/rank_training.h"
#include "host/stream_training.h"
#include "host/training.h"
#include "host/training_directory.h"

namespace tactel::host {
namespace {

/// A stream of frames, or a set that does not fit memory: mini-batches, one pass after the other.
int run_train_stream(TrainRequest request) {
  request.schedule = "batch";
  const SweepPlan plan = plan_of(request);
  if (plan.noises.size() > 1)
    throw ConfigError("command line", "--noise", "several levels", "one level with --stream or --block");
  TrainingDirectory(request.output).check(request.resume, request.force);
  check_figure_path("--output", TrainingDirectory(request.output).figure());
  return run_stream_training(request, plan);
}

int run_train(const TrainRequest& request) {
  if (request.set.empty() == request.stream.empty())
    throw ConfigError("command line", "SET.h5", request.set.empty() ? "(missing)" : request.set,
                      "given, or --stream SWEEP.toml instead of it");
  if (!request.stream.empty() || request.block) return run_train_stream(request);
  const SweepPlan plan = plan_of(request);
  const NamedSet set = read_learning_set(request);
  check_width(plan, set);
  std::optional<NamedSet> recall_set;
  if (!request.recall_set.empty()) {
    recall_set = read_set(request.recall_set);
    check_width(plan, *recall_set);
  }
  const Ranks ranks;
  if (ranks.count() > 1) return run_rank_training(ranks, request, plan, set, recall_set);
  TrainingDirectory(request.output).check(request.resume, request.force);
  check_figure_path("--output", TrainingDirectory(request.output).figure());
  return run_training(request, plan, set, recall_set);
}

void add_training_options(CLI::App& command, TrainRequest& request) {
  command
      .add_option("--schedule", request.schedule,
                  "online: pattern by pattern (the paper's); batch: mini-batches, for large sets")
      ->check(CLI::IsMember({"online", "batch"}))
      ->capture_default_str();
  command.add_option(
      "--cycles,--epochs", request.cycles,
      "passes over the set at most (default: 10000, 15000 with two hidden layers, 1000 with --schedule batch)");
  command.add_option("--learning-rate", request.rate, "no unit (default: 0.1, for adam 0.001)");
  command.add_option("--momentum", request.momentum,
                     "share of the last step that the next one keeps, 0 to 1 (default: 0.9)");
  command
      .add_option("--stop-error", request.stop_error,
                  "a network stops when no |error| of S in a cycle reaches this, no unit; 0: never")
      ->capture_default_str();
  command.add_option("--order", request.order, "of the rows in a cycle")
      ->check(CLI::IsMember({"permuted", "sequential"}))
      ->capture_default_str();
  command.add_option("--batch", request.batch, "rows to a change of the weights, with --schedule batch (default: 64)");
  command
      .add_option("--optimizer", request.optimizer,
                  "with --schedule batch: delta (the delta rule with momentum) or adam (default: adam)")
      ->check(CLI::IsMember({"delta", "adam"}));
}

}  // namespace

void add_train_command(CLI::App& app, Action& action) {
  auto request = std::make_shared<TrainRequest>();
  CLI::App* command = app.add_subcommand("train", "networks that read S from the stresses, with learning curves");
  command->add_option("set", request->set, "learning set (HDF5), see tactel generate")->type_name("SET.h5");
  command->add_option("--output", request->output, "directory for the networks, their report and figure")
      ->type_name("DIR")
      ->required();
  command
      ->add_option("--network", request->networks,
                   "1 to 6 of the paper, or widths as 42-42-21-1; may be given again (default: all six)")
      ->type_name("N|WIDTHS")
      ->allow_extra_args(false);
  command->add_option("--seeds", request->seeds, "networks of each kind, with seeds that count up")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command->add_option("--first-seed,--seed", request->first_seed, "of initial weights, order and noise")
      ->capture_default_str();
  command
      ->add_option("--noise", request->noises,
                   "standard deviation of Gaussian noise on the learning set over its largest |stress|, 0.1 for 10 %; "
                   "may be given again (default: 0)")
      ->allow_extra_args(false);
  command
      ->add_option("--scaling", request->scaling,
                   "stresses are divided by: set, the learning set's largest |stress|; frame, each frame's own largest "
                   "normal stress")
      ->check(CLI::IsMember({"set", "frame"}))
      ->capture_default_str();
  add_training_options(*command, *request);
  command
      ->add_option("--stream", request->stream,
                   "instead of a set: contacts of this sweep file, simulated as they are needed and never stored")
      ->type_name("SWEEP.toml");
  command->add_option("--rows", request->rows, "of --stream or --block to learn from in all")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command->add_option("--block", request->block, "read the set so many rows at a time: for sets larger than memory")
      ->check(CLI::Range(1, 100'000'000))
      ->type_name("ROWS");
  command->add_option("--recall", request->recall_set, "another set to judge the networks by")->type_name("SET.h5");
  command->add_option("--checkpoint-seconds", request->checkpoint_seconds, "s between two writings of DIR/checkpoint")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  CLI::Option* resume = command->add_flag("--resume", request->resume, "go on from DIR/checkpoint, if there is one");
  command->add_flag("--force", request->force, "train anew and write over what DIR holds")->excludes(resume);
  add_network_options(*command, request->shared);
  command->callback([request, &action] { action = [request] { return run_train(*request); }; });
}

}  // namespace tactel::host
