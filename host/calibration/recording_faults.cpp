// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/recording_faults.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/calibration/median.h"

namespace tactel::host {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Kind = CalibrationFault::Kind;

namespace {

constexpr double swapped_share = 0.25;  ///< of its own squared residuals that a channel has on the other's stress
constexpr double dead_signal = 20;      ///< standard deviations that a working channel would have shown
constexpr double wrong_press = 3;       ///< times the median press's residual
constexpr double wrong_indenter = 2;    ///< times noise at rest and model_error
constexpr double misfit = 1.25;         ///< times noise at rest, which few frames tell up to 7 % too small
constexpr double model_error = 0.02;    ///< of a transducer's signal: places, depths and shapes as a bench knows them

std::string channel_name(const PressReadings& readings, Index c) {
  return transducer_name(c, readings.count(), readings.tactels);
}

/// Squared residuals of readings of channel c as a linear function of the stress of channel d.
double unexplained(const MatrixXd& readings, const MatrixXd& frame, Index c, Index d) {
  double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0, syy = 0;
  for (Index row = 0; row < readings.rows(); ++row) {
    const double y = readings(row, c), x = frame(row, d);
    if (!std::isfinite(y)) continue;
    n += 1, sx += x, sy += y, sxx += x * x, sxy += x * y, syy += y * y;
  }
  const double vx = sxx - sx * sx / n, vy = syy - sy * sy / n, vxy = sxy - sx * sy / n;
  return vx > 0 ? vy - vxy * vxy / vx : vy;
}

}  // namespace

void find_constant_and_saturated(PressReadings& readings, const CalibrationOptions& options,
                                 std::vector<CalibrationFault>& faults) {
  for (Index c = 0; c < readings.count(); ++c) {
    int saturated = 0, finite = 0;
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (Index row = 0; row < readings.rows(); ++row) {
      double& reading = readings.value(row, c);
      if (!std::isfinite(reading)) continue;
      ++finite;
      low = std::min(low, reading), high = std::max(high, reading);
      if (reading > options.lowest_reading && reading < options.highest_reading) continue;
      reading = std::numeric_limits<double>::quiet_NaN();
      ++saturated;
    }
    if (finite == 0 || low == high) {
      readings.channels[static_cast<std::size_t>(c)].used = false;
      faults.push_back({Kind::dead_channel,
                        channel_name(readings, c) + (finite == 0 ? ": no readings" : ": the reading never changes") +
                            "; it has no gain",
                        c});
    } else if (saturated > 0) {
      faults.push_back({Kind::saturated,
                        fmt::format("{}: {} of {} readings are at an end of the converter's range and left out",
                                    channel_name(readings, c), saturated, finite),
                        c});
    }
  }
}

void find_swapped(PressReadings& readings, const MatrixXd& frame, std::vector<CalibrationFault>& faults) {
  const Index count = readings.count();
  std::vector<Index> best(static_cast<std::size_t>(count), -1);
  for (Index c = 0; c < count; ++c) {
    if (!readings.channel(c).used) continue;
    double least = swapped_share * unexplained(readings.value, frame, c, c);
    for (Index d = 0; d < count; ++d) {
      const double other = readings.channel(d).used && d != c ? unexplained(readings.value, frame, c, d) : least;
      if (other < least) least = other, best[static_cast<std::size_t>(c)] = d;
    }
  }
  for (Index c = 0; c < count; ++c) {
    const Index d = best[static_cast<std::size_t>(c)];
    if (d <= c || best[static_cast<std::size_t>(d)] != c) continue;
    for (const Index i : {c, d}) readings.channels[static_cast<std::size_t>(i)].used = false;
    faults.push_back({Kind::swapped_channels,
                      fmt::format("{} and {} are swapped: each reads as the other should; exchange them in [channels]",
                                  channel_name(readings, c), channel_name(readings, d)),
                      c, d});
  }
}

void find_dead(PressReadings& readings, const MatrixXd& frame, std::vector<CalibrationFault>& faults) {
  std::vector<double> sensitivities;
  for (const Channel& channel : readings.channels)
    if (channel.used) sensitivities.push_back(std::abs(channel.sensitivity));
  const double usual = median(sensitivities);
  for (Index c = 0; c < readings.count(); ++c) {
    Channel& channel = readings.channels[static_cast<std::size_t>(c)];
    if (!channel.used) continue;
    const double deviation = std::sqrt(channel.inverse(1, 1));
    const double range = frame.col(c).maxCoeff() - frame.col(c).minCoeff();
    if (std::abs(channel.sensitivity) > 3 * deviation || usual * range < dead_signal * channel.noise) continue;
    channel.used = false;
    faults.push_back({Kind::dead_channel,
                      channel_name(readings, c) + ": the reading does not follow the stress; it has no gain", c});
  }
}

bool find_wrong_press(PressReadings& readings, const MatrixXd& frame, std::vector<CalibrationFault>& faults) {
  const std::size_t presses = readings.presses.size();
  std::vector<double> size(presses, 0), sizes;
  for (std::size_t i = 0; i < presses; ++i) {
    const double of_press = rms(readings.residuals(i, frame(readings.rows(i), Eigen::all)));
    if (!std::isnan(of_press)) sizes.push_back(size[i] = of_press);
  }
  if (sizes.size() < 4) return false;
  const double usual = median(sizes);
  const auto worst = std::ranges::max_element(size) - size.begin();
  const auto i = static_cast<std::size_t>(worst);
  const auto left_out = std::ranges::count(readings.press_used, false);
  if (!(size[i] > wrong_press * usual) || 3 * (left_out + 1) > static_cast<std::ptrdiff_t>(presses)) return false;
  readings.leave_out_press(i);
  faults.push_back({.kind = Kind::wrong_press,
                    .text = fmt::format("{}: residuals {:.1f} times those of the other presses; its indenter, depth or "
                                        "place is another; left out",
                                        readings.presses[i].name, size[i] / usual),
                    .press = worst});
  return true;
}

namespace {

/// Root mean square of residuals over the noise at rest and a share of each transducer's signal: [presses], 0 where
/// there is nothing to compare, and of all; NaN: the noise at rest is not known.
struct OverRest {
  std::vector<double> presses;
  double all;
};

OverRest over_rest(const PressReadings& readings, const MatrixXd& frame, const CalibrationOptions& options,
                   double share) {
  const VectorXd& noise = options.rest_noise.size() > 0 ? options.rest_noise : options.noise;
  Eigen::RowVectorXd expected = Eigen::RowVectorXd::Constant(readings.count(), NAN);
  for (Index c = 0; c < noise.size(); ++c) {
    const Channel& channel = readings.channel(c);
    const double signal = channel.sensitivity * std::sqrt((frame.col(c).array() - frame.col(c).mean()).square().mean());
    const double off = std::hypot(noise[c], share * signal) / channel.noise;
    if (channel.used && off > 0) expected[c] = off;
  }
  MatrixXd all(readings.rows(), readings.count());
  OverRest over{};
  for (std::size_t i = 0; i < readings.presses.size(); ++i) {
    const auto rows = readings.rows(i);
    all(rows, Eigen::all) = readings.residuals(i, frame(rows, Eigen::all)).array().rowwise() / expected.array();
    over.presses.push_back(std::fmax(0, rms(all(rows, Eigen::all))));
  }
  over.all = rms(all);
  return over;
}

}  // namespace

void find_misfit(const PressReadings& readings, const MatrixXd& frame, const CalibrationOptions& options,
                 const std::vector<std::string>& better, std::vector<CalibrationFault>& faults) {
  constexpr std::size_t most_sentences = 3;
  std::string text;
  for (std::size_t i = 0; i < std::min(better.size(), most_sentences); ++i) text += (i > 0 ? "; " : "") + better[i];
  if (better.empty()) {
    const OverRest over = over_rest(readings, frame, options, 0);
    if (!(over.all > misfit)) return;
    const auto worst = std::ranges::max_element(over.presses) - over.presses.begin();
    text = fmt::format("residuals are {:.1f} times the noise at rest, {:.1f} times in {}: thickness? indenter? tilt?",
                       over.all, over.presses[static_cast<std::size_t>(worst)],
                       readings.presses[static_cast<std::size_t>(worst)].name);
  }
  faults.push_back({Kind::model_misfit, "the model does not fit: " + text});
}

void find_wrong_indenter(const PressReadings& readings, const MatrixXd& frame, const CalibrationOptions& options,
                         std::vector<CalibrationFault>& faults) {
  const double over = over_rest(readings, frame, options, model_error).all;
  if (over > wrong_indenter)
    faults.push_back({Kind::wrong_indenter,
                      fmt::format("residuals are {:.1f} times what noise at rest and {:g} % of the stress explain: all "
                                  "presses have another indenter, friction or place",
                                  over, 100 * model_error)});
}

}  // namespace tactel::host
