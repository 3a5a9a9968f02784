// SPDX-License-Identifier: Apache-2.0
#include "host/training/training.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "host/networks/network_training.h"
#include "host/networks/onnx_file.h"
#include "host/support/checksum.h"
#include "host/support/durable_file.h"
#include "host/support/errors.h"
#include "host/support/json_text.h"
#include "host/support/progress_line.h"
#include "host/training/network_report.h"
#include "host/training/streams.h"
#include "host/training/training_directory.h"

namespace tactel::host {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::uint64_t contacts_a_block = 8192;

Json options_json(const TrainRequest& request, const TrainingPlan& plan) {
  const double rate = plan.batch ? plan.batch->rate : plan.options.rate;
  const bool cosine = plan.batch && plan.batch->cosine;
  Json options = {{"schedule", cosine       ? "cosine"
                               : plan.batch ? "batch"
                                            : "online"},
                  {"target", nn::name(plan.target)},
                  {"scaling", nn::name(plan.scaling)},
                  {"order", request.order},
                  {"learning_rate", rate},
                  {"last_learning_rate", cosine      ? 0
                                         : plan.rows ? TrainingPlan::last_rate * rate
                                                     : rate},
                  {"momentum", plan.batch ? plan.batch->momentum : plan.options.momentum},
                  {"noise", plan.noises},
                  {"seeds", request.seeds},
                  {"first_seed", request.first_seed}};
  if (plan.rows) {
    options["rows"] = *plan.rows;
  } else {
    options["stop_error"] = plan.options.stop_error;
    options["cycles"] = plan.options.cycle_limit > 0 ? Json(plan.options.cycle_limit) : Json(nullptr);
  }
  if (plan.features != nn::Features::frame) options["features"] = nn::name(plan.features);
  if (plan.history.path() > 1)
    options["history"] = {
        {"frames", plan.history.path()}, {"stride", plan.history.stride}, {"change", plan.history.change}};
  if (plan.magnitude) options["magnitude"] = true;
  if (plan.history.friction) options["friction"] = true;
  if (plan.markers) options["inputs"] = "markers";
  if (!plan.batch) return options;
  options["batch"] = plan.batch->batch;
  options["optimizer"] = nn::name(plan.batch->rule);
  if (cosine) options["warm_up"] = plan.batch->warm_up;
  if (plan.batch->loss != nn::Loss::squared) options["loss"] = nn::name(plan.batch->loss);
  if (plan.batch->average > 0) options["average"] = plan.batch->average;
  if (plan.patience > 0) options["patience"] = plan.patience;
  return options;
}

template <class Value>
Json values_of(const std::vector<CurvePoint>& curve, Value CurvePoint::*value) {
  Json values = Json::array();
  for (const CurvePoint& point : curve) values.push_back(point.*value);
  return values;
}

Json curve_json(const std::vector<CurvePoint>& curve, bool judged, bool validated) {
  Json json = {{"cycle", values_of(curve, &CurvePoint::cycle)},
               {"rows", values_of(curve, &CurvePoint::rows)},
               {"sse", values_of(curve, &CurvePoint::sse)},
               {"mean_squared_error", values_of(curve, &CurvePoint::mean_square)},
               {"largest_error", values_of(curve, &CurvePoint::largest)}};
  if (judged) json["recall_mean_error"] = values_of(curve, &CurvePoint::recall);
  if (validated) json["validation_mean_error"] = values_of(curve, &CurvePoint::validation);
  return json;
}

/// A line of JSON for each point of the networks' curves, from training.json's "networks".
std::string curve_lines(const Json& networks) {
  std::string lines;
  for (const Json& network : networks) {
    const Json& curve = network["curve"];
    for (std::size_t i = 0; i < curve["cycle"].size(); ++i) {
      Json line = {{"network", network["file"]}, {"seed", network["seed"]}, {"noise", network["noise"]}};
      for (const auto& [name, values] : curve.items()) line[name] = values[i];
      lines += line.dump() + "\n";
    }
  }
  return lines;
}

/// What a training learns from, and what judges it.
struct Lesson {
  std::optional<NamedSet> set{};           ///< none: the stream
  std::unique_ptr<Executor> simulation{};  ///< of the stream's contacts, beside the training
  std::unique_ptr<FrameStream> stream{};
  std::optional<NamedSet> recall{};
  std::string name() const { return stream ? stream->name() : set->file; }
};

/// The seeds that a process trains.
TrainingPlan part_of(const TrainingPlan& plan, int rank, int count) {
  TrainingPlan part = plan;
  part.seeds.clear();
  for (std::size_t i = static_cast<std::size_t>(rank); i < plan.seeds.size(); i += static_cast<std::size_t>(count))
    part.seeds.push_back(plan.seeds[i]);
  return part;
}

/// From rows to files.
template <class Real>
class Training {
 public:
  Training(const TrainRequest& request, const TrainingPlan& plan, const Ranks& ranks, Lesson& lesson,
           Executor& executor, const TrainingWatch& watch)
      : request_(request),
        plan_(plan),
        ranks_(ranks),
        lesson_(lesson),
        executor_(executor),
        watch_(watch),
        directory_(request.output) {}

