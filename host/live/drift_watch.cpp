// SPDX-License-Identifier: Apache-2.0
#include "host/live/drift_watch.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace tactel::host {
namespace {

constexpr double most_noise = 2;         // of the noise in the calibration
constexpr double seen_noise = 0.75;      // steps of the readings: with less, half of the neighbours are equal
constexpr double tolerated_steps = 1.5;  // of the readings: the last bit of a converter may change
constexpr int touch_frames = 3;          // in a row: single ones come from a channel whose noise grew
constexpr std::size_t named = 3;         // channels in a sentence

}  // namespace

const char* Drift::name() const {
  return std::array{"offset", "noise", "stuck", "mounting"}[static_cast<std::size_t>(kind)];
}

const char* Drift::advice() const {
  return std::array{"offsets moved: tare again", "noise grew", "a channel is stuck",
                    "the pad is turned"}[static_cast<std::size_t>(kind)];
}

DriftWatch::DriftWatch(const hw::ChannelMap& map, double block, double most_shift)
    : block_(block), most_shift_(most_shift) {
  if (map.calibration.noise.empty()) return;
  for (std::size_t i = 0; i < map.places(); ++i) {
    const int channel = map.channel(i);
    if (channel < 0 || map.calibration.gain[static_cast<std::size_t>(channel)] == 0) continue;
    const auto c = static_cast<std::size_t>(channel);
    inputs_.push_back(
        {channel, map.channel_text(i), map.calibration.gain[c], map.calibration.noise[c], std::nan(""), 0, {}, 0});
    places_.push_back(i);
  }
  readings_.resize(inputs_.size());
}

std::vector<Drift> DriftWatch::next(std::span<const float> frame, bool contact, double arrival) {
  std::vector<Drift> found;
  if (inputs_.empty()) return found;
  read(frame, arrival);
  if (arrival >= next_check_) {
    find_stuck(arrival, found);
    next_check_ = arrival + block_;
  }
  touching_ = contact ? touching_ + 1 : 0;
  if (touching_ >= touch_frames) {
    begin_.reset(), now_.reset(), last_.reset();
    rested_ = false;
    return found;
  }
  if (begin_ && arrival - *begin_ >= block_ && now_->frames() >= least_frames) {
    if (last_ && rested_) judge(*last_, found);
    rested_ = last_.has_value();
    last_ = std::move(now_);
    begin_.reset();
  }
  if (!begin_) {
    begin_ = arrival;
    now_.emplace(inputs_.size());
  }
  now_->add(readings_);
  return found;
}

/// Readings less offsets, and their changes.
void DriftWatch::read(std::span<const float> frame, double arrival) {
  const double pause = std::max(0.0, arrival - last_arrival_.value_or(arrival) - block_);
  last_arrival_ = arrival;
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    Input& input = inputs_[i];
    const double reading = static_cast<double>(frame[places_[i]]) / input.gain;
    readings_[i] = reading;
    const double change = std::abs(reading - input.last);
    ++input.same, input.last_time += pause;
    if (change == 0 || !std::isfinite(reading)) {
      if (std::isnan(input.last) && input.last_time == 0) input.last_time = arrival;
      continue;
    }
    if (std::isfinite(change)) step_ = step_ > 0 ? std::min(step_, change) : change;
    input.last = reading, input.last_time = arrival, input.same = 0;
  }
}

void DriftWatch::judge(const hw::Tare& block, std::vector<Drift>& found) {
  std::vector<Finding> moved, noisy;
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    const hw::ChannelRest rest = block.channel(i);
    const double unit = std::max(inputs_[i].noise, tolerated_steps * step_);
    if (rest.readings < least_frames || !rest.at_rest() || unit == 0) continue;
    if (std::abs(rest.mean) > most_shift_ * unit) moved.push_back({i, std::abs(rest.mean) / unit});
    if (rest.noise > most_noise * unit) noisy.push_back({i, rest.noise / unit});
  }
  tell(Drift::Kind::offset, std::move(moved), found);
  tell(Drift::Kind::noise, std::move(noisy), found);
}

void DriftWatch::find_stuck(double arrival, std::vector<Drift>& found) {
  std::vector<Finding> stuck;
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    const double quiet = arrival - inputs_[i].last_time;
    if (step_ > 0 && inputs_[i].noise > seen_noise * step_ && quiet >= stuck_blocks * block_ &&
        static_cast<double>(inputs_[i].same) >= stuck_blocks * least_frames)
      stuck.push_back({i, quiet});
  }
  tell(Drift::Kind::stuck, std::move(stuck), found);
}

/// What was not told before.
void DriftWatch::tell(Drift::Kind kind, std::vector<Finding> findings, std::vector<Drift>& found) {
  std::erase_if(findings, [&](const Finding& finding) { return inputs_[finding.input].told[static_cast<int>(kind)]; });
  if (findings.empty()) return;
  std::ranges::stable_sort(findings, std::greater{}, &Finding::size);
  Drift drift{.kind = kind, .channels = {}, .size = findings.front().size, .text = {}};
  std::string names;
  for (std::size_t i = 0; i < findings.size(); ++i) {
    Input& input = inputs_[findings[i].input];
    input.told[static_cast<int>(kind)] = true;
    drift.channels.push_back(input.channel);
    if (i < named) names += (i > 0 ? ", " : "") + input.name;
  }
  if (findings.size() > named) names += fmt::format(" and {} others", findings.size() - named);
  if (kind == Drift::Kind::offset)
    drift.text = fmt::format(
        "the offset moved, by {:.1f} times the noise: {}; tare again with nothing touching (tactel tare); where that "
        "does not last, calibrate again (python -m tactel.calibrate)",
        drift.size, names);
  else if (kind == Drift::Kind::noise)
    drift.text = fmt::format(
        "the noise at rest is {:.1f} times that of the calibration: {}; check cable and supply, then tare again "
        "(tactel tare)",
        drift.size, names);
  else
    drift.text = fmt::format(
        "the reading has not changed for {:.0f} s: {}; check cable and channel; calibrate again after a repair (python "
        "-m "
        "tactel.calibrate)",
        drift.size, names);
  found.push_back(std::move(drift));
}

}  // namespace tactel::host
