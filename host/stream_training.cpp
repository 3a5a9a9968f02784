#include "host/stream_training.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>

#include "host/atomic_file.h"
#include "host/checksum.h"
#include "host/forward.h"
#include "host/frame_stream.h"
#include "host/interrupt.h"
#include "host/json_text.h"
#include "host/network_report.h"
#include "host/onnx_file.h"
#include "host/plot.h"
#include "host/progress_line.h"
#include "host/sweep_checkpoint.h"
#include "host/train_batch.h"
#include "host/training_directory.h"

namespace tactel::host {
namespace {

using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

constexpr std::uint64_t contacts_a_block = 8192;
constexpr double last_rate = 0.01;      ///< of the first
constexpr double validate_every = 1.5;  ///< each time so many times more rows have been seen

/// A network and its way. `curve.cycle` counts rows in thousands; sse is the mean squared error of a block before it
/// was learnt, largest the mean error on the validation set at the last validation.
struct StreamNetwork {
  SweepNetwork network;
  nn::BatchState<float> state;
};

class StreamTraining {
 public:
  StreamTraining(const TrainRequest& request, const SweepPlan& plan)
      : request_(request), plan_(plan), directory_(request.output), executor_(Device(request.shared.device)) {
    stream_ = request.stream.empty()
                  ? file_stream(request.set, static_cast<std::uint64_t>(*request.block), plan.seeds.front())
                  : simulated_stream(executor_, request.stream, contacts_a_block, {});
    for (const nn::Topology& topology : plan.topologies) {
      if (topology.inputs() != stream_->inputs())
        throw ConfigError("command line", "--network", topology.text(),
                          fmt::format("a network with {} inputs, as many as the frames have", stream_->inputs()));
      for (const std::uint64_t seed : plan.seeds)
        networks_.push_back({.network = {.topology = topology, .seed = seed, .noise = plan.noises[0], .curve = {}},
                             .state = nn::BatchState<float>(nn::initial_weights(topology, seed))});
    }
    if (!request.recall_set.empty()) recall_ = read_set(request.recall_set);
  }

  int run() {
    const std::string fingerprint = checksum_text(description());
    if (request_.resume && directory_.finished()) {
      directory_.expect_same(fingerprint);
      say(fmt::format("{}: this training is done\n", request_.output));
      return done;
    }
    if (request_.force) directory_.clear();
    scaling_ = nn::fit_scaling(plan_.scaling, stream_->block(0));
    if (request_.resume) load();
    const Interrupt interrupt;
    if (!learn(interrupt)) {
      fmt::print(stderr, "stopped; the same command with --resume goes on from {}\n", directory_.checkpoint().string());
      return interrupted;
    }
    finish(fingerprint);
    return done;
  }

 private:
  void say(const std::string& text) const {
    if (!request_.shared.quiet) fmt::print("{}", text);
  }

  /// All that the networks' bits depend on.
  std::string description() const {
    std::string text = fmt::format(
        "tactel " TACTEL_VERSION " stream rows {} batch {} rate {:a} {} scaling {} noise {:a} networks", request_.rows,
        plan_.batch->batch, plan_.batch->rate, nn::name(plan_.batch->rule), nn::name(plan_.scaling), plan_.noises[0]);
    for (const StreamNetwork& n : networks_) text += fmt::format(" {}:{}", n.network.topology.text(), n.network.seed);
    return text + "\n" + stream_->description();
  }

  bool learn(const Interrupt& interrupt) {
    ProgressLine line("training", "rows", request_.shared.quiet);
    auto written = Clock::now();
    while (rows_ < request_.rows) {
      const auto start = Clock::now();
      learn_block(stream_->block(block_));
      ++block_;
      if (recall_ && (rows_ >= request_.rows || static_cast<double>(rows_) >= validate_every * validated_)) validate();
      seconds_ += seconds_since(start);
      line.show(std::min<std::uint64_t>(rows_, request_.rows), request_.rows);
      const bool stop = interrupt.requested();
      if (stop || seconds_since(written) > request_.checkpoint_seconds) save(), written = Clock::now();
      if (stop && rows_ < request_.rows) return false;
    }
    return true;
  }