  TrainingOutcome run() {
    const std::string source =
        lesson_.stream ? lesson_.stream->description() : set_description(lesson_.set->rows.frames);
    const int lanes = executor_.device().lanes(precision_of<Real>);
    const std::string fingerprint = checksum_text(training_description(source, lanes, precision_of<Real>, plan_));
    if (request_.resume && directory_.finished()) {
      directory_.expect_same(fingerprint);
      return {.end = TrainingEnd::done_before};
    }
    if (ranks_.sum(std::vector<double>{1.0 * lanes})[0] != 1.0 * lanes * ranks_.count())
      throw ConfigError("command line", "--device", fmt::format("a device of {} lanes", lanes),
                        "devices of equally many lanes in all processes");
    const TrainingPlan own_plan = part_of(plan_, ranks_.rank(), ranks_.count());
    if (!own_plan.seeds.empty()) start(own_plan);
    if (request_.force && ranks_.first()) directory_.clear();
    ranks_.barrier();
    const bool done = own_plan.seeds.empty() || learn();
    if (ranks_.sum(std::vector{done ? 0.0 : 1.0})[0] > 0)
      return {.end = TrainingEnd::stopped,
              .share = share_,
              .checkpoint = ranks_.count() > 1 ? std::filesystem::path() : directory_.checkpoint()};
    TrainingOutcome outcome;
    if (ranks_.first()) outcome = finish(fingerprint);
    const auto networks =
        ranks_.sum(std::vector{static_cast<double>(outcome.networks), static_cast<double>(outcome.diverged)});
    outcome.networks = static_cast<std::size_t>(networks[0]), outcome.diverged = static_cast<std::size_t>(networks[1]);
    return outcome;
  }

 private:
  void start(const TrainingPlan& plan) {
    if (lesson_.stream)
      training_.emplace(executor_, *lesson_.stream, plan);
    else
      training_.emplace(executor_, lesson_.set->rows.frames, plan);
  }

  std::filesystem::path checkpoint(int rank) const {
    return ranks_.count() > 1 ? directory_.checkpoint(rank) : directory_.checkpoint();
  }

  bool learn() {
    const std::filesystem::path file = checkpoint(ranks_.rank());
    if (lesson_.stream && watch_.log)
      for (const std::string& warning : lesson_.stream->warnings()) watch_.log(LogLevel::warning, warning);
    if (lesson_.stream && lesson_.recall)
      judges_ = shown_rows(lesson_.recall->rows.frames, plan_.history, plan_.magnitude, lesson_.recall->file);
    if (request_.resume) training_->load(file);
    const auto progress = [&](std::size_t done, std::size_t all) {
      share_ = static_cast<double>(done) / static_cast<double>(all);
      return !watch_.progress || watch_.progress(done, all, pace());
    };
    return training_->run({.progress = progress,
                           .checkpoint = file,
                           .checkpoint_seconds = request_.checkpoint_seconds,
                           .recall = judges_ ? &*judges_ : nullptr,
                           .log = watch_.log});
  }

  double pace() const { return training_->seconds() > 0 ? training_->patterns() / training_->seconds() : 0; }

  // The networks of all processes, from their checkpoints.
  void gather() {
    start(plan_);
    for (int rank = 0; rank < ranks_.count(); ++rank)
      if (const TrainingPlan part = part_of(plan_, rank, ranks_.count());
          !part.seeds.empty() && !training_->load(checkpoint(rank), part.seeds))
        throw ConfigError(checkpoint(rank).string(), "checkpoint", "(missing)", "where its process wrote it");
    training_->run();  // all have stopped
  }

