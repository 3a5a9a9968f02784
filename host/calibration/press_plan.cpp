// SPDX-License-Identifier: Apache-2.0
#include "host/calibration/press_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "fem/value_error.h"
#include "host/calibration/median.h"
#include "host/support/side_by_side.h"

namespace tactel::host {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Set = std::vector<std::size_t>;

constexpr double none = std::numeric_limits<double>::quiet_NaN();
/// Weak information on each unknown, a standard deviation of 10 (no unit, mm): determinants exist before every
/// transducer has been pressed.
constexpr double weak = 0.01;
constexpr double never_found = 0.5;      ///< relative deviation of a gain, with all candidates
constexpr double weight_of_numbers = 4;  ///< beside that of gains: see plan_presses
constexpr double least_exchange = 1e-9;  ///< of the log determinant

/// Sums over the rows of presses, weighted by noise: those of the normal equations of a fit. Parameters of their
/// readings are offset, sensitivity and the numbers: the fitted ones, then the friction of each press.
struct Information {
  MatrixXd sums;     ///< [channels, 3]: of 1, stress, stress^2
  MatrixXd cross;    ///< [channels, 2 numbers]: of 1 and of stress with the numbers
  MatrixXd numbers;  ///< [numbers, numbers] all channels and P

  Information(Index channels, Index size)
      : sums(MatrixXd::Zero(channels, 3)),
        cross(MatrixXd::Zero(channels, 2 * size)),
        numbers(MatrixXd::Zero(size, size)) {}
  Index size() const { return numbers.rows(); }
  bool loads(Index channel) const { return sums(channel, 0) > 0; }
  /// Information on the gain of a channel, and on it with the numbers, [numbers]: the offset eliminated.
  double gain(Index channel) const {
    return weak + sums(channel, 2) - sums(channel, 1) * sums(channel, 1) / sums(channel, 0);
  }
  Eigen::RowVectorXd gain_cross(Index channel) const {
    return cross.row(channel).tail(size()) - sums(channel, 1) / sums(channel, 0) * cross.row(channel).head(size());
  }
};

class Planner {
 public:
  Planner(const fem::SensorFamily& family, const std::vector<PressCandidate>& candidates, const PlanOptions& options);
  PressPlan run();

 private:
  Information information(const PressCandidate& candidate, const PressFrames& frames) const;
  Information total(const Set& set) const;
  MatrixXd eliminated(const Information& sum) const;
  double criterion(const Set& set) const;
  Set choose() const;
  ExpectedDeviations deviations(const Set& set, MatrixXd* correlation = nullptr) const;
  std::vector<std::string> lost(const ExpectedDeviations& all, const MatrixXd& correlation) const;
  Index fitted() const { return static_cast<Index>(numbers_.size()); }
  bool with_friction() const { return options_.fit.friction_deviation > 0; }

