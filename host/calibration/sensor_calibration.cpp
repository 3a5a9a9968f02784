// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/sensor_calibration.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <span>
#include <utility>

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
constexpr double most_damping = 1e6, least_damping = 1e-9;
constexpr double spread_step = 1.3;  ///< of the distances at which the cost of a friction is looked at
constexpr double not_told = 0.9;     ///< of its deviation before the fit
/// What is left of the model's error after its correction, over the correction: on twice the elements a further
/// doubling changes 0.29 to 0.37 of what the first did (twenty presses of two cylinders, 12 to 96 elements).
constexpr double model_error_left = 0.35;
constexpr std::size_t error_groups = 16;  ///< of presses, most
constexpr double misfit_from = 4;         ///< standard deviations of a held number that does not fit
constexpr double unjudged = 1e-6;         ///< of the information on a number, left by the fitted ones: too little
constexpr int finer_drags = 2;            ///< increments of a drag on a pad, where the cells are halved

/// What a fit changes.
struct FitState {
  SensorState sensor;
  std::vector<double> friction;  ///< [presses]
};

/// A number by which all presses have derivatives: fitted, or held. The error of a held one is in the deviations of all
/// that is fitted.
struct Unknown {
  PressNumber number;
  std::vector<bool> presses;  ///< of which it is a number
  std::string name;           ///< for messages; a held number without one is known to `deviation`, and not judged
  std::string unit{};
  double value = 0;      ///< as it is held
  double deviation = 0;  ///< of its error, where it is held

  /// The press whose fitted friction it is; none: a number of the sensor.
  std::optional<std::size_t> friction_press() const {
    if (number != friction_number) return {};
    return static_cast<std::size_t>(std::ranges::find(presses, true) - presses.begin());
  }
};

/// Frames and forces of all presses, one below the other.
struct Stack {
  MatrixXd frame;                ///< [rows, channels] MPa
  VectorXd P;                    ///< [rows]
  std::vector<MatrixXd> by{};    ///< [numbers] their derivatives
  std::vector<VectorXd> P_by{};  ///< [numbers]
};

/// Normal equations of the numbers of a stack, gains and offsets eliminated.
struct Equations {
  MatrixXd H;
  VectorXd g;
  VectorXd alone;  ///< information on each number where all else is held
};

bool same_shape(const AnyScene& a, const AnyScene& b) {
  const auto kind = [](const AnyScene& scene) {
    return std::visit([](const auto& press) { return press.indenter.shape.index(); }, scene);
  };
  return kind(a) == kind(b) && shape_numbers(a) == shape_numbers(b);
}

bool same_friction(const AnyScene& a, const AnyScene& b) { return friction_of(a) == friction_of(b); }

/// Whether a tilt of the indenter changes its contact: on a pad that of a flat alone.
bool feels_tilt(const AnyScene& scene) {
  const auto* pad = std::get_if<fem::PadScene>(&scene);
  return pad == nullptr || fem::tilts(pad->indenter.shape);
}

class Fit {
 public:
  /// `family`: of lines.
  Fit(const fem::SensorFamily* family, const std::vector<KnownPress>& presses, const SensorState& start,
      const CalibrationOptions& options);
  SensorCalibration run();

 private:
  bool pads() const { return family_ == nullptr; }
  double nominal_friction(std::size_t press) const { return friction_of(presses_[press].scene); }
  double friction_deviation(std::size_t press) const { return options_.friction_deviation * nominal_friction(press); }
  /// Squares of what a friction is off from that of its scene, over its deviation.
  double friction_cost(std::size_t press, double mu) const {
    return std::pow((mu - nominal_friction(press)) / friction_deviation(press), 2);
  }

  std::unique_ptr<PressModel> model_of(const KnownPress& press, bool finer) const;
  void find_patches();
  void find_model_error();
  Stack stack(const std::vector<Unknown>& numbers = {}) const;
  void append_model_error(Stack& at) const;
  double cost(const Stack& at) const;
  Equations normal_equations(const Stack& at) const;
  FitState moved(const VectorXd& step) const;
  void choose_numbers();
  bool iterate();
  std::vector<Unknown> held_numbers() const;
  void weaken_forces(const Stack& at);
  MatrixXd covariance(const MatrixXd& H, const VectorXd& deviations) const;
  std::string name_presses(const std::vector<bool>& presses) const;
  VectorXd judge(const std::vector<Unknown>& held, const Equations& all, std::vector<std::string>& better) const;
  double cost_of_friction(std::size_t press, double mu) const;
  double friction_spread(std::size_t press, double deviation) const;
  void report_numbers(const Equations& all, const MatrixXd& covariance);
  void report_channels(const Stack& at, const MatrixXd& covariance);

