// SPDX-License-Identifier: Apache-2.0
#include "host/training/stream_training.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "host/networks/onnx_file.h"
#include "host/networks/train_batch.h"
#include "host/networks/training_checkpoint.h"
#include "host/support/checksum.h"
#include "host/support/durable_file.h"
#include "host/support/errors.h"
#include "host/support/json_text.h"
#include "host/support/made_ahead.h"
#include "host/support/progress_line.h"
#include "host/training/frame_stream.h"
#include "host/training/learning_curves.h"
#include "host/training/network_report.h"
#include "host/training/training_directory.h"

namespace tactel::host {
namespace {

using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

constexpr std::uint64_t contacts_a_block = 8192;
constexpr double last_rate = 0.01;      ///< of the first
constexpr double validate_every = 1.5;  ///< each time so many times more rows have been seen

/// Time of this run, s, summed over threads; the rest of `all` they waited.
struct Stages {
  double simulation = 0, inputs = 0, training = 0, all = 0;
};

/// The blocks under way at the end of a training are of no use.
class StopAtEnd {
 public:
  explicit StopAtEnd(FrameStream& stream) : stream_(stream) {}
  ~StopAtEnd() { stream_.stop(); }
  StopAtEnd(const StopAtEnd&) = delete;
  StopAtEnd& operator=(const StopAtEnd&) = delete;

 private:
  FrameStream& stream_;
};

/// Networks [topologies][seeds] on their way. Of each, `curve.cycle` counts rows; sse is the mean squared error of a
/// block before training on it, largest its largest error, or the mean error on the validation set where there is one.
template <class Real>
class StreamTraining : public TrainingJob {
 public:
  StreamTraining(const TrainRequest& request, const TrainingPlan& plan)
      : request_(request),
        plan_(plan),
        all_rows_(request.rows.value_or(default_rows)),
        name_(request.stream.empty() ? request.set : request.stream),
        directory_(request.output),
        executor_(Device(request.shared.device)),
        simulation_(executor_.device()) {
    stream_ = request.stream.empty()
                  ? file_stream(request.set, static_cast<std::uint64_t>(*request.block), plan.seeds.front(),
                                plan.batch->order, {plan.history, plan.magnitude})
                  : simulated_stream(simulation_, request.stream, contacts_a_block, {}, {plan.history, plan.magnitude});
    for (const nn::Topology& topology : plan.topologies) {
      if (topology.inputs() != stream_->inputs())
        throw ConfigError("command line", "--network", topology.text(),
                          fmt::format("a network with {} inputs, as many as the frames have", stream_->inputs()));
      for (const std::uint64_t seed : plan.seeds)
        networks_.push_back({.network = {.topology = topology, .seed = seed, .noise = plan.noises[0], .curve = {}},
                             .state = nn::BatchState<Real>(nn::initial_weights(topology, seed))});
    }
    if (!request.recall_set.empty()) {
      recall_ = read_set(request.recall_set);
      check_width(plan, *recall_);
    }
    done_before_ = request.resume && directory_.finished();
    if (!done_before_) {
      const auto start = Clock::now();
      take_first_block();
      first_seconds_ = seconds_since(start);
      scaling_ = nn::fit_scaling(plan.scaling, first_rows_);
      if (std::ranges::any_of(plan.topologies, &nn::Topology::has_bound)) {
        const nn::FrameSet shown = nn::with_noise(first_rows_, plan.noises[0], plan.seeds[0]);
        bound_ = nn::uncalibrated_bound(nn::scale_frames<float>(scaling_, shown.frames),
                                        stream_->inputs() / (2 * plan.history.frames));
        bound_.level = plan.batch->level;
      }
    }
  }

  TrainingOutcome run(const TrainingWatch& watch) override {
    const std::string fingerprint = checksum_text(description());
    if (done_before_) {
      directory_.expect_same(fingerprint);
      return {.end = TrainingEnd::done_before};
    }
    if (request_.force) directory_.clear();
    if (request_.resume) load();
    if (!learn(watch)) return {.end = TrainingEnd::stopped, .share = share(), .checkpoint = directory_.checkpoint()};
    return finish(fingerprint);
  }

 private:
  using Record = NetworkRecord<Real>;
  static bool running(const Record& n) { return n.network.status != nn::TrainStatus::not_finite; }

  double share() const { return std::min(1.0, static_cast<double>(rows_) / static_cast<double>(all_rows_)); }

  // What a stream's frames are scaled by is fitted to its first rows.
  void take_first_block() {
    for (; first_ < stream_->blocks(); ++first_)
      if (first_rows_ = stream_->block(first_); first_rows_.rows() > 0) return;
    throw ConfigError(name_, "slip_index", "of no row solved", "at least one row to learn from");
  }