  const std::vector<PressCandidate>& candidates_;
  PlanOptions options_;
  VectorXd noise_;  ///< [channels] MPa
  std::vector<PressNumber> numbers_;
  std::vector<Information> information_;  ///< [candidates]
  std::vector<double> P_;                 ///< [candidates] N/mm, the largest
};

Planner::Planner(const fem::SensorFamily& family, const std::vector<PressCandidate>& candidates,
                 const PlanOptions& options)
    : candidates_(candidates), options_(options) {
  options.validate(candidates.size());
  const fem::Sensor& sensor = candidates.front().scene.sensor;
  const Index channels = 2 * sensor.tactels;
  if (options.noise.size() > 0 && options.noise.size() != channels)
    throw ValueError("noise", fmt::format("{} numbers", options.noise.size()), fmt::format("{} numbers", channels));
  const auto by_force =
      std::ranges::count_if(candidates, [](const PressCandidate& candidate) { return fem::by_force(candidate.scene); });
  const bool by_depth = by_force < static_cast<std::ptrdiff_t>(candidates.size());
  numbers_ = fitted_numbers(options.fit, by_depth && (options.forces || by_force > 0), false);
  std::vector<PressNumber> asked = numbers_;
  if (with_friction()) asked.push_back(friction_number);
  const SensorState nominal{.log_young = std::log(sensor.young),
                            .poisson = sensor.poisson,
                            .thickness = sensor.thickness,
                            .log_time_constant = std::log(options.fit.time_constant)};
  std::vector<PressFrames> frames(candidates.size());
  side_by_side(candidates.size(), options.threads, [&](std::size_t i) {
    const PressCandidate& candidate = candidates[i];
    if (candidate.scene.sensor.tactels != sensor.tactels)
      throw ValueError("candidates", candidate.indenter, "presses on one sensor");
    try {
      const LinePress model(family, candidate.scene, candidate.timing, nominal, options.fit.elements);
      frames[i] = model.at(nominal, candidate.scene.friction, asked);
    } catch (const fem::PathError&) {  // it tells nothing; lost() names it
    }
  });
  noise_ = options.noise;
  if (noise_.size() == 0) {
    double largest = 0;
    for (const PressFrames& press : frames)
      if (press.frame.size() > 0) largest = std::max(largest, press.frame.cwiseAbs().maxCoeff());
    noise_.setConstant(channels, options.noise_of_largest * largest);
  }
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    information_.push_back(information(candidates[i], frames[i]));
    P_.push_back(frames[i].P.size() > 0 ? frames[i].P.maxCoeff() : none);
  }
}

Information Planner::information(const PressCandidate& candidate, const PressFrames& frames) const {
  const Index channels = noise_.size(), steps = frames.frame.rows(), size = fitted() + 1;
  Information result(channels, size);
  const auto number_of = [&](Index k) {
    return k < fitted() ? numbers_[static_cast<std::size_t>(k)] : friction_number;
  };
  const Index unknowns = with_friction() ? size : fitted();
  MatrixXd by = MatrixXd::Zero(steps, size);
  for (Index c = 0; c < channels; ++c) {
    if (!std::isfinite(noise_[c]) || steps == 0) continue;
    const VectorXd stress = frames.frame.col(c);
    const double weight = 1 / (noise_[c] * noise_[c]);
    for (Index k = 0; k < unknowns; ++k) by.col(k) = frames.frame_by.at(number_of(k)).col(c);
    result.sums.row(c) << static_cast<double>(steps), stress.sum(), stress.squaredNorm();
    result.cross.row(c).head(size) = by.colwise().sum();
    result.cross.row(c).tail(size) = stress.transpose() * by;
    result.sums.row(c) *= weight;
    result.cross.row(c) *= weight;
    result.numbers += weight * by.transpose() * by;
  }
  if (options_.forces) {  // the gauge's error is one for all forces of a press
    VectorXd P_by = VectorXd::Zero(size);
    double n = 0;
    for (Index row = 0; row < steps; ++row) {
      if (!(frames.P[row] > 0)) continue;
      for (Index k = 0; k < unknowns; ++k) P_by[k] += frames.P_by.at(number_of(k))[row] / frames.P[row];
      n += 1;
    }
    result.numbers += P_by * P_by.transpose() / std::pow(std::max(n, 1.0) * options_.fit.force_noise, 2);
  }
  const double friction = options_.fit.friction_deviation * candidate.scene.friction;
  result.numbers(size - 1, size - 1) += friction > 0 && std::isfinite(friction) ? 1 / (friction * friction) : 1;
  return result;
}