  const fem::SensorFamily* family_;
  const std::vector<KnownPress>& presses_;
  const CalibrationOptions& options_;
  PressReadings readings_;
  std::vector<std::unique_ptr<PressModel>> models_;
  Stack model_error_;  ///< twice the elements less the fit's; 0 before it is known
  FitState state_;
  std::vector<Unknown> numbers_;  ///< that are fitted
  SensorCalibration result_;
};

Fit::Fit(const fem::SensorFamily* family, const std::vector<KnownPress>& presses, const SensorState& start,
         const CalibrationOptions& options)
    : family_(family),
      presses_(presses),
      options_(options),
      readings_(presses, options),
      model_error_{MatrixXd::Zero(readings_.rows(), readings_.count()), VectorXd::Zero(readings_.rows())},
      state_{start, {}} {
  state_.sensor.log_time_constant = std::log(options.time_constant);
  for (const KnownPress& press : presses) state_.friction.push_back(friction_of(press.scene));
  find_patches();
}

/// At the present state; `finer`: on twice the elements.
std::unique_ptr<PressModel> Fit::model_of(const KnownPress& press, bool finer) const {
  const int elements = (finer ? 2 : 1) * options_.elements;
  if (const auto* line = std::get_if<fem::Scene>(&press.scene))
    return std::make_unique<LinePress>(*family_, *line, press.timing, state_.sensor, elements);
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

/// At the present state, with derivatives by these numbers, and with the model's error.
Stack Fit::stack(const std::vector<Unknown>& numbers) const {
  Stack all{MatrixXd(readings_.rows(), readings_.count()), VectorXd(readings_.rows())};
  all.by.assign(numbers.size(), MatrixXd::Zero(readings_.rows(), readings_.count()));
  all.P_by.assign(numbers.size(), VectorXd::Zero(readings_.rows()));
  side_by_side(models_.size(), options_.threads, [&](std::size_t i) {
    std::vector<PressNumber> asked;
    for (const Unknown& unknown : numbers)
      if (unknown.presses[i]) asked.push_back(unknown.number);
    const PressFrames frames = models_[i]->at(state_.sensor, state_.friction[i], asked);
    const auto rows = readings_.rows(i);
    if (frames.frame.rows() != rows.size())
      throw ValueError(presses_[i].name + ": readings", fmt::format("{} rows", rows.size()),
                       fmt::format("{} rows, one for each load step", frames.frame.rows()));
    all.frame(rows, Eigen::all) = frames.frame + model_error_.frame(rows, Eigen::all);
    all.P(rows) = frames.P + model_error_.P(rows);
    for (std::size_t k = 0; k < numbers.size(); ++k) {
      if (!numbers[k].presses[i]) continue;
      all.by[k](rows, Eigen::all) = frames.frame_by.at(numbers[k].number);
      all.P_by[k](rows) = frames.P_by.at(numbers[k].number);
    }
  });
  return all;
}

/// What twice the elements change; nothing in presses that have no answer there.
void Fit::find_model_error() {
  std::vector<char> unsolved(presses_.size(), false);
  side_by_side(presses_.size(), options_.threads, [&](std::size_t i) {
    try {
      const PressFrames to = model_of(presses_[i], true)->at(state_.sensor, state_.friction[i]),
                        from = models_[i]->at(state_.sensor, state_.friction[i]);
      model_error_.frame(readings_.rows(i), Eigen::all) = to.frame - from.frame;
      model_error_.P(readings_.rows(i)) = to.P - from.P;
    } catch (const fem::PathError&) {
      unsolved[i] = true;
    }
  });
  for (std::size_t i = 0; i < presses_.size(); ++i)
    if (unsolved[i])
      result_.held.push_back("the model's error in " + presses_[i].name + " is not known, and not counted");
}

/// As derivatives: errors of presses differ in sign, so that each group of presses has its own.
void Fit::append_model_error(Stack& at) const {
  for (std::size_t group = 0; group < std::min(error_groups, presses_.size()); ++group) {
    at.by.push_back(MatrixXd::Zero(readings_.rows(), readings_.count()));
    at.P_by.push_back(VectorXd::Zero(readings_.rows()));
    for (std::size_t i = group; i < presses_.size(); i += error_groups) {
      const auto rows = readings_.rows(i);
      at.by.back()(rows, Eigen::all) = model_error_.frame(rows, Eigen::all);
      at.P_by.back()(rows) = model_error_.P(rows);
    }
  }
}

double Fit::cost(const Stack& at) const {
  double sum = 0;
  for (std::size_t i = 0; i < presses_.size(); ++i) {
    const auto rows = readings_.rows(i);
    sum += readings_.squares(i, at.frame(rows, Eigen::all), at.P(rows));
  }
  for (const Unknown& fitted : numbers_)
    if (const auto press = fitted.friction_press()) sum += friction_cost(*press, state_.friction[*press]);
  return sum;
}

Equations Fit::normal_equations(const Stack& at) const {
  const auto size = static_cast<Index>(at.by.size());
  Equations all{MatrixXd::Zero(size, size), VectorXd::Zero(size), VectorXd::Zero(size)};
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
      all.g += weight * by * (readings_.residual(row, c, at.frame(row, c)) * channel.noise);
    }
    all.H += squares - cross.transpose() * channel.inverse * cross;
    all.alone += squares.diagonal();
  }
  for (std::size_t i = 0; i < presses_.size(); ++i) {
    if (!readings_.has_force(i)) continue;
    const double weight = readings_.P_weight[static_cast<Index>(i)];
    VectorXd by(size);
    for (Index k = 0; k < size; ++k)
      by[k] =
          readings_.over_measured(i, at.P_by[static_cast<std::size_t>(k)](readings_.rows(i))) / readings_.force_noise;
    all.H += weight * by * by.transpose();
    all.alone += weight * by.cwiseAbs2();
    all.g += weight * by * readings_.force_residual(i, at.P(readings_.rows(i)));
  }
  for (Index k = 0; k < static_cast<Index>(numbers_.size()); ++k) {
    const auto press = numbers_[static_cast<std::size_t>(k)].friction_press();
    if (!press) continue;
    const double weight = 1 / std::pow(friction_deviation(*press), 2);
    all.H(k, k) += weight;
    all.alone[k] += weight;
    all.g[k] += weight * (nominal_friction(*press) - state_.friction[*press]);
  }
  return all;
}

