// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "nn/frame_history.h"
#include "nn/input_scaling.h"
#include "nn/philox.h"
#include "nn/weights.h"

namespace tactel::nn {

/// Frames with their answers: a learning set or a recall set. A row is one load step of one contact.
struct FrameSet {
  RowMatrix<float> frames;                   ///< [rows, history * axes tactels] MPa: normal stresses first, then shear
  Vector<float> slip_index;                  ///< [rows] S = Q / (mu P)
  std::vector<std::uint16_t> shape_class;    ///< [rows] or empty: kind of indenter
  std::vector<std::int32_t> contact_nodes;   ///< [rows] or empty: surface nodes that touch; of pads touched tactels
  std::vector<std::uint8_t> torque{};        ///< [rows] or empty, of pads: class of torque_class
  std::vector<std::uint64_t> contact{};      ///< [rows] or empty: which contact; rows of a contact are in its order
  std::vector<std::uint32_t> step{};         ///< [rows] or empty: load step of the contact
  std::vector<float> friction{};             ///< [rows] or empty: mu
  std::vector<float> slip{};                 ///< [rows] or empty: S, which rests are chosen by
  std::vector<std::array<float, 2>> slid{};  ///< [rows] or empty: slide since first touch over the elastic limit, x, y
  bool press_rows = false;                   ///< the rows of a contact begin with its pressing
  int history = 1;                           ///< frames in a row of `frames`, the newest first (with_history)
  int told = 0;                              ///< numbers behind these frames that are no stresses (with_history)
  int axes = 2;                              ///< stresses of a tactel; of a pad 3, or 1
  int columns = 0;                           ///< tactels along x; 0: not known
  bool square = false;                       ///< the tactels of a pad lie along x as along y
  bool markers = false;                      ///< `frames` are of markers (InputScaling::markers)

  static constexpr float largest_slip_index = 1e3f;  ///< more is an error of the set

  Eigen::Index rows() const { return frames.rows(); }
  Eigen::Index stresses() const { return frames.cols() - told; }  ///< of a row
  float largest_stress() const;                                   ///< MPa, over all rows; 0 for an empty set
  /// Throws ValueError, keys "inputs[row]", "slip_index[row]", ..., for values that cannot train or judge a
  /// network.
  void validate() const;
};

/// Returns the scaling for this learning set. Throws ValueError, keys "scaling" and "features", where they do not fit
/// the set.
InputScaling fit_scaling(ScalingKind kind, const FrameSet& set, Features features = Features::frame);

/// Returns the largest |normal stress| of each row's newest frame [rows] MPa.
std::vector<float> peaks(const FrameSet& set);
/// Returns the ranges of a set that a network learns from.
Learnt learnt_ranges(const FrameSet& set);

/// Returns a noise-added copy, as the paper's learning sets (section V.B): each stress plus Gaussian noise with a
/// standard deviation of `fraction` of the set's largest |stress|. The noise is drawn once: the paper speaks of
/// noise-added sets, and a network may be judged on its own learning set. Value i = row * inputs + k is normal
/// number i % 4 of noise_words(seed, i / 4) by Box and Muller (1958).
FrameSet with_noise(const FrameSet& set, double fraction, std::uint64_t seed);

/// Returns `copies` noisy copies of a set, one after the other: each stress plus Gaussian noise with a standard
/// deviation of `fraction` of its own frame's largest |stress|. No two copies share their noise: a network that is
/// shown each copy once meets noise drawn anew at each showing. Value i of the result takes the normal number of
/// with_noise.
FrameSet with_frame_noise(const FrameSet& set, double fraction, std::uint64_t seed, int copies);

/// Returns the set with inputs of `history.frames` frames, [rows, frames * 2 tactels], formed by FrameHistory over the
/// rows in their order. A contact begins where `contact` changes, and where `step` does not follow the step before it:
/// the steps between had no P, or were not solved. A set with one frame in an input, and a history of one frame, stay
/// as they are. Throws ValueError, key "history", for a set without contact, step or the rows of its pressing.
///
/// With a rest, each row has the frame of an earlier row of its contact behind them, as a grip may rest at any load: by
/// the first of noise_words(contact, step) one of those with |S| < most_slip_at_rest and half to twice its P; its own
/// frame where there is none. Where the set has `slid`, `slip_index` becomes slid_target of its change since that
/// row. Throws ValueError, key "scaling", for a set without contact, step or S.
///
/// With friction, each row ends with mu and its relative deviation as told: mu exp(spread n), n a normal number.
/// `spread`: that of all rows, infinity where nothing is told; none: a row is told nothing in one of four cases, else
/// the logarithm of its spread lies evenly between those of least_told and most_told, all by noise_words(contact,
/// step). Throws ValueError, key "friction", for a set without contact, step or friction.
FrameSet with_history(const FrameSet& set, const InputHistory& history, std::optional<double> spread = {});
inline constexpr float most_slip_at_rest = 0.9f;
inline constexpr double least_told = 0.02, most_told = 1;

/// Returns the target of a slide of this distance over the elastic limit.
inline float slid_target(float distance) { return distance / (1 + distance); }

/// Replaces every frame behind the newest by its difference to the newest. frames: [rows, history * 2 tactels].
void take_differences(RowMatrix<float>& frames, int history);

/// Returns the weights that give for frames what `weights` give for their differences (take_differences): the newest
/// frame's weights less those of all differences. `history`: frames in an input.
template <class Scalar>
Weights<Scalar> weights_of_frames(const Weights<Scalar>& weights, int history) {
  Weights<Scalar> folded = weights;
  auto first = folded.layer(0);
  const Eigen::Index width = weights.topology.inputs() / history;
  for (int k = 1; k < history; ++k) first.leftCols(width) -= weights.layer(0).middleCols(k * width, width);
  return folded;
}

/// Scaled inputs, and targets in the output range of a network.
template <class Scalar>
struct TrainingSet {
  RowMatrix<Scalar> inputs;  ///< [rows, inputs] scaled
  Vector<Scalar> target;     ///< [rows] S - 0.5
};

/// Returns S - 0.5 of every row.
template <class Scalar>
Vector<Scalar> targets(const FrameSet& set) {
  return set.slip_index.template cast<Scalar>().array() - Scalar(0.5);
}

/// Throws ValueError as FrameSet::validate.
template <class Scalar>
TrainingSet<Scalar> training_set(const FrameSet& set, const InputScaling& scaling) {
  set.validate();
  scaling.validate();
  return {scale_frames<Scalar>(scaling, set.frames), targets<Scalar>(set)};
}

/// Returns the words of values 4 quad ... 4 quad + 3 of a set's noise (with_noise). The low half of `quad` is the
/// first word of the counter, the high half the second. No two values of a set therefore share their words; sets
/// below 2^34 values keep the words of earlier versions.
constexpr PhiloxCounter noise_words(std::uint64_t seed, std::uint64_t quad) {
  return random_words(seed, RandomStream::noise, static_cast<std::uint32_t>(quad),
                      static_cast<std::uint32_t>(quad >> 32));
}

/// Adds Gaussian noise of the standard deviation `deviation` to consecutive values of a set, the first of which is
/// value `first`. Value i takes normal number i % 4 of noise_words(seed, i / 4) by Box and Muller (1958).
void add_noise(std::span<float> values, double deviation, std::uint64_t seed, std::uint64_t first);
/// The same of what a camera sees of a step of a contact, in the numbers of that contact.
void add_pixel_noise(std::span<float> pixels, double deviation, std::uint64_t seed, std::uint64_t contact,
                     std::uint32_t step);

}  // namespace tactel::nn
