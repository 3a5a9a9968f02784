#include "host/training.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "host/atomic_file.h"
#include "host/checksum.h"
#include "host/interrupt.h"
#include "host/json_text.h"
#include "host/learning_curves.h"
#include "host/network_report.h"
#include "host/onnx_file.h"
#include "host/progress_line.h"
#include "host/training_directory.h"

namespace tactel::host {
namespace {

using Json = nlohmann::ordered_json;

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

}  // namespace

int run_training(const TrainRequest& request, const SweepPlan& plan, const NamedSet& set,
                 const std::optional<NamedSet>& recall_set) {
  if (request.shared.precision == "fp64") return Training<double>(request, plan, set).run(recall_set);
  return Training<float>(request, plan, set).run(recall_set);
}

}  // namespace tactel::host
