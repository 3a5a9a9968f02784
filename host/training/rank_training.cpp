// SPDX-License-Identifier: Apache-2.0
#include "host/training/rank_training.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "host/support/bounded_file.h"
#include "host/support/durable_file.h"
#include "host/support/errors.h"
#include "host/support/json_text.h"
#include "host/training/learning_curves.h"
#include "host/training/training.h"
#include "host/training/training_directory.h"

namespace tactel::host {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

fs::path rank_directory(const std::string& output, int rank) { return fs::path(output) / fmt::format("rank-{}", rank); }

Json report_of(const fs::path& directory) { return Json::parse(read_report(TrainingDirectory(directory).report())); }

// The networks' files lie in a directory itself, whatever its report says.
fs::path file_of(const Json& network) { return fs::path(network.at("file").get<std::string>()).filename(); }

/// What the figure needs of a network's part of the report.
TrainedNetwork network_of(const Json& json) {
  TrainedNetwork network{.topology = nn::Topology::parse(json.at("topology").get<std::string>()),
                         .seed = json.at("seed"),
                         .noise = json.at("noise"),
                         .curve = {}};
  network.curve.cycle = json.at("curve").at("cycle").get<std::vector<std::uint64_t>>();
  for (const auto& [from, to] : {std::pair{"sse", &network.curve.sse}, {"largest_error", &network.curve.largest}})
    for (const Json& value : json.at("curve").at(from)) to->push_back(value.is_number() ? value.get<float>() : NAN);
  return network;
}

/// In the order of one process: topologies, noises, seeds.
void sort_networks(Json& networks, const TrainingPlan& plan) {
  const auto place = [&](const Json& n) {
    const auto topology = std::ranges::find(plan.topologies, n.at("topology").get<std::string>(), &nn::Topology::text);
    return std::tuple(topology - plan.topologies.begin(), std::ranges::find(plan.noises, n.at("noise").get<double>()),
                      n.at("seed").get<std::uint64_t>());
  };
  std::vector<Json> all(networks.begin(), networks.end());
  std::ranges::stable_sort(all, {}, place);
  networks = all;
}

constexpr std::uintmax_t largest_network = std::uintmax_t{16} << 20;  ///< bytes of a file

void copy_network(const fs::path& from, const fs::path& to) try {
  write_file("--output", to, read_bounded_file(from, largest_network));
} catch (const UnreadableFile& error) {
  throw ConfigError(from.string(), "network", std::string("cannot be read (") + error.what() + ")",
                    "there, as this process wrote it; --force trains anew");
}

/// Copies a process's networks to DIR, so that they survive a power cut, and adds its report to that of all.
void add_part(const TrainingDirectory& directory, const fs::path& from, Json part, Json& report) {
  for (const Json& network : part["networks"])
    if (network.at("file").is_string()) copy_network(from / file_of(network), directory.network(file_of(network)));
  if (report.is_null()) {
    report = std::move(part);
    return;
  }
  for (Json& network : part["networks"]) report["networks"].push_back(std::move(network));
  report["patterns"] = report["patterns"].get<double>() + part["patterns"].get<double>();
  report["seconds"] = std::max(report["seconds"].get<double>(), part["seconds"].get<double>());
}

/// Moves the networks of all processes to DIR and joins their reports; training.json comes last, then the processes'
/// own directories go. Puts what there is to say into the outcome. Throws ConfigError for a report that is damaged.
void put_together(const TrainRequest& request, const TrainingPlan& plan, int ranks, TrainingOutcome& outcome) try {
  const TrainingDirectory directory(request.output);
  if (request.force) directory.clear();
  Json report;
  for (int rank = 0; rank < ranks; ++rank) {
    const fs::path from = rank_directory(request.output, rank);
    if (fs::exists(from)) add_part(directory, from, report_of(from), report);
  }
  sort_networks(report["networks"], plan);
  report["processes"] = ranks;
  report["options"]["seeds"] = request.seeds;
  report["options"]["first_seed"] = request.first_seed;
  report["patterns_per_second"] = report["patterns"].get<double>() / report["seconds"].get<double>();
  std::vector<TrainedNetwork> networks;
  for (const Json& network : report["networks"]) networks.push_back(network_of(network));
  outcome.undrawn = directory.draw(learning_curves(networks, plan.options.stop_error));
  write_file("--output", directory.report(), json_text(report));
  for (int rank = 0; rank < ranks; ++rank) fs::remove_all(rank_directory(request.output, rank));
  outcome.summary = fmt::format("{}: {} networks of {} processes, {:.2f} s\n", request.output, networks.size(), ranks,
                                report["seconds"].get<double>());
} catch (const nlohmann::json::exception& error) {
  throw ConfigError(request.output, "the processes' reports", error.what(), "whole; --force trains anew");
}

class RankTraining : public TrainingJob {
 public:
  RankTraining(const Ranks& ranks, const TrainRequest& request, const TrainingPlan& plan, const NamedSet& set,
               const std::optional<NamedSet>& recall_set)
      : ranks_(ranks), request_(request), own_request_(request), plan_(plan), own_plan_(plan) {
    if (ranks.first()) check_output();
    ranks.barrier();
    own_plan_.seeds.clear();
    for (std::size_t i = static_cast<std::size_t>(ranks.rank()); i < plan.seeds.size(); i += ranks.count())
      own_plan_.seeds.push_back(plan.seeds[i]);
    if (own_plan_.seeds.empty()) return;
    own_request_.output = rank_directory(request.output, ranks.rank());
    TrainingDirectory(own_request_.output).check(request.resume, request.force);
    own_ = set_training(own_request_, own_plan_, set, recall_set);
  }

  TrainingOutcome run(const TrainingWatch& watch) override {
    TrainingOutcome own;
    if (own_) own = own_->run(watch);
    struct Together {
      double stopped, networks, diverged;
    };
    const auto all = ranks_.sum(Together{own.end == TrainingEnd::stopped ? 1.0 : 0.0, static_cast<double>(own.networks),
                                         static_cast<double>(own.diverged)});
    if (all.stopped > 0) return {.end = TrainingEnd::stopped};
    TrainingOutcome outcome{.networks = static_cast<std::size_t>(all.networks),
                            .diverged = static_cast<std::size_t>(all.diverged)};
    if (ranks_.first()) put_together(request_, plan_, ranks_.count(), outcome);
    ranks_.barrier();
    return outcome;
  }

 private:
  void check_output() const {
    const TrainingDirectory directory(request_.output);
    directory.check(request_.resume, request_.force);
    if (request_.resume && directory.finished())
      throw ConfigError("command line", "--resume", request_.output, "an unfinished training; this one is complete");
  }

  const Ranks& ranks_;
  TrainRequest request_, own_request_;  ///< of all processes, and of this one
  TrainingPlan plan_, own_plan_;
  std::unique_ptr<TrainingJob> own_;  ///< none where there are more processes than seeds
};

}  // namespace

std::unique_ptr<TrainingJob> rank_training(const Ranks& ranks, const TrainRequest& request, const TrainingPlan& plan,
                                           const NamedSet& set, const std::optional<NamedSet>& recall_set) {
  return std::make_unique<RankTraining>(ranks, request, plan, set, recall_set);
}

}  // namespace tactel::host
