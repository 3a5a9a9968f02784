// SPDX-License-Identifier: Apache-2.0
#include "host/live/live_monitor.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "host/live/frame_reader.h"
#include "host/support/errors.h"
#include "nn/infer/friction_reading.h"
#include "nn/infer/network_file.h"

namespace tactel::host {
namespace {

// A pause of the reader (a slow disk, a stopped program) is no silence of the source: a turn counts for no more.
constexpr double longest_turn = 2 * longest_wait;  // s

/// Counts that are not tared are stresses far beyond all that a network learnt.
void check_zero(const SensorProfile& profile) {
  if (profile.map.calibration.has_zero) return;
  throw ConfigError("command line", "--calibration", "(missing)",
                    "given: the profile has a gain, but no reading at rest; run tactel tare with the same --source and "
                    "--profile and nothing touching, and give its --output here; of a device that sends 0 at rest, "
                    "write offset = 0 into [calibration]");
}

void check_networks(std::span<const nn::Model> networks, const SensorProfile& profile, AlarmSignal signal) {
  check_zero(profile);
  if (networks.empty() && signal != AlarmSignal::slip) return;
  const std::size_t pads = std::max<std::size_t>(profile.pads.size(), 1);
  const auto bounded = static_cast<std::size_t>(
      std::ranges::count_if(networks, [](const nn::Model& network) { return network.bound.has_value(); }));
  if (networks.size() != 1 && networks.size() != pads)
    throw ConfigError("command line", "--network", fmt::format("{} networks", networks.size()),
                      pads == 1 ? "one network" : fmt::format("one network for all pads, or {}, one for each", pads));
  if (bounded != 0 && bounded != networks.size())
    throw ConfigError("command line", "--network", "a network with a bound and one without",
                      "networks that all have a bound, or none");
}

/// The answer of the pad with the largest number to act on; S and its upper bound are the largest of all pads. A pad
/// whose alarm is on keeps it on, also in frames without an answer of that pad.
void take_largest(MonitorLine& line) {
  float most = -std::numeric_limits<float>::infinity();
  Answer largest = line.pads.front().answer;
  line.acted_on = line.pads.front().acted_on;
  for (const AlarmAnswer& pad : line.pads) {
    line.alarm |= pad.on, line.cannot_tell |= pad.cannot_tell, line.no_answer |= std::isnan(pad.acted_on);
    line.released |= pad.released;
    if (line.why == CannotTell::none) line.why = pad.why;
    line.left = std::fmax(line.left, pad.left), line.calm = std::fmax(line.calm, pad.calm);
    line.index = std::fmin(line.index, pad.index);
    if (pad.contact) line.contact = line.contact.value_or(false) || *pad.contact;
    if (pad.rest) line.rest = line.rest.value_or(false) || *pad.rest;
    line.moved = std::fmax(line.moved, pad.moved);
    if (pad.contact == false) continue;
    if (pad.acted_on > most) line.acted_on = most = pad.acted_on, largest = pad.answer;
  }
  for (const AlarmAnswer& pad : line.pads) {
    largest.slip_index = std::fmax(largest.slip_index, pad.answer.slip_index);
    largest.slip_upper = std::fmax(largest.slip_upper, pad.answer.slip_upper);
    largest.unlike |= pad.answer.unlike, largest.beyond_learnt |= pad.answer.beyond_learnt;
  }
  line.answer = largest;
}

/// Whether a network's smallest peak bounds what touches.
bool has_peak(const MonitorOptions& options, const SlipEstimator* network) {
  return network && !network->needs_rest() && options.signal != AlarmSignal::left;
}

/// touch: MPa, of options or profile.
AlarmOptions rules_of(const MonitorOptions& options, const SlipEstimator* network, double touch) {
  return {options.at,
          options.touch.value_or(std::max<double>(touch, has_peak(options, network) ? network->smallest_peak() : 0)),
          options.widest,
          options.hold,
          options.ignore_unlike,
          options.rest,
          options.signal};
}

/// The rules of a pad, with what tactel tare has read of its grips.
AlarmOptions rules_of(const MonitorOptions& options, const SlipEstimator* network, double touch,
                      const SensorProfile& profile, std::size_t pad) {
  AlarmOptions rules = rules_of(options, network, touch);
  const infer::PadShape shape = shape_of(profile, pad);
  const hw::Calibration& known = profile.map.calibration;
  rules.columns = shape.columns, rules.aspect = shape.aspect, rules.rate = usual_rate(profile);
  if (!known.slide.empty()) rules.slide = static_cast<float>(known.slide[pad]);
  if (known.hold.at > 0) std::ranges::copy(known.hold.covariance, rules.held.covariance.begin());
  rules.held.at = static_cast<float>(known.hold.at);
  return rules;
}

}  // namespace

std::vector<std::size_t> tactels_of(const SensorProfile& profile) {
  std::vector<std::size_t> tactels;
  for (const PadLayout& pad : profile.pads) tactels.push_back(pad.count());
  if (tactels.empty()) tactels.push_back(profile.map.tactels());
  return tactels;
}

void take_pad(std::span<const float> all, std::size_t all_tactels, std::size_t first, std::size_t tactels, float* to) {
  for (; first < all.size(); first += all_tactels, to += tactels) std::copy_n(&all[first], tactels, to);
}

void check_width(const nn::Model& model, const SensorProfile& profile, std::size_t tactels) {
  const std::size_t axes = profile.map.places() / profile.map.tactels(), inputs = axes * tactels;
  const auto frames = static_cast<std::size_t>(model.history.frames);
  if (model.scaling.markers)
    throw ConfigError("command line", "--network", "of markers", "a network of stresses, as sensors have them");
  if (model.scaling.features == nn::Features::pad)
    for (const PadLayout& pad : profile.pads)
      if (pad.count() == tactels && pad.tactels[0] != model.scaling.columns)
        throw ConfigError("command line", "--network", fmt::format("for {} tactels along x", model.scaling.columns),
                          fmt::format("for {}, as the pad of {} has", pad.tactels[0], profile.name));
  if (model.numbers() == nn::numbers_of(model.history, static_cast<int>(inputs))) return;
  throw ConfigError(
      "command line", "--network", model.weights.topology.text(),
      fmt::format(
          "a network with {} inputs, {} for each of the {} tactels that the profile of {} maps{}{}", inputs * frames,
          axes == 1   ? "a normal stress"
          : axes == 2 ? "a normal and a shear stress"
                      : "a normal stress and the shear along x and y",
          tactels, profile.name.empty() ? "this source" : profile.name, profile.pads.size() > 1 ? " for a pad" : "",
          frames > 1 ? fmt::format(", in each of {} frames", frames) : ""));
}

bool knows_touch(const SensorProfile& profile) {
  std::size_t first = 0;
  return std::ranges::all_of(tactels_of(profile), [&](std::size_t tactels) {
    return profile.map.touch(std::exchange(first, first + tactels), tactels) > 0;
  });
}

double usual_rate(const SensorProfile& profile) {
  const double of_hold = profile.map.calibration.hold.rate;
  return of_hold > 0 ? of_hold : AlarmOptions().rate;
}

LiveMonitor::Sensor::Sensor(const SlipEstimator* network, const SensorProfile& profile, std::size_t pad,
                            std::size_t first_tactel, std::size_t count, const MonitorOptions& options)
    : first(first_tactel),
      tactels(count),
      touch(options.touch.value_or(profile.map.touch(first, count))),
      alarm(network ? Alarm(*network, rules_of(options, network, touch, profile, pad))
                    : Alarm(count, profile.map.places() / profile.map.tactels(),
                            rules_of(options, network, touch, profile, pad))) {}

bool LiveMonitor::Sensor::rests() const {
  return std::ranges::all_of(std::span(stresses).first(tactels), [&](float s) { return std::abs(s) < touch; });
}

LiveMonitor::LiveMonitor(std::span<const nn::Model> networks, const SensorProfile& profile,
                         const MonitorOptions& options, const std::optional<Device>& device)
    : options_(options),
      map_(profile.map),
      drift_(options.drift > 0 ? std::optional<DriftWatch>(std::in_place, profile.map, options.drift) : std::nullopt),
      decoder_((check_networks(networks, profile, options.signal), profile.format())),
      has_bound_(!networks.empty() && networks.front().bound.has_value()),
      magnitude_(!networks.empty() && networks.front().magnitude),
      of_slid_(!networks.empty() && nn::is_slide(networks.front().target)),
      has_index_(options.signal == AlarmSignal::left && !profile.map.calibration.slide.empty()),
      rate_(usual_rate(profile)),
      stresses_(profile.map.places()) {
  std::vector<SlipEstimator> estimators;
  for (const nn::Model& network : networks) estimators.push_back(infer::estimator_of(network));
  std::vector<const nn::Model*> models;
  std::vector<double> touch;
  std::size_t first = 0;
  for (const std::size_t tactels : tactels_of(profile)) {
    const std::size_t which = networks.size() > 1 ? sensors_.size() : 0;
    if (!networks.empty()) check_width(networks[which], profile, tactels), models.push_back(&networks[which]);
    sensors_.emplace_back(networks.empty() ? nullptr : &estimators[which], profile, sensors_.size(),
                          std::exchange(first, first + tactels), tactels, options);
    if (!networks.empty()) touch.push_back(*rules_of(options, &estimators[which], sensors_.back().touch).touch);
  }
  frames_.resize(stresses_.size()), answers_.resize(sensors_.size());
  const std::size_t axes = frames_.size() / map_.tactels();
  for (Sensor& sensor : sensors_)
    sensor.stresses = std::span(frames_).subspan(axes * sensor.first, axes * sensor.tactels);
  if (!networks.empty()) estimator_ = device ? device_estimator(*device, models, touch) : host_estimator(models, touch);
  if (device) summary_.device = device->info().name;
  for (std::size_t i = 0; i < sensors_.size() && estimator_ && options.friction > 0; ++i)
    estimator_->friction(i, static_cast<float>(options.friction), static_cast<float>(options.friction_spread));
  for (std::size_t i = 0; i < profile.pads.size() && drift_; ++i)
    sensors_[i].mounting.emplace(profile.pads[i], map_.touch(sensors_[i].first, sensors_[i].tactels),
                                 !map_.shear_y.empty());
}

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

/// The pads' answers from stresses_, into line_.
void LiveMonitor::estimate() {
  for (const Sensor& sensor : sensors_)
    take_pad(stresses_, map_.tactels(), sensor.first, sensor.tactels, sensor.stresses.data());
  if (estimator_) estimator_->estimate(frames_, answers_);
  for (std::size_t i = 0; i < sensors_.size(); ++i) {
    Sensor& sensor = sensors_[i];
    line_.pads.push_back(estimator_ ? sensor.alarm.answer(sensor.stresses, answers_[i])
                                    : sensor.alarm.answer(sensor.stresses));
  }
}

/// Judges the pads; by AlarmSignal::left what they say together.
void LiveMonitor::judge() {
  own_ = line_.pads;
  if (line_.has_left) join(line_.pads);
  for (std::size_t i = 0; i < sensors_.size(); ++i) line_.pads[i] = sensors_[i].alarm.judge(line_.pads[i]);
}

// A late frame is answered for the history alone.
void LiveMonitor::answer(const hw::DecodedFrame& frame, double arrival, const MonitorEvents& events) {
  const double decoded = source_->now();
  map_.apply(frame.values, stresses_);
  MonitorLine& line = line_;
  std::vector<AlarmAnswer> pads = std::move(line.pads);
  pads.clear();
  line = {.frame = {decoder_.counts().frames - 1, frame.device_time, arrival, decoded},
          .stresses = stresses_,
          .has_bound = has_bound_,
          .has_left = options_.signal == AlarmSignal::left,
          .has_index = has_index_,
          .pads = std::move(pads)};
  if (const auto hz = source_->timed() ? rate_.next(frame.device_time.value_or(arrival)) : std::nullopt)
    for (Sensor& sensor : sensors_) sensor.alarm.rate(*hz);
  estimate();
  if (source_->live() && decoded - arrival > options_.late) {
    ++summary_.late;
    return;
  }
  judge();
  take_largest(line);
  for (std::size_t i = 0; i < own_.size(); ++i) line.pads[i].left = own_[i].left, line.pads[i].index = own_[i].index;
  if (line.pads.size() == 1) line.pads.clear();
  const double now = source_->now();
  line.latency = 1e6 * (now - arrival), line.answer_time = 1e6 * (now - decoded);
  summary_.latency.add(line.latency);
  const bool rest = std::ranges::all_of(sensors_, &Sensor::rests);
  if (drift_) line.drift = drift_->next(stresses_, !rest, arrival);
  for (Sensor& sensor : sensors_)
    if (auto turned = sensor.mounting ? sensor.mounting->next(sensor.stresses) : std::nullopt)
      line.drift.push_back(std::move(*turned));
  count(line, rest);
  if (events.line) events.line(line);
}

void LiveMonitor::count(MonitorLine& line, bool rest) {
  const bool contact = line.contact.value_or(true);
  summary_.drifts += line.drift.size(), summary_.contacts += contact, summary_.faint += !contact && !rest;
  if (!options_.true_slip_index) return;
  const float truth = *(line.true_slip_index = options_.true_slip_index(line.frame.number));
  const float error = std::abs(line.answer.slip_index - (magnitude_ ? std::abs(truth) : truth));
  if (!std::isnan(error) && !of_slid_) summary_.error_sum += error, ++summary_.judged;
}

void LiveMonitor::refresh() {
  summary_.decoder = decoder_.counts();
  summary_.transport = source_->counts();
}

/// Reads friction from what slides: of a network mu, of AlarmSignal::left Q / P.
void LiveMonitor::slides(const MonitorEvents& events, double now) {
  std::vector<float> known;
  for (std::size_t i = 0; i < sensors_.size(); ++i) {
    const float mu = estimator_ ? read_friction(i, now) : std::nanf("");
    known.push_back(options_.signal == AlarmSignal::left ? sensors_[i].alarm.slides() : mu);
    has_index_ |= options_.signal == AlarmSignal::left && !std::isnan(known.back());
  }
  if (events.friction) events.friction(known);
}

/// The share of a reading in what is known of mu falls as the earlier one grows old; it begins at a half.
float LiveMonitor::read_friction(std::size_t i, double now) {
  Sensor& sensor = sensors_[i];
  const float read = estimator_->slides(i), spread = infer::FrictionReading::spread;
  if (std::isnan(read)) return read;
  const float before = trust(sensor, now), share = before * before / (before * before + spread * spread);
  sensor.friction = sensor.friction > 0 ? sensor.friction * std::pow(read / sensor.friction, share) : read;
  sensor.read_at = now;
  return sensor.friction;
}

float LiveMonitor::trust(const Sensor& sensor, double now) const {
  const double minutes = (now - sensor.read_at) / 60;
  return static_cast<float>(std::hypot(infer::FrictionReading::spread, options_.friction_drift * std::sqrt(minutes)));
}

void LiveMonitor::watch(const MonitorEvents& events) {
  const double now = source_->now();
  const MonitorCalls calls = events.calls ? events.calls() : MonitorCalls{};
  if (calls.rest) {
    for (Sensor& sensor : sensors_) sensor.alarm.rest();
    if (estimator_) estimator_->rest();
  }
  if (calls.slides) slides(events, now);
  for (std::size_t i = 0; i < sensors_.size(); ++i)
    if (sensors_[i].friction > 0) estimator_->friction(i, sensors_[i].friction, trust(sensors_[i], now));
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
  if (decoder_.counts().frames != frames_before_) quiet_ = 0, told_ = 0;
  frames_before_ = decoder_.counts().frames;
  if (quiet_ < (told_ + 1) * options_.silence) return;
  if (++told_ == 1) ++summary_.silences;
  if (events.silence) events.silence(quiet_, now);
}

}  // namespace tactel::host