Information Planner::total(const Set& set) const {
  const Index m = fitted(), size = m + 1, all = m + (with_friction() ? static_cast<Index>(set.size()) : 0);
  Information sum(noise_.size(), all);
  for (std::size_t i = 0; i < set.size(); ++i) {
    const Information& press = information_[set[i]];
    sum.sums += press.sums;
    for (Index part = 0; part < 2; ++part)
      sum.cross.middleCols(part * all, m) += press.cross.middleCols(part * size, m);
    sum.numbers.topLeftCorner(m, m) += press.numbers.topLeftCorner(m, m);
    if (!with_friction()) continue;
    const Index place = m + static_cast<Index>(i);
    for (Index part = 0; part < 2; ++part) sum.cross.col(part * all + place) = press.cross.col(part * size + m);
    sum.numbers.col(place).head(m) = press.numbers.col(m).head(m);
    sum.numbers.row(place).head(m) = press.numbers.row(m).head(m);
    sum.numbers(place, place) = press.numbers(m, m);
  }
  return sum;
}

/// Information on the numbers, offsets and gains eliminated.
MatrixXd Planner::eliminated(const Information& sum) const {
  MatrixXd H = sum.numbers;
  H.diagonal().array() += weak;
  for (Index c = 0; c < noise_.size(); ++c) {
    if (!sum.loads(c)) continue;
    const auto of_offset = sum.cross.row(c).head(sum.size());
    const Eigen::RowVectorXd of_gain = sum.gain_cross(c);
    H -= of_offset.transpose() * of_offset / sum.sums(c, 0) + of_gain.transpose() * of_gain / sum.gain(c);
  }
  return H;
}

double log_determinant(const MatrixXd& matrix) {
  return matrix.rows() == 0 ? 0 : matrix.ldlt().vectorD().array().abs().log().sum();
}

double Planner::criterion(const Set& set) const {
  const Information sum = total(set);
  double gains = 0, channels = 0;
  for (Index c = 0; c < noise_.size(); ++c)
    if (sum.loads(c)) gains += std::log(sum.gain(c)), channels += 1;
  const MatrixXd H = eliminated(sum);
  const Index friction = sum.size() - fitted();
  const double numbers = log_determinant(H) - log_determinant(H.bottomRightCorner(friction, friction));
  return gains / std::max(channels, 1.0) + weight_of_numbers * numbers / std::max(static_cast<double>(fitted()), 1.0);
}

Set Planner::choose() const {
  Set set;
  std::vector<bool> taken(candidates_.size(), false);
  /// The best candidate for a place of the set, and its criterion.
  const auto best_at = [&](std::size_t place) {
    std::pair<double, std::size_t> best{-std::numeric_limits<double>::infinity(), set[place]};
    const std::size_t kept = set[place];
    for (std::size_t i = 0; i < candidates_.size(); ++i) {
      if (taken[i] && i != kept) continue;
      set[place] = i;
      best = std::max(best, {criterion(set), i});
    }
    set[place] = kept;
    return best;
  };
  const auto exchange = [&](std::size_t place) {
    const double before = criterion(set);
    const auto [after, candidate] = best_at(place);
    if (!(after > before + least_exchange * std::abs(before))) return false;
    taken[set[place]] = false;
    taken[set[place] = candidate] = true;
    return true;
  };
  const auto count = static_cast<std::size_t>(options_.presses);
  while (set.size() < count) {
    const auto first_free = static_cast<std::size_t>(std::ranges::find(taken, false) - taken.begin());
    taken[first_free] = true;
    set.push_back(first_free);
    exchange(set.size() - 1);
  }
  for (bool better = true; better;) {
    better = false;
    for (std::size_t place = 0; place < count; ++place) better |= exchange(place);
  }
  std::ranges::sort(set);
  return set;
}

