// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "host/commands/command.h"
#include "host/commands/live/sensor_session.h"
#include "host/live/frame_reader.h"
#include "host/live/live_monitor.h"
#include "host/networks/onnx_file.h"
#include "host/support/durable_file.h"
#include "host/support/errors.h"
#include "host/support/progress_line.h"
#include "hw/tare.h"
#include "nn/infer/rest_reference.h"

namespace tactel::host {
namespace {

constexpr std::size_t fewest_frames = 8;  // fewer cannot tell rest from motion

struct TareRequest : SensorRequest {
  std::string output, hold, network;
  bool force = false;
};

/// Readings of --seconds by their arrival: of a recording those of the time when it was made.
hw::Tare read_rest(const TareRequest& request, hw::FrameSource& source, hw::Decoder& decoder, const Until& until) {
  hw::Tare tare(decoder.format().channels());
  std::optional<double> first;
  bool enough = false;
  read_frames(source, decoder,
              {.packet =
                   [&](const hw::Packet& packet) {
                     if (!first) first = packet.arrival;
                     enough = packet.arrival - *first >= request.seconds;
                   },
               .frame = [&](const hw::DecodedFrame& frame, double) { tare.add(frame.values); },
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

/// Adds the thresholds of `moved` and of a network of `slid`: 1.2 times their largest in a recording of a hold. Throws
/// SourceError where it has no rest, or ends.
void add_thresholds(const TareRequest& request, std::span<const nn::Model> networks, hw::Calibration& calibration) {
  const std::string& given = request.hold;
  const bool source = given.starts_with("replay:") || given.starts_with("csv:") || given.starts_with("simulate:");
  OpenSource hold = open_source(source ? given : "replay:" + given, request.profiles, {});
  const auto refuse = [&](const std::string& problem, const char* fix) -> hw::SourceError {
    return hw::SourceError(fmt::format("{}: {}; {}", given, problem, fix));
  };
  if (hold.profile.format()->channels() != calibration.offset.size())
    throw refuse(
        fmt::format("{} channels, and --source has {}", hold.profile.format()->channels(), calibration.offset.size()),
        "give a hold of the same sensor");
  hold.profile.map.calibration = calibration;
  if (!knows_touch(hold.profile))
    throw refuse("the readings at rest have no noise, which tells a touch", "take --source from the sensor itself");
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
  calibration.moved = infer::hold_margin * largest;
  if (!(calibration.moved > 0 && calibration.moved < infer::most_moved))
    throw refuse(fmt::format("the stresses change by {:.2g} of the normal force", largest), "record a grip that holds");
  if (networks.empty()) return;
  calibration.slid = std::max(infer::hold_margin * most_slid, infer::least_slid);
  if (!(calibration.slid < 1))
    throw refuse(fmt::format("the network says that it slides, {:.2g}", most_slid), "record a grip that holds");
}

/// The network of --network; none without it.
std::vector<nn::Model> networks_of(const TareRequest& request) {
  if (request.network.empty()) return {};
  if (request.hold.empty())
    throw ConfigError("command line", "--network", request.network, "given with --hold, whose slid it judges");
  std::vector<nn::Model> networks{read_onnx(request.network)};
  if (networks.front().target != nn::Target::slid)
    throw ConfigError("command line", "--network", nn::name(networks.front().target), "a network of slid");
  return networks;
}

int run_tare(const TareRequest& request) {
  check_writable("--output", request.output);
  const std::vector<nn::Model> networks = networks_of(request);
  OpenSource opened = open_for(request);
  hw::Decoder decoder(opened.profile.format());
  const Until until(*opened.source, opened.source->live() ? request.seconds : 0);  // a recording's time is that of its packets
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
                    tare.frames(), request.seconds, fewest_frames));
  if (const std::string moved = motion(tare, opened.profile.map); !moved.empty() && !request.force) {
    say("error: the sensor was not at rest: " + moved + "; " + request.output +
        " was not written; --force writes the mean nevertheless");
    return not_converged;
  }
  hw::Calibration calibration = opened.profile.map.calibration;
  calibration.offset = tare.offset();
  calibration.noise = tare.noise();
  calibration.has_zero = true;
  if (!request.hold.empty()) add_thresholds(request, networks, calibration);
  write_file("--output", request.output, calibration_text(calibration));
  say(fmt::format("the mean of {} frames is in {}", tare.frames(), request.output));
  if (!request.hold.empty()) say(fmt::format("the alarm of moved begins at {:.4g}", calibration.moved));
  if (!networks.empty()) say(fmt::format("the alarm of {} begins at {:.4g}", request.network, calibration.slid));
  return done;
}

}  // namespace

void add_tare_command(CLI::App& app, Action& action) {
  auto request = std::make_shared<TareRequest>();
  request->seconds = 2;
  CLI::App* command = app.add_subcommand("tare", "measure the offsets of a sensor at rest");
  command->group("Read a sensor");
  add_sensor_options(*command, *request);
  command->add_option("--output", request->output, "file of offsets and noise, for --calibration")
      ->type_name("FILE.toml")
      ->required();
  command->add_option("--seconds", request->seconds, "time to listen, s")
      ->check(positive_number())
      ->capture_default_str();
  command
      ->add_option(
          "--hold", request->hold,
          "recording of a grip that holds, moved as in use: 1.2 times its largest \"moved\" is the threshold of "
          "monitor --signal moved --alarm; of tactel record, or csv:FILE")
      ->type_name("RECORDING");
  command
      ->add_option("--network", request->network,
                   "with --hold: 1.2 times the largest answer of this network of slid is its threshold, too")
      ->type_name("FILE.onnx");
  command->add_flag("--force", request->force, "write the file even if the sensor moved");
  command->callback([request, &action] { action = [request] { return run_tare(*request); }; });
}

}  // namespace tactel::host
