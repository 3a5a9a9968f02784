// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>

#include "host/commands/add_option.h"
#include "host/commands/command.h"
#include "host/commands/live/monitor.h"
#include "host/live/live_monitor.h"
#include "host/live/live_view.h"
#include "host/networks/onnx_file.h"
#include "host/support/errors.h"
#include "host/support/terminal.h"
#include "nn/infer/rest_reference.h"

namespace tactel::host {
namespace {

constexpr float default_alarm = 0.8f, never = 2;

/// Standard output, each piece at once. The first failure ends the reading.
class Output {
 public:
  bool terminal() const { return terminal_; }
  int columns() const {
    winsize size{};
    return terminal_ && ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
  }
  void put(const std::string& text) {
    if (error_ == 0 && (std::fputs(text.c_str(), stdout) < 0 || std::fflush(stdout) != 0)) error_ = errno;
  }
  bool failed() const { return error_ != 0; }
  void check() const {
    if (failed())
      throw ConfigError("standard output", "", "", std::string("a file that can be written: ") + std::strerror(error_));
  }

 private:
  bool terminal_ = is_terminal(STDOUT_FILENO);
  int error_ = 0;
};

/// Says once each what keeps a network from an answer that can be trusted.
class Doubts {
 public:
  explicit Doubts(const MonitorRequest& request) : request_(request) {}
  /// Returns what a line is the first to show; mostly nothing.
  std::vector<std::string> next(const MonitorLine& line) {
    std::vector<std::string> found;
    const auto say_once = [&](bool& said, bool now, const std::string& text) {
      if (now && !std::exchange(said, said || now))
        found.push_back(fmt::format("frame {}: {}", line.frame.number, text));
    };
    const bool unlike = line.has_bound && line.answer.unlike != 0 && line.contact.value_or(true);
    const char* then = !request_.alarm               ? ""
                       : request_.unlike == "ignore" ? "; the alarm goes by S all the same"
                                                     : "; then the alarm is on (--unlike ignore: by S)";
    say_once(unlike_, unlike,
             fmt::format("it is unlike those that the network learnt, which cannot tell its S{}", then));
    const bool left = request_.options.signal == AlarmSignal::left;
    const char* stays = left ? "; the alarm goes by the other stresses" : "; the alarm stays as it is meanwhile";
    const bool nan = line.why == CannotTell::not_a_number;
    say_once(no_answer_, line.no_answer || nan,
             std::string(left ? "a stress is NaN" : "it has no answer, as a stress is NaN or too large") + stays);
    say_once(frozen_, line.why == CannotTell::frozen,
             "no stress changes any more: is a cable out, or the driver stopped? the alarm stays as it is meanwhile");
    say_once(wrong_sign_, line.why == CannotTell::wrong_sign,
             "the normal stresses pull, where a touch presses: turn the sign of their gains in the profile; no alarm "
             "can be trusted meanwhile");
    say_once(beyond_, line.answer.beyond_learnt != 0,
             "a normal stress is above 10 times the largest that the network learnt; gains of the calibration must "
             "give MPa");
    return found;
  }

