// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <memory>

#include "host/commands/command.h"
#include "host/commands/live/live_server.h"
#include "host/commands/live/sensor_session.h"
#include "host/figures/live_page.h"
#include "host/live/live_monitor.h"
#include "host/live/live_view.h"
#include "host/networks/onnx_file.h"
#include "host/support/errors.h"
#include "host/support/terminal.h"
#include "nn/infer/rest_reference.h"

namespace tactel::host {
namespace {

constexpr float default_alarm = 0.8f, never = 2;

struct MonitorRequest : SensorRequest {
  std::vector<std::string> networks;
  std::string device;
  int every = 1;
  std::vector<std::string> alarm_given;  ///< of --alarm: none, or a number, or "" for that of the calibration
  std::optional<float> alarm;            ///< default_alarm for --view where not given
  std::optional<float> widest;
  std::string unlike = "alarm", signal;  ///< signal: empty for slip, or without a network for moved
  MonitorOptions options;
  bool view = false, stresses = false, takes_friction = false;  ///< takes_friction: of a network
  std::vector<std::string> serve{};                             ///< of --serve: none, or a place, or ""
};

/// A number as JSON has it: what is not finite is null.
std::string json_number(double value) { return std::isfinite(value) ? fmt::format("{}", value) : "null"; }
std::string json_number(float value) { return std::isfinite(value) ? fmt::format("{}", value) : "null"; }

/// Of a network S or its other target; whether there is a contact, where a threshold is known; whether the grip's rest
/// is known, and how far it has moved; the bound of a network that has one. target: null without a network.
std::string answer_text(const char* target, const Answer& answer, const std::optional<bool>& contact, bool has_bound,
                        const std::optional<bool>& rest, float moved) {
  std::string text;
  if (target) text += fmt::format(", \"{}\": {}", target, json_number(answer.slip_index));
  if (contact) text += fmt::format(", \"contact\": {}", *contact);
  if (has_bound)
    text += fmt::format(", \"slip_upper\": {}, \"unlike\": {}", json_number(answer.slip_upper), answer.unlike != 0);
  if (rest) text += fmt::format(", \"rest\": {}, \"moved\": {}", *rest, json_number(moved));
  return text.substr(2);
}

/// What a line says beside its answer: the true S of a simulation; the answer of each of several pads; the alarm, where
/// it was asked for; whether the frame can tell; what drifted.
std::string further_text(const MonitorRequest& request, const MonitorLine& line, const char* target) {
  std::string text;
  if (line.true_slip_index) text += fmt::format(", \"true_slip_index\": {}", json_number(*line.true_slip_index));
  for (const AlarmAnswer& pad : line.pads)
    text += fmt::format("{}{{{}}}{}", &pad == line.pads.data() ? ", \"pads\": [" : ", ",
                        answer_text(target, pad.answer, pad.contact, line.has_bound, pad.rest, pad.moved),
                        &pad == &line.pads.back() ? "]" : "");
  if (request.alarm) text += fmt::format(", \"alarm\": {}", line.alarm);
  if (request.alarm || line.has_bound) text += fmt::format(", \"cannot_tell\": {}", line.cannot_tell);
  for (const Drift& drift : line.drift)
    text += fmt::format("{}{{\"kind\": \"{}\", \"channels\": [{}], \"size\": {}, \"text\": \"{}\"}}{}",
                        &drift == line.drift.data() ? ", \"drift\": [" : ", ", drift.name(),
                        fmt::join(drift.channels, ", "), json_number(drift.size), drift.text,
                        &drift == &line.drift.back() ? "]" : "");
  return text;
}

/// Those of all tactels, axis by axis, MPa.
std::string stresses_text(const MonitorLine& line, std::size_t tactels) {
  std::string text = ", \"stresses\": [";
  for (std::size_t i = 0; i < line.stresses.size(); ++i)
    text += fmt::format("{}{}{}",
                        i % tactels > 0 ? ", "
                        : i > 0         ? "], ["
                                        : "[",
                        json_number(line.stresses[i]), i + 1 == line.stresses.size() ? "]]" : "");
  return text;
}

/// tactels: of all pads, where the line has their stresses; 0: it has none.
std::string line_text(const MonitorRequest& request, const MonitorLine& line, const char* target, std::size_t tactels) {
  const std::string latency = std::isfinite(line.latency) ? fmt::format("{:.1f}", line.latency) : "null";
  return fmt::format("{{\"frame\": {}, \"device_time\": {}, \"arrival\": {}, {}{}{}, \"latency_us\": {}}}",
                     line.frame.number, line.frame.device_time ? json_number(*line.frame.device_time) : "null",
                     json_number(line.frame.arrival),
                     answer_text(target, line.answer, line.contact, line.has_bound, line.rest, line.moved),
                     further_text(request, line, target), tactels > 0 ? stresses_text(line, tactels) : "", latency);
}

std::string summary_text(const MonitorSummary& all, bool cut_short) {
  const hw::DecoderCounts& d = all.decoder;
  return fmt::format(
      "{{\"frames\": {}, \"lost\": {}, \"bad\": {}, \"resynchronised\": {}, \"late\": {}, \"latency_us\": "
      "{{\"p50\": {:.1f}, "
      "\"p99\": {:.1f}, \"p99.9\": {:.1f}, \"max\": {:.1f}}}, \"duplicated\": {}, \"discarded_bytes\": {}, "
      "\"silences\": {}, \"overruns\": {}, \"stalls\": {}, \"transfer_errors\": {}, "
      "\"reconnects\": {}, \"drifts\": {}, \"cut_short\": {}, \"device\": \"{}\"{}}}",
      d.frames, d.lost, d.bad + all.transport.bad, d.resynchronised, all.late, all.latency.quantile(0.5),
      all.latency.quantile(0.99), all.latency.quantile(0.999), all.latency.largest(), d.duplicated, d.discarded,
      all.silences, all.transport.overruns, all.transport.stalls, all.transport.errors, all.transport.reconnects,
      all.drifts, cut_short, all.device.empty() ? "host code" : all.device,
      all.judged > 0 ? fmt::format(", \"slip_index_error\": {:.3f}", all.error_sum / static_cast<double>(all.judged))
                     : "");
}

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

/// The ranges that a network learnt, as far as its file knows them; empty where it knows none.
std::string learnt_text(const nn::Learnt& learnt) {
  std::string text;
  if (learnt.most_friction > 0)
    text = fmt::format("friction {:.3g} to {:.3g}", learnt.least_friction, learnt.most_friction);
  if (learnt.largest_peak > 0)
    text += fmt::format("{}normal stresses with a peak of {:.3g} to {:.3g} MPa", text.empty() ? "" : " and ",
                        learnt.smallest_peak, learnt.largest_peak);
  return text;
}

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
    say_once(no_answer_, line.no_answer,
             "it has no answer, as a stress is NaN or too large; the alarm stays as it is meanwhile");
    say_once(beyond_, line.answer.beyond_learnt != 0,
             "a normal stress is above 10 times the largest that the network learnt; gains of the calibration must "
             "give MPa");
    return found;
  }

