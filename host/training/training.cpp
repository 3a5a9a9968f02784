// SPDX-License-Identifier: Apache-2.0
#include "host/training/training.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "host/networks/onnx_file.h"
#include "host/support/checksum.h"
#include "host/support/durable_file.h"
#include "host/support/errors.h"
#include "host/support/json_text.h"
#include "host/support/progress_line.h"
#include "host/training/learning_curves.h"
#include "host/training/network_report.h"
#include "host/training/training_directory.h"

namespace tactel::host {
namespace {

using Json = nlohmann::ordered_json;

Json options_json(const TrainRequest& request, const TrainingPlan& plan) {
  Json options = {{"schedule", plan.batch ? "batch" : "online"},
                  {"scaling", nn::name(plan.scaling)},
                  {"order", request.order},
                  {"learning_rate", plan.batch ? plan.batch->rate : plan.options.rate},
                  {"momentum", plan.batch ? plan.batch->momentum : plan.options.momentum},
                  {"stop_error", plan.options.stop_error},
                  {"cycles", plan.options.cycle_limit > 0 ? Json(plan.options.cycle_limit) : Json(nullptr)},
                  {"noise", plan.noises},
                  {"seeds", request.seeds},
                  {"first_seed", request.first_seed}};
  if (plan.history.frames > 1)
    options["history"] = {
        {"frames", plan.history.frames}, {"stride", plan.history.stride}, {"change", plan.history.change}};
  if (plan.magnitude) options["magnitude"] = true;
  if (!plan.batch) return options;
  options["batch"] = plan.batch->batch;
  options["optimizer"] = nn::name(plan.batch->rule);
  return options;
}

/// A training from the set to its files.
template <class Real>
class SetTraining : public TrainingJob {
 public:
  SetTraining(const TrainRequest& request, const TrainingPlan& plan, const NamedSet& set,
              const std::optional<NamedSet>& recall_set)
      : request_(request),
        plan_(plan),
        set_(set),
        recall_set_(recall_set),
        directory_(request.output),
        executor_(Device(request.shared.device)),
        training_(executor_, set.rows.frames, plan) {}

  TrainingOutcome run(const TrainingWatch& watch) override {
    const std::string fingerprint = checksum_text(training_.description());
    if (request_.resume && directory_.finished()) {
      directory_.expect_same(fingerprint);
      return {.end = TrainingEnd::done_before};
    }
    if (request_.force) directory_.clear();
    if (request_.resume) training_.load(directory_.checkpoint());
    if (!train(watch))
      return {.end = TrainingEnd::stopped, .share = last_share_, .checkpoint = directory_.checkpoint()};
    return finish(fingerprint);
  }

 private:
  bool train(const TrainingWatch& watch) {
    const auto progress = [&](std::size_t done, std::size_t all) {
      last_share_ = static_cast<double>(done) / static_cast<double>(all);
      return !watch.progress || watch.progress(done, all, pace());
    };
    return training_.run({.progress = progress,
                          .checkpoint = directory_.checkpoint(),
                          .checkpoint_seconds = request_.checkpoint_seconds});
  }

  double pace() const { return training_.seconds() > 0 ? training_.patterns() / training_.seconds() : 0; }

  TrainingOutcome finish(const std::string& fingerprint) {
    take_networks();
    for (const NamedNetwork& network : networks_)
      if (!network.file.empty()) write_onnx(directory_.network(network.file), network.model);
    std::vector<NetworkResult> recalled;
    if (recall_set_)
      recalled = *recall_networks<Real>(executor_, networks_, recall_set_->rows.frames, false, Progress());
    const std::string undrawn = directory_.draw(learning_curves(training_.networks(), plan_.options.stop_error));
    Json report = report_json(fingerprint);
    for (std::size_t i = 0; i < recalled.size(); ++i)
      report["networks"][i].update(to_json(recalled[i], recall_set_->contacts.indenter_names));
    if (recall_set_) report["recall_set"] = recall_set_->file;
    write_file("--output", directory_.report(), json_text(report));
    directory_.remove_checkpoint();
    TrainingOutcome outcome{.networks = networks_.size(), .summary = summary(), .undrawn = undrawn};
    for (const NamedNetwork& network : networks_) outcome.diverged += network.file.empty();
    outcome.tables = {"errors |S - S of the set| on the learning set, noise included\n" +
                      error_table(networks_, learnt_)};
    if (recall_set_)
      outcome.tables.push_back(fmt::format("the same on {}\n{}", recall_set_->file, error_table(networks_, recalled)));
    return outcome;
  }

  // A network whose weights are not all finite has diverged, even where its outputs saturate and its errors are finite.
  nn::TrainStatus status_of(std::size_t i) const {
    return nn::all_finite(training_.weights(i)) ? training_.networks()[i].status : nn::TrainStatus::not_finite;
  }

  // Models and errors of all networks; one that has diverged has no file.
  void take_networks() {
    for (nn::ErrorReport& errors : training_.recall_learning_set()) {
      const std::size_t i = networks_.size();
      const TrainedNetwork& network = training_.networks()[i];
      const bool good = status_of(i) != nn::TrainStatus::not_finite;
      networks_.push_back({good ? network_file_name(network.topology, network.noise, network.seed) : "",
                           training_.model(i, request_.set, errors.all)});
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
            {"patterns", training_.patterns()},
            {"seconds", training_.seconds()},
            {"patterns_per_second", pace()},
            {"networks", networks}};
  }

  Json network_json(std::size_t i) const {
    const TrainedNetwork& network = training_.networks()[i];
    Json json = to_json(networks_[i]);
    if (networks_[i].file.empty()) json["file"] = nullptr;
    json["status"] = nn::name(status_of(i));
    json["seconds"] = network.seconds;
    json["sse"] = network.sse;
    json["largest_error"] = network.largest;
    json["curve"] = {
        {"cycle", network.curve.cycle}, {"sse", network.curve.sse}, {"largest_error", network.curve.largest}};
    return json;
  }

  std::string summary() const {
    std::map<nn::TrainStatus, int> count;
    for (std::size_t i = 0; i < networks_.size(); ++i) ++count[status_of(i)];
    std::string text = fmt::format("{}: {} networks trained on {} rows in {:.2f} s, {} patterns/s:", request_.output,
                                   networks_.size(), set_.rows.frames.rows(), training_.seconds(), with_prefix(pace()));
    for (const auto& [status, many] : count) text += fmt::format(" {} {},", many, nn::name(status));
    text.back() = '\n';
    if (set_.rows.left_out > 0)
      text += fmt::format("{} rows of the set were left out: over tolerance, or without a slippage index\n",
                          set_.rows.left_out);
    return text;
  }

  const TrainRequest& request_;
  const TrainingPlan& plan_;
  const NamedSet& set_;
  const std::optional<NamedSet>& recall_set_;
  TrainingDirectory directory_;
  Executor executor_;
  NetworkTraining<Real> training_;
  double last_share_ = 0;
  std::vector<NamedNetwork> networks_;
  std::vector<NetworkResult> learnt_;
};

}  // namespace

std::unique_ptr<TrainingJob> set_training(const TrainRequest& request, const TrainingPlan& plan, const NamedSet& set,
                                          const std::optional<NamedSet>& recall_set) try {
  if (request.shared.precision == "fp64") return std::make_unique<SetTraining<double>>(request, plan, set, recall_set);
  return std::make_unique<SetTraining<float>>(request, plan, set, recall_set);
} catch (const ValueError& error) {
  throw ConfigError(set.file, error);
}

}  // namespace tactel::host
