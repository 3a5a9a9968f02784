// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <optional>
#include <span>

#include "host/live/drift_watch.h"
#include "host/live/sensor_profile.h"

namespace tactel::host {

/// Notices shear axes of a pad that do not fit the places of its tactels: a pad turned or mirrored against its profile.
///
/// Pressed rubber flees outward and drags the base along, and sigma_z is lowest below the indenter: tau . grad sigma_z
/// is positive. Its fit is the sum of that product over the tactels, over the norms of both. A drag adds shear in
/// proportion to sigma_z, which is left out first. Of 1200 simulated presses inside of pads of 4 x 4 to 8 x 8 tactels,
/// pitch up to 1.2 thicknesses, the fit was 0.43 to 0.99, its median above 0.8; pads of pitch 2.3 thicknesses fit worse
/// (0.15 to 0.9). Each of the other seven exchanges and signs of the two axes has a median of 0 or less.
class MountingWatch {
 public:
  /// `touch`: MPa, of contact; with 0, without shear, and with fewer than 3 x 3 tactels there is nothing to watch.
  MountingWatch(const PadLayout& pad, double touch, bool has_shear);

  /// Takes the next frame [3 tactels] MPa. Returns what a press showed when it no longer grows, once.
  std::optional<Drift> next(std::span<const float> frame);

 private:
  static constexpr std::size_t images = 8;  ///< exchanges and signs of two axes
  void look(std::span<const float> frame, std::size_t lowest);
  std::optional<Drift> judge();

  PadLayout pad_;
  double touch_;
  bool done_, pending_ = false;
  double peak_ = 0;                    ///< MPa, of the press so far
  int since_ = 0;                      ///< frames since it grew
  std::array<double, images> fits_{};  ///< of the frame at the peak, by image
};

}  // namespace tactel::host