 private:
  const MonitorRequest& request_;
  bool unlike_ = false, no_answer_ = false, beyond_ = false, frozen_ = false, wrong_sign_ = false;
};

/// Where the lines go, and when it ends. later: warnings that would tear a picture.
MonitorEvents make_events(const MonitorRequest& request, const char* target, std::size_t tactels, LiveView& view,
                          BrowserView& browser, Output& output, const Until& until, std::vector<std::string>& later) {
  MonitorEvents events;
  const auto on = std::make_shared<std::optional<bool>>();  // the alarm; none before the first frame
  events.line = [&, target, tactels, on, cannot_tell = false, why = CannotTell::none, released = false,
                 doubts = Doubts(request)](const MonitorLine& line) mutable {
    const auto of_sensor = [](CannotTell reason) {
      return reason == CannotTell::not_a_number || reason == CannotTell::frozen || reason == CannotTell::wrong_sign;
    };
    const bool turned = line.alarm != on->value_or(false) || (request.widest && line.cannot_tell != cannot_tell) ||
                        (line.why != why && (of_sensor(why) || of_sensor(line.why)));
    const bool told = turned || line.cannot_tell != cannot_tell || line.released != released;  // to a browser
    *on = line.alarm, cannot_tell = line.cannot_tell, why = line.why, released = line.released;
    std::vector<std::string> warnings = doubts.next(line);
    for (const Drift& drift : line.drift) warnings.push_back(drift.text);
    for (const std::string& warning : warnings) {
      if (request.view)
        later.push_back(warning);
      else if (!request.quiet)
        print_warning(warning);
    }
    // Events are printed, whatever --every says.
    const bool event = (request.alarm && turned) || !line.drift.empty();
    browser.show([&] { return line_text(request, line, target, tactels); }, event || told);
    if (!event && line.frame.number % static_cast<std::uint64_t>(request.every) != 0) return;
    if (!request.view) return output.put(line_text(request, line, target, request.stresses ? tactels : 0) + "\n");
    if (const auto picture = view.show(line, output.columns())) output.put(*picture);
  };
  events.second = [&](const MonitorSummary& summary) {
    if (request.view) {
      if (const auto picture = view.show_newest(output.columns())) output.put(*picture);
    } else if (!request.quiet) {
      say(summary_text(summary, false));
    }
  };
  events.silence = [&, on](double seconds, double now) {
    if (!request.quiet && seconds < 2 * request.options.silence)
      print_warning(fmt::format("no frame for {:.1f} s", seconds));
    if (request.alarm && *on && !request.view) output.put(silence_text(seconds, now, **on) + "\n");
    browser.tell_silence(seconds);
  };
  events.stop = [&] { return output.failed() || until(); };
  if (request.options.rest || request.takes_friction)  // of which left takes "slides"
    events.calls = [lines = AskedLines(request.source.starts_with("csv:-"), request.quiet)]() mutable {
      return lines();
    };
  if (!request.quiet) events.friction = [](std::span<const float> mu) { say(friction_text(mu)); };
  return events;
}

/// What the options ask for together with the networks.
void check_request(const MonitorRequest& request, std::span<const nn::Model> networks) {
  const bool by_rest = request.options.signal != AlarmSignal::slip, none = networks.empty();
  if (none && !request.options.rest && request.signal != "slip")
    throw ConfigError("command line", "--network", "(missing)", "given, or left out with --rest");
  if (none && !by_rest)
    throw ConfigError("command line", "--signal", request.signal, "left or moved without --network");
  if (none && !request.device.empty())
    throw ConfigError("command line", "--device", request.device, "given with --network");
  if (request.widest && (none || !networks.front().bound))
    throw ConfigError("command line", "--widest", fmt::format("{}", *request.widest),
                      "left out for a network without a bound: it has no interval");
  for (std::size_t i = 1; i < networks.size(); ++i)
    if (networks[i].target != networks.front().target)
      throw ConfigError("command line", "--network", request.networks[i],
                        fmt::format("a network of {}, as the first", nn::name(networks.front().target)));
  if (request.view && by_rest)
    throw ConfigError("command line", "--view", "", "left out with --signal left or moved: it shows S");
  const nn::Target target = none ? nn::Target::slip_index : networks.front().target;
  const bool alarms = by_rest || target == nn::Target::slip_index || nn::is_slide(target);
  if ((request.view && target != nn::Target::slip_index) || (!request.alarm_given.empty() && !alarms))
    throw ConfigError("command line", request.view ? "--view" : "--alarm", request.networks.front(),
                      fmt::format("left out for a network of {}: they are for S", nn::name(target)));
  if (request.options.friction > 0 &&
      (none || !std::ranges::all_of(networks, [](const nn::Model& network) { return network.history.friction; })))
    throw ConfigError("command line", "--friction", fmt::format("{}", request.options.friction),
                      "left out but for networks of tactel train --friction");
  if (request.options.rest && request.options.touch == 0.0)
    throw ConfigError("command line", "--touch", "0",
                      "above 0 with --rest or a network by the rest: a grip ends where nothing touches");
}

/// The number of --alarm; without one, of --signal left 1, of --signal moved that of the calibration, and of a network
/// of slid that of the calibration or its own.
std::optional<float> alarm_of(const MonitorRequest& request, std::span<const nn::Model> networks,
                              const hw::Calibration& calibration) {
  if (request.alarm_given.empty()) return std::nullopt;
  const std::string& given = request.alarm_given.front();
  const bool moved = request.options.signal == AlarmSignal::moved, left = request.options.signal == AlarmSignal::left;
  if (!given.empty()) {
    const float number = std::stof(given);
    if (left ? !(number > 0) : !(number <= 1))
      throw ConfigError("command line", "--alarm", given, left ? "above 0 with --signal left" : "0 to 1");
    if (moved && !(number > 0 && number < infer::most_moved))
      throw ConfigError("command line", "--alarm", given, "a number above 0 and below 0.5 with --signal moved");
    return number;
  }
  if (left) return 1.0f;
  if (!moved && (networks.empty() || !nn::is_slide(networks.front().target))) return default_alarm;
  if (const double of_hold = moved ? calibration.moved : calibration.slid; of_hold > 0)
    return static_cast<float>(of_hold);
  if (!moved && networks.front().learnt.alarm_at > 0) return networks.front().learnt.alarm_at;
  throw ConfigError("command line", "--alarm", "(missing)",
                    fmt::format("given with a number, or after tactel tare --hold{}, whose --output is the "
                                "--calibration",
                                moved ? "" : " --network"));
}

/// What --alarm acts on where --signal does not say it: with --rest left, but for networks of S.
AlarmSignal signal_of(const MonitorRequest& request, std::span<const nn::Model> networks) {
  if (request.signal == "left") return AlarmSignal::left;
  if (request.signal == "moved") return AlarmSignal::moved;
  const bool of_slip = !networks.empty() && !nn::is_slide(networks.front().target);
  return request.signal.empty() && request.options.rest && !of_slip ? AlarmSignal::left : AlarmSignal::slip;
}

/// Says what the alarm of left goes by, and what it does not see.
void say_left(const MonitorRequest& request, const hw::ChannelMap& map) {
  if (request.quiet || !request.alarm || request.options.signal != AlarmSignal::left) return;
  say("note: \"left\" is 1 at the alarm; what slips more slowly than by 10 % of the normal force a second is not seen");
  if (map.calibration.hold.at == 0)
    say("note: no hold was recorded: slips that change little are missed, as of hard or slippery objects (tactel tare "
        "--hold)");
  if (map.shear.empty()) say("note: without shear the alarm goes by the pattern of pressure alone, and hears less");
  if (!request.alarm_given.front().empty() && *request.alarm < infer::most_moved && request.signal.empty())
    say(fmt::format("note: --alarm {} is of left; --signal moved goes by \"moved\"", request.alarm_given.front()));
}

int run_monitor(MonitorRequest request) {
  std::vector<nn::Model> networks;
  for (const std::string& file : request.networks) networks.push_back(read_onnx(file));
  request.options.signal = signal_of(request, networks);
  const bool needs_rest = std::ranges::any_of(networks, [](const nn::Model& network) { return network.history.rest; });
  request.options.rest |= request.options.signal != AlarmSignal::slip || needs_rest;
  request.takes_friction =
      std::ranges::any_of(networks, [](const nn::Model& network) { return network.history.friction; });
  check_request(request, networks);
  for (const std::string& name : request.serve_hosts) check_serve_host(name);
  const nn::Target target = networks.empty() ? nn::Target::slip_index : networks.front().target;
  std::optional<Device> device;
  std::unique_ptr<LiveEstimator> compiled;  // before the source is opened, whose frames do not wait
  if (!request.device.empty()) {
    device.emplace(request.device);
    std::vector<const nn::Model*> models;
    models.reserve(networks.size());
    for (const nn::Model& network : networks) models.push_back(&network);
    compiled = device_estimator(*device, models);
  }
  OpenSource opened = open_for(request);
  const bool touch_known = request.options.touch || knows_touch(opened.profile);
  MonitorOptions options = request.options;
  request.alarm = alarm_of(request, networks, opened.profile.map.calibration);
  if (request.alarm || (request.view && touch_known)) options.at = request.alarm.value_or(default_alarm);
  options.widest = request.widest.value_or(options.widest);
  options.ignore_unlike = request.unlike == "ignore";
  if (target == nn::Target::slip_index || nn::is_slide(target)) options.true_slip_index = opened.true_slip_index;
  if ((request.alarm || options.rest) && !touch_known && opened.profile.map.calibration.has_zero)
    throw ConfigError("command line", request.alarm ? "--alarm" : "--rest",
                      request.alarm ? fmt::format("{}", *request.alarm) : "",
                      "given with --touch MPa, or with noise in [calibration] (tactel tare measures it): without a "
                      "threshold of touch, noise at rest raises alarms");
  LiveMonitor monitor(networks, opened.profile, options, device);
  Output output;
  for (std::size_t i = 0; i < networks.size(); ++i)
    if (const std::string learnt = learnt_text(networks[i].learnt); !learnt.empty() && !request.quiet)
      say(fmt::format("note: {} learnt {}; its answers hold for no others", request.networks[i], learnt));
  for (std::size_t i = 0; i < networks.size(); ++i)
    if (networks[i].bound && !networks[i].bound->calibrated() && !request.quiet)
      print_warning(request.networks[i] + ": its bound is not calibrated (tactel calibrate bound)");
  if (!touch_known && !request.quiet)
    print_warning(
        "no threshold of touch: [calibration] has no noise, so that frames at rest have an S, too; run tactel "
        "tare, or give --touch MPa");
  LiveView view({.alarm = touch_known ? request.alarm.value_or(default_alarm) : never,
                 .cursor = output.terminal(),
                 .colour = takes_colour(STDOUT_FILENO),
                 .pads = opened.profile.pads});
  const bool slid = target == nn::Target::slid || target == nn::Target::slip_path;
  const char* const name = networks.empty() ? nullptr : slid ? "slid" : nn::name(target);
  say_left(request, opened.profile.map);
  BrowserView browser(request, opened.profile, name, !networks.empty() && networks.front().bound);
  const Until until(*opened.source, request.seconds);
  std::vector<std::string> later;
  const MonitorSummary summary = monitor.run(
      *opened.source, make_events(request, name, opened.profile.map.tactels(), view, browser, output, until, later));
  if (const auto picture = view.show_newest(output.columns())) output.put(*picture);
  for (const std::string& warning : later)
    if (!request.quiet) print_warning(warning);
  if (summary.faint > 0 && summary.contacts == 0 && !request.quiet)
    print_warning(
        "something touched, but below the smallest peak that the network learnt: no frame has an answer; gains of the "
        "calibration must give MPa, or --touch says what is a contact");
  say_if_cut_short(request, *opened.source);
  say_if_nothing_decoded(request, *opened.source, summary.decoder);
  say(summary_text(summary, opened.source->cut_short()));
  output.check();
  return until.by_signal() ? static_cast<int>(interrupted) : done;
}

}  // namespace

void add_monitor_command(CLI::App& app, Action& action) {
  const auto [command, request] =
      add_command(app, action, "Read a sensor", "monitor",
                  "print the slippage index of a live sensor: one JSON line a frame", run_monitor);
  add_monitor_options(command, request);
}

}  // namespace tactel::host
