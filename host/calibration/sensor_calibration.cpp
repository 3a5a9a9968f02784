// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/sensor_calibration.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "fem/value_error.h"
#include "host/calibration/pad_press.h"
#include "host/calibration/press_readings.h"
#include "host/calibration/recording_faults.h"
#include "host/support/side_by_side.h"

namespace tactel::host {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double converged_step = 0.01;  ///< of a standard deviation
constexpr double spread_step = 1.3;      ///< of the distances at which the cost of a friction is looked at
constexpr double not_told = 0.9;         ///< of its deviation before the fit
/// What is left of the model's error after its correction, over the correction: on twice the elements a further
/// doubling changes 0.29 to 0.37 of what the first did (twenty presses of two cylinders, 12 to 96 elements).
constexpr double model_error_left = 0.35;
constexpr std::size_t error_groups = 16;  ///< of presses, most
constexpr double misfit_from = 4;         ///< standard deviations of a known number that does not fit
constexpr double unjudged = 1e-6;         ///< of the information on a number, left by the fitted ones: too little
constexpr int finer_drags = 2;            ///< increments of a drag on a pad, where the cells are halved

/// What a fit changes.
struct FitState {
  SensorState sensor;
  std::vector<double> friction;  ///< [presses]
};

/// A number of the sensor, or the friction of a press.
struct FitNumber {
  PressNumber number;
  std::size_t press = 0;  ///< of a friction
  bool friction() const { return number == friction_number; }
};

/// All presses, one below the other.
struct Stack {
  MatrixXd frame;            ///< [rows, channels] MPa
  VectorXd P;                ///< [rows]
  std::vector<MatrixXd> by;  ///< [fitted numbers, then known ones]
  std::vector<VectorXd> P_by;
};

/// A number that the fit takes as known. Its error is in the deviations of all that is fitted.
struct Known {
  std::string name, unit;  ///< for messages; without a name it is known to `deviation`, and not judged
  double value;            ///< as it is taken
  PressNumber number;
  std::vector<bool> presses;  ///< of which it is a number
  double deviation = 0;       ///< of its error
};

bool same_shape(const AnyScene& a, const AnyScene& b) {
  const auto kind = [](const AnyScene& scene) {
    return std::visit([](const auto& press) { return press.indenter.shape.index(); }, scene);
  };
  return kind(a) == kind(b) && shape_numbers(a) == shape_numbers(b);
}

/// Whether a tilt of the indenter of a pad changes its contact.
bool has_flat(const AnyScene& scene) {
  const auto& shape = std::get<fem::PadScene>(scene).indenter.shape;
  return std::holds_alternative<fem::Punch>(shape) || std::holds_alternative<fem::Box>(shape);
}

class Fit {
 public:
  /// `family`: of lines.
  Fit(const fem::SensorFamily* family, const std::vector<KnownPress>& presses, const SensorState& start,
      const CalibrationOptions& options);
  SensorCalibration run();

 private:
  std::unique_ptr<PressModel> model_of(const KnownPress& press, bool finer) const;
  void find_patches();
  void find_model_error();
  void append_model_error(Stack& at) const;
  Stack stack(const FitState& state, bool derivatives, const std::vector<Known>& known = {}) const;
  std::vector<Known> known_numbers() const;
  double nominal_friction(std::size_t press) const { return friction_of(presses_[press].scene); }
  double friction_deviation(std::size_t press) const { return options_.friction_deviation * nominal_friction(press); }
  std::string name_of(const FitNumber& fitted) const {
    return fitted.friction() ? "friction of " + presses_[fitted.press].name : sensor_names[fitted.number];
  }
  double cost(const Stack& at) const;
  void normal_equations(const Stack& at, MatrixXd& H, VectorXd& g) const;
  bool pads() const { return family_ == nullptr; }
  bool iterate(int& iterations);
  void choose_numbers();
  void weaken_forces(const Stack& at);
  MatrixXd covariance(const MatrixXd& H, const VectorXd& deviations) const;
  std::string name_presses(const std::vector<bool>& presses) const;
  VectorXd judge(std::vector<Known>& known, const MatrixXd& H, const VectorXd& g,
                 std::vector<std::string>& better) const;
  FitState moved(const VectorXd& step) const;
  double cost_of_friction(std::size_t press, double mu) const;
  double held_information(const Stack& at, Index k) const;
  double friction_spread(std::size_t press, double deviation) const;
  void report_numbers(const Stack& at, const MatrixXd& covariance);
  void report_channels(const Stack& at, const MatrixXd& covariance);
  void report_residuals(const Stack& at);

