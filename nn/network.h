// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "nn/frame_history.h"
#include "nn/topology.h"

// A network as its file holds it. The standard library alone: tactel::infer takes it, too.
namespace tactel::nn {

/// The weights of one network, or anything of the same shape (steps of the momentum, gradients).
template <class Scalar>
struct Weights {
  explicit Weights(const Topology& topology) : topology(topology), values(topology.weight_count(), Scalar(0)) {}
  template <class Other>
  explicit Weights(const Weights<Other>& other)
      : topology(other.topology), values(other.values.begin(), other.values.end()) {}

  /// [out, in + 1] as a matrix of Eigen: the bias in the last column (nn/weights.h).
  auto layer(int l);
  auto layer(int l) const;

  Topology topology;
  std::vector<Scalar> values;  ///< [layer][out][in + 1]
};

/// Divisor of a frame in MPa, applied before the network; part of the network's file. `set`: the largest |stress|
/// of the learning set (the paper's). `frame`: the frame's own largest |normal stress|, so that S does not depend
/// on E or on a common factor of all stresses. `rest`: the sum P of the normal stresses of the input's last frame, the
/// grip at rest (InputHistory::rest); the other frames become their differences to it.
enum class ScalingKind { set, frame, rest };

const char* name(ScalingKind kind);
/// Returns the kind named "set", "frame" or "rest". Throws ValueError, key "scaling".
ScalingKind parse_scaling(std::string_view text);

/// A fixed layer between scaled frames and the network (nn/features.h). `frame`: none. `line` and `pad`: all images of
/// a frame become one, and sums of it are further inputs.
enum class Features { frame, line, pad };

const char* name(Features features);
/// Returns the layer named "frame", "line" or "pad". Throws ValueError, key "features".
Features parse_features(std::string_view text);

/// What becomes of the stresses of an input, frames in MPa, before the network; part of the network's file.
struct InputScaling {
  ScalingKind kind = ScalingKind::set;
  float largest_stress = 1.0f;  ///< MPa, > 0: the divisor of `set`; unused by `frame`
  int history = 1;              ///< frames in an input; `frame` divides all of them by the newest's, which is the
                                ///< first; of `rest` 2 or more
  int axes = 2;                 ///< stresses of a tactel; of a pad 3, or 1
  Features features = Features::frame;
  int columns = 0;            ///< of features: tactels along x
  bool square = false;        ///< of features: the pad's tactels lie along x as along y
  float usual_stress = 1.0f;  ///< MPa, > 0: an input of features is peak / (peak + usual_stress), of the newest frame;
                              ///< not of `rest`
  bool friction = false;      ///< behind the stresses an input has mu and its spread as told (InputHistory::friction)
  bool markers = false;       ///< in the place of stresses in MPa a frame has x and y of every marker, mm

  /// MPa: below it, a normal stress counts as none. A frame without larger ones carries no stress (`frame`), nor does
  /// one whose rest has a smaller P (`rest`).
  static constexpr float smallest_stress = 1e-12f;
  /// MPa: the reciprocal of more is no normal number in fp32. No learning set may hold more (`set`); a frame with more
  /// is first taken times large_scale (`frame`), which keeps its bits.
  static constexpr float large_stress = 0x1p126f, large_scale = 0x1p-8f;
  /// `rest` takes all stresses times this, which keeps their bits and the sum of finite ones within 2^126.
  static constexpr float rest_scale = 0x1p-10f;
  bool operator==(const InputScaling&) const = default;
  /// Returns the frames that the network sees: of `rest` the differences.
  int shown() const { return kind == ScalingKind::rest ? history - 1 : history; }
  /// Returns whether the peak is an input.
  bool has_peak() const { return features != Features::frame && kind != ScalingKind::rest; }
  /// Returns the numbers of an input that are told.
  int told() const { return friction ? 2 : 0; }
  /// Returns how many sums the features add for each frame.
  int sums() const { return features == Features::pad ? 17 : features == Features::line ? 8 : 0; }
  /// Returns the network's inputs for so many numbers: the stresses of all frames of an input and what is told; and
  /// those numbers.
  int inputs(int numbers) const { return width(numbers) * shown() + shown() * sums() + has_peak() + told(); }
  int numbers(int inputs) const {
    const int frames = shown() > 0 ? shown() : 1;  // of a scaling that validate() refuses there may be none
    return (inputs - told() - frames * sums() - has_peak()) / frames * history + told();
  }
  /// Returns the stresses of a frame.
  int width(int numbers) const { return (numbers - told()) / history; }
  /// Returns the normal stresses of the newest frame, with which an input begins.
  int normals(int numbers) const { return width(numbers) / axes; }
  void validate() const;  ///< throws ValueError, key "scaling"
};

/// What a network estimates: a column of its learning set.
/// Those of a slide are D / (1 + D) of a distance D over the contact's elastic limit (definition()).
enum class Target { slip_index, force_ratio, stick_fraction, slid, slip_path, net_slip, slid_ahead };

inline bool is_slide(Target target) { return target >= Target::slid; }
inline constexpr const char* slide_names = "slid, slip_path, net_slip or slid_ahead";
/// Returns what the distance of a slide is, as files of networks state it; empty of other targets.
const char* definition(Target target);

/// Returns the name of the column, which is also that of the output in the network's file.
const char* name(Target target);
/// Returns the target of that name. Throws ValueError, key "target".
Target parse_target(std::string_view text);

/// Absolute errors of S over some rows, as in Table II of the paper.
struct ErrorSummary {
  std::size_t count = 0;  ///< rows that have an error: status ok or no stress
  double max = 0;
  double mean = 0;
  double std = 0;  ///< standard deviation of the absolute error over these rows (division by count)
};

/// Quantiles of S that a network with three outputs estimates (nn/quantile_heads.h).
template <class Scalar>
struct Quantiles {
  Scalar median, upper, lower;
};

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
  std::vector<float> distance;  ///< none before a calibration, or one of few rows
  /// [classes] added to the upper quantile, and to both ends of the interval; touching slowest, distance fastest.
  std::vector<float> upper_correction, interval_correction;

