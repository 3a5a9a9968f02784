// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "host/commands/add_option.h"
#include "host/commands/command.h"
#include "host/commands/live/sensor_session.h"
#include "host/live/frame_reader.h"
#include "host/live/live_monitor.h"
#include "host/live/recorded_hold.h"
#include "host/networks/onnx_file.h"
#include "host/support/durable_file.h"
#include "host/support/errors.h"
#include "host/support/progress_line.h"
#include "host/support/terminal.h"
#include "hw/tare.h"
#include "nn/infer/rest_reference.h"

namespace tactel::host {
namespace {

constexpr std::size_t fewest_frames = 8;  // fewer cannot tell rest from motion
constexpr double patience = 10;           // s, for the first frame: some boards take seconds to boot

struct TareRequest : SensorRequest {
  std::string output, network;
  std::vector<std::string> holds, slides;
  bool force = false;
};

/// Readings of --seconds from the first frame on, by their arrival: of a recording those of the time when it was made.
hw::Tare read_rest(const TareRequest& request, hw::FrameSource& source, hw::Decoder& decoder, const Until& until) {
  hw::Tare tare(decoder.format().channels());
  std::optional<double> first;
  bool enough = false;
  read_frames(source, decoder,
              {.frame =
                   [&](const hw::DecodedFrame& frame, double arrival) {
                     if (!first) first = arrival;
                     enough = arrival - *first >= request.seconds;
                     tare.add(frame.values);
                   },
               .turn =
                   [&] {
                     if (source.live())
                       enough |= source.now() - first.value_or(0) >= (first ? request.seconds : patience);
                   },
               .stop = [&] { return enough || until(); }});
  return tare;
}

/// The channel that moved most, as a sentence; empty for a sensor at rest. Throws SourceError for a channel without
/// readings.
std::string motion(const hw::Tare& tare, const hw::ChannelMap& map) {
  std::string worst;
  double most = 1;
  for (std::size_t place = 0; place < map.places(); ++place) {
    if (map.channel(place) < 0) continue;
    const hw::ChannelRest rest = tare.channel(static_cast<std::size_t>(map.channel(place)));
    if (rest.readings == 0) throw hw::SourceError(map.channel_text(place) + " sends no finite number");
    const double share = rest.at_rest() ? 0 : (rest.highest - rest.lowest) / rest.allowed;
    if (share <= most) continue;
    most = share;
    worst = fmt::format("{} moved from {:.4g} to {:.4g}, with a noise of {:.2g}", map.channel_text(place), rest.lowest,
                        rest.highest, rest.noise);
  }
  return worst;
}

/// Opens a recording of the sensor whose zero is in `calibration`. Throws SourceError for another sensor.
OpenSource open_recording(const TareRequest& request, const std::string& given, const hw::Calibration& calibration) {
  const bool source = given.starts_with("replay:") || given.starts_with("csv:") || given.starts_with("simulate:");
  OpenSource opened = open_source(source ? given : "replay:" + given, request.profiles, {});
  if (opened.profile.format()->channels() != calibration.offset.size())
    throw hw::SourceError(fmt::format("{}: {} channels, and --source has {}; give a recording of the same sensor",
                                      given, opened.profile.format()->channels(), calibration.offset.size()));
  opened.profile.map.calibration = calibration;
  if (!knows_touch(opened.profile))
    throw hw::SourceError(given +
                          ": the readings at rest have no noise, which tells a touch; take --source from the "
                          "sensor itself");
  return opened;
}

/// Thresholds of `moved` and of a network of `slid` in one hold: 1.2 times their largest. Throws SourceError where it
/// has no rest, or ends.
struct Thresholds {
  double moved = 0, slid = 0;
};
Thresholds thresholds_of(const std::string& given, OpenSource& hold, std::span<const nn::Model> networks) {
  const auto refuse = [&](const std::string& problem, const char* fix) -> hw::SourceError {
    return hw::SourceError(fmt::format("{}: {}; {}", given, problem, fix));
  };
  LiveMonitor monitor(networks, hold.profile,
                      {.late = 1e9, .rest = true, .signal = networks.empty() ? AlarmSignal::moved : AlarmSignal::slip});
  float largest = 0, most_slid = 0;
  std::size_t found = 0;  // pads whose rest is known
  std::optional<std::uint64_t> ended;
  monitor.run(*hold.source, {.line = [&](const MonitorLine& line) {
    std::size_t rests = line.rest == true, touch = line.contact == true;
    if (!line.pads.empty())
      rests = static_cast<std::size_t>(std::ranges::count(line.pads, true, &AlarmAnswer::rest)),
      touch = static_cast<std::size_t>(std::ranges::count(line.pads, true, &AlarmAnswer::contact));
    if (rests < found && !ended && touch < found) ended = line.frame.number;
    if (rests < found) largest = most_slid = 0;  // the hand tightened its grip
    largest = std::fmax(largest, line.moved), most_slid = std::fmax(most_slid, line.acted_on);
    found = rests;
  }});
  if (found == 0 && !ended)
    throw refuse("no grip at rest in it", "record a hand that grips, holds still, and moves as in use");
  if (ended)
    throw refuse(fmt::format("the grip ends at frame {}", *ended), "record a hold that ends before the hand opens");
  const Thresholds all{infer::hold_margin * largest, std::max(infer::hold_margin * most_slid, infer::least_slid)};
  if (!(all.moved > 0 && all.moved < infer::most_moved))
    throw refuse(fmt::format("the stresses change by {:.2g} of the normal force", largest), "record a grip that holds");
  if (!networks.empty() && !(all.slid < 1))
    throw refuse(fmt::format("the network says that it slides, {:.2g}", most_slid), "record a grip that holds");
  return all;
}

/// Adds the largest thresholds of all holds. `moved` alone, a second opinion, may have none.
void add_thresholds(const TareRequest& request, std::span<const nn::Model> networks, hw::Calibration& calibration) {
  Thresholds most;
  for (const std::string& given : request.holds) try {
      OpenSource hold = open_recording(request, given, calibration);
      const Thresholds of_hold = thresholds_of(given, hold, networks);
      most = {std::max(most.moved, of_hold.moved), std::max(most.slid, of_hold.slid)};
    } catch (const hw::SourceError&) {
      if (!networks.empty()) throw;
    }
  calibration.moved = most.moved;
  if (!networks.empty()) calibration.slid = most.slid;
}

/// Learns the hold of all recordings. Returns what is said of it.
std::string add_hold(const TareRequest& request, const SensorProfile& profile, hw::Calibration& calibration) {
  SensorProfile tared = profile;
  tared.map.calibration = calibration, tared.map.calibration.hold = profile.map.calibration.hold;
  HoldLearner learner(tared);
  for (const std::string& given : request.holds) {
    const OpenSource hold = open_recording(request, given, calibration);
    learner.read(*hold.source, given);
  }
  const HoldReport report = learner.learn();
  calibration.hold = report.hold;
  for (const std::string& warning : report.warnings) print_warning(warning);
  return fmt::format("hold of {:.1f} s: the alarm of left begins at {:.3g}, {:.3g} times its largest change, {:.3g}",
                     report.hold.seconds, report.hold.at, report.hold.margin, report.largest);
}

std::string add_slide(const TareRequest& request, const SensorProfile& profile, hw::Calibration& calibration) {
  SensorProfile tared = profile;
  tared.map.calibration = calibration;
  std::vector<double> mean(tactels_of(profile).size());  // of logarithms
  for (const std::string& given : request.slides) {
    const OpenSource slide = open_recording(request, given, calibration);
    const std::vector<double> readings = read_slide(*slide.source, tared, given);
    for (std::size_t i = 0; i < mean.size(); ++i)
      mean[i] += std::log(readings[i]) / static_cast<double>(request.slides.size());
  }
  for (const double log : mean) calibration.slide.push_back(std::exp(log));
  return fmt::format("it slides at Q / P = {:.3g}", fmt::join(calibration.slide, ", "));
}

/// The network of --network; none without it.
std::vector<nn::Model> networks_of(const TareRequest& request) {
  if (request.network.empty()) return {};
  if (request.holds.empty())
    throw ConfigError("command line", "--network", request.network, "given with --hold, whose slid it judges");
  std::vector<nn::Model> networks{read_onnx(request.network)};
  if (!nn::is_slide(networks.front().target))
    throw ConfigError("command line", "--network", nn::name(networks.front().target),
                      std::string("a network of ") + nn::slide_names);
  return networks;
}

int run_tare(const TareRequest& request) {
  check_writable("--output", request.output);
  const std::vector<nn::Model> networks = networks_of(request);
  OpenSource opened = open_for(request);
  hw::Decoder decoder(opened.profile.format());
  const Until until(*opened.source, 0);
  const hw::Tare tare = [&] {
    const StageLine stage("listening to the sensor at rest", request.quiet);
    return read_rest(request, *opened.source, decoder, until);
  }();
  if (until.by_signal()) {
    say(request.output + " was not written");
    return interrupted;
  }
  say_if_cut_short(request, *opened.source);
  if (tare.frames() < fewest_frames)
    throw hw::SourceError(
        fmt::format("{} frames arrived within {} s, fewer than {}; switch the sensor on, or listen longer "
                    "(--seconds)",
                    tare.frames(), tare.frames() > 0 ? request.seconds : patience, fewest_frames));
  if (const std::string moved = motion(tare, opened.profile.map); !moved.empty() && !request.force) {
    say("error: the sensor was not at rest: " + moved + "; " + request.output +
        " was not written; --force writes the mean nevertheless");
    return not_converged;
  }
  hw::Calibration calibration = opened.profile.map.calibration;
  calibration.offset = tare.offset();
  calibration.noise = tare.noise();
  calibration.has_zero = true;
  calibration.hold = {}, calibration.slide.clear();
  std::vector<std::string> said;
  if (!request.holds.empty()) {
    add_thresholds(request, networks, calibration);
    said.push_back(add_hold(request, opened.profile, calibration));
  }
  if (!request.slides.empty()) said.push_back(add_slide(request, opened.profile, calibration));
  write_file("--output", request.output, calibration_text(calibration));
  say(fmt::format("the mean of {} frames is in {}", tare.frames(), request.output));
  for (const std::string& text : said) say(text);
  if (calibration.moved > 0 && !request.holds.empty())
    say(fmt::format("the alarm of moved begins at {:.4g}", calibration.moved));
  if (!networks.empty()) say(fmt::format("the alarm of {} begins at {:.4g}", request.network, calibration.slid));
  return done;
}

}  // namespace

void add_tare_command(CLI::App& app, Action& action) {
  const auto [command, request] =
      add_command(app, action, "Read a sensor", "tare", "measure the offsets of a sensor at rest", run_tare);
  request.seconds = 2;
  add_sensor_options(command, request);
  add_option(command, "--output", request.output, "file of offsets and noise, for --calibration", {.type = "FILE.toml"})
      ->required();
  add_option(command, "--seconds", request.seconds, "time to listen, s")->check(positive_number());
  add_option(command, "--hold", request.holds,
             "recording of grips that hold, moved as in use, from which the alarm of monitor --rest learns how the "
             "hand trembles; 1.2 times its largest \"moved\" is the threshold of monitor --signal moved; of tactel "
             "record, or csv:FILE; repeatable",
             {.type = "RECORDING"});
  add_option(command, "--slide", request.slides,
             "recording in which the held object slides: lines of monitor --rest say how near they are to it, "
             "\"index\"; repeatable",
             {.type = "RECORDING"});
  add_option(command, "--network", request.network,
             "with --hold: 1.2 times the largest answer of this network of slid is its threshold, too",
             {.type = "FILE.onnx"});
  add_option(command, "--force", request.force, "write the file even if the sensor moved");
}

}  // namespace tactel::host