  void learn_block(const nn::FrameSet& block) {
    const double share = static_cast<double>(rows_) / static_cast<double>(request_.rows);
    nn::BatchOptions options = *plan_.batch;
    options.rate *= std::max(last_rate, 1 - share);
    std::vector<SetVariant> variants;
    std::vector<OnlineMember> members;
    for (const std::uint64_t seed : plan_.seeds) {
      members.push_back({seed, plan_.noises[0] == 0 ? 0 : static_cast<std::uint32_t>(variants.size())});
      if (variants.empty() || plan_.noises[0] != 0)  // noise is drawn anew for every block
        variants.push_back({plan_.noises[0], seed + (block_ << 20)});
    }
    const LearningInputs<float> inputs(executor_.device(), block, scaling_, variants);
    for (std::size_t first = 0; first < networks_.size(); first += members.size()) {
      TrainBatch<float> training(executor_, networks_[first].network.topology, inputs, members, options);
      for (std::size_t i = 0; i < members.size(); ++i) training.set_state(i, networks_[first + i].state);
      const auto errors = training.train_epoch();
      for (std::size_t i = 0; i < members.size(); ++i) {
        networks_[first + i].state = training.state(i);
        networks_[first + i].network.sse = static_cast<float>((*errors)[i].sse / static_cast<double>(block.rows()));
        networks_[first + i].network.largest = static_cast<float>((*errors)[i].largest);
      }
    }
    rows_ += static_cast<std::uint64_t>(block.rows());
    if (!recall_ && static_cast<double>(rows_) >= validate_every * validated_) note();
  }

  /// Notes where every network stands: rows seen, squared error on the last block, and on the validation set.
  void note() {
    validated_ = static_cast<double>(rows_);
    for (StreamNetwork& n : networks_) {
      n.network.curve.cycle.push_back(static_cast<std::uint32_t>(rows_ / 1000));
      n.network.curve.sse.push_back(n.network.sse);
      n.network.curve.largest.push_back(n.network.largest);
    }
  }
  void validate() {
    note();
    for (StreamNetwork& n : networks_) n.network.curve.largest.back() = static_cast<float>(recalled(n).errors.all.mean);
  }

  NetworkResult recalled(const StreamNetwork& n) {
    const NamedNetwork named{"", model_of(n)};
    return (*recall_networks<float>(executor_, std::span(&named, 1), recall_->rows.frames, false, Progress()))[0];
  }
  nn::Model model_of(const StreamNetwork& n) const {
    nn::Model model{n.state.weights,
                    scaling_,
                    n.network.seed,
                    n.network.noise,
                    request_.stream.empty() ? request_.set : request_.stream,
                    static_cast<std::uint32_t>(block_),
                    {}};
    model.learning_errors.count = rows_;
    return model;
  }

  void save() const {
    std::vector<NetworkRecord<float>> records;
    for (const StreamNetwork& n : networks_) {
      records.push_back({n.network, n.state.weights.values, n.state.first.values, n.state.second.values});
      records.back().network.cycles = static_cast<std::uint32_t>(block_);
      records.back().network.seconds = seconds_;
      records.back().rows = rows_;
      records.back().updates = n.state.updates;
    }
    write_checkpoint<float>(directory_.checkpoint(), description(), records);
  }

  void load() {
    std::vector<NetworkRecord<float>> records;
    for (const StreamNetwork& n : networks_)
      records.push_back({n.network, n.state.weights.values, n.state.first.values, n.state.second.values});
    if (!read_checkpoint<float>(directory_.checkpoint(), description(), records)) return;
    block_ = records[0].network.cycles;
    seconds_ = records[0].network.seconds;
    rows_ = records[0].rows;
    for (std::size_t i = 0; i < networks_.size(); ++i) {
      networks_[i].network = records[i].network;
      nn::BatchState<float>& state = networks_[i].state;
      state.weights.values = records[i].weights;
      state.first.values = records[i].first;
      state.second.values = records[i].second;
      state.epoch = static_cast<std::uint32_t>(block_);
      state.updates = records[i].updates;
    }
    if (!networks_[0].network.curve.cycle.empty()) validated_ = 1000.0 * networks_[0].network.curve.cycle.back();
  }