 private:
  const MonitorRequest& request_;
  bool unlike_ = false, no_answer_ = false, beyond_ = false;
};

/// Lines "rest", or empty ones, and "slides" on standard input.
class AskedLines {
 public:
  /// frames: they come by standard input, too.
  AskedLines(bool frames, bool quiet) : open_(!frames), quiet_(quiet) {}
  /// Returns what came since the last call. Waits for nothing.
  MonitorCalls operator()() {
    pollfd input{STDIN_FILENO, POLLIN, 0};
    MonitorCalls asked;
    // Reading a terminal stops a program in its background.
    while (open_ && !(isatty(STDIN_FILENO) && tcgetpgrp(STDIN_FILENO) != getpgrp()) && ::poll(&input, 1, 0) > 0) {
      char bytes[256];
      const ssize_t size = ::read(STDIN_FILENO, bytes, sizeof bytes);
      if (size < 0 && (errno == EINTR || errno == EAGAIN)) break;
      open_ = size > 0;
      for (const char byte : std::string_view(bytes, static_cast<std::size_t>(std::max<ssize_t>(size, 0)))) {
        if (byte != '\n' && byte != '\r') {
          if (line_.size() < sizeof bytes) line_ += byte;
        } else if (byte == '\n') {
          take(asked);
          line_.clear();
        }
      }
    }
    return asked;
  }