/// The state after a step of the fitted numbers, each within its range and not far from where it is.
FitState Fit::moved(const VectorXd& step) const {
  FitState next = state_;
  SensorState& sensor = next.sensor;
  const SensorState& last = state_.sensor;
  for (Index k = 0; k < step.size(); ++k) {
    const Unknown& unknown = numbers_[static_cast<std::size_t>(k)];
    const auto press = unknown.friction_press();
    (press ? next.friction[*press] : sensor.*sensor_table[unknown.number].member) += step[k];
  }
  sensor.poisson = pads() ? std::clamp(sensor.poisson, 0.0, 0.5)
                          : std::clamp(sensor.poisson, family_->range().poisson_low, family_->range().poisson_high);
  sensor.thickness = std::clamp(sensor.thickness, 0.8 * last.thickness, 1.25 * last.thickness);
  for (double SensorState::*log : {&SensorState::log_young, &SensorState::log_time_constant})
    if (std::isfinite(last.*log)) sensor.*log = std::clamp(sensor.*log, last.*log - 1, last.*log + 1);
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
    both |= !force && readings_.P(readings_.rows(i)).array().isFinite().any();
  }
  numbers_.clear();
  result_.held.clear();
  const std::vector<PressNumber> fitted = fitted_numbers(options_, both || (depth_given && force_given), pads());
  for (const PressNumber number : fitted)
    numbers_.push_back({number, std::vector<bool>(presses_.size(), true), sensor_table[number].fitted});
  const std::pair<PressNumber, const char*> why_held[] = {
      {young_number, "no press has both depth and force, and a softer rubber reads as smaller gains"},
      {poisson_number, "not asked for"},
      {thickness_number, pads() ? "not asked for" : "it and sensor.poisson change frames nearly alike, so measure it"}};
  for (const auto& [number, why] : why_held)
    if (std::ranges::find(fitted, number) == fitted.end())
      result_.held.push_back(fmt::format("{} is held: {}", sensor_table[number].label, why));
  for (std::size_t i = 0; i < presses_.size(); ++i) {
    const double mu = nominal_friction(i);
    if (options_.friction_deviation == 0 || !readings_.press_used[i] || !(mu > 0 && std::isfinite(mu))) continue;
    std::vector<bool> press(presses_.size(), false);
    press[i] = true;
    numbers_.push_back({friction_number, std::move(press), "friction of " + presses_[i].name});
  }
}