  void finish(const std::string& fingerprint) {
    Json report = {{"tactel", TACTEL_VERSION},
                   {"stream", request_.stream.empty() ? request_.set : request_.stream},
                   {"rows", rows_},
                   {"blocks", block_},
                   {"device", executor_.device().info().name},
                   {"fingerprint", fingerprint},
                   {"options",
                    {{"batch", plan_.batch->batch},
                     {"optimizer", nn::name(plan_.batch->rule)},
                     {"learning_rate", plan_.batch->rate},
                     {"last_learning_rate", last_rate * plan_.batch->rate},
                     {"scaling", nn::name(plan_.scaling)},
                     {"noise", plan_.noises[0]}}},
                   {"seconds", seconds_},
                   {"networks", Json::array()}};
    std::vector<NamedNetwork> named;
    std::vector<NetworkResult> results;
    for (const StreamNetwork& n : networks_) {
      named.push_back({network_file_name(n.network.topology, n.network.noise, n.network.seed), model_of(n)});
      write_onnx(directory_.network(named.back().file), named.back().model);
      Json json = to_json(named.back());
      json["curve"] = {{"thousand_rows", n.network.curve.cycle}, {"mean_squared_error", n.network.curve.sse}};
      if (recall_) {
        json["curve"]["recall_mean_error"] = n.network.curve.largest;
        results.push_back(recalled(n));
        json.update(to_json(results.back(), recall_->contacts.indenter_names));
      }
      report["networks"].push_back(std::move(json));
    }
    write_figure("--output", directory_.figure(), figure());
    write_file("--output", directory_.report(), json_text(report));
    directory_.remove_checkpoint();
    say(fmt::format("{}: {} networks, {} rows in {:.1f} s ({} rows/s)\n", request_.output, networks_.size(), rows_,
                    seconds_, with_prefix(static_cast<double>(rows_) / seconds_)));
    if (recall_) say(fmt::format("errors |S - S of the set| on {}\n{}", recall_->file, error_table(named, results)));
  }

  Figure figure() const {
    constexpr Ink inks[] = {Ink::black, Ink::blue,   Ink::green, Ink::orange,
                            Ink::red,   Ink::purple, Ink::brown, Ink::grey};
    Panel block{.title = "fresh frames, before they are learnt",
                .x_label = "rows seen",
                .y_label = "root mean square error of S",
                .log_x = true,
                .log_y = true};
    Panel recall = block;
    recall.title = "validation set", recall.y_label = "mean error of S";
    for (std::size_t i = 0; i < networks_.size(); ++i) {
      const SweepNetwork& n = networks_[i].network;
      Series curve{.label = n.seed == plan_.seeds.front() ? n.topology.text() : "",
                   .mark = Mark::line_dots,
                   .ink = inks[i / plan_.seeds.size() % std::size(inks)]};
      for (std::size_t k = 0; k < n.curve.cycle.size(); ++k) {
        curve.x.push_back(1000.0 * n.curve.cycle[k]);
        curve.y.push_back(std::sqrt(n.curve.sse[k]));
      }
      block.series.push_back(curve);
      curve.y.assign(n.curve.largest.begin(), n.curve.largest.end());
      recall.series.push_back(std::move(curve));
    }
    Figure figure{.panels = {block}, .columns = 2, .width = 900, .panel_height = 340};
    if (recall_) figure.panels.push_back(recall);
    return figure;
  }

  const TrainRequest& request_;
  const SweepPlan& plan_;
  TrainingDirectory directory_;
  Executor executor_;
  std::unique_ptr<FrameStream> stream_;
  std::optional<NamedSet> recall_;
  nn::InputScaling scaling_;
  std::vector<StreamNetwork> networks_;  ///< [topologies][seeds]
  std::uint64_t block_ = 0, rows_ = 0;
  double validated_ = 0, seconds_ = 0;
};

}  // namespace

int run_stream_training(const TrainRequest& request, const SweepPlan& plan) {
  return StreamTraining(request, plan).run();
}

}  // namespace tactel::host
