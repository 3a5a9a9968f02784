#include "host/rank_training.h"

#include <fmt/format.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "host/atomic_file.h"
#include "host/errors.h"
#include "host/interrupt.h"
#include "host/json_text.h"
#include "host/learning_curves.h"
#include "host/plot.h"
#include "host/training.h"
#include "host/training_directory.h"

namespace tactel::host {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

fs::path rank_directory(const std::string& output, int rank) { return fs::path(output) / fmt::format("rank-{}", rank); }

Json report_of(const fs::path& directory) { return Json::parse(std::ifstream(TrainingDirectory(directory).report())); }

/// What the figure needs of a network's part of the report.
SweepNetwork network_of(const Json& json) {
  SweepNetwork network{.topology = nn::Topology::parse(json["topology"].get<std::string>()),
                       .seed = json["seed"],
                       .noise = json["noise"],
                       .curve = {}};
  network.curve.cycle = json["curve"]["cycle"].get<std::vector<std::uint32_t>>();
  for (const auto& [from, to] : {std::pair{"sse", &network.curve.sse}, {"largest_error", &network.curve.largest}})
    for (const Json& value : json["curve"][from]) to->push_back(value.is_number() ? value.get<float>() : NAN);
  return network;
}

/// In the order of one process: topologies, noises, seeds.
void sort_networks(Json& networks, const SweepPlan& plan) {
  const auto place = [&](const Json& n) {
    const auto topology = std::ranges::find(plan.topologies, n["topology"].get<std::string>(), &nn::Topology::text);
    return std::tuple(topology - plan.topologies.begin(), std::ranges::find(plan.noises, n["noise"].get<double>()),
                      n["seed"].get<std::uint64_t>());
  };
  std::vector<Json> all(networks.begin(), networks.end());
  std::ranges::stable_sort(all, {}, place);
  networks = all;
}

/// Moves the networks of all processes to DIR and joins their reports; training.json comes last, then the processes'
/// own directories go.
void put_together(const TrainRequest& request, const SweepPlan& plan, int ranks) {
  const TrainingDirectory directory(request.output);
  if (request.force) directory.clear();
  Json report;
  for (int rank = 0; rank < ranks; ++rank) {
    const fs::path from = rank_directory(request.output, rank);
    if (!fs::exists(from)) continue;
    Json part = report_of(from);
    for (const Json& network : part["networks"])
      if (network["file"].is_string())
        fs::copy_file(from / network["file"].get<std::string>(), directory.network(network["file"].get<std::string>()),
                      fs::copy_options::overwrite_existing);
    if (report.is_null()) {
      report = std::move(part);
      continue;
    }
    for (Json& network : part["networks"]) report["networks"].push_back(std::move(network));
    report["patterns"] = report["patterns"].get<double>() + part["patterns"].get<double>();
    report["seconds"] = std::max(report["seconds"].get<double>(), part["seconds"].get<double>());
  }
  sort_networks(report["networks"], plan);
  report["processes"] = ranks;
  report["options"]["seeds"] = request.seeds;
  report["options"]["first_seed"] = request.first_seed;
  report["patterns_per_second"] = report["patterns"].get<double>() / report["seconds"].get<double>();
  std::vector<SweepNetwork> networks;
  for (const Json& network : report["networks"]) networks.push_back(network_of(network));
  write_figure("--output", directory.figure(), learning_curves(networks, plan.options.stop_error));
  write_file("--output", directory.report(), json_text(report));
  for (int rank = 0; rank < ranks; ++rank) fs::remove_all(rank_directory(request.output, rank));
  if (!request.shared.quiet)
    fmt::print("{}: {} networks of {} processes, {:.2f} s\n", request.output, networks.size(), ranks,
               report["seconds"].get<double>());
}

}  // namespace

int run_rank_training(const Ranks& ranks, TrainRequest request, SweepPlan plan, const NamedSet& set,
                      const std::optional<NamedSet>& recall_set) {
  const SweepPlan whole = plan;
  const std::string output = request.output;
  if (ranks.first()) {
    TrainingDirectory(output).check(request.resume, request.force);
    check_figure_path("--output", TrainingDirectory(output).figure());
    if (request.resume && TrainingDirectory(output).finished())
      throw ConfigError("command line", "--resume", output, "an unfinished training: this one is done");
  }
  ranks.barrier();
  plan.seeds.clear();
  for (std::size_t i = static_cast<std::size_t>(ranks.rank()); i < whole.seeds.size(); i += ranks.count())
    plan.seeds.push_back(whole.seeds[i]);
  int code = done;
  if (!plan.seeds.empty()) {
    request.output = rank_directory(output, ranks.rank());
    const bool quiet = std::exchange(request.shared.quiet, true);
    TrainingDirectory(request.output).check(request.resume, request.force);
    code = run_training(request, plan, set, recall_set);
    request.output = output;
    request.shared.quiet = quiet;
  }
  const std::vector<double> sums = ranks.sum({code == interrupted ? 1.0 : 0.0, code == not_converged ? 1.0 : 0.0});
  if (sums[0] > 0) {
    if (ranks.first()) fmt::print(stderr, "stopped; the same command with --resume and as many processes goes on\n");
    return interrupted;
  }
  if (ranks.first()) put_together(request, whole, ranks.count());
  ranks.barrier();
  return sums[1] > 0 ? not_converged : done;
}

}  // namespace tactel::host
