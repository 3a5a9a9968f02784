// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace tactel::infer {

inline constexpr std::size_t most_moments = 8;
using Moments = std::array<double, most_moments>;

/// Where the tactels of a frame are, and which of its numbers are what.
struct PadShape {
  std::size_t tactels = 0, axes = 0;  ///< axes: 1, normal stresses alone; 2: shear along x; 3: and along y
  std::size_t columns = 0;            ///< tactels along x, x fastest; 0: a square, else a line
  double aspect = 1;                  ///< pitch along y over that along x
};

/// How a frame differs from the rest, whatever its force.
struct Change {
  Moments moments{};  ///< d = (m - P / P0 m0) / max(P, P0)
  /// sqrt(T) |u|, u = z / P - z0 / P0 of the T tactels, and sqrt(T) |v|, v = tau / P - tau0 / P0 less its mean over
  /// them: how the patterns of pressure and of shear change. A load moves the mean.
  double pressure = 0, shear = 0;
  double moved = 0;  ///< |f - r| / P0
};

/// Moments of a pad's stresses, but for P: of a shear axis its sum Q and its products with x and y, of the normal
/// stresses their products with x and y; in this order: Q_x, Q_y, z x, z y, tau_x x, tau_x y, tau_y x, tau_y y. Places
/// are from the middle, over their rms radius. A pad of normal stresses has two; a line has none along y.
///
/// A number of a frame that is not finite is left out, of the rest, too.
class PadMoments {
 public:
  explicit PadMoments(const PadShape& shape);
  std::size_t count() const noexcept { return count_; }
  /// Returns which of the eight moments this pad has, in order.
  std::span<const std::size_t> which() const noexcept { return {which_.data(), count_}; }
  /// frame, rest: [inputs] MPa.
  Change change(std::span<const float> frame, std::span<const float> rest) const noexcept;
  double force(std::span<const float> frame) const noexcept { return sums(frame, frame).force; }  ///< P, MPa
  /// Returns hypot(|Q|, |M| / rho) / P, M the torque about the centre of pressure and rho the mean distance of pressure
  /// from it; NaN without force. It is mu where all slides.
  double friction(std::span<const float> frame) const noexcept;

 private:
  struct Sums {
    double force = 0;
    Moments moments{};
  };
  Sums sums(std::span<const float> frame, std::span<const float> like) const noexcept;

  std::size_t tactels_, axes_, count_ = 0;
  std::vector<float> x_, y_;  ///< [tactels] over their rms radius
  std::array<std::size_t, most_moments> which_{};
};

}  // namespace tactel::infer
