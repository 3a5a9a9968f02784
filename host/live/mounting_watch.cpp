// SPDX-License-Identifier: Apache-2.0
#include "host/live/mounting_watch.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace tactel::host {
namespace {

constexpr double clear_touch = 10;                   // thresholds of touch: noise is then a seventieth of the peak
constexpr double growth = 1.05;                      // a smaller rise of the peak is none
constexpr int still_frames = 10;                     // without growth: the press is over
constexpr double right_fit = 0.5;                    // of the profile's own axes: they are right
constexpr double wrong_fit = 0.1, other_fit = 0.55;  // of the profile's own axes, and of others

/// Image i of the axes: whether they are exchanged, and the signs of the new shear_x and shear_y.
struct Image {
  bool exchanged;
  int x, y;
};
constexpr Image image(std::size_t i) { return {i >= 4, i & 1 ? -1 : 1, i & 2 ? -1 : 1}; }

std::string remedy(const Image& mounting) {
  std::string text = mounting.exchanged ? "shear_x and shear_y exchanged" : "";
  const auto add = [&](int sign, const char* axis) {
    if (sign < 0) text += (text.empty() ? "the gains of " : " and the gains of ") + std::string(axis) + " turned";
  };
  add(mounting.x, "shear_x"), add(mounting.y, "shear_y");
  return text;
}

using Grid = Eigen::ArrayXXd;  // [along x][along y]

/// Difference of neighbours along x, over their distance in pitches; one-sided at the border.
Grid slope(const Grid& s) {
  Grid g(s.rows(), s.cols());
  for (Eigen::Index i = 0; i < s.rows(); ++i) {
    const Eigen::Index left = std::max<Eigen::Index>(i - 1, 0), right = std::min(i + 1, s.rows() - 1);
    g.row(i) = (s.row(right) - s.row(left)) / static_cast<double>(right - left);
  }
  return g;
}

}  // namespace

MountingWatch::MountingWatch(const PadLayout& pad, double touch, bool has_shear)
    : pad_(pad), touch_(touch), done_(!(touch > 0) || !has_shear || std::min(pad.tactels[0], pad.tactels[1]) < 3) {}

std::optional<Drift> MountingWatch::next(std::span<const float> frame) {
  if (done_) return std::nullopt;
  const auto normal = frame.first(pad_.count());
  const auto lowest = std::ranges::min_element(normal);
  const double peak = -static_cast<double>(*lowest);
  if (peak >= clear_touch * touch_ && peak > growth * peak_) {
    look(frame, static_cast<std::size_t>(lowest - normal.begin()));
    peak_ = peak, since_ = 0, pending_ = true;
    return std::nullopt;
  }
  const bool touches = peak >= touch_;
  if (!touches) peak_ = 0;
  if (!pending_ || (touches && ++since_ < still_frames)) return std::nullopt;
  pending_ = false;
  return judge();
}

/// Fits of one frame; 0 where the press is at the border, or shear is not finite.
void MountingWatch::look(std::span<const float> frame, std::size_t lowest) {
  fits_.fill(0);
  const Eigen::Index nx = pad_.tactels[0], ny = pad_.tactels[1], i = static_cast<Eigen::Index>(lowest) % nx,
                     j = static_cast<Eigen::Index>(lowest) / nx;
  if (i == 0 || j == 0 || i == nx - 1 || j == ny - 1) return;
  const auto grid = [&](std::size_t axis) -> Grid {
    return Eigen::Map<const Eigen::ArrayXXf>(frame.data() + axis * pad_.count(), nx, ny).cast<double>();
  };
  const Grid sigma = grid(0);
  const auto without_drag = [&](const Grid& tau) -> Grid {
    return tau - (tau * sigma).sum() / sigma.square().sum() * sigma;
  };
  const double ratio = pad_.pitch[0] > 0 ? pad_.pitch[0] / pad_.pitch[1] : 1;
  const Grid tau[] = {without_drag(grid(1)), without_drag(grid(2))};
  const Grid gradient[] = {slope(sigma), ratio * slope(sigma.transpose()).transpose()};
  const double norm =
      std::sqrt((tau[0].square() + tau[1].square()).sum() * (gradient[0].square() + gradient[1].square()).sum());
  if (!(norm > 0)) return;
  for (std::size_t k = 0; k < images; ++k) {
    const Image mounting = image(k);
    fits_[k] = (mounting.x * (tau[mounting.exchanged] * gradient[0]).sum() +
                mounting.y * (tau[!mounting.exchanged] * gradient[1]).sum()) /
               norm;
  }
}

std::optional<Drift> MountingWatch::judge() {
  const auto best = std::ranges::max_element(fits_);
  const bool wrong = fits_[0]<wrong_fit&& * best> other_fit;
  done_ = wrong || fits_[0] > right_fit;
  if (!wrong) return std::nullopt;
  return Drift{
      .kind = Drift::Kind::mounting,
      .channels = {},
      .size = fits_[0],
      .text = fmt::format(
          "pressed rubber drags its base outward, but the shear of this pad does not point there (fit {:.2f} of "
          "1): the pad is turned or mirrored against its profile; the fit is {:.2f} with {}; correct [channels] "
          "or gain of the profile",
          fits_[0], *best, remedy(image(static_cast<std::size_t>(best - fits_.begin()))))};
}

}  // namespace tactel::host