  /// All that the networks' bits depend on.
  std::string description() const {
    std::string text =
        fmt::format("tactel " TACTEL_VERSION
                    " stream precision {} lanes {} rows {} batch {} rate {:a} {} momentum {:a} order {} "
                    "scaling {} noise {:a} networks",
                    sizeof(Real), executor_.device().lanes(precision_of<Real>), all_rows_, plan_.batch->batch,
                    plan_.batch->rate, nn::name(plan_.batch->rule), plan_.batch->momentum, nn::name(plan_.batch->order),
                    nn::name(plan_.scaling), plan_.noises[0]);
    for (const Record& n : networks_) text += fmt::format(" {}:{}", n.network.topology.text(), n.network.seed);
    if (std::ranges::any_of(plan_.topologies, &nn::Topology::has_bound))
      text += fmt::format(" level {:a}", plan_.batch->level);
    return text + "\n" + stream_->description();
  }

  bool learn(const TrainingWatch& watch) {
    for (const std::string& warning : stream_->warnings())
      if (watch.log) watch.log(LogLevel::warning, warning);
    auto written = Clock::now();
    const int threads = stream_->at_once();
    if (block_ > first_)
      first_rows_ = {};
    else
      seconds_ += first_seconds_, stages_.simulation += first_seconds_, stages_.all += first_seconds_;
    MadeAhead<Block> blocks(block_, threads, static_cast<std::size_t>(threads) + 2,
                            [this](std::uint64_t k) { return made_block(k); });
    const StopAtEnd stop_at_end(*stream_);
    while (rows_ < all_rows_ && std::ranges::any_of(networks_, running)) {
      const auto start = Clock::now();
      const Block block = blocks.next();
      const auto taken = Clock::now();
      if (!block.inputs && block_ < stream_->blocks() && watch.log)
        watch.log(LogLevel::warning, name_ + ": a block without a row that was solved with a slippage index");
      learn_block(block);
      ++block_;
      if (recall_ && (rows_ >= all_rows_ || time_to_note())) validate();
      const double seconds = seconds_since(start);
      seconds_ += seconds;
      stages_.simulation += block.simulation, stages_.inputs += block.inputs_seconds;
      stages_.training += seconds_since(taken);
      stages_.all += seconds * (1 + blocks.threads());
      const bool stop = watch.progress && !watch.progress(std::min(rows_, all_rows_), all_rows_, 0);
      if (stop || seconds_since(written) > request_.checkpoint_seconds) save(), written = Clock::now();
      if (stop && rows_ < all_rows_) return false;
    }
    return true;
  }

  /// A block as networks learn it, and the time that its parts took, s.
  struct Block {
    std::optional<LearningInputs<Real>> inputs{};  ///< none: no row has an answer
    double simulation = 0, inputs_seconds = 0;
  };

  // A frame of the block that passes the range of numbers once it is scaled throws ConfigError.
  Block made_block(std::uint64_t k) try {
    const auto start = Clock::now();
    const nn::FrameSet rows = k == first_ ? std::exchange(first_rows_, {}) : stream_->block(k);
    Block block;
    block.simulation = seconds_since(start);
    if (rows.rows() == 0) return block;
    const double noise = plan_.noises[0];
    std::vector<SetVariant> variants{{}};
    if (noise != 0) variants.clear();  // drawn anew for every block
    for (const std::uint64_t seed : plan_.seeds)
      if (noise != 0) variants.push_back({noise, seed + (k << 20)});
    block.inputs.emplace(executor_.device(), rows, scaling_, variants);
    block.inputs_seconds = seconds_since(start) - block.simulation;
    return block;
  } catch (const ValueError& error) {
    throw ConfigError(name_, fmt::format("{} of block {}", error.key, k), error.value, error.allowed);
  }

  void learn_block(const Block& block) {
    if (!block.inputs) return;
    nn::BatchOptions options = *plan_.batch;
    options.rate *= std::max(last_rate, 1 - static_cast<double>(rows_) / static_cast<double>(all_rows_));
    for (std::size_t first = 0; first < networks_.size(); first += plan_.seeds.size())
      learn_topology(std::span(networks_).subspan(first, plan_.seeds.size()), *block.inputs, options);
    rows_ += block.inputs->rows();
    if (!recall_ && time_to_note()) note();
  }