  int tactels = 0;               ///< normal stresses that a scaled frame begins with, of the newest frame
  std::vector<float> centre;     ///< [inputs] mean scaled frame of the learning set
  std::vector<float> whitening;  ///< [inputs, inputs] (scaled - centre) * whitening has unit covariance
  float unlike_above = 0;        ///< squared length of that product above which a frame is unlike the learning set;
                                 ///< the largest float before a calibration

  double level = 0.95;
  std::string set;         ///< that the bound was calibrated on; empty: it was not
  std::uint64_t rows = 0;  ///< of that set
  std::uint64_t seed = 0;  ///< of that set

  bool calibrated() const { return rows > 0; }
  std::size_t classes() const {
    return (touching.size() + 1) * (slip_index.size() + 1) * (width.size() + 1) * (distance.size() + 1);
  }
  std::size_t class_of(int touching_tactels, const Quantiles<float>& quantiles, float squared_distance) const noexcept;
  /// Returns the bound of a frame; NaN where the quantiles are.
  BoundAnswer answer(int touching_tactels, const Quantiles<float>& quantiles, float squared_distance) const noexcept;
  void validate(int inputs) const;  ///< throws ValueError, keys "bound. ..."
};

/// Ranges of what a network learnt; of a stream of its first block. 0: not known.
struct Learnt {
  /// MPa, of the largest |normal stress| of a frame: 1 % of the rows with any were below the first, none above the
  /// second.
  float smallest_peak = 0, largest_peak = 0;
  float least_friction = 0, most_friction = 0;  ///< mu
  float alarm_at = 0;                           ///< of a slide: threshold of an alarm, as the user gave it

  /// Returns whether one of the normal stresses [count] MPa is far beyond all that was learnt. A set of other shapes
  /// and depths has peaks of a few times; another unit is at least 1000 times. NaN is not.
  bool beyond(const float* normals, int count) const noexcept {
    bool found = false;
    for (int k = 0; k < count; ++k) found |= largest_peak > 0 && std::abs(normals[k]) > beyond_times * largest_peak;
    return found;
  }
  static constexpr float beyond_times = 10;
};

/// A network with its scaling and origin: the contents of a model file. scaling.history equals history.frames.
struct Model {
  Weights<float> weights;
  InputScaling scaling;
  std::uint64_t seed = 0;              ///< of initial weights, order and noise
  double noise = 0;                    ///< fraction of the largest stress
  std::string learning_set;            ///< name of the learning set, as the user gave it
  std::uint32_t cycles = 0;            ///< cycles or epochs of its training
  ErrorSummary learning_errors;        ///< on its learning set
  InputHistory history{};              ///< which earlier frames its input has
  bool magnitude = false;              ///< its answer is |S|: it learnt from drags to both sides
  Target target = Target::slip_index;  ///< its answer; S stands for it in the comments
  std::optional<Bound> bound{};        ///< of a network with the heads of a bound
  Learnt learnt{};

  /// Returns the numbers of an input: the stresses of all its frames, and what is told of friction.
  int numbers() const { return scaling.numbers(weights.topology.inputs()); }
};

}  // namespace tactel::nn