ExpectedDeviations Planner::deviations(const Set& set, MatrixXd* correlation) const {
  const Information sum = total(set);
  const MatrixXd covariance = eliminated(sum).inverse();
  ExpectedDeviations result;
  std::ranges::fill(result.number, none);
  for (Index k = 0; k < fitted(); ++k)
    result.number[numbers_[static_cast<std::size_t>(k)]] = std::sqrt(covariance(k, k));
  if (correlation != nullptr) {
    const VectorXd scale = covariance.diagonal().head(fitted()).cwiseSqrt().cwiseInverse();
    *correlation = scale.asDiagonal() * covariance.topLeftCorner(fitted(), fitted()) * scale.asDiagonal();
  }
  result.gain.setConstant(noise_.size(), none);
  std::vector<double> kinds[2];
  for (Index c = 0; c < noise_.size(); ++c) {
    if (!sum.loads(c)) continue;
    const Eigen::RowVectorXd by = sum.gain_cross(c) / sum.gain(c);
    result.gain[c] = std::sqrt(1 / sum.gain(c) + by * covariance * by.transpose());
    kinds[c < noise_.size() / 2 ? 0 : 1].push_back(result.gain[c]);
    result.worst_gain = std::max(result.worst_gain, result.gain[c]);
  }
  result.normal_gain = median(std::move(kinds[0])), result.shear_gain = median(std::move(kinds[1]));
  return result;
}

/// What no plan finds, or only badly with all candidates together.
std::vector<std::string> Planner::lost(const ExpectedDeviations& all, const MatrixXd& correlation) const {
  std::vector<std::string> sentences;
  for (std::size_t i = 0; i < candidates_.size(); ++i)
    if (std::isnan(P_[i]))
      sentences.push_back(fmt::format("{} at {:g} mm is no candidate: its contact is not solved.",
                                      candidates_[i].indenter, candidates_[i].scene.indenter.position));
  if (!std::isfinite(all.number[young_number]))
    sentences.emplace_back(
        "No plan finds sensor.young without measured forces: a softer rubber reads as smaller gains. Measure P.");
  if (!options_.fit.fit_thickness)
    sentences.emplace_back(
        "sensor.thickness is held: it and sensor.poisson change frames nearly alike, so measure it.");
  for (Index k = 0; k < fitted(); ++k)
    for (Index j = 0; j < k; ++j)
      if (std::abs(correlation(k, j)) > degenerate)
        sentences.push_back(
            fmt::format("No plan tells {} and {} apart well: with all candidates together their correlation "
                        "is {:.3f}. Hold one of them.",
                        sensor_table[numbers_[static_cast<std::size_t>(j)]].fitted,
                        sensor_table[numbers_[static_cast<std::size_t>(k)]].fitted, correlation(k, j)));
  for (Index c = 0; c < noise_.size(); ++c)
    if (all.gain[c] > never_found)
      sentences.push_back(
          fmt::format("No candidate loads the {} enough: its gain would be known to {:.0f} % with all of "
                      "them. Add presses over it{}.",
                      transducer_name(c, noise_.size(), noise_.size() / 2), 100 * all.gain[c],
                      c < noise_.size() / 2 ? "" : ", with a drag"));
  return sentences;
}

PressPlan Planner::run() {
  PressPlan plan{.chosen = choose(), .P = P_, .noise = noise_};
  plan.planned = deviations(plan.chosen);
  Set every(candidates_.size());
  std::iota(every.begin(), every.end(), 0);
  MatrixXd correlation;
  const ExpectedDeviations all = deviations(every, &correlation);
  plan.lost = lost(all, correlation);
  return plan;
}

}  // namespace

void PlanOptions::validate(std::size_t candidates) const {
  fit.validate();
  const auto check = [](bool good, const char* key, double value, const std::string& allowed) {
    if (!good) throw ValueError(key, fmt::format("{:g}", value), allowed);
  };
  check(presses >= 1 && static_cast<std::size_t>(presses) <= candidates, "presses", presses,
        fmt::format("1 to {}, the number of candidates", candidates));
  check(noise_of_largest > 0 && std::isfinite(noise_of_largest), "noise", noise_of_largest, "a number above 0");
  for (const double value : noise)
    check(std::isnan(value) || (value > 0 && std::isfinite(value)), "noise", value, "numbers of MPa above 0");
}

PressPlan plan_presses(const fem::SensorFamily& family, const std::vector<PressCandidate>& candidates,
                       const PlanOptions& options) {
  return Planner(family, candidates, options).run();
}

}  // namespace tactel::host