/// Levenberg-Marquardt on the fitted numbers; each channel is fitted to their frames. Returns whether it converged.
bool Fit::iterate() {
  Stack current = stack(numbers_);
  const auto fit_channels = [&] {
    readings_.reweight(current.frame, current.P);
    readings_.fit_channels(current.frame, true, result_.faults);
  };
  readings_.fit_channels(current.frame, true, result_.faults);
  if (numbers_.empty()) return fit_channels(), true;
  double damping = 1e-3;
  for (; result_.iterations < options_.most_iterations; ++result_.iterations) {
    fit_channels();
    const Equations equations = normal_equations(current);
    const double before = cost(current);
    bool converged = false;
    for (;; damping *= 10) {
      if (damping > most_damping) return false;
      MatrixXd damped = equations.H;
      damped.diagonal() *= 1 + damping;
      const VectorXd step = damped.ldlt().solve(equations.g);
      converged = (step.array() * equations.H.diagonal().array().sqrt()).abs().maxCoeff() < converged_step;
      const FitState last = std::exchange(state_, moved(step));
      const std::vector<Channel> channels = readings_.channels;
      Stack next = stack(numbers_);
      readings_.fit_channels(next.frame, false, result_.faults);
      if (converged || cost(next) <= before) {
        current = std::move(next);
        break;
      }
      state_ = last;
      readings_.channels = channels;
    }
    if (converged) return fit_channels(), true;
    damping = std::max(damping / 10, least_damping);
  }
  return false;
}

