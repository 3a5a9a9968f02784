// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <tactel/infer.h>

#include <algorithm>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "nn/infer/rest_reference.h"
#include "nn/network.h"

namespace tactel::infer {

/// The frames of one sensor as a network's input has them: those of its path by change of load, then the rest of the
/// grip where the network is by the rest, then what is told of friction. Only the constructor allocates.
class SensorFrames {
 public:
  /// touch: MPa, where a normal stress of this size touches; none: the smallest peak that the network learnt.
  SensorFrames(const nn::InputScaling& scaling, const nn::InputHistory& history, const nn::Learnt& learnt, int numbers,
               std::optional<double> touch = {})
      : path_(static_cast<std::size_t>(scaling.width(numbers)), history),
        normals_(static_cast<std::size_t>(scaling.normals(numbers))),
        takes_friction_(scaling.friction),
        touch_(std::max<double>(touch.value_or(learnt.smallest_peak), nn::InputScaling::smallest_stress)) {
    if (history.rest) rest_.emplace(path_.width(), normals_, touch_);
  }

  std::size_t width() const noexcept { return path_.width(); }  ///< numbers of a frame
  /// Takes the newest frame [width] MPa.
  void push(const float* frame) noexcept {
    path_.push(frame);
    if (!rest_) return;
    const std::span<const float> normals(frame, normals_);
    rest_->next({frame, width()}, std::ranges::any_of(normals, [&](float s) { return std::abs(s) >= touch_; }));
  }
  /// Writes the input: [frames][width] MPa, whose rest is zeros until one is found, and what is told.
  void write(float* input) const noexcept {
    path_.write(input);
    input += path_.inputs();
    if (rest_) rest_->write(input), input += width();
    if (takes_friction_) input[0] = friction_, input[1] = spread_;
  }
  /// Tells mu, 0: it is not known, and its relative deviation.
  void friction(float mu, float spread) noexcept { friction_ = mu, spread_ = spread; }
  /// Seeks the rest anew from the next frame on.
  void rest() noexcept {
    if (rest_) rest_->forget();
  }
  /// Forgets all frames: the next one begins a contact.
  void clear() noexcept { path_.clear(), rest(); }

 private:
  nn::FrameHistory path_;
  std::size_t normals_;
  bool takes_friction_;
  float friction_ = 0, spread_ = 0;
  double touch_;  ///< MPa
  std::optional<RestReference> rest_;
};

/// Whether a sensor that touches can be believed: says which of its frames are not those of a sound one.
///
/// A frame stands still where all its numbers have stayed the same for more than twice as many frames as ever before,
/// and for ten at least: a cable is out, or a driver repeats itself. Before 20 frames that changed nothing is known of
/// a sensor. Normal stresses that pull, by more than a third of their absolute sum, have the wrong sign.
class FrameHealth {
 public:
  FrameHealth(std::size_t inputs, std::size_t normals) : normals_(normals), last_(inputs) {}
  /// Takes the next frame [inputs] MPa. Returns why it cannot tell if it touches. Allocates nothing.
  CannotTell next(std::span<const float> frame) noexcept;

 private:
  std::size_t normals_;
  std::vector<float> last_;
  int same_ = 0, longest_ = 0, changed_ = 0;  ///< frames: the same in a row; most of these that ended; others
};

}  // namespace tactel::infer
