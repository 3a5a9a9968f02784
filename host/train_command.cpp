#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "host/atomic_file.h"
#include "host/checksum.h"
#include "host/command.h"
#include "host/errors.h"
#include "host/interrupt.h"
#include "host/json_text.h"
#include "host/learning_curves.h"
#include "host/network_report.h"
#include "host/network_sweep.h"
#include "host/onnx_file.h"
#include "host/progress_line.h"
#include "host/training_directory.h"

namespace tactel::host {
namespace {

using Json = nlohmann::ordered_json;

struct TrainRequest {
  NetworkOptions shared;
  std::string set, recall_set, output;
  std::vector<std::string> networks;
  std::vector<double> noises;
  std::uint64_t seeds = 1, first_seed = 1;
  std::string scaling = "set", schedule = "online", order = "permuted";
  std::optional<double> rate, momentum;
  std::optional<int> cycles, batch;
  std::optional<std::string> optimizer;
  double stop_error = 0.01, checkpoint_seconds = 10;
  bool resume = false, force = false;
};

constexpr int default_epochs = 1000;

/// A set's file and the rows of it that count.
struct NamedSet {
  std::string file;
  ContactSet contacts;
  AnsweredRows rows;
};

NamedSet read_set(const std::string& file) {
  NamedSet set{file, read_contact_set(file), {}};
  set.rows = answered_rows(set.contacts, file);
  return set;
}

NamedSet read_learning_set(const TrainRequest& request) try {
  NamedSet set = read_set(request.set);
  set.rows.frames.validate();
  nn::fit_scaling(nn::parse_scaling(request.scaling), set.rows.frames);
  return set;
} catch (const ValueError& error) {
  throw ConfigError(request.set, error);
}

/// What the library calls by a name of its own, as the user wrote it.
[[noreturn]] void blame_option(const ValueError& error) {
  static const std::map<std::string, std::string> options = {{"training.rate", "--learning-rate"},
                                                             {"training.momentum", "--momentum"},
                                                             {"training.stop_error", "--stop-error"},
                                                             {"training.cycle_limit", "--cycles"},
                                                             {"training.batch", "--batch"}};
  const auto found = options.find(error.key);
  throw ConfigError("command line", found == options.end() ? "--" + error.key : found->second, error.value,
                    error.allowed);
}

void refuse_unless_batch(const TrainRequest& request) {
  const char* option = request.optimizer ? "--optimizer" : request.batch ? "--batch" : nullptr;
  if (option && request.schedule != "batch")
    throw ConfigError("command line", option, request.optimizer.value_or(std::to_string(request.batch.value_or(0))),
                      "left out, or with --schedule batch");
}

nn::BatchOptions batch_options(const TrainRequest& request) {
  nn::BatchOptions batch;
  if (request.optimizer) batch.rule = nn::parse_rule(*request.optimizer);
  if (request.batch) batch.batch = *request.batch;
  batch.rate = request.rate.value_or(batch.rule == nn::BatchRule::adam ? 1e-3 : 0.1);
  if (request.momentum) batch.momentum = *request.momentum;
  batch.order = nn::parse_order(request.order);
  return batch;
}

std::vector<nn::Topology> topologies_of(const TrainRequest& request) {
  std::vector<std::string> names = request.networks;
  if (names.empty()) names = {"1", "2", "3", "4", "5", "6"};
  std::vector<nn::Topology> topologies;
  for (const std::string& name : names) {
    topologies.push_back(nn::Topology::parse(name));
    if (std::ranges::count(topologies, topologies.back()) > 1) throw ValueError("network", name, "named once");
  }
  return topologies;
}

SweepPlan plan_of(const TrainRequest& request) try {
  refuse_unless_batch(request);
  SweepPlan plan;
  plan.topologies = topologies_of(request);
  if (request.seeds > 1'000'000) throw ValueError("seeds", std::to_string(request.seeds), "at most a million");
  for (std::uint64_t i = 0; i < request.seeds; ++i) plan.seeds.push_back(request.first_seed + i);
  if (!request.noises.empty()) plan.noises = request.noises;
  if (std::set<double>(plan.noises.begin(), plan.noises.end()).size() < plan.noises.size())
    throw ValueError("noise", fmt::format("{}", fmt::join(plan.noises, ", ")), "levels that differ");
  plan.scaling = nn::parse_scaling(request.scaling);
  plan.options.stop_error = request.stop_error;
  plan.options.cycle_limit = request.cycles.value_or(request.schedule == "batch" ? default_epochs : 0);
  plan.options.order = nn::parse_order(request.order);
  if (request.schedule == "batch") {
    plan.batch = batch_options(request);
  } else {
    plan.options.rate = request.rate.value_or(plan.options.rate);
    plan.options.momentum = request.momentum.value_or(plan.options.momentum);
  }
  plan.validate();
  return plan;
} catch (const ValueError& error) {
  blame_option(error);
}

void check_width(const SweepPlan& plan, const NamedSet& set) {
  for (const nn::Topology& topology : plan.topologies)
    if (topology.inputs() != set.contacts.inputs)
      throw ConfigError("command line", "--network", topology.text(),
                        fmt::format("a network with {} inputs, as many as {} has", set.contacts.inputs, set.file));
}

Json options_json(const TrainRequest& request, const SweepPlan& plan) {
  Json options = {{"schedule", request.schedule},
                  {"scaling", nn::name(plan.scaling)},
                  {"order", request.order},
                  {"learning_rate", plan.batch ? plan.batch->rate : plan.options.rate},
                  {"momentum", plan.batch ? plan.batch->momentum : plan.options.momentum},
                  {"stop_error", plan.options.stop_error},
                  {"cycles", plan.options.cycle_limit > 0 ? Json(plan.options.cycle_limit) : Json(nullptr)},
                  {"noise", plan.noises},
                  {"seeds", request.seeds},
                  {"first_seed", request.first_seed}};
  if (!plan.batch) return options;
  options["batch"] = plan.batch->batch;
  options["optimizer"] = nn::name(plan.batch->rule);
  return options;
}

/// A training from the set to its files.
template <class Real>
class Training {
 public:
  Training(const TrainRequest& request, const SweepPlan& plan, const NamedSet& set)
      : request_(request),
        plan_(plan),
        set_(set),
        directory_(request.output),
        executor_(Device(request.shared.device)),
        sweep_(executor_, set.rows.frames, plan) {}