 private:
  void take(MonitorCalls& asked) const {
    if (line_.empty() || line_ == "rest")
      asked.rest = true;
    else if (line_ == "slides")
      asked.slides = true;
    else if (!quiet_)
      print_warning("a line of standard input was left out: it is neither \"rest\" nor \"slides\"");
  }

  bool open_, quiet_;
  std::string line_;
};

/// What is said of a reading of mu.
std::string friction_text(std::span<const float> mu) {
  std::string text;
  bool read = false;
  for (const float one : mu) {
    text += fmt::format("{}{}", text.empty() ? "" : ", ", std::isnan(one) ? "not read" : fmt::format("{:.2g}", one));
    read |= !std::isnan(one);
  }
  return read ? "note: it slides: friction " + text : "note: friction was not read: no frame has an answer";
}

/// The page of --serve and its lines: 33 a second, and events. None where it was not asked for.
class BrowserView {
 public:
  BrowserView(const MonitorRequest& request, const SensorProfile& profile, const char* target, bool bound) {
    if (request.serve.empty()) return;
    LivePage page{.source = request.source, .pads = {}, .signal = "moved"};
    if (request.options.signal == AlarmSignal::slip) page.signal = target, page.bound = bound;
    if (request.alarm) page.alarm = *request.alarm;
    for (std::size_t i = 0; i < profile.pads.size(); ++i)
      page.pads.push_back({profile.pads.size() > 1 ? fmt::format("pad {}", i + 1) : "pad", profile.pads[i].tactels,
                           profile.pads[i].pitch});
    if (page.pads.empty()) page.pads.push_back({.name = "line"});
    const std::string& place = request.serve.front();
    server_ = std::make_unique<LiveServer>(place.empty() ? default_place : place, html(page));
    say("note: open " + server_->address() + " in a browser");
  }
  /// event: the line is sent, however recent the last one is.
  template <class Text>
  void show(const Text& text, bool event) {
    if (!server_) return;
    const auto now = std::chrono::steady_clock::now();
    if (!event && now - last_ < refresh) return;
    last_ = now;
    server_->send(text());
  }

 private:
  static constexpr const char* default_place = "8080";
  static constexpr auto refresh = std::chrono::milliseconds(30);
  std::unique_ptr<LiveServer> server_;
  std::chrono::steady_clock::time_point last_{};
};

