// SPDX-License-Identifier: Apache-2.0
#include "host/live/live_monitor.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/live/frame_reader.h"
#include "host/support/errors.h"

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

}  // namespace

LiveMonitor::LiveMonitor(Executor& executor, const nn::Model& model, const SensorProfile& profile,
                         const MonitorOptions& options)
    : options_(options),
      map_(profile.map),
      touch_(options.touch.value_or(profile.map.touch())),
      drift_(options.drift > 0 ? std::optional<DriftWatch>(std::in_place, profile.map, options.drift) : std::nullopt),
      decoder_((check_width(model, profile), profile.format())),
      queue_(options.queue, 2 * profile.map.tactels()),
      history_(2 * profile.map.tactels(), model.history),
      input_(history_.inputs()),
      one_(executor, model.weights, model.scaling),
      batch_(executor, std::span(&model.weights, 1), model.scaling),
      device_(&executor.device()),
      bound_(model.bound),
      scaling_(model.scaling),
      scaled_(static_cast<std::size_t>(model.weights.topology.inputs())) {
  const std::vector<float> rest(history_.inputs(), 0.0f);
  one_(rest);
  batch_.recall(nn::RowMatrix<float>::Zero(static_cast<Eigen::Index>(options.batch_from),
                                           static_cast<Eigen::Index>(rest.size())));
}

void LiveMonitor::compile(Executor& executor, const nn::Model& model) {
  ForwardOne<float>(executor, model.weights, model.scaling);
  Forward<float>(executor, std::span(&model.weights, 1), model.scaling);
}

MonitorSummary LiveMonitor::run(hw::FrameSource& source, const MonitorEvents& events) {
  source_ = &source;
  last_turn_ = source.now();
  next_second_ = last_turn_ + 1;
  read_frames(source, decoder_,
              {.frame = [&](const hw::DecodedFrame& frame, double arrival) { queue(frame, arrival); },
               .turn =
                   [&] {
                     answer_waiting(events);
                     watch(events);
                   },
               .stop = events.stop});
  refresh();
  return summary_;
}

void LiveMonitor::queue(const hw::DecodedFrame& frame, double arrival) {
  map_.apply(frame.values, queue_.push({decoder_.counts().frames - 1, frame.device_time, arrival, source_->now()}));
}

void LiveMonitor::answer_waiting(const MonitorEvents& events) {
  if (queue_.size() == 0) return;
  if (source_->live()) drop_late();
  if (queue_.size() >= options_.batch_from) return answer_batch(events);
  while (queue_.size() > 0) answer_one(events);
}

void LiveMonitor::drop_late() {
  const double now = source_->now();
  while (queue_.size() > 0 && now - queue_.frame(0).arrival > options_.late) {
    history_.push(queue_.inputs(0).data());
    queue_.pop();
    ++summary_.late;
  }
}

void LiveMonitor::answer_one(const MonitorEvents& events) {
  history_.push(queue_.inputs(0).data());
  history_.write(input_.data());
  const FrameAnswer<float> answer = one_(input_);
  const auto bound = bounded(input_, answer);
  tell(0, answer, bound, source_->now(), events);
  queue_.pop();
}

void LiveMonitor::answer_batch(const MonitorEvents& events) {
  const std::size_t count = queue_.size();
  nn::RowMatrix<float> frames(count, history_.inputs());
  for (std::size_t i = 0; i < count; ++i) {
    history_.push(queue_.inputs(i).data());
    history_.write(frames.row(static_cast<Eigen::Index>(i)).data());
  }
  batch_.run(DeviceFrames(*device_, frames));
  const nn::Recall<float> recall = batch_.result(0);
  const double now = source_->now();
  summary_.batched += count;
  for (std::size_t i = 0; i < count; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    FrameAnswer<float> answer{.slip_index = recall.slip_index[row], .status = recall.status[i]};
    if (recall.upper.size() > 0) answer.upper = recall.upper[row], answer.lower = recall.lower[row];
    tell(i, answer, bounded({frames.row(row).data(), scaled_.size()}, answer), now, events);
  }
  for (std::size_t i = 0; i < count; ++i) queue_.pop();
}

// Of a whole input of the network.
std::optional<nn::BoundAnswer> LiveMonitor::bounded(std::span<const float> input, const FrameAnswer<float>& answer) {
  if (!bound_) return std::nullopt;
  nn::scale_frame(scaling_, input.data(), static_cast<int>(input.size()), scaled_.data());
  return nn::bounded(*bound_, {answer.slip_index, answer.upper, answer.lower}, scaled_.data());
}

void LiveMonitor::tell(std::size_t i, FrameAnswer<float> answer, std::optional<nn::BoundAnswer> bound, double now,
                       const MonitorEvents& events) {
  const LiveFrame& frame = queue_.frame(i);
  std::optional<bool> contact;
  if (touch_ > 0) {
    contact = answer.status == nn::FrameStatus::not_finite || touches(queue_.inputs(i), touch_);
    if (!*contact) answer.slip_index = std::nanf("");
    if (!*contact && bound) bound->upper = std::nanf("");
  }
  const double latency = 1e6 * (now - frame.arrival);
  summary_.latency.add(latency);
  std::vector<Drift> drift;
  if (drift_) drift = drift_->next(queue_.inputs(i), contact.value_or(true), frame.arrival);
  summary_.drifts += drift.size();
  if (events.line)
    events.line(
        {frame, queue_.inputs(i), answer, bound, contact, std::move(drift), latency, 1e6 * (now - frame.decoded)});
}

void LiveMonitor::refresh() {
  summary_.decoder = decoder_.counts();
  summary_.transport = source_->counts();
  summary_.late += queue_.dropped() - dropped_before_;
  dropped_before_ = queue_.dropped();
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