  TrainingOutcome finish(const std::string& fingerprint) {
    if (ranks_.count() > 1) gather();
    std::vector<NamedNetwork> networks;  // one that has diverged has no file
    std::vector<NetworkResult> learnt, recalled;
    TrainingOutcome outcome;
    for (nn::ErrorReport& errors : training_->recall_learning_set()) {
      const std::size_t i = networks.size();
      const TrainedNetwork& network = training_->networks()[i];
      const bool good = network.status != nn::TrainStatus::not_finite;
      networks.push_back({good ? network_file_name(network.topology, network.noise, network.seed) : "",
                          training_->model(i, lesson_.name(), errors.all)});
      learnt.push_back({.errors = std::move(errors)});
      if (good) write_onnx(directory_.network(networks.back().file), networks.back().model);
      outcome.diverged += !good;
    }
    outcome.networks = networks.size();
    if (!lesson_.stream)
      outcome.tables = {fmt::format("{} on the learning set, noise included\n", errors_of(plan_.target)) +
                        error_table(networks, learnt)};
    if (lesson_.recall) {
      recalled = *recall_networks(executor_, precision_of<Real>, networks, lesson_.recall->rows.frames, false, {});
      outcome.tables.push_back(
          fmt::format("{} on {}\n{}", errors_of(plan_.target), lesson_.recall->file, error_table(networks, recalled)));
    }
    outcome.undrawn = directory_.draw(learning_curves(training_->networks(), {.stream = lesson_.stream != nullptr,
                                                                              .judged = lesson_.recall.has_value(),
                                                                              .validated = plan_.validation != nullptr,
                                                                              .stop_error = plan_.options.stop_error}));
    const Json report = report_json(fingerprint, networks, recalled);
    write_file("--output", directory_.curves(), curve_lines(report["networks"]));
    write_file("--output", directory_.report(), json_text(report));
    directory_.remove_checkpoints();
    outcome.summary = summary();
    return outcome;
  }

  Json report_json(const std::string& fingerprint, std::span<const NamedNetwork> networks,
                   std::span<const NetworkResult> recalled) const {
    Json report = {{"tactel", TACTEL_VERSION},
                   {request_.stream.empty() ? "set" : "stream", lesson_.name()},
                   {"rows", training_->rows()},
                   {"blocks", training_->blocks()},
                   {"device", executor_.device().info().name},
                   {"precision", request_.precision},
                   {"processes", ranks_.count()},
                   {"options", options_json(request_, plan_)},
                   {"fingerprint", fingerprint},
                   {"patterns", training_->patterns()},
                   {"seconds", training_->seconds()},
                   {"patterns_per_second", pace()},
                   {"networks", Json::array()}};
    if (lesson_.set) report["rows_left_out"] = lesson_.set->rows.left_out;
    if (lesson_.recall) report["recall_set"] = lesson_.recall->file;
    if (plan_.validation) report["validation_set"] = request_.validation_set;
    for (std::size_t i = 0; i < networks.size(); ++i) {
      Json json = network_json(networks[i], training_->networks()[i]);
      if (lesson_.recall) json.update(to_json(recalled[i], lesson_.recall->contacts.indenter_names));
      report["networks"].push_back(std::move(json));
    }
    return report;
  }

  Json network_json(const NamedNetwork& named, const TrainedNetwork& network) const {
    Json json = to_json(named);
    if (named.file.empty()) json["file"] = nullptr;
    json["status"] = status_text(network);
    json["seconds"] = network.seconds;
    json["sse"] = network.sse;
    json["largest_error"] = network.largest;
    if (plan_.validation) {
      json["best_cycle"] = network.best_cycle;
      json["best_validation_mean_error"] = network.best_error;
    }
    json["curve"] = curve_json(network.curve, lesson_.stream && lesson_.recall, plan_.validation != nullptr);
    return json;
  }

  std::string status_text(const TrainedNetwork& network) const {
    const bool at_end = plan_.rows && network.status == nn::TrainStatus::cycle_limit;
    return at_end ? "all rows seen" : nn::name(network.status);
  }

  std::string summary() const {
    std::map<std::string, int> count;
    for (const TrainedNetwork& network : training_->networks()) ++count[status_text(network)];
    std::string text = fmt::format("{}: {} networks trained on {} rows{} in {:.2f} s, {} patterns/s:", request_.output,
                                   training_->networks().size(), training_->rows(),
                                   ranks_.count() > 1 ? fmt::format(" by {} processes", ranks_.count()) : "",
                                   training_->seconds(), with_prefix(pace()));
    for (const auto& [status, many] : count) text += fmt::format(" {} {},", many, status);
    text.back() = '\n';
    text += fmt::format("device: {}\n", executor_.device().info().name);
    if (lesson_.set && lesson_.set->rows.left_out > 0)
      text += fmt::format("{} rows of the set were left out: over tolerance, or without a slippage index\n",
                          lesson_.set->rows.left_out);
    if (plan_.validation)
      for (const TrainedNetwork& network : training_->networks()) text += kept(network);
    return text + shares();
  }

