// SPDX-License-Identifier: Apache-2.0
#include "host/training/named_network.h"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>

#include "host/networks/forward.h"
#include "host/networks/onnx_file.h"
#include "host/support/errors.h"
#include "nn/infer/built_in.h"

namespace tactel::host {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t most_answers = 32 * 1024 * 1024;  ///< networks times rows of one run, for memory's sake

// Topologies with numbers first; then by text, noise, scaling and seed.
auto order_key(const NamedNetwork& network) {
  const nn::Model& model = network.model;
  const int number = paper_number(model.weights.topology);
  return std::tuple(number == 0 ? 7 : number, model.weights.topology.text(), model.noise, model.scaling.kind,
                    model.scaling.largest_stress, model.seed, network.file);
}

std::vector<fs::path> onnx_files(const fs::path& path) {
  const auto refuse = [&](const std::string& allowed) {
    throw ConfigError("command line", "networks", path.string(), allowed);
  };
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) refuse("an existing directory or file");
  if (path.extension() == ".h5") refuse("a directory of networks or a network (*.onnx); the set stands behind it");
  if (!fs::is_directory(status)) return {path};
  std::vector<fs::path> files;
  for (fs::directory_iterator entry(path, error), end; !error && entry != end; entry.increment(error))
    if (entry->path().extension() == ".onnx") files.push_back(entry->path());
  if (error) refuse("a directory that can be read (" + error.message() + ")");
  if (files.empty()) refuse("a directory with networks (*.onnx), as tactel train writes it when it is done");
  return files;
}

void check_width(const NamedNetwork& network, const nn::FrameSet& set) {
  const int frames = network.model.history.frames, inputs = network.model.numbers();
  if (network.model.scaling.markers != set.markers)
    throw ConfigError(network.file, "inputs", set.markers ? "stresses" : "markers",
                      set.markers ? "markers, as of the others" : "stresses, as of the others");
  if (inputs != nn::numbers_of(network.model.history, static_cast<int>(set.frames.cols())))
    throw ConfigError(network.file, "topology", network.model.weights.topology.text(),
                      frames == 1 ? fmt::format("a network with {} inputs, as many as the set has", set.frames.cols())
                                  : fmt::format("a network with {} inputs, {} frames of the set",
                                                frames * set.frames.cols(), frames));
  const nn::InputScaling& scaling = network.model.scaling;
  if (scaling.features == nn::Features::pad && set.columns > 0 && set.columns != scaling.columns)
    throw ConfigError(network.file, "tactel_columns", fmt::format("{}", scaling.columns),
                      fmt::format("a network for {} tactels along x, as the set has", set.columns));
}

// How many networks from `first` on share topology and scaling, and fit into one run.
std::size_t run_length(std::span<const NamedNetwork> networks, std::size_t first, std::size_t rows) {
  const nn::Model& model = networks[first].model;
  const std::size_t most = std::max<std::size_t>(1, most_answers / rows);
  std::size_t count = 1;
  while (count < most && first + count < networks.size() &&
         networks[first + count].model.weights.topology == model.weights.topology &&
         networks[first + count].model.scaling == model.scaling &&
         networks[first + count].model.history == model.history &&
         networks[first + count].model.magnitude == model.magnitude)
    ++count;
  return count;
}

template <class Real>
NetworkResult judge(const nn::Recall<Real>& answer, const nn::Model& model, const nn::FrameSet& set, bool keep_rows) {
  const std::vector<double> errors = nn::absolute_errors(answer.slip_index, set);
  NetworkResult result{.errors = nn::report_errors(errors, set)};
  for (const nn::FrameStatus status : answer.status) ++result.frames[static_cast<std::size_t>(status)];
  if (keep_rows) {
    result.slip_index.assign(answer.slip_index.begin(), answer.slip_index.end());
    result.truth.assign(set.slip_index.begin(), set.slip_index.end());
  }
  if (!model.bound) return result;
  result.bound = report_bound(answer.bounds, errors, set);
  if (model.bound->calibrated()) result.bound->holds = holds(result.bound->all, model.bound->level);
  if (keep_rows) result.bounds = answer.bounds;
  return result;
}

}  // namespace

int paper_number(const nn::Topology& topology) {
  for (int number = 1; number <= 6; ++number)
    if (nn::Topology::paper(number) == topology) return number;
  return 0;
}

std::vector<NamedNetwork> read_networks(const fs::path& path) {
  if (!infer::built_in_network(path.string()).empty()) return {{path.string(), read_onnx(path)}};
  std::vector<NamedNetwork> networks;
  for (const fs::path& file : onnx_files(path)) networks.push_back({file.filename().string(), read_onnx(file)});
  std::ranges::sort(networks, {}, order_key);
  return networks;
}

template <class Real>
static std::optional<std::vector<NetworkResult>> recall_in(Executor& executor, std::span<const NamedNetwork> networks,
                                                           const nn::FrameSet& set, bool keep_rows,
                                                           const Progress& progress, double spread) {
  for (const NamedNetwork& network : networks) check_width(network, set);
  std::optional<nn::FrameSet> formed;  // where a network takes other than single frames and S
  std::optional<DeviceFrames> frames;
  const nn::Model* same = nullptr;  // the network whose rows these are
  const auto rows = static_cast<std::size_t>(set.rows());
  std::vector<NetworkResult> results;
  while (results.size() < networks.size()) {
    const std::size_t first = results.size(), count = run_length(networks, first, rows);
    const nn::Model& model = networks[first].model;
    if (same == nullptr || same->history != model.history || same->magnitude != model.magnitude) {
      frames.reset(), formed.reset();
      if (model.history != nn::InputHistory{} || model.magnitude)
        formed = shown_rows(set, model.history, model.magnitude, networks[first].file, spread);
      frames.emplace(executor.device(), (formed ? *formed : set).frames);
      same = &model;
    }
    std::vector<nn::Weights<Real>> weights;
    std::vector<const nn::Bound*> bounds;
    for (const NamedNetwork& network : networks.subspan(first, count)) {
      weights.emplace_back(network.model.weights);
      if (network.model.bound) bounds.push_back(&*network.model.bound);
    }
    Forward<Real> forward(executor, std::span<const nn::Weights<Real>>(weights), model.scaling, bounds);
    bool going = true;
    const auto ask = [&](std::size_t done, std::size_t all) {
      return going = progress((first + count * done / std::max<std::size_t>(all, 1)) * rows, networks.size() * rows);
    };
    forward.run(*frames, {.progress = progress ? Progress(ask) : Progress()});
    if (!going) return std::nullopt;
    for (std::size_t i = 0; i < count; ++i)
      results.push_back(judge(forward.result(i), networks[first + i].model, formed ? *formed : set, keep_rows));
  }
  return results;
}

std::optional<std::vector<NetworkResult>> recall_networks(Executor& executor, Precision precision,
                                                          std::span<const NamedNetwork> networks,
                                                          const nn::FrameSet& set, bool keep_rows,
                                                          const Progress& progress, double spread) {
  return in_precision(
      precision, [&]<class Real>() { return recall_in<Real>(executor, networks, set, keep_rows, progress, spread); });
}

}  // namespace tactel::host