/// Where the lines go, and when it ends. later: warnings that would tear a picture.
MonitorEvents make_events(const MonitorRequest& request, const char* target, std::size_t tactels, LiveView& view,
                          BrowserView& browser, Output& output, const Until& until, std::vector<std::string>& later) {
  MonitorEvents events;
  events.line = [&, target, tactels, on = false, cannot_tell = false,
                 doubts = Doubts(request)](const MonitorLine& line) mutable {
    const bool turned = line.alarm != on || (request.widest && line.cannot_tell != cannot_tell);
    on = line.alarm, cannot_tell = line.cannot_tell;
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
    browser.show([&] { return line_text(request, line, target, tactels); }, event);
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
  events.silence = [&](double seconds) {
    if (!request.quiet) print_warning(fmt::format("no frame for {:.1f} s", seconds));
  };
  events.stop = [&] { return output.failed() || until(); };
  if (request.options.rest || request.takes_friction)
    events.calls = [lines = AskedLines(request.source.starts_with("csv:-"), request.quiet)]() mutable {
      return lines();
    };
  if (!request.quiet) events.friction = [](std::span<const float> mu) { say(friction_text(mu)); };
  return events;
}

/// What the options ask for together with the networks.
void check_request(const MonitorRequest& request, std::span<const nn::Model> networks) {
  const bool moved = request.options.signal == AlarmSignal::moved, none = networks.empty();
  if (none && !request.options.rest && request.signal != "slip")
    throw ConfigError("command line", "--network", "(missing)", "given, or left out with --rest");
  if (none && !moved) throw ConfigError("command line", "--signal", request.signal, "moved without --network");
  if (none && !request.device.empty())
    throw ConfigError("command line", "--device", request.device, "given with --network");
  if (request.widest && (none || !networks.front().bound))
    throw ConfigError("command line", "--widest", fmt::format("{}", *request.widest),
                      "left out for a network without a bound: it has no interval");
  for (std::size_t i = 1; i < networks.size(); ++i)
    if (networks[i].target != networks.front().target)
      throw ConfigError("command line", "--network", request.networks[i],
                        fmt::format("a network of {}, as the first", nn::name(networks.front().target)));
  if (request.view && moved)
    throw ConfigError("command line", "--view", "", "left out with --signal moved: it shows S");
  const nn::Target target = none ? nn::Target::slip_index : networks.front().target;
  const bool alarms = moved || target == nn::Target::slip_index || target == nn::Target::slid;
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

/// The number of --alarm; without one, of --signal moved that of the calibration, and of a network of slid that of the
/// calibration or its own.
std::optional<float> alarm_of(const MonitorRequest& request, std::span<const nn::Model> networks,
                              const hw::Calibration& calibration) {
  if (request.alarm_given.empty()) return std::nullopt;
  const std::string& given = request.alarm_given.front();
  const bool moved = request.options.signal == AlarmSignal::moved;
  if (!given.empty()) {
    const float number = std::stof(given);
    if (moved && !(number > 0 && number < infer::most_moved))
      throw ConfigError("command line", "--alarm", given, "a number above 0 and below 0.5 with --signal moved");
    return number;
  }
  if (!moved && (networks.empty() || networks.front().target != nn::Target::slid)) return default_alarm;
  if (const double of_hold = moved ? calibration.moved : calibration.slid; of_hold > 0)
    return static_cast<float>(of_hold);
  if (!moved && networks.front().learnt.alarm_at > 0) return networks.front().learnt.alarm_at;
  throw ConfigError("command line", "--alarm", "(missing)",
                    fmt::format("given with a number, or after tactel tare --hold{}, whose --output is the "
                                "--calibration",
                                moved ? "" : " --network"));
}

int run_monitor(MonitorRequest request) {
  std::vector<nn::Model> networks;
  for (const std::string& file : request.networks) networks.push_back(read_onnx(file));
  const bool moved = request.signal == "moved" || (networks.empty() && request.options.rest && request.signal.empty());
  if (moved) request.options.signal = AlarmSignal::moved;
  const bool needs_rest = std::ranges::any_of(networks, [](const nn::Model& network) { return network.history.rest; });
  request.options.rest |= moved || needs_rest;
  request.takes_friction =
      std::ranges::any_of(networks, [](const nn::Model& network) { return network.history.friction; });
  check_request(request, networks);
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
  if (target == nn::Target::slip_index || target == nn::Target::slid) options.true_slip_index = opened.true_slip_index;
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
  const char* const name = networks.empty() ? nullptr : nn::name(target);
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
  auto request = std::make_shared<MonitorRequest>();
  CLI::App* command = app.add_subcommand("monitor", "print the slippage index of a live sensor: one JSON line a frame");
  command->group("Read a sensor");
  add_sensor_options(*command, *request);
  command
      ->add_option("--network", request->networks,
                   "network that evaluates the frames, see tactel train; of several pads once, or once for each; "
                   "needed but with --rest")
      ->type_name("FILE.onnx")
      ->allow_extra_args(false);
  command->add_option("--every", request->every, "print only every N-th frame")
      ->type_name("N")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command
      ->add_option("--seconds", request->seconds,
                   "stop after this time, s (default: at the end of the source, or Ctrl-C)")
      ->check(positive_number());
  command->add_option("--late", request->options.late, "drop and count live frames older than this, s")
      ->check(positive_number())
      ->capture_default_str();
  command
      ->add_option("--touch", request->options.touch,
                   "a frame whose normal stresses all stay below this is no contact: its S is null, and it ends an "
                   "alarm; 0: every frame is a contact, MPa (default: 7 standard deviations of the noise in the "
                   "calibration, see tactel tare, and at least the smallest peak that the network learnt)")
      ->check(not_negative_number());
  command
      ->add_option("--drift", request->options.drift,
                   "compare this long at rest with offsets and noise of the calibration, and say which channels no "
                   "longer fit; twice the time constant of charge amplifiers, or more; 0: never, s")
      ->check(not_negative_number())
      ->capture_default_str();
  command->add_flag(
      "--view", request->view,
      "a picture instead of lines: S and its history, the tactels' stresses as blocks, shear with its direction; of "
      "pads a tile a tactel, shaded by pressure, with an arrow of shear");
  command
      ->add_option(
          "--serve", request->serve,
          "a page for browsers beside the lines: pads or the line, what the alarm judges over ten seconds, and "
          "the truth of a simulation; PORT of this machine alone, or ADDRESS:PORT, 0.0.0.0:8080 for a telephone "
          "beside the gripper; port 0: any (default: 8080)")
      ->type_name("PLACE")
      ->expected(0, 1);
  command->add_flag("--stresses", request->stresses, "add \"stresses\" to each line: all tactels, axis by axis, MPa");
  CLI::Option* alarm =
      command
          ->add_option(
              "--alarm", request->alarm_given,
              "add \"alarm\" to each line: true from this upper bound of S on (S itself where the network has no "
              "bound), false again 0.05 below; a line where it changes is always printed; --view shows it, too; with "
              "--signal moved from this \"moved\" on, with a network of slid from this answer on, no unit (default: "
              "0.8; of moved that of tactel tare --hold; of slid that or the network's own)")
          ->type_name("FLOAT")
          ->expected(0, 1)
          ->check(CLI::Range(0.0f, 1.0f));
  command->add_flag(
      "--rest", request->options.rest,
      "add \"rest\", whether a rest of the grip is known, and \"moved\", the change of all stresses since, "
      "over the normal force then; a line \"rest\" on standard input seeks rest anew");
  command
      ->add_option(
          "--signal", request->signal,
          "what --alarm acts on: slip, S or its bound, or moved, with --rest (default: slip, without a network "
          "moved)")
      ->check(CLI::IsMember({"slip", "moved"}));
  CLI::Option* friction = command
                              ->add_option("--friction", request->options.friction,
                                           "mu, as far as it is known, for networks of train --friction; while an "
                                           "object slides, a line \"slides\" on standard input has it read")
                              ->type_name("MU")
                              ->check(CLI::Range(1e-3, 1e3));
  command->add_option("--friction-spread", request->options.friction_spread, "relative standard deviation of that mu")
      ->type_name("FLOAT")
      ->check(CLI::Range(0.0, 1e3))
      ->capture_default_str()
      ->needs(friction);
  command
      ->add_option("--friction-drift", request->options.friction_drift,
                   "relative standard deviation by which mu, as read from a slide, drifts in the next minute; it is "
                   "trusted less with the root of time")
      ->type_name("FLOAT")
      ->check(CLI::Range(0.0, 1e3))
      ->capture_default_str();
  command
      ->add_option("--hold", request->options.hold,
                   "with --alarm: it begins at the last of so many frames in a row that ask for it")
      ->type_name("N")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str()
      ->needs(alarm);
  command
      ->add_option("--unlike", request->unlike,
                   "with --alarm: what a frame does that is unlike those learnt, of which the network cannot tell S: "
                   "alarm, or ignore: the alarm goes by S")
      ->check(CLI::IsMember({"alarm", "ignore"}))
      ->capture_default_str()
      ->needs(alarm);
  command
      ->add_option("--widest", request->widest,
                   "with --alarm: no alarm begins at a frame with a wider interval of S, which is then "
                   "\"cannot_tell\", no unit")
      ->type_name("FLOAT")
      ->check(CLI::Range(0.0f, 2.0f))
      ->needs(alarm)
      ->excludes("--view");
  command
      ->add_option("--device", request->device,
                   "OpenCL device that evaluates the networks, all pads by one launch; gpu, cpu, or as of "
                   "`tactel devices` (default: host code, with the same bits, quicker for a sensor or two)")
      ->type_name("NAME|INDEX");
  command->add_flag("--quiet", request->quiet, "no summary each second and no warnings; the final summary stays");
  command->callback([request, &action] { action = [request] { return run_monitor(*request); }; });
}

}  // namespace tactel::host
