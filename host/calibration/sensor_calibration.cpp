// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/sensor_calibration.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "fem/value_error.h"
#include "host/calibration/median.h"
#include "host/support/side_by_side.h"

namespace tactel::host {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double outlier = 3;            ///< standard deviations, from which Huber's loss is linear
constexpr double converged_step = 0.01;  ///< of a standard deviation
constexpr double swapped_share = 0.25;   ///< of its own squared residuals that a channel has on the other's stress
constexpr double dead_signal = 20;       ///< standard deviations that a working channel would have shown
constexpr double wrong_press = 3;        ///< times the median press's residual
constexpr double wrong_indenter = 2;     ///< times noise at rest and model_error
constexpr double model_error = 0.02;     ///< of a transducer's signal: places, depths and shapes as a bench knows them
constexpr double spread_step = 1.3;      ///< of the distances at which the cost of a friction is looked at
constexpr double not_told = 0.9;         ///< of its deviation before the fit
constexpr int first_friction =
    sensor_numbers;  ///< numbers of the fit: those of SensorState, then each press's friction

/// What a fit changes.
struct FitState {
  SensorState sensor;
  std::vector<double> friction;  ///< [presses]
};

/// All presses, one below the other.
struct Stack {
  MatrixXd frame;            ///< [rows, channels] MPa
  VectorXd P;                ///< [rows]
  std::vector<MatrixXd> by;  ///< [fitted numbers]
  std::vector<VectorXd> P_by;
};

/// Linear fit of a channel: reading = offset + sensitivity stress.
struct Channel {
  bool used = false;
  double offset = nan, sensitivity = nan, noise = 1;
  Eigen::Matrix2d inverse = Eigen::Matrix2d::Zero();  ///< of the normal matrix, with weights over noise^2
};

class Fit {
 public:
  Fit(const fem::SensorFamily& family, const std::vector<KnownPress>& presses, const SensorState& start,
      const CalibrationOptions& options);
  SensorCalibration run();

 private:
  void find_patches();
  Stack stack(const FitState& state, bool derivatives) const;
  double friction_deviation(int number) const {
    const double mu = presses_[static_cast<std::size_t>(number - first_friction)].scene.friction;
    return options_.friction_deviation * mu;
  }
  static double& number_of(FitState& state, int number);
  std::string number_name(int number) const;
  void find_constant_and_saturated();
  void find_swapped(const Stack& at);
  void fit_channels(const Stack& at, bool renew_noise);
  void reweight(const Stack& at);
  double cost(const Stack& at) const;
  void normal_equations(const Stack& at, MatrixXd& H, VectorXd& g) const;
  bool iterate(int& iterations);
  bool leave_out_wrong_presses();
  void find_dead(const Stack& at);
  void find_wrong_indenter(const Stack& at);
  void choose_numbers();
  FitState moved(const VectorXd& step) const;
  double cost_of_friction(std::size_t press, double mu) const;
  double held_information(const Stack& at, Index k) const;
  double friction_spread(std::size_t press, double deviation) const;
  double residual(const Stack& at, Index row, Index c) const {
    const Channel& channel = channels_[static_cast<std::size_t>(c)];
    return (readings_(row, c) - channel.offset - channel.sensitivity * at.frame(row, c)) / channel.noise;
  }
  Index rows() const { return readings_.rows(); }
  Index count() const { return readings_.cols(); }
  void add(CalibrationFault::Kind kind, int channel, int other, int press, std::string text) {
    result_.faults.push_back({kind, channel, other, press, std::move(text)});
  }
  std::string channel_name(Index c) const { return transducer_name(c, count() / 2); }

