// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "host/commands/live/monitor.h"

namespace tactel::host {
namespace {

/// A number as JSON has it: what is not finite is null.
std::string json_number(double value) { return std::isfinite(value) ? fmt::format("{}", value) : "null"; }
std::string json_number(float value) { return std::isfinite(value) ? fmt::format("{}", value) : "null"; }

/// Of a network S or its other target; whether there is a contact, where a threshold is known; the bound of a network
/// that has one; whether the grip's rest is known, and how far it has moved. said: of the line, or of one of its pads.
/// target: null without a network.
template <class Said>
std::string answer_text(const char* target, const Said& said, const MonitorLine& line) {
  std::string text;
  if (target) text += fmt::format(", \"{}\": {}", target, json_number(said.answer.slip_index));
  if (said.contact) text += fmt::format(", \"contact\": {}", *said.contact);
  if (line.has_bound)
    text += fmt::format(", \"slip_upper\": {}, \"unlike\": {}", json_number(said.answer.slip_upper),
                        said.answer.unlike != 0);
  if (said.rest) text += fmt::format(", \"rest\": {}, \"moved\": {}", *said.rest, json_number(said.moved));
  if (line.has_left)
    text += fmt::format(", \"calm\": {}, \"left\": {}", json_number(said.calm), json_number(said.left));
  if (line.has_index) text += fmt::format(", \"index\": {}", json_number(said.index));
  if (said.released) text += ", \"released\": true";
  return text.substr(2);
}

/// What a line says beside its answer: the true S of a simulation; the answer of each of several pads; the alarm, where
/// it was asked for; whether the frame can tell; what drifted.
std::string further_text(const MonitorRequest& request, const MonitorLine& line, const char* target) {
  std::string text;
  if (line.true_slip_index) text += fmt::format(", \"true_slip_index\": {}", json_number(*line.true_slip_index));
  for (const AlarmAnswer& pad : line.pads)
    text += fmt::format("{}{{{}}}{}", &pad == line.pads.data() ? ", \"pads\": [" : ", ", answer_text(target, pad, line),
                        &pad == &line.pads.back() ? "]" : "");
  if (request.alarm) text += fmt::format(", \"alarm\": {}", line.alarm);
  if (request.alarm || line.has_bound)
    text += fmt::format(", \"cannot_tell\": {}{}", line.cannot_tell,
                        line.cannot_tell ? fmt::format(", \"why\": \"{}\"", name(line.why)) : "");
  for (const Drift& drift : line.drift)
    text += fmt::format("{}{{\"kind\": \"{}\", \"channels\": [{}], \"size\": {}, \"text\": {}}}{}",
                        &drift == line.drift.data() ? ", \"drift\": [" : ", ", drift.name(),
                        fmt::join(drift.channels, ", "), json_number(drift.size), nlohmann::json(drift.text).dump(),
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

}  // namespace

std::string line_text(const MonitorRequest& request, const MonitorLine& line, const char* target, std::size_t tactels) {
  const std::string latency = std::isfinite(line.latency) ? fmt::format("{:.1f}", line.latency) : "null";
  return fmt::format("{{\"frame\": {}, \"device_time\": {}, \"arrival\": {}, {}{}{}, \"latency_us\": {}}}",
                     line.frame.number, line.frame.device_time ? json_number(*line.frame.device_time) : "null",
                     json_number(line.frame.arrival), answer_text(target, line, line),
                     further_text(request, line, target), tactels > 0 ? stresses_text(line, tactels) : "", latency);
}

std::string silence_text(double seconds, double arrival, bool alarm) {
  return fmt::format(
      "{{\"arrival\": {}, \"silence\": {:.1f}, \"alarm\": {}, \"cannot_tell\": true, \"why\": \"silent\"}}",
      json_number(arrival), seconds, alarm);
}

std::string summary_text(const MonitorSummary& all, bool cut_short) {
  const hw::DecoderCounts& d = all.decoder;
  return fmt::format(
      "{{\"frames\": {}, \"lost\": {}, \"bad\": {}, \"resynchronised\": {}, \"late\": {}, \"latency_us\": "
      "{{\"p50\": {:.1f}, "
      "\"p99\": {:.1f}, \"p99.9\": {:.1f}, \"max\": {:.1f}}}, \"duplicated\": {}, \"discarded_bytes\": {}, "
      "\"silences\": {}, \"overruns\": {}, \"stalls\": {}, \"transfer_errors\": {}, "
      "\"reconnects\": {}, \"drifts\": {}, \"cut_short\": {}, \"device\": {}{}}}",
      d.frames, d.lost, d.bad + all.transport.bad, d.resynchronised, all.late, all.latency.quantile(0.5),
      all.latency.quantile(0.99), all.latency.quantile(0.999), all.latency.largest(), d.duplicated, d.discarded,
      all.silences, all.transport.overruns, all.transport.stalls, all.transport.errors, all.transport.reconnects,
      all.drifts, cut_short, nlohmann::json(all.device.empty() ? "host code" : all.device).dump(),
      all.judged > 0 ? fmt::format(", \"slip_index_error\": {:.3f}", all.error_sum / static_cast<double>(all.judged))
                     : "");
}

std::string learnt_text(const nn::Learnt& learnt) {
  std::string text;
  if (learnt.most_friction > 0)
    text = fmt::format("friction {:.3g} to {:.3g}", learnt.least_friction, learnt.most_friction);
  if (learnt.largest_peak > 0)
    text += fmt::format("{}normal stresses with a peak of {:.3g} to {:.3g} MPa", text.empty() ? "" : " and ",
                        learnt.smallest_peak, learnt.largest_peak);
  return text;
}

std::string friction_text(std::span<const float> mu) {
  std::string text;
  bool read = false;
  for (const float each : mu) {
    text += fmt::format("{}{}", text.empty() ? "" : ", ", std::isnan(each) ? "not read" : fmt::format("{:.2g}", each));
    read |= !std::isnan(each);
  }
  return read ? "note: it slides: friction " + text : "note: friction was not read: no frame has an answer";
}

}  // namespace tactel::host
