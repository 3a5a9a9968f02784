// SPDX-License-Identifier: Apache-2.0
#include "host/sets/held_contact.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "fem/numbers/angles.h"
#include "fem/pad/pad_layers.h"
#include "fem/pad/pad_surface.h"

namespace tactel::host {
namespace {

constexpr double highest = 3;  ///< rms heights by which an uneven face reaches below its mean: depths count from there
constexpr double power = 1.5;  ///< of the force over the depth, for the hand that keeps its force
constexpr double surrounding =
    1.7;  ///< H over radius: what rubber beside a contact adds to its stiffness along the pad
constexpr double longest_way = 0.05;                   ///< H, of a frame by force
constexpr double least_force = 0.3, most_force = 1.5;  ///< left of a grip that loses its force as the object slides

}  // namespace

HeldContact::HeldContact(const fem::PadScene& scene, const Hold& hold, const fem::PadCells& cells)
    : sensor_(scene.sensor),
      indenter_(scene.indenter),
      friction_(scene.friction),
      preload_(scene.load.normal_force.back()),
      hold_(hold),
      cells_(cells),
      pressing_(static_cast<std::size_t>(hold.pressing())) {}

/// The shear of the layer that bears mu times the mean pressure, mm.
double HeldContact::limit(const HeldStep& step) const {
  if (!(step.area > 0)) return 0;
  return friction_ * step.force[0] / step.area * sensor_.thickness * 2 * (1 + sensor_.poisson) / sensor_.young *
         fem::softer_in_shear(sensor_);
}

double HeldContact::force(std::size_t k) const {
  return preload_ * hold_.frames[k].P * std::clamp(1 - hold_.loss * way_, least_force, most_force);
}

/// N/mm along the pad of a contact that sticks.
double HeldContact::shear_stiffness(const HeldStep& step) const {
  const double radius = std::sqrt(step.area / std::numbers::pi), G = sensor_.young / (2 * (1 + sensor_.poisson));
  return stiffness_ * G * step.area / sensor_.thickness * (1 + surrounding * sensor_.thickness / radius) /
         fem::softer_in_shear(sensor_);
}

/// x, y (mm) and turn (rad) of a frame.
std::array<double, 3> HeldContact::way_by_force(std::size_t k) const {
  if (!(last_.area > 0 && arm_ > 0)) return {};
  const double most = friction_ * preload_, stiffness = shear_stiffness(last_);
  const auto& [x, y, turn] = hold_.frames[k].load;
  const std::array<double, 2>& tremor = hold_.frames[k].tremor;
  std::array<double, 3> way{(most * x + force(k) * tremor[0] - last_.force[1]) / stiffness,
                            (most * y + force(k) * tremor[1] - last_.force[2]) / stiffness,
                            (most * arm_ * turn - last_.force[3]) / (stiffness * arm_)};  // the turn times the arm
  const double length = std::hypot(way[0], way[1], way[2]), longest = longest_way * sensor_.thickness;
  for (double& part : way) part *= length > longest ? longest / length : 1;
  way[2] /= arm_;
  return way;
}

/// Where the hand has taken the object, beside its load: x, y (mm) and turn (rad).
std::array<double, 3> HeldContact::moved(std::size_t k) const {
  const Hold::Frame& frame = hold_.frames[k];
  const double c = 1 - std::cos(frame.swing), s = std::sin(frame.swing);
  const auto& [x, y] = hold_.pivot;
  return {frame.shift[0] + c * x + s * y, frame.shift[1] - s * x + c * y, frame.swing};
}

/// Of a frame that keeps the force, opens the hand, or closes it again.
double HeldContact::depth(std::size_t k) const {
  const double P = last_.force[0], shallow = 0.01 * sensor_.thickness,
               over = std::max(from_lowest(), hold_.rate > 0 ? std::min(shallow, 0.1 * pressed_depth_) : shallow);
  if (!(hold_.frames[k].P > 0)) return lowest_ - 0.01 * sensor_.thickness;
  if (!(hold_.frames[k - 1].P > 0)) return lowest_ + pressed_depth_ * std::pow(force(k) / pressed_.force[0], 1 / power);
  return lowest_ + over * std::pow(P > 0 ? std::clamp(force(k) / P, 0.5, 2.0) : 2.0, 1 / power);
}

std::array<double, 4> HeldContact::pose(std::size_t k) const {
  std::array<double, 4> to = last_.pose;
  to[0] = depth(k);
  std::array<double, 3> way = moved(k);
  if (hold_.by_motion) {
    const auto& [x, y, turn] = hold_.frames[k].load;
    const std::array<double, 2>& tremor = hold_.frames[k].tremor;
    const double trembling = pressed_.area > 0 ? force(k) / shear_stiffness(pressed_) : 0;
    to[1] = pressed_.pose[1] + unit_ * x, to[2] = pressed_.pose[2] + unit_ * y;
    to[3] = pressed_.pose[3] + (arm_ > 0 ? unit_ * turn / arm_ : 0);
    for (std::size_t i = 0; i < 2; ++i) way[i] += trembling * tremor[i];
  } else {
    const std::array<double, 3> loaded = way_by_force(k), before = moved(k - 1);
    for (std::size_t i = 0; i < 3; ++i) way[i] += loaded[i] - before[i];
  }
  for (std::size_t i = 0; i < 3; ++i) to[i + 1] += way[i];
  return to;
}

void HeldContact::put_object(std::size_t k, std::span<double> heights, std::span<double> cover,
                             std::array<double, 2>& axis) {
  axis = {indenter_.position[0] + place_[0], indenter_.position[1] + place_[1]};
  const double swing = hold_.frames[k].swing;
  const std::array<double, 2> middle{axis[0] + hold_.roll[0] * swing, axis[1] + hold_.roll[1] * swing};
  fem::PadSurface surface = fem::pad_surface(cells_, indenter_, middle, fem::degrees(place_[2]));
  fem::add_skin(sensor_, cells_, surface.height);
  std::ranges::copy(surface.height, heights.begin());
  std::ranges::copy(surface.cover, cover.begin());
  if (hold_.rms > 0) hold_.face.add(cells_, middle, fem::radians(indenter_.yaw) + place_[2], heights);
  const double most = friction_ * last_.force[0];
  const double slope = most > 0 ? hold_.tilt * pressed_depth_ / (cells_.half_size() * most) : 0;
  const double along = slope * std::cos(hold_.tilt_direction), across = slope * std::sin(hold_.tilt_direction);
  const double rise_x = along * last_.force[1] - across * last_.force[2],
               rise_y = across * last_.force[1] + along * last_.force[2];
  lowest_ = std::numeric_limits<double>::infinity();
  for (int i = 0; i < cells_.count(); ++i) {
    double& height = heights[static_cast<std::size_t>(i)];
    height += highest * hold_.rms + rise_x * (cells_.x(i / cells_.ny()) - axis[0]) +
              rise_y * (cells_.y(i % cells_.ny()) - axis[1]);
    lowest_ = std::min(lowest_, height);
  }
  if (!std::isfinite(lowest_)) lowest_ = 0;
}

std::array<double, 4> HeldContact::ask(std::size_t k, std::span<double> heights, std::span<double> cover,
                                       std::array<double, 2>& axis) {
  const std::array<double, 4> to = by_wrench(k) ? std::array{force(k), 0.0, 0.0, 0.0} : pose(k);
  for (std::size_t i = 0; i < 3; ++i) place_[i] = by_wrench(k) ? last_.pose[i + 1] : to[i + 1];
  put_object(k, heights, cover, axis);
  return to;
}

/// A hand knows how stiff its contact is from how the force has grown as it took up the weight and trembled.
void HeldContact::learn_stiffness(std::size_t k, const HeldStep& step) {
  const bool sticks = std::hypot(step.force[1], step.force[2]) < 0.5 * friction_ * step.force[0];
  if (!(hold_.rate > 0) || by_wrench(k) || k >= static_cast<std::size_t>(hold_.press) || !sticks) return;
  for (std::size_t i = 1; i < 3; ++i) {
    const double way = step.pose[i] - last_.pose[i];
    work_ += way * (step.force[i] - last_.force[i]), estimated_ += way * way * shear_stiffness(step) / stiffness_;
  }
  if (estimated_ > 0) stiffness_ = std::clamp(work_ / estimated_, 0.2, 2.0);
}

void HeldContact::take(std::size_t k, const HeldStep& step) {
  learn_stiffness(k, step);
  const double own = limit(step);
  if (own > 0) slip_path_ += step.slip / own, slid_ += step.slides ? step.slip / own : 0;
  for (std::size_t i = 0; i < 3 && own > 0; ++i) net_slip_[i] += step.mean[i] / own;
  way_ += step.slip;
  last_ = step;
  if (k + 1 != pressing_) return;
  pressed_ = step;
  pressed_depth_ = from_lowest();
  arm_ = std::sqrt(step.area / 6);
  unit_ = own;
  for (const Hold::Frame& frame : hold_.frames) {
    const auto& [x, y, turn] = frame.load;
    const double way = std::sqrt(x * x + y * y + turn * turn);
    if (way * unit_ > sensor_.thickness) unit_ = sensor_.thickness / way;
  }
}

}  // namespace tactel::host