  int run(const std::optional<NamedSet>& recall_set) {
    const std::string fingerprint = checksum_text(sweep_.description());
    if (request_.resume && directory_.finished()) {
      directory_.expect_same(fingerprint);
      say(fmt::format("{}: this training is done\n", request_.output));
      return done;
    }
    if (request_.force) directory_.clear();
    if (request_.resume) sweep_.load(directory_.checkpoint());
    const Interrupt interrupt;
    if (!train(interrupt)) return say_stopped();
    finish(fingerprint, recall_set);
    return say_diverged();
  }

 private:
  void say(const std::string& text) const {
    if (!request_.shared.quiet) fmt::print("{}", text);
  }

  bool train(const Interrupt& interrupt) {
    ProgressLine line("training", "weight updates", request_.shared.quiet);
    const auto progress = [&](std::size_t done, std::size_t all) {
      last_share_ = static_cast<double>(done) / static_cast<double>(all);
      line.show(done, all, pace_text());
      return !interrupt.requested();
    };
    return sweep_.run({.progress = progress,
                       .checkpoint = directory_.checkpoint(),
                       .checkpoint_seconds = request_.checkpoint_seconds});
  }

  std::string pace_text() const { return with_prefix(pace()) + " patterns/s"; }

  double pace() const { return sweep_.seconds() > 0 ? sweep_.patterns() / sweep_.seconds() : 0; }

  int say_stopped() const {
    if (!request_.shared.quiet)
      fmt::print(stderr,
                 "stopped after {:.1f} % of the cycles at most; the same command with --resume goes on from {}\n",
                 100 * last_share_, directory_.checkpoint().string());
    return interrupted;
  }

  int say_diverged() const {
    const auto diverged = std::ranges::count(sweep_.networks(), nn::TrainStatus::not_finite, &SweepNetwork::status);
    if (diverged == 0) return done;
    if (!request_.shared.quiet)
      fmt::print(stderr, "warning: {} of {} networks diverged and have no file: a smaller --learning-rate may help\n",
                 diverged, sweep_.networks().size());
    return not_converged;
  }

