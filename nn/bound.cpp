// SPDX-License-Identifier: Apache-2.0
#include "nn/bound.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "fem/numbers/value_error.h"

namespace tactel::nn {
namespace {

constexpr double least_deviation = 1e-3;                       // of a scaled input
constexpr double distance_shares[] = {0.6, 0.86, 0.94, 0.98};  // of the rows, up to the edges of the distance

// No smaller than `value`, so that a correction keeps its rank.
float rounded_up(double value) {
  const auto near = static_cast<float>(value);
  return near < value ? std::nextafter(near, std::numeric_limits<float>::infinity()) : near;
}

std::size_t rank(std::size_t scores, double level) {
  return static_cast<std::size_t>(std::ceil(static_cast<double>(scores + 1) * level - 1e-9));  // 20 * 0.95 is 19
}

double upper_score(const CalibrationRow& row) { return double(row.slip_index) - double(row.quantiles.upper); }
double interval_score(const CalibrationRow& row) {
  return std::max(upper_score(row), double(row.quantiles.lower) - double(row.slip_index));
}

/// Scores of the rows of a group of classes.
struct Scores {
  std::vector<double> upper, interval;
  void add(const CalibrationRow& row) {
    upper.push_back(upper_score(row));
    interval.push_back(interval_score(row));
  }
};

/// Groups of ever more classes: the class, those of its touching, width and distance, those of its touching, all.
constexpr std::size_t widest_group = 3;
std::array<std::size_t, widest_group + 1> groups_of(const Bound& bound, std::size_t which) {
  const std::size_t inner = (bound.width.size() + 1) * (bound.distance.size() + 1);  // classes of one touching and S
  const std::size_t touching = which / inner / (bound.slip_index.size() + 1);
  return {which, touching * inner + which % inner, touching, 0};
}

std::size_t class_of(const Bound& bound, const CalibrationRow& row, float squared_distance) {
  return bound.class_of(touching_tactels(row.scaled, bound.tactels), row.quantiles, squared_distance);
}

}  // namespace

Bound uncalibrated_bound(const RowMatrix<float>& scaled, int tactels) {
  Bound bound;
  bound.tactels = tactels;
  bound.upper_correction.assign(bound.classes(), 0.0f);
  bound.interval_correction = bound.upper_correction;
  bound.unlike_above = std::numeric_limits<float>::max();
  const Eigen::Index inputs = scaled.cols();
  const Vector<double> mean = scaled.cast<double>().colwise().mean().transpose();
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Identity(inputs, inputs) * (least_deviation * least_deviation);
  constexpr Eigen::Index some = 4096;  // rows at a time, for memory's sake
  for (Eigen::Index row = 0; row < scaled.rows(); row += some) {
    const Eigen::Index count = std::min(some, scaled.rows() - row);
    const Eigen::MatrixXd centred = scaled.middleRows(row, count).cast<double>().rowwise() - mean.transpose();
    covariance += centred.transpose() * centred / static_cast<double>(scaled.rows());
  }
  const Eigen::MatrixXd inverse =
      covariance.llt().matrixL().solve(Eigen::MatrixXd::Identity(inputs, inputs));  // L^-1, covariance = L L^T
  bound.centre.resize(static_cast<std::size_t>(inputs));
  bound.whitening.resize(bound.centre.size() * bound.centre.size());
  Eigen::Map<Vector<float>>(bound.centre.data(), inputs) = mean.cast<float>();
  Eigen::Map<RowMatrix<float>>(bound.whitening.data(), inputs, inputs) = inverse.transpose().cast<float>();
  return bound;
}

int touching_tactels(const float* scaled, int tactels) {
  float largest = 0;
  for (int k = 0; k < tactels; ++k) largest = std::max(largest, std::abs(scaled[k]));
  const float least = Bound::touching_share * largest;
  return static_cast<int>(std::count_if(scaled, scaled + tactels, [least](float x) { return std::abs(x) > least; }));
}

float squared_distance(const Bound& bound, const float* scaled) {
  const auto inputs = static_cast<Eigen::Index>(bound.centre.size());
  float sum = 0;
  constexpr Eigen::Index some = 64;  // of the product at a time
  for (Eigen::Index first = 0; first < inputs; first += some) {
    const Eigen::Index count = std::min(some, inputs - first);
    float product[some] = {};
    const float* row = bound.whitening.data() + first;
    for (Eigen::Index j = 0; j < inputs; ++j, row += inputs) {
      const float x = scaled[j] - bound.centre[static_cast<std::size_t>(j)];
      for (Eigen::Index i = 0; i < count; ++i) product[i] += x * row[i];
    }
    for (Eigen::Index i = 0; i < count; ++i) sum += product[i] * product[i];
  }
  return std::isnan(sum) ? std::numeric_limits<float>::infinity() : sum;  // infinity less infinity
}

BoundAnswer bounded(const Bound& bound, const Quantiles<float>& quantiles, const float* scaled) {
  return bound.answer(touching_tactels(scaled, bound.tactels), quantiles, squared_distance(bound, scaled));
}

std::size_t fewest_scores(double level) {
  std::size_t scores = 1;
  while (rank(scores, level) > scores) ++scores;
  return scores;
}

double conformal_quantile(std::vector<double> scores, double level) {
  const std::size_t which = rank(scores.size(), level);
  if (which > scores.size())
    throw ValueError("rows", std::to_string(scores.size()),
                     "at least " + std::to_string(fewest_scores(level)) + " for a level of " + std::to_string(level));
  const auto place = scores.begin() + static_cast<std::ptrdiff_t>(which - 1);
  std::nth_element(scores.begin(), place, scores.end());
  return *place;
}

void renew_classes(Bound& bound, std::span<const CalibrationRow> rows) {
  const Bound today;
  bound.touching = today.touching;
  bound.slip_index = today.slip_index;
  bound.width = today.width;
  bound.distance.clear();
  if (rows.size() >= fewest_scores(Bound::known_share)) {
    std::vector<double> distances;
    distances.reserve(rows.size());
    for (const CalibrationRow& row : rows) distances.push_back(squared_distance(bound, row.scaled));
    for (const double share : distance_shares) {
      const float edge = rounded_up(conformal_quantile(distances, share));
      if (std::isfinite(edge) && (bound.distance.empty() || edge > bound.distance.back()))
        bound.distance.push_back(edge);
    }
  }
  bound.upper_correction.assign(bound.classes(), 0.0f);
  bound.interval_correction = bound.upper_correction;
}

Calibration calibrate(Bound& bound, std::span<const CalibrationRow> rows, double level) {
  const std::size_t classes = bound.classes();
  std::array<std::vector<Scores>, widest_group + 1> groups;
  for (auto& group : groups) group.resize(classes);
  std::vector<double> distances;
  distances.reserve(rows.size());
  for (const CalibrationRow& row : rows) {
    const float distance = squared_distance(bound, row.scaled);
    const auto places = groups_of(bound, class_of(bound, row, distance));
    for (std::size_t g = 0; g <= widest_group; ++g) groups[g][places[g]].add(row);
    distances.push_back(distance);
  }
  Calibration report{.rows = rows.size(), .classes = classes};
  Bound renewed = bound;
  for (std::size_t which = 0; which < classes; ++which) {
    const auto places = groups_of(bound, which);
    const std::size_t least = std::max(Bound::own_rows, fewest_scores(level));
    std::size_t g = 0;
    while (g < widest_group && groups[g][places[g]].upper.size() < least) ++g;
    report.own_classes += g == 0;
    renewed.upper_correction[which] = rounded_up(conformal_quantile(groups[g][places[g]].upper, level));
    renewed.interval_correction[which] = rounded_up(conformal_quantile(groups[g][places[g]].interval, level));
  }
  report.known = rows.size() >= fewest_scores(Bound::known_share);
  if (report.known) renewed.unlike_above = rounded_up(conformal_quantile(std::move(distances), Bound::known_share));
  renewed.level = level;
  renewed.rows = rows.size();
  bound = std::move(renewed);
  return report;
}

}  // namespace tactel::nn