  /// Which weights of a network are its result, and why its training ended.
  std::string kept(const TrainedNetwork& network) const {
    const char* const unit = lesson_.stream ? "block" : "cycle";
    std::string text = fmt::format("{} seed {}", network.topology.text(), network.seed);
    if (plan_.noises.size() > 1) text += fmt::format(" noise {:g}", network.noise);
    if (network.best_cycle > 0)
      text += fmt::format(": weights of {} {}, mean error {:.5f} on {}", unit, network.best_cycle, network.best_error,
                          request_.validation_set);
    const bool early = network.status == nn::TrainStatus::early_stop;
    return text +
           fmt::format("; ended at {} {}: {}\n", unit, network.cycles,
                       early ? fmt::format("no smaller one for {} {}s", plan_.patience, unit) : status_text(network));
  }

  /// "simulation 70 %, ...": shares of the time of all threads of this run on a stream.
  std::string shares() const {
    const TrainingStages& stages = training_->stages();
    if (!lesson_.stream || stages.all <= 0) return "";  // nothing was left to learn
    const auto share = [&](double seconds) { return 100 * std::max(0.0, seconds) / stages.all; };
    return fmt::format("{} {:.0f} %, inputs {:.0f} %, training {:.0f} %, waiting {:.0f} %\n",
                       request_.stream.empty() ? "reading" : "simulation", share(stages.rows), share(stages.inputs),
                       share(stages.training), share(stages.all - stages.rows - stages.inputs - stages.training));
  }

  const TrainRequest& request_;
  const TrainingPlan& plan_;
  const Ranks& ranks_;
  Lesson& lesson_;
  Executor& executor_;
  const TrainingWatch& watch_;
  TrainingDirectory directory_;
  std::optional<NetworkTraining<Real>> training_;  ///< none where there are more processes than seeds
  std::optional<nn::FrameSet> judges_;             ///< of the recall set, for the curves of a stream
  double share_ = 0;
};

/// Reads the plan's validation set, too.
Lesson read_lesson(const TrainRequest& request, TrainingPlan& plan, const Device& device, const TrainingWatch& watch) {
  const auto stage = [&](const std::string& file) {
    if (watch.stage) watch.stage(file.empty() ? "" : "reading " + file);
  };
  Lesson lesson;
  const ShownRows shown{plan.history, plan.magnitude, plan.target, plan.markers};
  if (!request.stream.empty()) {
    lesson.simulation = std::make_unique<Executor>(device);
    lesson.stream = simulated_stream(*lesson.simulation, request.stream, contacts_a_block, request.rung, {}, shown);
  } else if (request.block) {
    lesson.stream = file_stream(request.set, static_cast<std::uint64_t>(*request.block), plan.seeds.front(),
                                plan.batch->order, shown);
  } else {
    stage(request.set);
    lesson.set = read_learning_set(request);
    check_width(plan, *lesson.set);
  }
  if (!request.validation_set.empty()) {
    stage(request.validation_set);
    const NamedSet set = read_set(request.validation_set, plan.target, plan.markers);
    check_width(plan, set);
    check_learnable(set.rows, set.file);
    plan.validation =
        std::make_shared<nn::FrameSet>(shown_rows(set.rows.frames, plan.history, plan.magnitude, set.file));
  }
  if (lesson.stream) check_width(plan, lesson.stream->inputs(), lesson.name());
  if (!request.recall_set.empty()) {
    stage(request.recall_set);
    lesson.recall = read_set(request.recall_set, plan.target, plan.markers);
    check_width(plan, *lesson.recall);
  }
  stage("");
  return lesson;
}

}  // namespace

TrainingOutcome train(const TrainRequest& request, const Ranks& ranks, const TrainingWatch& watch) try {
  TrainingPlan plan = plan_of(request);
  if (request.streams() && ranks.count() > 1)
    throw ConfigError("command line", request.stream.empty() ? "--block" : "--stream",
                      fmt::format("with {} processes", ranks.count()), "trained by one process, without mpirun");
  const Device device(request.device);
  Executor executor{training_device(device, plan)};
  if (watch.log && executor.device().info().index != device.info().index)
    watch.log(LogLevel::warning, fmt::format("networks train on {}: of these, training has no layout for {}",
                                             executor.device().info().name, device.info().name));
  Lesson lesson = read_lesson(request, plan, device, watch);
  if (ranks.first()) TrainingDirectory(request.output).check(request.resume, request.force);
  ranks.barrier();
  return in_precision(precision_named(request.precision), [&]<class Real>() {
    return Training<Real>(request, plan, ranks, lesson, executor, watch).run();
  });
} catch (const ValueError& error) {
  throw ConfigError(request.stream.empty() ? request.set : request.stream, error);
}

}  // namespace tactel::host