  void finish(const std::string& fingerprint, const std::optional<NamedSet>& recall_set) {
    take_networks();
    for (const NamedNetwork& network : networks_)
      if (!network.file.empty()) write_onnx(directory_.network(network.file), network.model);
    std::vector<NetworkResult> recalled;
    if (recall_set) recalled = *recall_networks<Real>(executor_, networks_, recall_set->rows.frames, false, Progress());
    write_figure("--output", directory_.figure(), learning_curves(sweep_.networks(), plan_.options.stop_error));
    Json report = report_json(fingerprint);
    for (std::size_t i = 0; i < recalled.size(); ++i)
      report["networks"][i].update(to_json(recalled[i], recall_set->contacts.indenter_names));
    if (recall_set) report["recall_set"] = recall_set->file;
    write_file("--output", directory_.report(), json_text(report));
    directory_.remove_checkpoint();
    say(summary() + "\nerrors |S - S of the set| on the learning set, as it was shown\n" +
        error_table(networks_, learnt_));
    if (recall_set) say(fmt::format("\nthe same on {}\n{}", recall_set->file, error_table(networks_, recalled)));
  }

  // Models and errors of all networks; one that has diverged has no file.
  void take_networks() {
    for (nn::ErrorReport& errors : sweep_.recall_learning_set()) {
      const std::size_t i = networks_.size();
      const SweepNetwork& network = sweep_.networks()[i];
      const bool good = network.status != nn::TrainStatus::not_finite;
      networks_.push_back({good ? network_file_name(network.topology, network.noise, network.seed) : "",
                           sweep_.model(i, request_.set, errors.all)});
      learnt_.push_back({.errors = std::move(errors)});
    }
  }

  Json report_json(const std::string& fingerprint) const {
    Json networks = Json::array();
    for (std::size_t i = 0; i < networks_.size(); ++i) networks.push_back(network_json(i));
    return {{"tactel", TACTEL_VERSION},
            {"set", request_.set},
            {"rows", set_.rows.frames.rows()},
            {"rows_left_out", set_.rows.left_out},
            {"device", executor_.device().info().name},
            {"precision", sizeof(Real) == 8 ? "fp64" : "fp32"},
            {"options", options_json(request_, plan_)},
            {"fingerprint", fingerprint},
            {"patterns", sweep_.patterns()},
            {"seconds", sweep_.seconds()},
            {"patterns_per_second", pace()},
            {"networks", networks}};
  }

  Json network_json(std::size_t i) const {
    const SweepNetwork& network = sweep_.networks()[i];
    Json json = to_json(networks_[i]);
    if (networks_[i].file.empty()) json["file"] = nullptr;
    json["status"] = nn::name(network.status);
    json["seconds"] = network.seconds;
    json["sse"] = network.sse;
    json["largest_error"] = network.largest;
    json["curve"] = {
        {"cycle", network.curve.cycle}, {"sse", network.curve.sse}, {"largest_error", network.curve.largest}};
    return json;
  }

  std::string summary() const {
    std::map<nn::TrainStatus, int> count;
    for (const SweepNetwork& network : sweep_.networks()) ++count[network.status];
    std::string text = fmt::format("{}: {} networks learnt {} rows in {:.2f} s, {}:", request_.output, networks_.size(),
                                   set_.rows.frames.rows(), sweep_.seconds(), pace_text());
    for (const auto& [status, many] : count) text += fmt::format(" {} {},", many, nn::name(status));
    text.back() = '\n';
    if (set_.rows.left_out > 0)
      text += fmt::format("{} rows of the set were left out: over tolerance, or without a slippage index\n",
                          set_.rows.left_out);
    return text;
  }

  const TrainRequest& request_;
  const SweepPlan& plan_;
  const NamedSet& set_;
  TrainingDirectory directory_;
  Executor executor_;
  NetworkSweep<Real> sweep_;
  double last_share_ = 0;
  std::vector<NamedNetwork> networks_;
  std::vector<NetworkResult> learnt_;
};

int run_train(const TrainRequest& request) {
  const SweepPlan plan = plan_of(request);
  const NamedSet set = read_learning_set(request);
  check_width(plan, set);
  std::optional<NamedSet> recall_set;
  if (!request.recall_set.empty()) {
    recall_set = read_set(request.recall_set);
    check_width(plan, *recall_set);
  }
  TrainingDirectory(request.output).check(request.resume, request.force);
  check_figure_path("--output", TrainingDirectory(request.output).figure());
  if (request.shared.precision == "fp64") return Training<double>(request, plan, set).run(recall_set);
  return Training<float>(request, plan, set).run(recall_set);
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
  command->add_option("set", request->set, "learning set (HDF5), see tactel generate")->type_name("SET.h5")->required();
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