/// The part of cost() that a press's friction changes, all else held.
double Fit::cost_of_friction(std::size_t press, double mu) const {
  const PressFrames frames = models_[press]->at(state_.sensor, mu);
  const auto rows = readings_.rows(press);
  return friction_cost(press, mu) +
         readings_.squares(press, frames.frame + model_error_.frame(rows, Eigen::all), frames.P + model_error_.P(rows));
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
void Fit::report_numbers(const Equations& all, const MatrixXd& covariance) {
  for (int number = 0; number < sensor_numbers; ++number) {
    const double value = state_.sensor.*sensor_table[number].member;
    (result_.*found_numbers[number]).value = sensor_table[number].logarithm ? std::exp(value) : value;
  }
  for (const double friction : state_.friction) result_.friction.push_back({friction, 0});
  std::string hardly_sliding;
  const auto size = static_cast<Index>(numbers_.size());
  result_.correlation = MatrixXd::Identity(size, size);
  for (Index k = 0; k < size; ++k) {
    const Unknown& unknown = numbers_[static_cast<std::size_t>(k)];
    double deviation = std::sqrt(covariance(k, k));
    if (const auto press = unknown.friction_press()) {
      const double before_fit = friction_deviation(*press);
      deviation = std::min(before_fit, deviation * friction_spread(*press, 1 / std::sqrt(all.alone[k])));
      result_.friction[*press].deviation = deviation;
      if (deviation > not_told * before_fit)
        hardly_sliding += (hardly_sliding.empty() ? "" : ", ") + presses_[*press].name;
    } else {
      Fitted& found = result_.*found_numbers[unknown.number];
      found.deviation = deviation * (sensor_table[unknown.number].logarithm ? found.value : 1);
      if (unknown.number == time_constant_number && deviation > 0.5)
        result_.held.emplace_back(
            "transducer.time_constant is not told: readings decay too little within these presses");
    }
    result_.fitted.push_back(unknown.name);
    for (Index j = 0; j < k; ++j) {
      const double rho = covariance(k, j) / std::sqrt(covariance(k, k) * covariance(j, j));
      result_.correlation(k, j) = result_.correlation(j, k) = rho;
      if (std::abs(rho) > degenerate)
        result_.held.push_back(fmt::format("{} and {} are not told apart (correlation {:.3f}): hold one of them",
                                           result_.fitted[static_cast<std::size_t>(j)], unknown.name, rho));
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
    Fitted& gain = result_.gain.emplace_back(Fitted{nan, nan});
    Fitted& offset = result_.offset.emplace_back(Fitted{nan, nan});
    if (!channel.used) continue;
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
    gain = {1 / s, std::sqrt(total(1, 1)) / (s * s)};
    offset = {channel.offset, std::sqrt(total(0, 0))};
  }
}

/// Numbers that the fit holds: those that may be what does not fit, and the loads of presses by force.
std::vector<Unknown> Fit::held_numbers() const {
  std::vector<Unknown> all;
  /// Adds a number of those used presses whose scenes have it.
  const auto add = [&](PressNumber number, const std::string& name, const std::string& unit, double value,
                       const auto& has_it) {
    std::vector<bool> presses = readings_.press_used;
    for (std::size_t i = 0; i < presses.size(); ++i) presses[i] = presses[i] && has_it(presses_[i].scene);
    if (std::ranges::find(presses, true) != presses.end())
      all.push_back({number, std::move(presses), name, unit, value});
  };
  const auto every = [](const AnyScene&) { return true; };
  const auto along = [&](const char* name, const char* axis) { return pads() ? std::string(name) + axis : name; };
  if (!options_.fit_thickness) add(thickness_number, "sensor.thickness", " mm", state_.sensor.thickness, every);
  if (!options_.fit_shift) {
    add(shift_number, along("shift of the tactels", " along x"), " mm", state_.sensor.shift, every);
    if (pads()) add(shift_y_number, "shift of the tactels along y", " mm", state_.sensor.shift_y, every);
  }
  add(tilt_number, along("tilt of the indenters", " along their x"), " degrees", 0, feels_tilt);
  if (pads()) add(tilt_y_number, "tilt of the indenters along their y", " degrees", 0, feels_tilt);
  add(depth_number, "zero of the depth", " mm", 0, [](const AnyScene& scene) { return !by_force(scene); });
  for (std::size_t i = 0; i < presses_.size(); ++i) {
    const AnyScene& scene = presses_[i].scene;
    /// Adds a number that presses share where they are the same, with the first of them.
    const auto add_shared = [&](PressNumber number, const std::string& name, const std::string& unit, double value,
                                const auto& same) {
      const auto is_same = [&](const KnownPress& other) { return same(other.scene, scene); };
      if (std::ranges::none_of(std::span(presses_).first(i), is_same))
        add(number, name, unit, value, [&](const AnyScene& other) { return same(other, scene); });
    };
    const double friction = friction_of(scene);
    if (options_.friction_deviation == 0 && friction > 0 && std::isfinite(friction))
      add_shared(friction_number, "contact.friction", "", friction, same_friction);
    for (int k = shape_number; const ShapeNumber& shape : shape_numbers(scene))
      add_shared(static_cast<PressNumber>(k++), "indenter." + shape.key, shape.unit.empty() ? "" : " " + shape.unit,
                 shape.value, same_shape);
    if (by_force(scene) && readings_.press_used[i]) {
      std::vector<bool> alone(presses_.size(), false);
      alone[i] = true;
      all.push_back({load_number, std::move(alone), "", "", 0, readings_.force_noise});
    }
  }
  return all;
}

/// Where forces scatter by more than their noise, that of the fit is theirs.
void Fit::weaken_forces(const Stack& at) {
  double sum = 0, n = -1;
  for (std::size_t i = 0; i < presses_.size(); ++i)
    if (readings_.has_force(i))
      sum +=
          readings_.P_weight[static_cast<Index>(i)] * std::pow(readings_.force_residual(i, at.P(readings_.rows(i))), 2),
          n += 1;
  if (n > 0) readings_.force_noise *= std::sqrt(std::max(1.0, sum / n));
}

/// Of all numbers in the normal equations: the fitted ones, which answer to errors of the held ones, `deviations`.
MatrixXd Fit::covariance(const MatrixXd& H, const VectorXd& deviations) const {
  const auto fitted = static_cast<Index>(numbers_.size()), held = deviations.size();
  MatrixXd alone = MatrixXd::Zero(fitted, fitted);
  if (fitted > 0) alone = H.topLeftCorner(fitted, fitted).ldlt().solve(MatrixXd::Identity(fitted, fitted));
  MatrixXd answer(fitted + held, held);
  answer << -alone * H.topRightCorner(fitted, held), MatrixXd::Identity(held, held);
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

/// Judges each held number alone: by one Newton step, does another value explain more of the residuals than noise and
/// the model's error? That is a sentence in `better`, the largest first, and the step a deviation of the number.
/// Returns the deviations of all held numbers, and of the model's error.
VectorXd Fit::judge(const std::vector<Unknown>& held, const Equations& all, std::vector<std::string>& better) const {
  const auto fitted = static_cast<Index>(numbers_.size()), count = static_cast<Index>(held.size()),
             others = all.H.rows() - fitted, errors = others - count;
  MatrixXd answer = MatrixXd::Zero(fitted, others);
  if (fitted > 0) answer = all.H.topLeftCorner(fitted, fitted).ldlt().solve(all.H.topRightCorner(fitted, others));
  const MatrixXd left = all.H.bottomRightCorner(others, others) - all.H.bottomLeftCorner(others, fitted) * answer;
  const VectorXd slope = all.g.tail(others) - answer.transpose() * all.g.head(fitted);
  VectorXd deviations = VectorXd::Constant(others, model_error_left);
  std::vector<std::pair<double, std::string>> found;
  for (Index j = 0; j < count; ++j) {
    const Unknown& number = held[static_cast<std::size_t>(j)];
    deviations[j] = number.deviation;
    if (number.name.empty() || !(left(j, j) > unjudged * all.H(fitted + j, fitted + j))) continue;
    const double step = slope[j] / left(j, j);
    const double over =
        std::abs(slope[j]) / std::hypot(std::sqrt(left(j, j)), model_error_left * left.row(j).tail(errors).norm());
    if (!(over > misfit_from)) continue;
    deviations[j] = std::abs(step);
    found.emplace_back(
        over,
        fmt::format("{}{}? the readings ask for {:.3g}{}, not {:.3g}{} ({:.0f} standard deviations)", number.name,
                    name_presses(number.presses), number.value + step, number.unit, number.value, number.unit, over));
  }
  std::ranges::sort(found, std::greater());
  for (auto& [over, sentence] : found) better.push_back(std::move(sentence));
  return deviations;
}

SensorCalibration Fit::run() {
  result_.pad = pads(), result_.tactels = readings_.tactels;
  find_constant_and_saturated(readings_, options_, result_.faults);
  find_swapped(readings_, stack().frame, result_.faults);
  choose_numbers();
  iterate();
  find_patches();
  bool settled = iterate();
  find_dead(readings_, stack().frame, result_.faults);
  while (find_wrong_press(readings_, stack().frame, result_.faults)) {
    readings_.weight.setOnes();
    readings_.P_weight.setOnes();
    choose_numbers();
    settled = iterate();
  }
  find_model_error();
  settled = settled && iterate();
  result_.converged = settled;
  const std::vector<Unknown> held = held_numbers();
  std::vector<Unknown> all = numbers_;
  all.insert(all.end(), held.begin(), held.end());
  Stack solved = stack(all);
  append_model_error(solved);
  weaken_forces(solved);
  const Equations equations = normal_equations(solved);
  std::vector<std::string> better;
  const MatrixXd deviations = covariance(equations.H, judge(held, equations, better));
  report_numbers(equations, deviations);
  report_channels(solved, deviations);
  for (std::size_t i = 0; i < presses_.size(); ++i)
    result_.residuals.push_back(readings_.residuals(i, solved.frame(readings_.rows(i), Eigen::all)));
  find_misfit(readings_, solved.frame, options_, better, result_.faults);
  find_wrong_indenter(readings_, solved.frame, options_, result_.faults);
  return result_;
}

}  // namespace

std::vector<PressNumber> fitted_numbers(const CalibrationOptions& options, bool young_told, bool pads) {
  std::vector<PressNumber> all;
  for (const auto& [number, fit] : {std::pair{young_number, young_told},
                                    {poisson_number, options.fit_poisson},
                                    {thickness_number, options.fit_thickness},
                                    {shift_number, options.fit_shift},
                                    {shift_y_number, options.fit_shift && pads},
                                    {time_constant_number, options.fit_time_constant}})
    if (fit) all.push_back(number);
  return all;
}

std::vector<PressNumber> numbers_of(const SensorCalibration& found) {
  std::vector<PressNumber> all{young_number, poisson_number, thickness_number, shift_number};
  if (found.pad) all.push_back(shift_y_number);
  if (std::isfinite(found.time_constant.value)) all.push_back(time_constant_number);
  return all;
}

std::vector<std::string> stress_names(Index channels, Index tactels) {
  if (channels / tactels == 2) return {"normal stress", "shear stress"};
  if (channels / tactels == 3) return {"normal stress", "shear stress along x", "shear stress along y"};
  return {"normal stress"};
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