  const fem::SensorFamily* family_;
  const std::vector<KnownPress>& presses_;
  const CalibrationOptions& options_;
  PressReadings readings_;
  std::vector<std::unique_ptr<PressModel>> models_;
  Stack model_error_;  ///< twice the elements less the fit's; empty before it is known
  FitState state_;
  std::vector<FitNumber> numbers_;  ///< that are fitted
  SensorCalibration result_;
};

Fit::Fit(const fem::SensorFamily* family, const std::vector<KnownPress>& presses, const SensorState& start,
         const CalibrationOptions& options)
    : family_(family), presses_(presses), options_(options), readings_(presses, options), state_{start, {}} {
  state_.sensor.log_time_constant = std::log(options.time_constant);
  for (const KnownPress& press : presses) state_.friction.push_back(friction_of(press.scene));
  find_patches();
}

/// At the present state; `finer`: on twice the elements.
std::unique_ptr<PressModel> Fit::model_of(const KnownPress& press, bool finer) const {
  const int elements = (finer ? 2 : 1) * options_.elements;
  if (!pads())
    return std::make_unique<LinePress>(*family_, std::get<fem::Scene>(press.scene), press.timing, state_.sensor,
                                       elements);
  try {
    return std::make_unique<PadPress>(std::get<fem::PadScene>(press.scene), press.timing, state_.sensor, elements / 2,
                                      finer ? finer_drags : 1);
  } catch (const ValueError& error) {
    throw ValueError(press.name + ": " + error.key, error.value, error.allowed);
  }
}

/// Searches the patches of all presses at the present state.
void Fit::find_patches() {
  models_.resize(presses_.size());
  side_by_side(presses_.size(), options_.threads, [&](std::size_t i) { models_[i] = model_of(presses_[i], false); });
}

/// At the state, corrected by the model's error where that is known; with derivatives by the fitted numbers, and those
/// of `known`.
Stack Fit::stack(const FitState& state, bool derivatives, const std::vector<Known>& known) const {
  Stack all{MatrixXd(readings_.rows(), readings_.count()), VectorXd(readings_.rows()), {}, {}};
  const std::size_t columns = derivatives ? numbers_.size() + known.size() : 0;
  all.by.assign(columns, all.frame), all.P_by.assign(columns, all.P);
  side_by_side(models_.size(), options_.threads, [&](std::size_t i) {
    const auto of_press = [&](std::size_t k) {  // none: the press has another
      const bool fitted = k < numbers_.size();
      const bool concerned = fitted ? !numbers_[k].friction() || numbers_[k].press == i
                                    : static_cast<bool>(known[k - numbers_.size()].presses[i]);
      const PressNumber number = fitted ? numbers_[k].number : known[k - numbers_.size()].number;
      return concerned ? std::optional(number) : std::nullopt;
    };
    std::vector<PressNumber> asked;
    for (std::size_t k = 0; k < columns; ++k)
      if (const auto number = of_press(k)) asked.push_back(*number);
    const PressFrames frames = models_[i]->at(state.sensor, state.friction[i], asked);
    const Index first = readings_.first_row[i], steps = readings_.steps(i);
    if (frames.frame.rows() != steps)
      throw ValueError(presses_[i].name + ": readings", fmt::format("{} rows", steps),
                       fmt::format("{} rows, one for each load step", frames.frame.rows()));
    all.frame.middleRows(first, steps) = frames.frame;
    all.P.segment(first, steps) = frames.P;
    for (std::size_t k = 0; k < columns; ++k) {
      const auto number = of_press(k);
      auto by = all.by[k].middleRows(first, steps);
      auto P_by = all.P_by[k].segment(first, steps);
      by.setZero();
      P_by.setZero();
      if (number) by = frames.frame_by[*number], P_by = frames.P_by[*number];
    }
  });
  if (model_error_.P.size() > 0) all.frame += model_error_.frame, all.P += model_error_.P;
  return all;
}

/// What twice the elements change; nothing in presses that have no answer there.
void Fit::find_model_error() {
  Stack error{MatrixXd::Zero(readings_.rows(), readings_.count()), VectorXd::Zero(readings_.rows()), {}, {}};
  std::vector<char> known(presses_.size(), true);
  side_by_side(presses_.size(), options_.threads, [&](std::size_t i) {
    const Index first = readings_.first_row[i], steps = readings_.steps(i);
    try {
      const std::unique_ptr<PressModel> finer = model_of(presses_[i], true);
      const PressFrames to = finer->at(state_.sensor, state_.friction[i]),
                        from = models_[i]->at(state_.sensor, state_.friction[i]);
      error.frame.middleRows(first, steps) = to.frame - from.frame;
      error.P.segment(first, steps) = to.P - from.P;
    } catch (const fem::PathError&) {
      known[i] = false;
    }
  });
  for (std::size_t i = 0; i < presses_.size(); ++i)
    if (!known[i])
      result_.held.push_back("the model's error in " + presses_[i].name + " is not known, and not counted");
  model_error_ = std::move(error);
}

/// As derivatives: errors of presses differ in sign, so that each group of presses has its own.
void Fit::append_model_error(Stack& at) const {
  for (std::size_t group = 0; group < std::min(error_groups, presses_.size()); ++group) {
    at.by.push_back(MatrixXd::Zero(readings_.rows(), readings_.count()));
    at.P_by.push_back(VectorXd::Zero(readings_.rows()));
    for (std::size_t i = group; i < presses_.size(); i += error_groups) {
      const Index first = readings_.first_row[i], steps = readings_.steps(i);
      at.by.back().middleRows(first, steps) = model_error_.frame.middleRows(first, steps);
      at.P_by.back().segment(first, steps) = model_error_.P.segment(first, steps);
    }
  }
}

double Fit::cost(const Stack& at) const {
  double sum = 0;
  for (Index c = 0; c < readings_.count(); ++c)
    for (Index row = 0; row < readings_.rows(); ++row)
      if (readings_.takes(row, c))
        sum += readings_.weight(row, c) * std::pow(readings_.residual(row, c, at.frame(row, c)), 2);
  for (std::size_t i = 0; i < presses_.size(); ++i)
    if (readings_.has_force(i))
      sum += readings_.P_weight[static_cast<Index>(i)] * std::pow(readings_.force_residual(i, at.P), 2);
  for (const FitNumber& fitted : numbers_)
    if (const std::size_t press = fitted.press; fitted.friction())
      sum += std::pow((state_.friction[press] - nominal_friction(press)) / friction_deviation(press), 2);
  return sum;
}

/// Of the numbers by which `at` has derivatives, gains and offsets eliminated.
void Fit::normal_equations(const Stack& at, MatrixXd& H, VectorXd& g) const {
  const auto size = static_cast<Index>(at.by.size());
  H = MatrixXd::Zero(size, size);
  g = VectorXd::Zero(size);
  for (Index c = 0; c < readings_.count(); ++c) {
    const Channel& channel = readings_.channel(c);
    if (!channel.used) continue;
    MatrixXd cross = MatrixXd::Zero(2, size), squares = MatrixXd::Zero(size, size);
    for (Index row = 0; row < readings_.rows(); ++row) {
      if (!readings_.takes(row, c)) continue;
      VectorXd by(size);
      for (Index k = 0; k < size; ++k) by[k] = channel.sensitivity * at.by[static_cast<std::size_t>(k)](row, c);
      const double weight = readings_.weight(row, c) / (channel.noise * channel.noise);
      cross.row(0) += weight * by;
      cross.row(1) += weight * at.frame(row, c) * by;
      squares += weight * by * by.transpose();
      g += weight * by * (readings_.residual(row, c, at.frame(row, c)) * channel.noise);
    }
    H += squares - cross.transpose() * channel.inverse * cross;
  }
  for (std::size_t i = 0; i < presses_.size(); ++i) {
    if (!readings_.has_force(i)) continue;
    const double weight = readings_.P_weight[static_cast<Index>(i)], noise = readings_.force_noise;
    VectorXd by(size);
    for (Index k = 0; k < size; ++k) by[k] = readings_.over_measured(i, at.P_by[static_cast<std::size_t>(k)]) / noise;
    H += weight * by * by.transpose();
    g += weight * by * readings_.force_residual(i, at.P);
  }
  for (Index k = 0; k < static_cast<Index>(numbers_.size()); ++k) {
    const auto& [number, press] = numbers_[static_cast<std::size_t>(k)];
    if (number != friction_number) continue;
    const double weight = 1 / std::pow(friction_deviation(press), 2);
    H(k, k) += weight;
    g[k] += weight * (nominal_friction(press) - state_.friction[press]);
  }
}

FitState Fit::moved(const VectorXd& step) const {
  FitState next = state_;
  for (Index k = 0; k < step.size(); ++k) {
    const auto& [number, press] = numbers_[static_cast<std::size_t>(k)];
    (number == friction_number ? next.friction[press] : next.sensor.*sensor_members[number]) += step[k];
  }
  SensorState& sensor = next.sensor;
  const SensorState& last = state_.sensor;
  const auto [lowest, highest] =
      family_ != nullptr ? std::pair(family_->range().poisson_low, family_->range().poisson_high) : std::pair(0.0, 0.5);
  sensor.poisson = std::clamp(sensor.poisson, lowest, highest);
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
  bool both = false, depth_given = false, force_given = false;
  for (std::size_t i = 0; i < presses_.size(); ++i) {
    if (!readings_.press_used[i]) continue;
    const bool force = by_force(presses_[i].scene);
    (force ? force_given : depth_given) = true;
    both |= !force && readings_.P.segment(readings_.first_row[i], readings_.steps(i)).array().isFinite().any();
  }
  numbers_.clear();
  result_.held.clear();
  if (both || (depth_given && force_given))
    numbers_.push_back({young_number});
  else
    result_.held.emplace_back(
        "sensor.young is held: no press has both depth and force, and a softer rubber reads as smaller gains");
  if (options_.fit_poisson)
    numbers_.push_back({poisson_number});
  else
    result_.held.emplace_back("sensor.poisson is held: not asked for");
  if (options_.fit_thickness)
    numbers_.push_back({thickness_number});
  else
    result_.held.emplace_back(
        pads() ? "sensor.thickness is held: not asked for"
               : "sensor.thickness is held: it and sensor.poisson change frames nearly alike, so measure it");
  if (options_.fit_shift) numbers_.push_back({shift_number});
  if (options_.fit_shift && pads()) numbers_.push_back({shift_y_number});
  if (options_.fit_time_constant) numbers_.push_back({time_constant_number});
  for (std::size_t i = 0; i < presses_.size(); ++i) {
    const double mu = nominal_friction(i);
    if (options_.friction_deviation > 0 && readings_.press_used[i] && mu > 0 && std::isfinite(mu))
      numbers_.push_back({friction_number, i});
  }
}

bool Fit::iterate(int& iterations) {
  Stack current = stack(state_, true);
  readings_.fit_channels(current.frame, true, result_.faults);
  if (numbers_.empty()) {
    readings_.reweight(current.frame, current.P);
    readings_.fit_channels(current.frame, true, result_.faults);
    return true;
  }
  double damping = 1e-3;
  for (; iterations < options_.most_iterations; ++iterations) {
    readings_.reweight(current.frame, current.P);
    readings_.fit_channels(current.frame, true, result_.faults);
    MatrixXd H;
    VectorXd g;
    normal_equations(current, H, g);
    const double before = cost(current);
    for (;;) {
      MatrixXd damped = H;
      damped.diagonal() *= 1 + damping;
      const VectorXd step = damped.ldlt().solve(g);
      const FitState last = state_;
      state_ = moved(step);
      Stack next = stack(state_, true);
      const std::vector<Channel> kept = readings_.channels;
      readings_.fit_channels(next.frame, false, result_.faults);
      const double after = cost(next);
      const double size = (step.array() * H.diagonal().array().sqrt()).abs().maxCoeff();
      if (after <= before || size < converged_step) {
        damping = std::max(damping / 10, 1e-9);
        current = std::move(next);
        if (size < converged_step) {
          readings_.reweight(current.frame, current.P);
          readings_.fit_channels(current.frame, true, result_.faults);
          return true;
        }
        break;
      }
      state_ = last;
      readings_.channels = kept;
      damping *= 10;
      if (damping > 1e6) return false;
    }
  }
  return false;
}

/// The part of cost() that a press's friction changes, all else held.
double Fit::cost_of_friction(std::size_t press, double mu) const {
  PressFrames frames = models_[press]->at(state_.sensor, mu);
  const Index first = readings_.first_row[press], steps = readings_.steps(press);
  VectorXd forces = VectorXd::Zero(readings_.rows());
  forces.segment(first, steps) = frames.P;
  if (model_error_.P.size() > 0) {
    frames.frame += model_error_.frame.middleRows(first, steps);
    forces.segment(first, steps) += model_error_.P.segment(first, steps);
  }
  const double nominal = nominal_friction(press);
  double sum = std::pow((mu - nominal) / (options_.friction_deviation * nominal), 2);
  for (Index step = 0; step < steps; ++step)
    for (Index c = 0; c < readings_.count(); ++c)
      if (const Index row = first + step; readings_.takes(row, c))
        sum += readings_.weight(row, c) * std::pow(readings_.residual(row, c, frames.frame(step, c)), 2);
  if (readings_.has_force(press))
    sum += readings_.P_weight[static_cast<Index>(press)] * std::pow(readings_.force_residual(press, forces), 2);
  return sum;
}

/// Information on the friction that is the fitted number k, all else held.
double Fit::held_information(const Stack& at, Index k) const {
  const auto place = static_cast<std::size_t>(k);
  const std::size_t press = numbers_[place].press;
  double sum = 1 / std::pow(friction_deviation(press), 2);
  for (Index row = 0; row < readings_.rows(); ++row)
    for (Index c = 0; c < readings_.count(); ++c) {
      const Channel& channel = readings_.channel(c);
      if (readings_.takes(row, c))
        sum += readings_.weight(row, c) * std::pow(channel.sensitivity * at.by[place](row, c) / channel.noise, 2);
    }
  const double force = readings_.over_measured(press, at.P_by[place]) / readings_.force_noise;
  return sum + readings_.P_weight[static_cast<Index>(press)] * std::pow(force, 2);
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

/// Values, deviations and correlation of the fitted numbers, and which of them are not told.
void Fit::report_numbers(const Stack& at, const MatrixXd& covariance) {
  Fitted* const fitted[sensor_numbers] = {&result_.young, &result_.poisson,       &result_.thickness,
                                          &result_.shift, &result_.time_constant, &result_.shift_y};
  const auto by_logarithm = [](int number) { return number == young_number || number == time_constant_number; };
  for (int number = 0; number < sensor_numbers; ++number) {
    const double value = state_.sensor.*sensor_members[number];
    fitted[number]->value = by_logarithm(number) ? std::exp(value) : value;
  }
  for (const double friction : state_.friction) result_.friction.push_back({friction, 0});
  std::string hardly_sliding;
  const auto size = static_cast<Index>(numbers_.size());
  result_.correlation = MatrixXd::Identity(size, size);
  for (Index k = 0; k < size; ++k) {
    const auto& [number, press] = numbers_[static_cast<std::size_t>(k)];
    double deviation = std::sqrt(covariance(k, k));
    if (number == friction_number) {
      const double before_fit = friction_deviation(press);
      deviation = std::min(before_fit, deviation * friction_spread(press, 1 / std::sqrt(held_information(at, k))));
      result_.friction[press].deviation = deviation;
      if (deviation > not_told * before_fit)
        hardly_sliding += (hardly_sliding.empty() ? "" : ", ") + presses_[press].name;
    } else {
      fitted[number]->deviation = deviation * (by_logarithm(number) ? fitted[number]->value : 1);
    }
    if (number == time_constant_number && deviation > 0.5)
      result_.held.emplace_back("transducer.time_constant is not told: readings decay too little within these presses");
    result_.fitted.push_back(name_of(numbers_[static_cast<std::size_t>(k)]));
    for (Index j = 0; j < k; ++j) {
      const double rho = covariance(k, j) / std::sqrt(covariance(k, k) * covariance(j, j));
      result_.correlation(k, j) = result_.correlation(j, k) = rho;
      if (std::abs(rho) > degenerate)
        result_.held.push_back(fmt::format("{} and {} are not told apart (correlation {:.3f}): hold one of them",
                                           name_of(numbers_[static_cast<std::size_t>(j)]), result_.fitted.back(), rho));
    }
  }
  if (!hardly_sliding.empty())
    result_.held.push_back("friction is not told by " + hardly_sliding + ": hardly any of the contact slides");
}

/// Gains and offsets, with deviations that include those of the fitted numbers.
void Fit::report_channels(const Stack& at, const MatrixXd& covariance) {
  const auto size = static_cast<Index>(at.by.size());
  for (Index c = 0; c < readings_.count(); ++c) {
    const Channel& channel = readings_.channel(c);
    result_.noise.push_back(channel.used ? channel.noise : nan);
    if (!channel.used) {
      result_.gain.push_back({nan, nan});
      result_.offset.push_back({nan, nan});
      continue;
    }
    MatrixXd cross = MatrixXd::Zero(2, size);
    for (Index row = 0; row < readings_.rows(); ++row) {
      if (!readings_.takes(row, c)) continue;
      const double weight = readings_.weight(row, c) * channel.sensitivity / (channel.noise * channel.noise);
      for (Index k = 0; k < size; ++k) {
        const double by = weight * at.by[static_cast<std::size_t>(k)](row, c);
        cross(0, k) += by;
        cross(1, k) += by * at.frame(row, c);
      }
    }
    const MatrixXd by_rubber = channel.inverse * cross;
    const MatrixXd total = channel.inverse + by_rubber * covariance * by_rubber.transpose();
    const double s = channel.sensitivity;
    result_.gain.push_back({1 / s, std::sqrt(total(1, 1)) / (s * s)});
    result_.offset.push_back({channel.offset, std::sqrt(total(0, 0))});
  }
}

/// Numbers that the fit takes as known: those that may be what does not fit, and the loads of presses by force.
std::vector<Known> Fit::known_numbers() const {
  std::vector<Known> all;
  const std::vector<bool> every = readings_.press_used;
  const auto presses_of = [&](const auto& belongs) {
    std::vector<bool> concerned = every;
    for (std::size_t i = 0; i < concerned.size(); ++i) concerned[i] = concerned[i] && belongs(presses_[i].scene);
    return concerned;
  };
  const auto add = [&](std::string name, const char* unit, double value, PressNumber number,
                       std::vector<bool> presses) {
    if (std::ranges::find(presses, true) != presses.end())
      all.push_back({std::move(name), unit, value, number, std::move(presses)});
  };
  if (!options_.fit_thickness) add("sensor.thickness", " mm", state_.sensor.thickness, thickness_number, every);
  if (!options_.fit_shift) {
    add(pads() ? "shift of the tactels along x" : "shift of the tactels", " mm", state_.sensor.shift, shift_number,
        every);
    if (pads()) add("shift of the tactels along y", " mm", state_.sensor.shift_y, shift_y_number, every);
  }
  if (pads()) {
    add("tilt of the indenters along their x", " degrees", 0, tilt_number, presses_of(has_flat));
    add("tilt of the indenters along their y", " degrees", 0, tilt_y_number, presses_of(has_flat));
  } else {
    add("tilt of the indenters", " degrees", 0, tilt_number, every);
  }
  add("zero of the depth", " mm", 0, depth_number, presses_of([](const AnyScene& scene) { return !by_force(scene); }));
  const auto once = [&](std::size_t i, const auto& same) {
    for (std::size_t j = 0; j < i; ++j)
      if (same(presses_[j].scene, presses_[i].scene)) return false;
    return true;
  };
  const auto same_friction = [](const AnyScene& a, const AnyScene& b) { return friction_of(a) == friction_of(b); };
  for (std::size_t i = 0; i < presses_.size(); ++i) {
    const AnyScene& scene = presses_[i].scene;
    const auto like_this = [&](const auto& same) {
      return presses_of([&](const AnyScene& other) { return same(other, scene); });
    };
    const double friction = friction_of(scene);
    if (options_.friction_deviation == 0 && friction > 0 && std::isfinite(friction) && once(i, same_friction))
      add("contact.friction", "", friction, friction_number, like_this(same_friction));
    if (once(i, same_shape)) {
      const std::vector<ShapeNumber> numbers = shape_numbers(scene);
      for (int k = 0; k < std::min(most_shape_numbers, static_cast<int>(numbers.size())); ++k) {
        const ShapeNumber& shape = numbers[static_cast<std::size_t>(k)];
        add("indenter." + shape.key, shape.unit.empty() ? "" : (" " + shape.unit).c_str(), shape.value,
            static_cast<PressNumber>(shape_number + k), like_this(same_shape));
      }
    }
    if (by_force(scene) && readings_.press_used[i]) {
      std::vector<bool> alone(presses_.size(), false);
      alone[i] = true;
      all.push_back({"", "", 0, load_number, std::move(alone), readings_.force_noise});
    }
  }
  return all;
}

/// Where forces scatter by more than their noise, that of the fit is theirs.
void Fit::weaken_forces(const Stack& at) {
  double sum = 0, n = -1;
  for (std::size_t i = 0; i < presses_.size(); ++i)
    if (readings_.has_force(i))
      sum += readings_.P_weight[static_cast<Index>(i)] * std::pow(readings_.force_residual(i, at.P), 2), n += 1;
  if (n > 0) readings_.force_noise *= std::sqrt(std::max(1.0, sum / n));
}

/// Of all numbers in the normal equations: the fitted ones, which answer to errors of the known ones, `deviations`.
MatrixXd Fit::covariance(const MatrixXd& H, const VectorXd& deviations) const {
  const auto fitted = static_cast<Index>(numbers_.size()), known = deviations.size();
  MatrixXd alone = MatrixXd::Zero(fitted, fitted);
  if (fitted > 0) alone = H.topLeftCorner(fitted, fitted).ldlt().solve(MatrixXd::Identity(fitted, fitted));
  MatrixXd answer(fitted + known, known);
  answer << -alone * H.topRightCorner(fitted, known), MatrixXd::Identity(known, known);
  MatrixXd all = answer * deviations.array().square().matrix().asDiagonal() * answer.transpose();
  all.topLeftCorner(fitted, fitted) += alone;
  return all;
}

/// " of press 1, press 3 and 8 more"; empty for all.
std::string Fit::name_presses(const std::vector<bool>& presses) const {
  constexpr int most_names = 2;
  std::string text;
  int count = 0;
  for (std::size_t i = 0; i < presses.size(); ++i)
    if (presses[i] && count++ < most_names) text += (count == 1 ? " of " : ", ") + presses_[i].name;
  if (presses == readings_.press_used) return "";
  return count > most_names ? fmt::format("{} and {} more", text, count - most_names) : text;
}

/// Judges each known number alone: by one Newton step, does another value explain more of the residuals than noise and
/// the model's error? That is a sentence in `better`, and the step a deviation of the number. Returns the deviations of
/// all known numbers, and of the model's error.
VectorXd Fit::judge(std::vector<Known>& known, const MatrixXd& H, const VectorXd& g,
                    std::vector<std::string>& better) const {
  const auto fitted = static_cast<Index>(numbers_.size()), count = static_cast<Index>(known.size()),
             others = H.rows() - fitted, errors = others - count;
  MatrixXd answer = MatrixXd::Zero(fitted, others);
  if (fitted > 0) answer = H.topLeftCorner(fitted, fitted).ldlt().solve(H.topRightCorner(fitted, others));
  const MatrixXd left = H.bottomRightCorner(others, others) - H.bottomLeftCorner(others, fitted) * answer;
  const VectorXd slope = g.tail(others) - answer.transpose() * g.head(fitted);
  VectorXd deviations = VectorXd::Constant(others, model_error_left);
  std::vector<std::pair<double, std::string>> found;
  for (Index j = 0; j < count; ++j) {
    Known& number = known[static_cast<std::size_t>(j)];
    if (!number.name.empty() && left(j, j) > unjudged * H(fitted + j, fitted + j)) {
      const double step = slope[j] / left(j, j);
      const double over =
          std::abs(slope[j]) / std::hypot(std::sqrt(left(j, j)), model_error_left * left.row(j).tail(errors).norm());
      if (over > misfit_from) {
        number.deviation = std::abs(step);
        found.emplace_back(
            over, fmt::format("{}{}? the readings ask for {:.3g}{}, not {:.3g}{} ({:.0f} standard deviations)",
                              number.name, name_presses(number.presses), number.value + step, number.unit, number.value,
                              number.unit, over));
      }
    }
    deviations[j] = number.deviation;
  }
  std::ranges::sort(found, std::greater());
  for (const auto& [over, sentence] : found) better.push_back(sentence);
  return deviations;
}

void Fit::report_residuals(const Stack& at) {
  for (std::size_t i = 0; i < presses_.size(); ++i) {
    MatrixXd& residuals =
        result_.residuals.emplace_back(MatrixXd::Constant(readings_.steps(i), readings_.count(), nan));
    for (Index step = 0; step < residuals.rows(); ++step) {
      const Index row = readings_.first_row[i] + step;
      for (Index c = 0; c < readings_.count(); ++c)
        if (readings_.takes(row, c)) residuals(step, c) = readings_.residual(row, c, at.frame(row, c));
    }
  }
}

SensorCalibration Fit::run() {
  result_.pad = pads(), result_.tactels = readings_.tactels;
  find_constant_and_saturated(readings_, options_, result_.faults);
  find_swapped(readings_, stack(state_, false).frame, result_.faults);
  choose_numbers();
  iterate(result_.iterations);
  find_patches();
  bool settled = iterate(result_.iterations);
  find_dead(readings_, stack(state_, false).frame, result_.faults);
  while (find_wrong_press(readings_, stack(state_, false).frame, result_.faults)) {
    readings_.weight.setOnes();
    readings_.P_weight.setOnes();
    choose_numbers();
    settled = iterate(result_.iterations);
  }
  find_model_error();
  settled = settled && iterate(result_.iterations);
  result_.converged = settled;
  std::vector<Known> known = known_numbers();
  Stack solved = stack(state_, true, known);
  append_model_error(solved);
  weaken_forces(solved);
  MatrixXd H;
  VectorXd g;
  normal_equations(solved, H, g);
  std::vector<std::string> better;
  const MatrixXd all = covariance(H, judge(known, H, g, better));
  report_numbers(solved, all);
  report_channels(solved, all);
  report_residuals(solved);
  find_misfit(readings_, solved.frame, options_, better, result_.faults);
  find_wrong_indenter(readings_, solved.frame, options_, result_.faults);
  return result_;
}

}  // namespace

std::vector<std::string> stress_names(Index channels, Index tactels) {
  switch (channels / tactels) {
    case 2:
      return {"normal stress", "shear stress"};
    case 3:
      return {"normal stress", "shear stress along x", "shear stress along y"};
    default:
      return {"normal stress"};
  }
}

std::string transducer_name(Index channel, Index channels, Index tactels) {
  return fmt::format("{} of tactel {}", stress_names(channels, tactels).at(static_cast<std::size_t>(channel / tactels)),
                     channel % tactels);
}

void CalibrationOptions::validate() const {
  if (!(force_noise > 0 && force_noise <= 1))
    throw ValueError("force_noise", fmt::format("{:g}", force_noise), "a number above 0, at most 1");
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
  options.validate();
  return Fit(&family, presses, start, options).run();
}

SensorCalibration calibrate_pad(const std::vector<KnownPress>& presses, const SensorState& start,
                                const CalibrationOptions& options) {
  options.validate();
  return Fit(nullptr, presses, start, options).run();
}

}  // namespace tactel::host
