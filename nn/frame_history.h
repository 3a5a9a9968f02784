// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

namespace tactel::nn {

/// Which earlier frames a network's input has behind the newest.
struct InputHistory {
  int frames = 1;         ///< frames in an input, the newest included; 1: no history
  int stride = 1;         ///< kept frames from one of them to the next
  double change = 0.1;    ///< a frame is kept that differs by more than this, over the largest stress of the contact
  bool rest = false;      ///< the last of `frames` is the grip at rest (nn/infer/rest_reference.h)
  bool friction = false;  ///< behind the frames an input has mu as told, 0: it is not, and its relative deviation

  /// Returns the frames of the path, without the rest.
  int path() const { return frames - rest; }

  /// A frame whose largest stress is below this, over the largest of the contact, ends the contact.
  static constexpr float released = 0.05f;
  static constexpr int most_frames = 128;  ///< each has two numbers or more; Topology::widest_layer
  static constexpr int most_stride = 1000;
  bool operator==(const InputHistory&) const = default;
  bool valid() const {
    return path() >= 1 && frames <= most_frames && stride >= 1 && stride <= most_stride && change >= 0 && change <= 1;
  }
};

/// Returns the numbers of an input whose frames have `width` stresses.
inline int numbers_of(const InputHistory& history, int width) {
  return history.frames * width + (history.friction ? 2 : 0);
}

/// The frames of a contact that an input takes: by change of load, not by the clock. Live frames and the rows of a set
/// pass the same rule:
/// - the first frame of a contact is kept;
/// - a frame is kept where one of its stresses differs from the last kept frame by more than `change` of the largest
///   stress since the contact began;
/// - a frame below `released` of that stress ends the contact and begins another: what was kept is forgotten.
/// An input is the newest frame, then the frames kept `stride`, 2 `stride`, ... before the last kept one. Frames before
/// the first are zeros: the sensor was at rest. A frame that is not finite is the newest and is not kept.
/// Only the constructor allocates.
class FrameHistory {
 public:
  /// `width`: numbers of a frame.
  FrameHistory(std::size_t width, const InputHistory& input)
      : width_(width),
        input_(input),
        slots_(static_cast<std::size_t>(input.path() - 1) * static_cast<std::size_t>(input.stride) + 1),
        kept_(slots_ * width, 0.0f),
        number_(slots_),
        newest_(width, 0.0f) {}

  std::size_t width() const noexcept { return width_; }
  std::size_t inputs() const noexcept { return width_ * static_cast<std::size_t>(input_.path()); }

  /// Returns how many frames were pushed after the input's frame i, 1 <= i < path(). None: it is zeros.
  std::optional<std::size_t> age(int i) const noexcept {
    const std::size_t back = static_cast<std::size_t>(i) * static_cast<std::size_t>(input_.stride);
    if (back >= count_) return std::nullopt;
    return pushed_ - number_[place(back)];
  }

  /// Takes the newest frame [width] MPa.
  void push(const float* frame) noexcept {
    std::copy_n(frame, width_, newest_.begin());
    ++pushed_;
    float most = 0;
    for (std::size_t k = 0; k < width_; ++k) {
      if (!std::isfinite(frame[k])) return;
      most = std::max(most, std::abs(frame[k]));
    }
    if (most < InputHistory::released * largest_) forget();
    largest_ = std::max(largest_, most);
    if (count_ == 0 || changed(frame)) keep(frame);
  }
  /// Forgets all frames: the next one begins a contact.
  void clear() noexcept {
    forget();
    std::fill(newest_.begin(), newest_.end(), 0.0f);
  }
  /// Writes the input's frames of the path [path()][width] MPa, the newest frame first.
  void write(float* input) const noexcept {
    std::copy_n(newest_.begin(), width_, input);
    for (int i = 1; i < input_.path(); ++i) {
      const std::size_t back = static_cast<std::size_t>(i) * static_cast<std::size_t>(input_.stride);
      float* to = input + static_cast<std::size_t>(i) * width_;
      if (back < count_)
        std::copy_n(slot(back), width_, to);
      else
        std::fill_n(to, width_, 0.0f);
    }
  }

 private:
  std::size_t place(std::size_t back) const noexcept { return (last_ + slots_ - back) % slots_; }
  const float* slot(std::size_t back) const noexcept { return &kept_[place(back) * width_]; }
  bool changed(const float* frame) const noexcept {
    const float limit = static_cast<float>(input_.change) * largest_;
    const float* last = slot(0);
    for (std::size_t k = 0; k < width_; ++k)
      if (std::abs(frame[k] - last[k]) > limit) return true;
    return false;
  }
  void keep(const float* frame) noexcept {
    last_ = (last_ + 1) % slots_;
    std::copy_n(frame, width_, &kept_[last_ * width_]);
    number_[last_] = pushed_;
    count_ = std::min(count_ + 1, slots_);
  }
  void forget() noexcept { count_ = 0, largest_ = 0; }

  std::size_t width_;
  InputHistory input_;
  std::size_t slots_, last_ = 0, count_ = 0, pushed_ = 0;
  float largest_ = 0;                ///< MPa, since the contact began
  std::vector<float> kept_;          ///< [slots][width], a ring
  std::vector<std::size_t> number_;  ///< [slots] frames pushed up to the kept one
  std::vector<float> newest_;        ///< [width]
};

}  // namespace tactel::nn
