// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "host/commands/network_parts.h"
#include "host/live/frame_reader.h"
#include "host/live/live_monitor.h"
#include "host/live/open_source.h"
#include "host/networks/forward.h"
#include "host/support/durable_file.h"
#include "host/support/errors.h"
#include "host/support/json_text.h"
#include "host/training/network_report.h"
#include "hw/recording.h"
#include "nn/infer/sensor_frames.h"

namespace tactel::host {
namespace {

using Json = nlohmann::ordered_json;

struct Recorded {
  SensorProfile profile;
  std::vector<double> arrival{};    ///< s, [frames]
  std::vector<float> stresses{};    ///< [frames][places of the map] MPa
  std::vector<std::size_t> pads{};  ///< tactels of each; of a line one
};

Recorded read_recording(const std::string& file) {
  OpenSource opened = open_source("replay:" + file, "", "");
  hw::Decoder decoder(opened.profile.format());
  Recorded all{.profile = std::move(opened.profile)};
  const hw::ChannelMap& map = all.profile.map;
  std::vector<float> frame(map.places());
  read_frames(*opened.source, decoder, {.frame = [&](const hw::DecodedFrame& decoded, double arrival) {
    map.apply(decoded.values, frame);
    all.arrival.push_back(arrival);
    all.stresses.insert(all.stresses.end(), frame.begin(), frame.end());
  }});
  if (all.arrival.empty()) throw ConfigError(file, "frames", "0", "a recording with frames of its sensor");
  all.pads = tactels_of(all.profile);
  return all;
}

/// Inputs of a network, [frames, inputs] MPa, from the frames of `tactels` tactels from `first` on.
nn::RowMatrix<float> inputs_of(const Recorded& all, const nn::Model& model, std::size_t first, std::size_t tactels) {
  const std::size_t places = all.profile.map.places(), every = all.profile.map.tactels(), axes = places / every;
  const double touch = all.profile.map.touch(first, tactels);
  infer::SensorFrames sensor(model.scaling, model.history, model.learnt, model.numbers(),
                             touch > 0 ? std::optional(touch) : std::nullopt);
  nn::RowMatrix<float> inputs(static_cast<Eigen::Index>(all.arrival.size()), model.numbers());
  std::vector<float> frame(axes * tactels);
  for (std::size_t k = 0; k < all.arrival.size(); ++k) {
    take_pad(std::span(all.stresses).subspan(k * places, places), every, first, tactels, frame.data());
    sensor.push(frame.data());
    sensor.write(inputs.row(static_cast<Eigen::Index>(k)).data());
  }
  return inputs;
}

/// [pads]
std::vector<nn::Recall<float>> answers_of(Executor& executor, const NamedNetwork& network, const Recorded& all) {
  const nn::Model& model = network.model;
  const nn::Bound* const bound = model.bound ? &*model.bound : nullptr;
  Forward<float> forward(executor, std::span(&model.weights, 1), model.scaling, std::span(&bound, bound ? 1 : 0));
  std::vector<nn::Recall<float>> answers;
  std::size_t first = 0;
  for (const std::size_t tactels : all.pads) {
    check_width(model, all.profile, tactels);
    answers.push_back(forward.recall(inputs_of(all, model, first, tactels)));
    first += tactels;
  }
  return answers;
}

/// What a network says about a pad in all.
struct Said {
  std::array<std::size_t, 4> frames{};  ///< by nn::FrameStatus
  std::size_t unlike = 0;
  double mean = 0, most = 0;  ///< of the frames that have an answer
};

Said said(const nn::Recall<float>& answer) {
  Said all;
  std::size_t answered = 0;
  for (std::size_t k = 0; k < answer.status.size(); ++k) {
    ++all.frames[static_cast<std::size_t>(answer.status[k])];
    if (!answer.bounds.empty()) all.unlike += answer.bounds[k].unlike;
    const double s = answer.slip_index(static_cast<Eigen::Index>(k));
    if (std::isnan(s)) continue;
    all.most = std::max(all.most, s);
    all.mean += (s - all.mean) / static_cast<double>(++answered);
  }
  return all;
}

Json recording_json(const Said& all, bool bound) {
  Json frames;
  for (std::size_t i = 0; i < all.frames.size(); ++i) frames[nn::name(static_cast<nn::FrameStatus>(i))] = all.frames[i];
  Json json{{"frames", frames}, {"mean", all.mean}, {"max", all.most}};
  if (bound) json["unlike"] = all.unlike;
  return json;
}

using Answers = std::vector<std::vector<nn::Recall<float>>>;  ///< [networks][pads]

std::string table(std::span<const NamedNetwork> networks, const Answers& answers) {
  std::string text = fmt::format("{:>3} {:>9} {:>9} {:>9} {:>6} {:>6}  {}\n", "pad", "answered", "no stress", "unlike",
                                 "mean", "max", "network");
  for (std::size_t n = 0; n < networks.size(); ++n)
    for (std::size_t pad = 0; pad < answers[n].size(); ++pad) {
      const Said all = said(answers[n][pad]);
      text +=
          fmt::format("{:>3} {:>9} {:>9} {:>9} {:>6.3f} {:>6.3f}  {}\n", pad + 1, all.frames[0], all.frames[1],
                      networks[n].model.bound ? std::to_string(all.unlike) : "-", all.mean, all.most, networks[n].file);
    }
  return text;
}

/// An empty field where a network gave no answer.
std::string recording_rows(std::span<const NamedNetwork> networks, const Answers& answers, const Recorded& all) {
  std::string text = "frame,arrival,pad";
  for (const NamedNetwork& network : networks) {
    text += "," + network.file;
    if (network.model.bound) text += fmt::format(",{0} slip_upper,{0} lower,{0} upper,{0} unlike", network.file);
  }
  for (std::size_t k = 0; k < all.arrival.size(); ++k)
    for (std::size_t pad = 0; pad < all.pads.size(); ++pad) {
      text += fmt::format("\n{},{},{}", k, all.arrival[k], pad + 1);
      for (const auto& of_pads : answers) {
        const nn::Recall<float>& answer = of_pads[pad];
        const float s = answer.slip_index(static_cast<Eigen::Index>(k));
        text += std::isnan(s) ? "," : fmt::format(",{:.9g}", s);
        if (answer.bounds.empty()) continue;
        const nn::BoundAnswer& bound = answer.bounds[k];
        text += std::isnan(s) ? ",,,"
                              : fmt::format(",{:.9g},{:.9g},{:.9g}", bound.upper, bound.interval[0], bound.interval[1]);
        text += bound.unlike ? ",1" : ",0";
      }
    }
  return text + "\n";
}

}  // namespace

bool is_recording(const std::string& file) {
  std::array<char, 8> begin{};
  std::ifstream(file, std::ios::binary).read(begin.data(), begin.size());
  return std::string_view(begin.data(), begin.size()) == hw::recording_magic;
}

int recall_recording(std::span<const NamedNetwork> networks, const std::string& file, const NetworkOptions& shared,
                     const std::string& json, const std::string& rows) {
  if (precision_named(shared.precision) == Precision::fp64)
    throw ConfigError("command line", "--precision", "fp64", "fp32 for a recording, as of tactel monitor");
  const Recorded all = read_recording(file);
  Executor executor{Device(shared.device)};
  Answers answers;
  for (const NamedNetwork& network : networks) answers.push_back(answers_of(executor, network, all));
  const std::string& device = executor.device().info().name;
  if (!rows.empty()) write_file("--rows", rows, recording_rows(networks, answers, all));
  Json report{{"tactel", TACTEL_VERSION},
              {"recording", file},
              {"frames", all.arrival.size()},
              {"device", device},
              {"networks", Json::array()}};
  for (std::size_t n = 0; n < networks.size(); ++n) {
    report["networks"].push_back(to_json(networks[n]));
    for (const auto& answer : answers[n])
      report["networks"].back()["pads"].push_back(recording_json(said(answer), networks[n].model.bound.has_value()));
  }
  if (json == "-") {
    fmt::print("{}", json_text(report));
    return done;
  }
  if (!json.empty()) write_file("--json", json, json_text(report));
  fmt::print("{} of {} networks on {} frames of {}, those at rest among them\n\n{}\ndevice: {}\n",
             nn::name(networks.front().model.target), networks.size(), all.arrival.size(), file,
             table(networks, answers), device);
  return done;
}

}  // namespace tactel::host