  // The networks of one topology, of each seed; those that have diverged are left as they are.
  void learn_topology(std::span<Record> family, const LearningInputs<Real>& inputs, const nn::BatchOptions& options) {
    std::vector<OnlineMember> members;
    std::vector<Record*> learning;
    for (std::size_t i = 0; i < family.size(); ++i) {
      if (!running(family[i])) continue;
      members.push_back({plan_.seeds[i], plan_.noises[0] == 0 ? 0 : static_cast<std::uint32_t>(i)});
      learning.push_back(&family[i]);
    }
    if (learning.empty()) return;
    TrainBatch<Real> training(executor_, family[0].network.topology, inputs, members, options);
    for (std::size_t i = 0; i < learning.size(); ++i) training.set_state(i, learning[i]->state);
    const auto errors = training.train_epoch();
    for (std::size_t i = 0; i < learning.size(); ++i) {
      TrainedNetwork& network = learning[i]->network;
      learning[i]->state = training.state(i);
      network.sse = static_cast<float>((*errors)[i].sse / static_cast<double>(inputs.rows()));
      network.largest = static_cast<float>((*errors)[i].largest);
      if (!std::isfinite(network.sse) || !nn::all_finite(learning[i]->state.weights))
        network.status = nn::TrainStatus::not_finite;
    }
  }

  bool time_to_note() const {
    return rows_ > 0 && static_cast<double>(rows_) >= validate_every * static_cast<double>(noted_rows());
  }
  // Rows seen when the curves were last noted: they keep it, so that a resumed training notes where any other does.
  std::uint64_t noted_rows() const {
    const std::vector<std::uint64_t>& noted = networks_[0].network.curve.cycle;
    return noted.empty() ? 0 : noted.back();
  }
  /// Notes where every network stands: rows seen, squared error on the last block, and on the validation set.
  void note() {
    for (Record& n : networks_) {
      n.network.curve.cycle.push_back(rows_);
      n.network.curve.sse.push_back(n.network.sse);
      n.network.curve.largest.push_back(n.network.largest);
    }
  }
  void validate() {
    note();
    for (Record& n : networks_)
      n.network.curve.largest.back() = running(n) ? static_cast<float>(recalled(n).errors.all.mean) : NAN;
  }

  NetworkResult recalled(const Record& n) {
    const NamedNetwork named{"", model_of(n)};
    return (*recall_networks<Real>(executor_, std::span(&named, 1), recall_->rows.frames, false, Progress()))[0];
  }
  nn::Model model_of(const Record& n) const {
    nn::Model model{nn::Weights<float>(nn::weights_of_frames(n.state.weights, plan_.history.frames)),
                    scaling_,
                    n.network.seed,
                    n.network.noise,
                    name_,
                    static_cast<std::uint32_t>(block_),
                    {},
                    plan_.history,
                    plan_.magnitude};
    model.learning_errors.count = rows_;
    if (n.network.topology.has_bound()) model.bound = bound_;
    return model;
  }

  void save() {
    for (Record& n : networks_) {
      n.network.cycles = static_cast<std::uint32_t>(block_);
      n.network.seconds = seconds_;
      n.rows = rows_;
    }
    write_checkpoint<Real>(directory_.checkpoint(), description(), networks_);
  }

  void load() {
    if (!read_checkpoint<Real>(directory_.checkpoint(), description(), networks_)) return;
    const Record& first = networks_[0];
    const auto learns = std::ranges::find_if(networks_, running);
    const auto alike = [&](const Record& n) {
      const bool in_step =
          !running(n) || (n.state.epoch == learns->state.epoch && n.state.updates == learns->state.updates);
      return in_step && n.network.cycles == first.network.cycles && n.rows == first.rows &&
             n.network.curve.cycle == first.network.curve.cycle;
    };
    if (!std::ranges::all_of(networks_, alike) || noted_rows() > first.rows)
      throw ConfigError(directory_.checkpoint().string(), "checkpoint", "damaged", "whole; delete it to start anew");
    block_ = first.network.cycles;
    seconds_ = first.network.seconds;
    rows_ = first.rows;
  }

  Json report_json(const std::string& fingerprint) const {
    Json report = {{"tactel", TACTEL_VERSION},
                   {"stream", name_},
                   {"rows", rows_},
                   {"blocks", block_},
                   {"device", executor_.device().info().name},
                   {"precision", sizeof(Real) == 8 ? "fp64" : "fp32"},
                   {"fingerprint", fingerprint},
                   {"options",
                    {{"batch", plan_.batch->batch},
                     {"optimizer", nn::name(plan_.batch->rule)},
                     {"learning_rate", plan_.batch->rate},
                     {"last_learning_rate", last_rate * plan_.batch->rate},
                     {"momentum", plan_.batch->momentum},
                     {"order", nn::name(plan_.batch->order)},
                     {"scaling", nn::name(plan_.scaling)},
                     {"noise", plan_.noises[0]}}},
                   {"seconds", seconds_},
                   {"networks", Json::array()}};
    if (plan_.history.frames > 1)
      report["options"]["history"] = {
          {"frames", plan_.history.frames}, {"stride", plan_.history.stride}, {"change", plan_.history.change}};
    if (plan_.magnitude) report["options"]["magnitude"] = true;
    return report;
  }

