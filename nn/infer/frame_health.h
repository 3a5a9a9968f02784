// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <tactel/infer.h>

#include <cstddef>
#include <span>
#include <vector>

namespace tactel::infer {

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
