// SPDX-License-Identifier: Apache-2.0
#include "host/live/live_monitor.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/live/frame_reader.h"
#include "host/support/errors.h"
#include "nn/infer/network_file.h"

namespace tactel::host {
namespace {

// A pause of the reader (a slow disk, a stopped program) is no silence of the source: a turn counts for no more.
constexpr double longest_turn = 2 * longest_wait;  // s

void check_width(const nn::Model& model, const SensorProfile& profile) {
  const std::size_t inputs = 2 * profile.map.tactels();
  const auto frames = static_cast<std::size_t>(model.history.frames);
  if (static_cast<std::size_t>(model.weights.topology.inputs()) == inputs * frames) return;
  throw ConfigError(
      "command line", "--network", model.weights.topology.text(),
      fmt::format("a network with {} inputs, a normal and a shear stress for each of the {} tactels that the "
                  "profile of {} maps{}",
                  inputs * frames, profile.map.tactels(), profile.name.empty() ? "this source" : profile.name,
                  frames > 1 ? fmt::format(", in each of {} frames", frames) : ""));
}

/// Whether a normal stress of the frame [2 tactels] MPa reaches the threshold.
bool touches(std::span<const float> frame, double threshold) {
  return std::ranges::any_of(frame.first(frame.size() / 2),
                             [&](float stress) { return !(std::abs(stress) < threshold); });
}

SlipEstimator estimator_of(const nn::Model& model) {
  const std::string bytes = infer::network_bytes(model);
  return SlipEstimator::parse(std::as_bytes(std::span(bytes)));
}

}  // namespace

LiveMonitor::LiveMonitor(const nn::Model& model, const SensorProfile& profile, const MonitorOptions& options)
    : options_(options),
      map_(profile.map),
      touch_(options.touch.value_or(profile.map.touch())),
      drift_(options.drift > 0 ? std::optional<DriftWatch>(std::in_place, profile.map, options.drift) : std::nullopt),
      decoder_((check_width(model, profile), profile.format())),
      has_bound_(model.bound.has_value()),
      history_(estimator_of(model)),
      stresses_(2 * profile.map.tactels()) {}

MonitorSummary LiveMonitor::run(hw::FrameSource& source, const MonitorEvents& events) {
  source_ = &source;
  last_turn_ = source.now();
  next_second_ = last_turn_ + 1;
  read_frames(source, decoder_,
              {.frame = [&](const hw::DecodedFrame& frame, double arrival) { answer(frame, arrival, events); },
               .turn = [&] { watch(events); },
               .stop = events.stop});
  refresh();
  return summary_;
}

// A late frame is answered for the history alone.
void LiveMonitor::answer(const hw::DecodedFrame& frame, double arrival, const MonitorEvents& events) {
  const double decoded = source_->now();
  map_.apply(frame.values, stresses_);
  MonitorLine line{.frame = {decoder_.counts().frames - 1, frame.device_time, arrival, decoded},
                   .stresses = stresses_,
                   .answer = history_.estimate(stresses_),
                   .has_bound = has_bound_};
  if (source_->live() && decoded - arrival > options_.late) {
    ++summary_.late;
    return;
  }
  const double now = source_->now();
  if (touch_ > 0) {
    line.contact = line.answer.status == AnswerStatus::not_finite || touches(stresses_, touch_);
    if (!*line.contact) line.answer.slip_index = line.answer.slip_upper = std::nanf("");
  }
  line.latency = 1e6 * (now - arrival), line.answer_time = 1e6 * (now - decoded);
  summary_.latency.add(line.latency);
  if (drift_) line.drift = drift_->next(stresses_, line.contact.value_or(true), arrival);
  summary_.drifts += line.drift.size();
  if (events.line) events.line(line);
}

void LiveMonitor::refresh() {
  summary_.decoder = decoder_.counts();
  summary_.transport = source_->counts();
}

void LiveMonitor::watch(const MonitorEvents& events) {
  const double now = source_->now();
  if (now >= next_second_) {
    next_second_ = now + 1;
    refresh();
    if (events.second) events.second(summary_);
  }
  if (source_->live()) listen(now, events);
  last_turn_ = now;
}

void LiveMonitor::listen(double now, const MonitorEvents& events) {
  quiet_ += std::min(now - last_turn_, longest_turn);
  if (decoder_.counts().frames != frames_before_) quiet_ = 0, silent_ = false;
  frames_before_ = decoder_.counts().frames;
  if (silent_ || quiet_ < options_.silence) return;
  silent_ = true;
  ++summary_.silences;
  if (events.silence) events.silence(quiet_);
}

}  // namespace tactel::host
