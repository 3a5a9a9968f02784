// SPDX-License-Identifier: Apache-2.0
#include "host/live/recorded_hold.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <functional>

#include "host/live/frame_reader.h"
#include "host/live/live_monitor.h"
#include "nn/infer/grip_score.h"

namespace tactel::host {
namespace {

constexpr double least_seconds = 1, enough_seconds = 3, prior_seconds = 1.5;
constexpr double window = 1.0 / 3;     // s, before the first rest
constexpr double left_out = 0.01;      // of the frames of a hold of 4 s and more
constexpr double mixed = 0.9;          // of the off-diagonal numbers of H
constexpr double least_square = 1e-7;  // of a moment: noise of a calm pad is 0.1 % of P
constexpr double hold_margin = 1.4, hold_margin_seconds = 6.5, most_margin = 4.5;  // of D: short holds show less
constexpr double much_left = 1, most_left = 2.4;  // of the score: people that hold 1.35, swings above 2.5
constexpr double least_slide = 0.2;               // s
constexpr double upper = 0.98, near_upper = 0.85, least_rise = 1.1;
constexpr std::size_t rest_frames = 20;

using Take = std::function<void(std::size_t pad, std::span<const float> stresses, double time)>;

/// Hands the stresses of each pad of each frame to `take`, and each new rate of frames to `tell`. Returns the last one.
double for_frames(hw::FrameSource& source, const SensorProfile& profile, const Take& take,
                  const std::function<void(double hz)>& tell) {
  const std::vector<std::size_t> tactels = tactels_of(profile);
  const std::size_t all = profile.map.tactels(), axes = profile.map.places() / all;
  hw::Decoder decoder(profile.format());
  std::vector<float> frame(profile.map.places()), pad(frame.size());
  RateMeter rate(usual_rate(profile));
  read_frames(source, decoder, {.frame = [&](const hw::DecodedFrame& decoded, double arrival) {
                const double time = decoded.device_time.value_or(arrival);
                if (const auto hz = source.timed() ? rate.next(time) : std::nullopt) tell(*hz);
                profile.map.apply(decoded.values, frame);
                for (std::size_t i = 0, first = 0; i < tactels.size(); first += tactels[i++]) {
                  take_pad(frame, all, first, tactels[i], pad.data());
                  take(i, std::span(pad).first(axes * tactels[i]), time);
                }
              }});
  return rate.rate();
}

std::vector<double> touches_of(const SensorProfile& profile) {
  std::vector<double> touches;
  std::size_t first = 0;
  for (const std::size_t tactels : tactels_of(profile)) {
    touches.push_back(profile.map.touch(first, tactels));
    first += tactels;
  }
  return touches;
}

double quantile(std::vector<double>& values, double share) {
  std::ranges::sort(values);
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

/// Of a pad's frictions, those of its first rest among them.
double slide_of(std::vector<double>& frictions, std::vector<double>& at_rest, double rate, const std::string& name) {
  const double most = frictions.empty() ? 0 : quantile(frictions, upper);
  std::vector<double> sliding;
  std::ranges::copy_if(frictions, std::back_inserter(sliding), [&](double w) { return w >= near_upper * most; });
  const bool rises = at_rest.empty() || most >= least_rise * quantile(at_rest, 0.5);
  if (static_cast<double>(sliding.size()) < least_slide * rate || !rises || !(most > 0))
    throw hw::SourceError(name + ": nothing slides in it; record a held object that slides on all pads");
  return quantile(sliding, 0.5);
}

}  // namespace

void HoldLearner::read(hw::FrameSource& source, const std::string& name) {
  const std::vector<double> touches = touches_of(profile_);
  std::deque<infer::GripScore> scores;
  for (std::size_t i = 0; i < touches.size(); ++i)
    scores.emplace_back(shape_of(profile_, i), AlarmOptions{.rate = usual_rate(profile_)}, touches[i]);
  moments_ = scores.front().moments().count();
  std::vector<std::size_t> frames(scores.size());
  std::vector<bool> closing(scores.size());
  std::optional<double> begin;
  const auto take = [&](std::size_t i, std::span<const float> stresses, double time) {
    const auto normals = stresses.first(shape_of(profile_, i).tactels);
    const bool touching = std::ranges::any_of(normals, [&](float s) { return std::abs(s) >= touches[i]; });
    const infer::GripReading said = scores[i].next(stresses, touching);
    if (!begin) begin = time;
    closing[i] = said.rest && (closing[i] || said.released);  // until the next rest
    if (!std::isfinite(said.score) || closing[i]) return;
    ++frames[i];
    const infer::Moments& d = scores[i].newest().moments;
    changes_.insert(changes_.end(), d.begin(), d.begin() + static_cast<std::ptrdiff_t>(moments_));
    most_left_ = std::max<double>(most_left_, said.score);
    if (said.score >= most_left)
      throw hw::SourceError(fmt::format("{}: it moves at {:.2f} s; record a grip that holds", name, time - *begin));
  };
  const double rate = for_frames(source, profile_, take, [&](double hz) {
    for (infer::GripScore& score : scores) score.rate(hz);
  });
  const std::size_t most = std::ranges::max(frames);
  if (most == 0)
    throw hw::SourceError(name + ": no grip at rest in it; record a hand that grips, holds still, and moves as in use");
  rate_ = rate, seconds_ += static_cast<double>(most) / rate;
}

/// Of the frames, and of other holders.
std::vector<double> HoldLearner::covariance() const {
  const std::size_t n = moments_;
  const std::size_t whole = changes_.size() / n;
  const auto frames = static_cast<double>(whole);
  const std::vector<double>& prior = profile_.map.calibration.hold.covariance;
  const double share = frames / (frames + prior_seconds * rate_);
  std::vector<double> all(n * (n + 1) / 2);
  for (std::size_t f = 0; f < changes_.size(); f += n)
    for (std::size_t i = 0, k = 0; i < n; ++i)
      for (std::size_t j = 0; j <= i; ++j, ++k) all[k] += changes_[f + i] * changes_[f + j] / frames;
  for (std::size_t i = 0, k = 0; i < n; ++i)
    for (std::size_t j = 0; j <= i; ++j, ++k) {
      const double others = !prior.empty() ? prior[k] : i == j ? all[k] : 0;
      all[k] = share * all[k] * (i == j ? 1 : mixed) + (1 - share) * others + (i == j ? least_square : 0);
    }
  return all;
}

/// The largest D; of long holds but for one frame of a hundred, as when an object is lifted.
double HoldLearner::largest(const std::vector<double>& covariance) const {
  const std::vector<double> white =
      infer::whitening(std::vector<float>(covariance.begin(), covariance.end()), moments_);
  std::vector<double> distances;
  for (std::size_t f = 0; f < changes_.size(); f += moments_)
    distances.push_back(infer::norm(white, std::span<const float>(changes_).subspan(f, moments_)));
  return quantile(distances, 1 - left_out * std::clamp(seconds_ - enough_seconds, 0.0, 1.0));
}

HoldReport HoldLearner::learn() const {
  HoldReport report;
  hw::RecordedHold& hold = report.hold;
  if (seconds_ + window < least_seconds)
    throw hw::SourceError(
        fmt::format("--hold: {:.2g} s of a grip at rest; record a grip that holds still for {:g} s or "
                    "more",
                    seconds_, least_seconds));
  hold = {covariance(), 0, seconds_, rate_, std::min(hold_margin + hold_margin_seconds / seconds_, most_margin)};
  report.largest = largest(hold.covariance);
  if (!(report.largest > 0)) throw hw::SourceError("--hold: nothing trembles in it; record the sensor itself");
  hold.at = hold.margin * report.largest;
  if (seconds_ < enough_seconds)
    report.warnings.push_back(
        fmt::format("{:.1f} s of hold; {:g} or more give fewer false alarms", seconds_, enough_seconds));
  if (most_left_ > much_left)
    report.warnings.push_back(
        fmt::format("it moves more than a hold mostly does, {:.2g} times what alarms without it", most_left_));
  return report;
}

std::vector<double> read_slide(hw::FrameSource& source, const SensorProfile& profile, const std::string& name) {
  const std::vector<double> touches = touches_of(profile);
  std::deque<infer::GripScore> scores;
  for (std::size_t i = 0; i < touches.size(); ++i)
    scores.emplace_back(shape_of(profile, i), AlarmOptions{.rate = usual_rate(profile)}, touches[i]);
  std::vector<std::vector<double>> frictions(touches.size()), at_rest(touches.size());
  std::vector<bool> begins(touches.size());  // with a touch-down; else it may slide all along
  const auto take = [&](std::size_t i, std::span<const float> stresses, double) {
    const auto normals = stresses.first(shape_of(profile, i).tactels);
    const bool touching = std::ranges::any_of(normals, [&](float s) { return std::abs(s) >= touches[i]; });
    const bool rests = scores[i].next(stresses, touching).rest;
    begins[i] = begins[i] || !touching;
    const infer::PadMoments& moments = scores[i].moments();
    if (!(moments.force(stresses) >= infer::earnest * touches[i])) return;
    frictions[i].push_back(moments.friction(stresses));
    if (rests && begins[i] && at_rest[i].size() < rest_frames) at_rest[i].push_back(frictions[i].back());
  };
  const double rate = for_frames(source, profile, take, [&](double hz) {
    for (infer::GripScore& score : scores) score.rate(hz);
  });
  std::vector<double> slides;
  for (std::size_t i = 0; i < frictions.size(); ++i) slides.push_back(slide_of(frictions[i], at_rest[i], rate, name));
  return slides;
}

}  // namespace tactel::host
