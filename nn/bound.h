// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "nn/quantile_heads.h"

namespace tactel::nn {

/// The bound of S of a frame.
struct BoundAnswer {
  float upper = 0;             ///< S is below it, at the bound's level
  float interval[2] = {0, 0};  ///< S is within it, at the same level
  bool unlike = false;         ///< the frame is unlike those of the learning set: the level does not hold
};

/// Conformal corrections of a network's quantiles (Romano, Patterson and Candes 2019), one for each class of what a
/// controller knows of a frame (Mondrian; Vovk, Lindsay, Nouretdinov and Gammerman 2003), and the learning set's
/// frames as a mean and a covariance.
///
/// With n rows of another seed in a class, c is the ceil((n + 1) level)-th smallest S - upper quantile. A new row of
/// the class, exchangeable with those, has S <= upper quantile + c with a probability of at least `level`.
struct Bound {
  /// A tactel is touched where its |normal stress| exceeds this share of the frame's largest.
  static constexpr float touching_share = 0.05f;
  static constexpr std::size_t most_edges = 16;  ///< of a feature
  /// Rows from which a class has a correction of its own: coverage then varies by 1.5 % (standard deviation) at 95 %.
  static constexpr std::size_t own_rows = 200;
  /// Share of the calibration's frames that are not `unlike`.
  static constexpr double known_share = 0.999;

  /// Edges of the classes, ascending, of the number of touched tactels, of the network's S, of the distance between
  /// its quantiles, and of the frame's squared_distance. A value above k edges is in class k of its feature.
  std::vector<float> touching{1.5f, 2.5f, 4.5f, 8.5f, 19.5f};
  std::vector<float> slip_index{0.2f, 0.4f, 0.6f, 0.8f, 0.95f};
  std::vector<float> width{0.02f, 0.05f, 0.1f, 0.2f, 0.4f};
  std::vector<float> distance;  ///< none before a calibration, and in files of the first version
  /// [classes] added to the upper quantile, and to both ends of the interval; touching slowest, distance fastest.
  std::vector<float> upper_correction, interval_correction;

  int tactels = 0;             ///< normal stresses that a scaled frame begins with, of the newest frame
  Vector<float> centre;        ///< [inputs] mean scaled frame of the learning set
  RowMatrix<float> whitening;  ///< [inputs, inputs] (scaled - centre) * whitening has unit covariance
  float unlike_above = 0;      ///< squared length of that product above which a frame is unlike the learning set;
                               ///< the largest float before a calibration

  double level = 0.95;
  std::string set;         ///< that the bound was calibrated on; empty: it was not
  double least = 0;        ///< share of every kind of row that raise() aimed at; 0: of none
  std::string left_out;    ///< sets of families that a network did not learn, which widened the bound, by commas
  std::uint64_t rows = 0;  ///< of that set
  std::uint64_t seed = 0;  ///< of that set

  bool calibrated() const { return rows > 0; }
  std::size_t classes() const {
    return (touching.size() + 1) * (slip_index.size() + 1) * (width.size() + 1) * (distance.size() + 1);
  }
  std::size_t class_of(int touching_tactels, const Quantiles<float>& quantiles, float squared_distance) const;
  void validate(int inputs) const;  ///< throws ValueError, keys "bound. ..."
};

/// Returns a bound without corrections for a learning set's scaled frames [rows, inputs], which begin with the normal
/// stresses of `tactels`. Their covariance is taken
/// with a noise of 0.1 % of the divisor on every input, so that a direction in which noiseless frames never vary does
/// not make every real frame unlike them.
Bound uncalibrated_bound(const RowMatrix<float>& scaled, int tactels);

/// Returns the number of touched tactels of a scaled frame.
int touching_tactels(const float* scaled, int tactels);
/// Returns |(scaled - centre) * whitening|^2; infinity where it overflows.
float squared_distance(const Bound& bound, const float* scaled);
/// Returns the bound of a frame; NaN where the quantiles are. scaled: [inputs].
BoundAnswer bounded(const Bound& bound, const Quantiles<float>& quantiles, const float* scaled);

/// Returns the ceil((n + 1) level)-th smallest of n scores. Throws ValueError, key "rows", where n is so small that
/// this exceeds n.
double conformal_quantile(std::vector<double> scores, double level);
/// Returns the fewest scores of which conformal_quantile exists: 19 at 95 %.
std::size_t fewest_scores(double level);

/// A row to calibrate by.
struct CalibrationRow {
  Quantiles<float> quantiles;
  float slip_index = 0;  ///< true
  const float* scaled = nullptr;
};

/// Outcome of a calibration.
struct Calibration {
  std::size_t rows = 0, own_classes = 0, classes = 0;  ///< own_classes: with a correction of their own
  bool known = false;                                  ///< enough rows for unlike_above; else it stays as it was
  double least = 0;                                    ///< smallest share of a kind, after raise(); 0: not raised
};

/// Gives a bound the classes of today: the edges of a new one, and those of the distance at 60, 86, 94 and 98 % of the
/// rows' distances, where the rows suffice for unlike_above. The corrections become 0.
void renew_classes(Bound& bound, std::span<const CalibrationRow> rows);

/// Calibrates a bound anew: its corrections, at `level`, and unlike_above. A class of fewer than own_rows rows takes
/// the correction of all rows of its touching, width and distance, or of its touching, or of all. Throws ValueError as
/// conformal_quantile.
Calibration calibrate(Bound& bound, std::span<const CalibrationRow> rows, double level);

/// Raises the corrections of a calibrated bound until `least` of the rows of each kind lie below the bound, and within
/// the interval; a controller does not know the kinds. Rows of a kind that has too few weigh more in the quantile of
/// their class, which stays at the bound's level; no correction becomes smaller. kinds: [kinds] places among `rows`;
/// those of fewer than own_rows are left out. Returns the smallest share of a kind: less than `least` where few classes
/// cannot serve all kinds.
double raise(Bound& bound, std::span<const CalibrationRow> rows, std::span<const std::vector<std::uint32_t>> kinds,
             double least);

/// Widens a bound to the corrections of `other`, class by class, where these are larger. Both have the same classes.
void widen(Bound& bound, const Bound& other);

}  // namespace tactel::nn