  const fem::SensorFamily& family_;
  const std::vector<KnownPress>& presses_;
  CalibrationOptions options_;
  std::vector<PressModel> models_;
  std::vector<Index> first_row_;
  MatrixXd readings_, weight_;  ///< [rows, channels]; NaN: left out
  VectorXd P_, P_weight_;       ///< [rows]
  FitState state_;
  std::vector<int> numbers_;  ///< that are fitted
  std::vector<Channel> channels_;
  std::vector<bool> press_used_;
  SensorCalibration result_;
};

Fit::Fit(const fem::SensorFamily& family, const std::vector<KnownPress>& presses, const SensorState& start,
         const CalibrationOptions& options)
    : family_(family), presses_(presses), options_(options), state_{start, {}}, press_used_(presses.size(), true) {
  options.validate();
  state_.sensor.log_time_constant = std::log(options.time_constant);
  if (presses.empty()) throw ValueError("presses", "none", "at least one known press");
  const Index channels = 2 * presses.front().scene.sensor.tactels;
  Index total = 0;
  for (const KnownPress& press : presses) {
    if (press.readings.cols() != channels || press.readings.rows() == 0 ||
        (press.P.size() > 0 && press.P.size() != press.readings.rows()))
      throw ValueError(press.name + ": readings", fmt::format("{} x {}", press.readings.rows(), press.readings.cols()),
                       fmt::format("one row for each load step, {} columns", channels));
    if (std::isfinite(options.time_constant)) press.timing.validate(static_cast<std::size_t>(press.readings.rows()));
    state_.friction.push_back(press.scene.friction);
    first_row_.push_back(total);
    total += press.readings.rows();
  }
  readings_.resize(total, channels);
  P_.setConstant(total, nan);
  for (std::size_t i = 0; i < presses.size(); ++i) {
    readings_.middleRows(first_row_[i], presses[i].readings.rows()) = presses[i].readings;
    if (presses[i].P.size() > 0) P_.segment(first_row_[i], presses[i].P.size()) = presses[i].P;
  }
  find_patches();
  weight_ = MatrixXd::Ones(total, channels);
  P_weight_ = VectorXd::Ones(total);
  channels_.resize(static_cast<std::size_t>(channels));
  for (Channel& channel : channels_) channel.used = true;
}

/// Searches the patches of all presses at the present state.
void Fit::find_patches() {
  std::vector<std::optional<PressModel>> models(presses_.size());
  side_by_side(presses_.size(), options_.threads, [&](std::size_t i) {
    const KnownPress& press = presses_[i];
    models[i].emplace(family_, press.scene, press.timing, state_.sensor, options_.elements);
  });
  models_.clear();
  for (std::optional<PressModel>& model : models) models_.push_back(std::move(*model));
}

double& Fit::number_of(FitState& state, int number) {
  if (number >= first_friction) return state.friction[static_cast<std::size_t>(number - first_friction)];
  SensorState& sensor = state.sensor;
  double* const places[] = {&sensor.log_young, &sensor.poisson, &sensor.thickness, &sensor.shift,
                            &sensor.log_time_constant};
  return *places[number];
}

std::string Fit::number_name(int number) const {
  if (number < first_friction) return sensor_names[number];
  return "friction of " + presses_[static_cast<std::size_t>(number - first_friction)].name;
}

Stack Fit::stack(const FitState& state, bool derivatives) const {
  Stack all{MatrixXd(rows(), count()), VectorXd(rows()), {}, {}};
  if (derivatives) all.by.assign(numbers_.size(), all.frame), all.P_by.assign(numbers_.size(), all.P);
  side_by_side(models_.size(), options_.threads, [&](std::size_t i) {
    const auto of_press = [own = first_friction + static_cast<int>(i)](int number) {
      return number < first_friction ? number : number == own ? friction_number : -1;
    };
    std::vector<int> asked;
    for (const int number : numbers_)
      if (derivatives && of_press(number) >= 0) asked.push_back(of_press(number));
    const PressFrames frames = models_[i].at(state.sensor, state.friction[i], asked);
    const Index first = first_row_[i], steps = presses_[i].readings.rows();
    if (frames.frame.rows() != steps)
      throw ValueError(presses_[i].name + ": readings", fmt::format("{} rows", steps),
                       fmt::format("{} rows, one for each load step", frames.frame.rows()));
    all.frame.middleRows(first, steps) = frames.frame;
    all.P.segment(first, steps) = frames.P;
    for (std::size_t k = 0; derivatives && k < numbers_.size(); ++k) {
      const int number = of_press(numbers_[k]);
      auto by = all.by[k].middleRows(first, steps);
      auto P_by = all.P_by[k].segment(first, steps);
      by.setZero();
      P_by.setZero();
      if (number >= 0) by = frames.frame_by[number], P_by = frames.P_by[number];
    }
  });
  return all;
}

void Fit::find_constant_and_saturated() {
  for (Index c = 0; c < count(); ++c) {
    int saturated = 0, finite = 0;
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (Index row = 0; row < rows(); ++row) {
      double& reading = readings_(row, c);
      if (!std::isfinite(reading)) continue;
      ++finite;
      low = std::min(low, reading), high = std::max(high, reading);
      if (reading > options_.lowest_reading && reading < options_.highest_reading) continue;
      reading = nan;
      ++saturated;
    }
    if (finite == 0 || low == high) {
      channels_[static_cast<std::size_t>(c)].used = false;
      add(CalibrationFault::Kind::dead_channel, static_cast<int>(c), -1, -1,
          channel_name(c) + (finite == 0 ? ": no readings" : ": the reading never changes") + "; it has no gain");
    } else if (saturated > 0) {
      add(CalibrationFault::Kind::saturated, static_cast<int>(c), -1, -1,
          fmt::format("{}: {} of {} readings are at an end of the converter's range and left out", channel_name(c),
                      saturated, finite));
    }
  }
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

void Fit::find_swapped(const Stack& at) {
  std::vector<Index> best(static_cast<std::size_t>(count()), -1);
  const auto used = [&](Index c) { return channels_[static_cast<std::size_t>(c)].used; };
  for (Index c = 0; c < count(); ++c) {
    if (!used(c)) continue;
    double least = swapped_share * unexplained(readings_, at.frame, c, c);
    for (Index d = 0; d < count(); ++d) {
      const double other = used(d) && d != c ? unexplained(readings_, at.frame, c, d) : least;
      if (other < least) least = other, best[static_cast<std::size_t>(c)] = d;
    }
  }
  for (Index c = 0; c < count(); ++c) {
    const Index d = best[static_cast<std::size_t>(c)];
    if (d <= c || best[static_cast<std::size_t>(d)] != c) continue;
    for (const Index i : {c, d}) channels_[static_cast<std::size_t>(i)].used = false;
    add(CalibrationFault::Kind::swapped_channels, static_cast<int>(c), static_cast<int>(d), -1,
        fmt::format("{} and {} are swapped: each reads as the other should; exchange them in [channels]",
                    channel_name(c), channel_name(d)));
  }
}

void Fit::fit_channels(const Stack& at, bool renew_noise) {
  for (Index c = 0; c < count(); ++c) {
    Channel& channel = channels_[static_cast<std::size_t>(c)];
    if (!channel.used) continue;
    Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
    Eigen::Vector2d right = Eigen::Vector2d::Zero();
    for (Index row = 0; row < rows(); ++row) {
      if (!std::isfinite(readings_(row, c))) continue;
      const double weight = weight_(row, c), x = at.frame(row, c), y = readings_(row, c);
      normal(0, 0) += weight, normal(0, 1) += weight * x, normal(1, 1) += weight * x * x;
      right[0] += weight * y, right[1] += weight * x * y;
    }
    normal(1, 0) = normal(0, 1);
    const double determinant = normal.determinant();
    if (!(determinant > 1e-12 * normal(0, 0) * normal(1, 1))) {
      channel.used = false;
      add(CalibrationFault::Kind::dead_channel, static_cast<int>(c), -1, -1,
          channel_name(c) + ": no press changes its stress; it has no gain");
      continue;
    }
    const Eigen::Vector2d fitted = normal.inverse() * right;
    channel.offset = fitted[0], channel.sensitivity = fitted[1];
    if (renew_noise) {
      double sum = 0, n = -2;
      channel.noise = 1;
      for (Index row = 0; row < rows(); ++row)
        if (std::isfinite(readings_(row, c))) {
          const double r = residual(at, row, c);
          sum += weight_(row, c) * r * r;
          n += 1;
        }
      channel.noise = options_.noise.size() > 0 ? options_.noise[c] : std::sqrt(sum / std::max(1.0, n));
      if (!(channel.noise > 0)) channel.noise = 1e-12 * std::max(1.0, std::abs(channel.offset));
    }
    channel.inverse = normal.inverse() * channel.noise * channel.noise;
  }
}

void Fit::reweight(const Stack& at) {
  const auto weight = [](double r) { return std::abs(r) <= outlier ? 1 : outlier / std::abs(r); };
  for (Index c = 0; c < count(); ++c)
    if (channels_[static_cast<std::size_t>(c)].used)
      for (Index row = 0; row < rows(); ++row)
        if (std::isfinite(readings_(row, c))) weight_(row, c) = weight(residual(at, row, c));
  for (Index row = 0; row < rows(); ++row)
    if (std::isfinite(P_[row]) && P_[row] != 0)
      P_weight_[row] = weight((P_[row] - at.P[row]) / (options_.force_noise * P_[row]));
}

double Fit::cost(const Stack& at) const {
  double sum = 0;
  for (Index c = 0; c < count(); ++c)
    if (channels_[static_cast<std::size_t>(c)].used)
      for (Index row = 0; row < rows(); ++row)
        if (std::isfinite(readings_(row, c))) sum += weight_(row, c) * std::pow(residual(at, row, c), 2);
  for (Index row = 0; row < rows(); ++row)
    if (std::isfinite(P_[row]) && P_[row] != 0)
      sum += P_weight_[row] * std::pow((P_[row] - at.P[row]) / (options_.force_noise * P_[row]), 2);
  for (const int number : numbers_)
    if (number >= first_friction)
      sum += std::pow((state_.friction[static_cast<std::size_t>(number - first_friction)] -
                       presses_[static_cast<std::size_t>(number - first_friction)].scene.friction) /
                          friction_deviation(number),
                      2);
  return sum;
}

/// Of the fitted numbers, gains and offsets eliminated.
void Fit::normal_equations(const Stack& at, MatrixXd& H, VectorXd& g) const {
  const auto size = static_cast<Index>(numbers_.size());
  H = MatrixXd::Zero(size, size);
  g = VectorXd::Zero(size);
  for (Index c = 0; c < count(); ++c) {
    const Channel& channel = channels_[static_cast<std::size_t>(c)];
    if (!channel.used) continue;
    MatrixXd cross = MatrixXd::Zero(2, size), own = MatrixXd::Zero(size, size);
    for (Index row = 0; row < rows(); ++row) {
      if (!std::isfinite(readings_(row, c))) continue;
      VectorXd by(size);
      for (Index k = 0; k < size; ++k) by[k] = channel.sensitivity * at.by[static_cast<std::size_t>(k)](row, c);
      const double weight = weight_(row, c) / (channel.noise * channel.noise);
      cross.row(0) += weight * by;
      cross.row(1) += weight * at.frame(row, c) * by;
      own += weight * by * by.transpose();
      g += weight * by * (residual(at, row, c) * channel.noise);
    }
    H += own - cross.transpose() * channel.inverse * cross;
  }
  for (Index row = 0; row < rows(); ++row) {
    if (!(std::isfinite(P_[row]) && P_[row] != 0)) continue;
    const double noise = options_.force_noise * P_[row], weight = P_weight_[row] / (noise * noise);
    VectorXd by(size);
    for (Index k = 0; k < size; ++k) by[k] = at.P_by[static_cast<std::size_t>(k)][row];
    H += weight * by * by.transpose();
    g += weight * by * (P_[row] - at.P[row]);
  }
  for (Index k = 0; k < size; ++k) {
    const int number = numbers_[static_cast<std::size_t>(k)];
    if (number < first_friction) continue;
    const auto press = static_cast<std::size_t>(number - first_friction);
    const double weight = 1 / std::pow(friction_deviation(number), 2);
    H(k, k) += weight;
    g[k] += weight * (presses_[press].scene.friction - state_.friction[press]);
  }
}

FitState Fit::moved(const VectorXd& step) const {
  FitState next = state_;
  for (Index k = 0; k < step.size(); ++k) number_of(next, numbers_[static_cast<std::size_t>(k)]) += step[k];
  SensorState& sensor = next.sensor;
  const SensorState& last = state_.sensor;
  sensor.poisson = std::clamp(sensor.poisson, family_.range().poisson_low, family_.range().poisson_high);
  sensor.log_young = std::clamp(sensor.log_young, last.log_young - 1, last.log_young + 1);
  sensor.thickness = std::clamp(sensor.thickness, 0.8 * last.thickness, 1.25 * last.thickness);
  if (options_.fit_time_constant)
    sensor.log_time_constant =
        std::clamp(sensor.log_time_constant, last.log_time_constant - 1, last.log_time_constant + 1);
  for (std::size_t i = 0; i < next.friction.size(); ++i)
    next.friction[i] = std::clamp(next.friction[i], 0.5 * state_.friction[i], 2 * state_.friction[i]);
  return next;
}

/// E and gains are told apart where depth and force of a press are both known, or where some presses have one and some
/// the other.
void Fit::choose_numbers() {
  bool both = false, by_depth = false, by_force = false;
  for (std::size_t i = 0; i < presses_.size(); ++i) {
    if (!press_used_[i]) continue;
    const bool force = fem::by_force(presses_[i].scene);
    (force ? by_force : by_depth) = true;
    both |= !force && P_.segment(first_row_[i], presses_[i].readings.rows()).array().isFinite().any();
  }
  numbers_.clear();
  result_.held.clear();
  if (both || (by_depth && by_force))
    numbers_.push_back(0);
  else
    result_.held.emplace_back(
        "sensor.young is held: no press has both depth and force, and a softer rubber reads as smaller gains");
  if (options_.fit_poisson)
    numbers_.push_back(1);
  else
    result_.held.emplace_back("sensor.poisson is held: not asked for");
  if (options_.fit_thickness)
    numbers_.push_back(2);
  else
    result_.held.emplace_back(
        "sensor.thickness is held: it and sensor.poisson change frames nearly alike, so measure it");
  if (options_.fit_shift) numbers_.push_back(3);
  if (options_.fit_time_constant) numbers_.push_back(time_constant_number);
  for (std::size_t i = 0; i < presses_.size(); ++i) {
    const double mu = presses_[i].scene.friction;
    if (options_.friction_deviation > 0 && press_used_[i] && mu > 0 && std::isfinite(mu))
      numbers_.push_back(first_friction + static_cast<int>(i));
  }
}

bool Fit::iterate(int& iterations) {
  Stack now = stack(state_, true);
  fit_channels(now, true);
  if (numbers_.empty()) {
    reweight(now);
    fit_channels(now, true);
    return true;
  }
  double damping = 1e-3;
  for (; iterations < options_.most_iterations; ++iterations) {
    reweight(now);
    fit_channels(now, true);
    MatrixXd H;
    VectorXd g;
    normal_equations(now, H, g);
    const double before = cost(now);
    for (;;) {
      MatrixXd damped = H;
      damped.diagonal() *= 1 + damping;
      const VectorXd step = damped.ldlt().solve(g);
      const FitState last = state_;
      state_ = moved(step);
      Stack next = stack(state_, true);
      const std::vector<Channel> kept = channels_;
      fit_channels(next, false);
      const double after = cost(next);
      const double size = (step.array() * H.diagonal().array().sqrt()).abs().maxCoeff();
      if (after <= before || size < converged_step) {
        damping = std::max(damping / 10, 1e-9);
        now = std::move(next);
        if (size < converged_step) {
          reweight(now);
          fit_channels(now, true);
          return true;
        }
        break;
      }
      state_ = last;
      channels_ = kept;
      damping *= 10;
      if (damping > 1e6) return false;
    }
  }
  return false;
}

/// A press with another indenter, depth or place than it says has residuals far beyond those of the others.
bool Fit::leave_out_wrong_presses() {
  const Stack now = stack(state_, false);
  std::vector<double> size(presses_.size(), 0), sizes;
  for (std::size_t i = 0; i < presses_.size(); ++i) {
    if (!press_used_[i]) continue;
    double sum = 0, n = 0;
    for (Index row = first_row_[i]; row < first_row_[i] + presses_[i].readings.rows(); ++row)
      for (Index c = 0; c < count(); ++c)
        if (channels_[static_cast<std::size_t>(c)].used && std::isfinite(readings_(row, c)))
          sum += std::pow(residual(now, row, c), 2), n += 1;
    if (n > 0) sizes.push_back(size[i] = std::sqrt(sum / n));
  }
  if (sizes.size() < 4) return false;
  const double usual = median(sizes);
  const auto worst = std::ranges::max_element(size) - size.begin();
  const auto i = static_cast<std::size_t>(worst);
  const auto left_out = std::ranges::count(press_used_, false);
  if (!(size[i] > wrong_press * usual) || 3 * (left_out + 1) > static_cast<std::ptrdiff_t>(presses_.size()))
    return false;
  press_used_[i] = false;
  readings_.middleRows(first_row_[i], presses_[i].readings.rows()).setConstant(nan);
  P_.segment(first_row_[i], presses_[i].readings.rows()).setConstant(nan);
  add(CalibrationFault::Kind::wrong_press, -1, -1, static_cast<int>(worst),
      fmt::format(
          "{}: residuals {:.1f} times those of the other presses; its indenter, depth or place is another; left out",
          presses_[i].name, size[i] / usual));
  return true;
}

/// A channel of which the gain does not differ from none, where others would have shown a signal.
void Fit::find_dead(const Stack& at) {
  std::vector<double> sensitivities;
  for (const Channel& channel : channels_)
    if (channel.used) sensitivities.push_back(std::abs(channel.sensitivity));
  const double usual = median(sensitivities);
  for (Index c = 0; c < count(); ++c) {
    Channel& channel = channels_[static_cast<std::size_t>(c)];
    if (!channel.used) continue;
    const double deviation = std::sqrt(channel.inverse(1, 1));
    const double range = at.frame.col(c).maxCoeff() - at.frame.col(c).minCoeff();
    if (std::abs(channel.sensitivity) > 3 * deviation || usual * range < dead_signal * channel.noise) continue;
    channel.used = false;
    add(CalibrationFault::Kind::dead_channel, static_cast<int>(c), -1, -1,
        channel_name(c) + ": the reading does not follow the stress; it has no gain");
  }
}

/// A wrong indenter, friction or place of all presses bends the model to readings that no gain explains.
void Fit::find_wrong_indenter(const Stack& at) {
  const VectorXd& noise = options_.rest_noise.size() > 0 ? options_.rest_noise : options_.noise;
  if (noise.size() == 0) return;
  double sum = 0, n = 0;
  for (Index c = 0; c < count(); ++c) {
    const Channel& channel = channels_[static_cast<std::size_t>(c)];
    if (!channel.used) continue;
    const double signal =
        channel.sensitivity * std::sqrt((at.frame.col(c).array() - at.frame.col(c).mean()).square().mean());
    const double expected = std::hypot(noise[c], model_error * signal) / channel.noise;
    for (Index row = 0; row < rows(); ++row)
      if (std::isfinite(readings_(row, c))) sum += std::pow(residual(at, row, c) / expected, 2), n += 1;
  }
  if (n > 0 && std::sqrt(sum / n) > wrong_indenter)
    add(CalibrationFault::Kind::wrong_indenter, -1, -1, -1,
        fmt::format("residuals are {:.1f} times what noise at rest and {:g} % of the stress explain: all presses have "
                    "another indenter, friction or place",
                    std::sqrt(sum / n), 100 * model_error));
}

/// The part of cost() that a press's friction changes, all else held.
double Fit::cost_of_friction(std::size_t press, double mu) const {
  const PressFrames frames = models_[press].at(state_.sensor, mu);
  const KnownPress& known = presses_[press];
  double sum = std::pow((mu - known.scene.friction) / (options_.friction_deviation * known.scene.friction), 2);
  for (Index step = 0; step < frames.frame.rows(); ++step) {
    const Index row = first_row_[press] + step;
    for (Index c = 0; c < count(); ++c) {
      const Channel& channel = channels_[static_cast<std::size_t>(c)];
      if (!channel.used || !std::isfinite(readings_(row, c))) continue;
      const double expected = channel.offset + channel.sensitivity * frames.frame(step, c);
      sum += weight_(row, c) * std::pow((readings_(row, c) - expected) / channel.noise, 2);
    }
    if (std::isfinite(P_[row]) && P_[row] != 0)
      sum += P_weight_[row] * std::pow((P_[row] - frames.P[step]) / (options_.force_noise * P_[row]), 2);
  }
  return sum;
}

/// Information on the fitted number k, all else held.
double Fit::held_information(const Stack& at, Index k) const {
  const auto place = static_cast<std::size_t>(k);
  double sum = 1 / std::pow(friction_deviation(numbers_[place]), 2);
  for (Index row = 0; row < rows(); ++row) {
    for (Index c = 0; c < count(); ++c) {
      const Channel& channel = channels_[static_cast<std::size_t>(c)];
      if (channel.used && std::isfinite(readings_(row, c)))
        sum += weight_(row, c) * std::pow(channel.sensitivity * at.by[place](row, c) / channel.noise, 2);
    }
    if (std::isfinite(P_[row]) && P_[row] != 0)
      sum += P_weight_[row] * std::pow(at.P_by[place][row] / (options_.force_noise * P_[row]), 2);
  }
  return sum;
}

/// Returns how much wider a friction may be off than its covariance says, 1 or more. Where the contact no longer
/// slides, a larger friction changes nothing: the cost then rises less than the parabola of the derivatives. Half the
/// distance at which it has risen by 4, on the farther side, over `deviation`, that of the parabola with all else held.
double Fit::friction_spread(std::size_t press, double deviation) const {
  const double mu = state_.friction[press], least = cost_of_friction(press, mu);
  double farthest = 2 * deviation;
  for (const double side : {-1.0, 1.0}) {
    double distance = 2 * deviation;
    try {
      while (mu + side * distance > 0 && cost_of_friction(press, mu + side * distance) < least + 4)
        distance *= spread_step;
    } catch (const fem::PathError&) {  // no solution there: as far as there is one
    }
    farthest = std::max(farthest, distance);
  }
  return farthest / (2 * deviation);
}

SensorCalibration Fit::run() {
  find_constant_and_saturated();
  find_swapped(stack(state_, false));
  choose_numbers();
  iterate(result_.iterations);
  find_patches();
  bool settled = iterate(result_.iterations);
  find_dead(stack(state_, false));
  while (leave_out_wrong_presses()) {
    weight_.setOnes();
    P_weight_.setOnes();
    choose_numbers();
    settled = iterate(result_.iterations);
  }
  result_.converged = settled;
  const Stack now = stack(state_, true);
  MatrixXd H;
  VectorXd g;
  normal_equations(now, H, g);
  const MatrixXd covariance =
      numbers_.empty() ? MatrixXd(0, 0) : MatrixXd(H.ldlt().solve(MatrixXd::Identity(H.rows(), H.cols())));
  const double E = std::exp(state_.sensor.log_young), time_constant = std::exp(state_.sensor.log_time_constant);
  result_.young.value = E, result_.poisson.value = state_.sensor.poisson;
  result_.thickness.value = state_.sensor.thickness, result_.shift.value = state_.sensor.shift;
  result_.time_constant.value = time_constant;
  for (const double friction : state_.friction) result_.friction.push_back({friction, 0});
  double* const deviations[] = {&result_.young.deviation, &result_.poisson.deviation, &result_.thickness.deviation,
                                &result_.shift.deviation, &result_.time_constant.deviation};
  std::string hardly_sliding;
  const auto size = static_cast<Index>(numbers_.size());
  result_.correlation = MatrixXd::Identity(size, size);
  for (Index k = 0; k < size; ++k) {
    const int number = numbers_[static_cast<std::size_t>(k)];
    double deviation = std::sqrt(covariance(k, k));
    if (number >= first_friction) {
      const auto press = static_cast<std::size_t>(number - first_friction);
      const double before_fit = friction_deviation(number);
      deviation = std::min(before_fit, deviation * friction_spread(press, 1 / std::sqrt(held_information(now, k))));
      result_.friction[press].deviation = deviation;
      if (deviation > not_told * before_fit)
        hardly_sliding += (hardly_sliding.empty() ? "" : ", ") + presses_[press].name;
    } else {
      *deviations[number] = deviation * (number == 0 ? E : number == time_constant_number ? time_constant : 1);
    }
    if (number == time_constant_number && deviation > 0.5)
      result_.held.emplace_back("transducer.time_constant is not told: readings decay too little within these presses");
    result_.fitted.push_back(number_name(number));
    for (Index j = 0; j < k; ++j) {
      const double rho = covariance(k, j) / std::sqrt(covariance(k, k) * covariance(j, j));
      result_.correlation(k, j) = result_.correlation(j, k) = rho;
      if (std::abs(rho) > degenerate)
        result_.held.push_back(fmt::format("{} and {} are not told apart (correlation {:.3f}): hold one of them",
                                           number_name(numbers_[static_cast<std::size_t>(j)]), number_name(number),
                                           rho));
    }
  }
  if (!hardly_sliding.empty())
    result_.held.push_back("friction is not told by " + hardly_sliding + ": hardly any of the contact slides");
  for (Index c = 0; c < count(); ++c) {
    const Channel& channel = channels_[static_cast<std::size_t>(c)];
    result_.noise.push_back(channel.used ? channel.noise : nan);
    if (!channel.used) {
      result_.gain.push_back({nan, nan});
      result_.offset.push_back({nan, nan});
      continue;
    }
    MatrixXd cross = MatrixXd::Zero(2, size);
    for (Index row = 0; row < rows(); ++row) {
      if (!std::isfinite(readings_(row, c))) continue;
      const double weight = weight_(row, c) * channel.sensitivity / (channel.noise * channel.noise);
      for (Index k = 0; k < size; ++k) {
        const double by = weight * now.by[static_cast<std::size_t>(k)](row, c);
        cross(0, k) += by;
        cross(1, k) += by * now.frame(row, c);
      }
    }
    const MatrixXd by_rubber = channel.inverse * cross;
    const MatrixXd own = channel.inverse + by_rubber * covariance * by_rubber.transpose();
    const double s = channel.sensitivity;
    result_.gain.push_back({1 / s, std::sqrt(own(1, 1)) / (s * s)});
    result_.offset.push_back({channel.offset, std::sqrt(own(0, 0))});
  }
  for (std::size_t i = 0; i < presses_.size(); ++i) {
    MatrixXd& residuals = result_.residuals.emplace_back(MatrixXd::Constant(presses_[i].readings.rows(), count(), nan));
    for (Index row = 0; row < residuals.rows(); ++row)
      for (Index c = 0; c < count(); ++c)
        if (channels_[static_cast<std::size_t>(c)].used && std::isfinite(readings_(first_row_[i] + row, c)))
          residuals(row, c) = residual(now, first_row_[i] + row, c);
  }
  find_wrong_indenter(now);
  return result_;
}

}  // namespace

std::string transducer_name(Index channel, Index tactels) {
  return channel < tactels ? fmt::format("normal stress of tactel {}", channel)
                           : fmt::format("shear stress of tactel {}", channel - tactels);
}

void CalibrationOptions::validate() const {
  if (!(force_noise > 0 && std::isfinite(force_noise)))
    throw ValueError("force_noise", fmt::format("{:g}", force_noise), "a number above 0");
  if (!(lowest_reading < highest_reading))
    throw ValueError("lowest_reading", fmt::format("{:g}", lowest_reading), "below highest_reading");
  if (noise.size() > 0 && !(noise.array() > 0).all()) throw ValueError("noise", "an array", "numbers above 0");
  if (!(time_constant > 0)) throw ValueError("time_constant", fmt::format("{:g}", time_constant), "s above 0");
  if (fit_time_constant && !std::isfinite(time_constant))
    throw ValueError("time_constant", "true", "given with transducer.time_constant, s, from which the search starts");
  if (!(friction_deviation >= 0 && friction_deviation < 1))
    throw ValueError("friction", fmt::format("{:g}", friction_deviation),
                     "standard deviation of each press's friction, relative, 0 to 1");
  if (most_iterations < 1) throw ValueError("most_iterations", std::to_string(most_iterations), "1 or more");
}

SensorCalibration calibrate_sensor(const fem::SensorFamily& family, const std::vector<KnownPress>& presses,
                                   const SensorState& start, const CalibrationOptions& options) {
  return Fit(family, presses, start, options).run();
}

}  // namespace tactel::host
