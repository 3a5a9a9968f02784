// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <random>

#include "host/commands/command.h"
#include "host/commands/guarded.h"
#include "host/live/sensor_profile.h"
#include "host/networks/onnx_chain.h"
#include "host/networks/onnx_file.h"
#include "host/support/durable_file.h"
#include "host/support/errors.h"
#include "host/support/number_lines.h"
#include "host/training/train_request.h"
#include "nn/forward.h"

namespace tactel::host {
namespace {

/// fp32 in both programs, in sums of other orders: a misread operation errs by far more.
constexpr double largest_difference = 1e-4;
constexpr int random_frames = 1000;
constexpr std::uintmax_t most_bytes_of_frames = 64 << 20;

struct ImportRequest {
  std::string network, output, profile, frames, scaling = "set", target = "slip_index";
  double largest_stress = 1;
  std::optional<std::string> history;
  std::optional<double> history_change;
};

/// `map`: of the profile; without one a tactel has two stresses.
nn::Model model_of(const ImportRequest& request, const DenseChain& chain, const hw::ChannelMap* map) try {
  const int axes = map != nullptr ? static_cast<int>(map->places() / map->tactels()) : 2;
  return model_of_chain(chain,
                        {nn::parse_scaling(request.scaling), static_cast<float>(request.largest_stress), 1, axes},
                        parse_history(request.history, request.history_change),
                        std::filesystem::path(request.network).filename().string(), nn::parse_target(request.target));
} catch (const ValueError& error) {
  throw ConfigError(request.network, error);
}

void check_inputs(const ImportRequest& request, const nn::Model& model, const hw::ChannelMap& map) {
  const auto inputs = static_cast<std::size_t>(model.weights.topology.inputs());
  const std::size_t wanted = map.places() * static_cast<std::size_t>(model.scaling.shown());
  if (inputs != wanted)
    throw ConfigError(request.network, "network", fmt::format("{} inputs", inputs),
                      fmt::format("a network of {} inputs for {}: normal stresses of all tactels, then the others",
                                  wanted, request.profile));
}

/// The larger of a difference so far and one more; infinite where an answer is no number.
double worst(double most, double difference) {
  return std::isnan(difference) ? std::numeric_limits<double>::infinity() : std::max(most, std::abs(difference));
}

/// Largest difference to the chain itself on random frames of up to twice the divisor.
double difference_on_random_frames(const DenseChain& chain, const nn::Model& model) {
  std::mt19937 generator(1);
  std::uniform_real_distribution<float> stress(-2 * model.scaling.largest_stress, 2 * model.scaling.largest_stress);
  nn::RowMatrix<float> frames(random_frames, model.numbers());
  for (float& number : frames.reshaped()) number = stress(generator);
  const nn::RowMatrix<double> scaled = nn::scale_frames<double>(model.scaling, frames);
  const nn::Vector<float> answers = nn::recall(model.weights, model.scaling, frames).slip_index;
  double most = 0;
  for (Eigen::Index i = 0; i < frames.rows(); ++i)
    most = worst(most, answers[i] - evaluate(chain, scaled.row(i).transpose()));
  return most;
}

/// Lines of an input and its S, as the other program gave it. Returns the largest difference and the number of lines.
std::pair<double, int> difference_on(const std::string& file, const nn::Model& model) {
  const Eigen::Index inputs = model.numbers();
  NumberLines numbers(
      file, {.count = static_cast<std::size_t>(inputs) + 1, .meaning = "an input in MPa, then S of the other program"});
  double most = 0;
  int lines = 0;
  read_number_file(file, most_bytes_of_frames, "frames", numbers, [&](std::span<const double> line) {
    const nn::RowMatrix<float> frame = Eigen::Map<const nn::RowMatrix<double>>(line.data(), 1, inputs).cast<float>();
    const float answer = nn::recall(model.weights, model.scaling, frame).slip_index[0];
    most = worst(most, double(answer) - line.back());
    ++lines;
  });
  if (lines == 0) throw ConfigError(file, "frames", "none", "at least one line of an input and its S");
  return {most, lines};
}

int run_import(const ImportRequest& request) {
  check_writable("--output", request.output);
  const DenseChain chain = read_onnx_chain(request.network);
  const auto profile = request.profile.empty() ? std::nullopt : std::optional(read_profile(request.profile));
  const nn::Model model = model_of(request, chain, profile ? &profile->map : nullptr);
  if (profile) check_inputs(request, model, profile->map);
  double most = difference_on_random_frames(chain, model);
  std::string where = fmt::format("{} random frames", random_frames);
  if (!request.frames.empty() && most <= largest_difference) {
    const auto [on_frames, lines] = difference_on(request.frames, model);
    most = on_frames, where = fmt::format("the {} frames of {}", lines, request.frames);
  }
  if (!(most <= largest_difference)) {
    complain(not_converged,
             std::isinf(most)
                 ? fmt::format("{}: an S on {} is no number, by overflow; {} was not written", request.network, where,
                               request.output)
                 : fmt::format("{}: S differs by {:.2g} on {}; {} was not written; give the scaling that the "
                               "network learnt with (--scaling, --largest-stress)",
                               request.network, most, where, request.output));
    return not_converged;
  }
  write_onnx(request.output, model);
  fmt::print("{}: {}, within {:.1g} of {} on {}\n", request.output, model.weights.topology.text(), most,
             request.network, where);
  return done;
}

}  // namespace

void add_import_network_command(CLI::App& app, Action& action) {
  auto request = std::make_shared<ImportRequest>();
  CLI::App* command = app.add_subcommand("import-network", "take a network that another program trained");
  command->group("Learn");
  command->add_option("network", request->network, "a chain of dense layers (ONNX), such as PyTorch exports")
      ->type_name("OWN.onnx")
      ->required();
  command->add_option("--output", request->output, "network file to write")->type_name("N.onnx")->required();
  command
      ->add_option("--profile", request->profile, "sensor that it is for: checks the number of inputs; needed of a pad")
      ->type_name("P.toml");
  command->add_option("--frames", request->frames, "inputs (MPa) and S of the other program, line by line, to check by")
      ->type_name("FILE.csv")
      ->group("Input");
  command
      ->add_option(
          "--scaling", request->scaling,
          "what divides a frame before the network: --largest-stress (set), its largest normal stress (frame), or, of "
          "its difference to the rest of a grip, the force at rest (rest)")
      ->check(CLI::IsMember({"set", "frame", "rest"}))
      ->capture_default_str();
  command->add_option("--largest-stress", request->largest_stress, "divisor of --scaling set, MPa; 1: none")
      ->capture_default_str();
  command->add_option("--history", request->history, "frames in an input, newest first, as of tactel train")
      ->type_name("K[:STRIDE]");
  command->add_option("--history-change", request->history_change, "as of tactel train (default: 0.1)");
  command->add_option("--target", request->target, "what it answers, as of tactel train")
      ->check(CLI::IsMember({"slip_index", "force_ratio", "stick_fraction", "slid", "slip_path"}))
      ->capture_default_str();
  command->footer("Exit codes: 0 done, 2 wrong input, 4 other answers than the network's own.");
  command->callback([request, &action] { action = [request] { return run_import(*request); }; });
}

}  // namespace tactel::host