  static Json curve_json(const LearningCurve& curve, bool validated) {
    Json thousands = Json::array();
    for (const std::uint64_t rows : curve.cycle) thousands.push_back(rows / 1000);
    Json json = {{"thousand_rows", thousands}, {"rows", curve.cycle}, {"mean_squared_error", curve.sse}};
    if (validated) json["recall_mean_error"] = curve.largest;
    return json;
  }

  /// "simulation 70 %, ...": shares of the time of all threads of this run.
  std::string shares() const {
    if (stages_.all <= 0) return "";  // nothing was left to learn
    const double waiting = stages_.all - stages_.simulation - stages_.inputs - stages_.training;
    const auto share = [&](double seconds) { return 100 * std::max(0.0, seconds) / stages_.all; };
    return fmt::format("{} {:.0f} %, inputs {:.0f} %, training {:.0f} %, waiting {:.0f} %\n",
                       request_.stream.empty() ? "reading" : "simulation", share(stages_.simulation),
                       share(stages_.inputs), share(stages_.training), share(waiting));
  }

  TrainingOutcome finish(const std::string& fingerprint) {
    Json report = report_json(fingerprint);
    std::vector<NamedNetwork> named;
    std::vector<NetworkResult> results;
    TrainingOutcome outcome{.networks = networks_.size()};
    std::vector<TrainedNetwork> drawn;
    for (const Record& n : networks_) {
      const bool good = running(n);
      drawn.push_back(n.network);
      Json json = to_json(NamedNetwork{"", model_of(n)});
      json["status"] = good ? "all rows seen" : nn::name(n.network.status);
      json["curve"] = curve_json(n.network.curve, recall_.has_value());
      json["file"] = nullptr;
      if (good) {
        named.push_back({network_file_name(n.network.topology, n.network.noise, n.network.seed), model_of(n)});
        write_onnx(directory_.network(named.back().file), named.back().model);
        json["file"] = named.back().file;
        if (recall_) {
          results.push_back(recalled(n));
          json.update(to_json(results.back(), recall_->contacts.indenter_names));
        }
      }
      outcome.diverged += !good;
      report["networks"].push_back(std::move(json));
    }
    outcome.undrawn = directory_.draw(stream_curves(drawn, recall_.has_value()));
    write_file("--output", directory_.report(), json_text(report));
    directory_.remove_checkpoint();
    outcome.summary =
        fmt::format("{}: {} networks, {} rows in {:.1f} s ({} rows/s)\n", request_.output, networks_.size(), rows_,
                    seconds_, with_prefix(static_cast<double>(rows_) / seconds_)) +
        shares();
    if (!results.empty())
      outcome.tables.push_back(
          fmt::format("errors |S - S of the set| on {}\n{}", recall_->file, error_table(named, results)));
    return outcome;
  }

  const TrainRequest& request_;
  const TrainingPlan& plan_;
  std::uint64_t all_rows_;
  std::string name_;
  TrainingDirectory directory_;
  Executor executor_;
  Executor simulation_;  ///< of the stream's contacts, beside the training
  std::unique_ptr<FrameStream> stream_;
  std::optional<NamedSet> recall_;
  std::uint64_t first_ = 0;  ///< the first block that has rows
  nn::FrameSet first_rows_;  ///< its rows, until they are learnt
  double first_seconds_ = 0;
  nn::InputScaling scaling_;
  nn::Bound bound_{};             ///< before its calibration; of networks with its heads
  std::vector<Record> networks_;  ///< [topologies][seeds]
  std::uint64_t block_ = 0, rows_ = 0;
  double seconds_ = 0;
  Stages stages_;
  bool done_before_ = false;
};

}  // namespace

std::unique_ptr<TrainingJob> stream_training(const TrainRequest& request, const TrainingPlan& plan) try {
  if (request.shared.precision == "fp64") return std::make_unique<StreamTraining<double>>(request, plan);
  return std::make_unique<StreamTraining<float>>(request, plan);
} catch (const ValueError& error) {
  throw ConfigError(request.stream.empty() ? request.set : request.stream, error);
}

}  // namespace tactel::host
