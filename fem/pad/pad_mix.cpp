// SPDX-License-Identifier: Apache-2.0
#include "fem/pad/pad_mix.h"

#include <cmath>
#include <numbers>

namespace tactel::fem {

double PadMix::in(double from, double to) { return std::uniform_real_distribution<double>(from, to)(random_); }
double PadMix::log_in(double from, double to) { return std::exp(in(std::log(from), std::log(to))); }

// A further shape needs a kind below. A height map is drawn elsewhere.
static_assert(std::variant_size_v<PadShape> == 7);

PadScene PadMix::operator()() {
  PadScene scene;
  if (sensor_) {
    scene.sensor = *sensor_;
  } else {
    scene.sensor.thickness = in(1, 4);
    scene.sensor.poisson = in(0.3, 0.5);
    scene.sensor.young = 1;
    scene.sensor.pitch = {0.75 * scene.sensor.thickness, 0.75 * scene.sensor.thickness};
  }
  const double H = scene.sensor.thickness, d = H * log_in(0.02, 0.2);
  kind_ = kind_ < 0 ? static_cast<int>(in(0, 9)) : (kind_ + 1) % 9;
  PadIndenter& indenter = scene.indenter;
  switch (kind_) {
    case 0:
    case 1:
      indenter.shape = Sphere{H * log_in(1, 8)};
      break;
    case 2:
      indenter.shape = Paraboloid{{H * log_in(1, 8), H * log_in(1, 8)}};
      break;
    case 3:
      indenter.shape = LyingCylinder{H * log_in(1, 6), H * in(0.5, 2)};
      break;
    case 4:
      indenter.shape = Punch{H * in(0.4, 1.5), 0};
      break;
    case 5:
      indenter.shape = Punch{H * in(0.4, 1.5), H * in(0.1, 0.5)};
      indenter.tilt = in(0, 5);
      indenter.tilt_direction = in(0, 360);
      break;
    case 6:
      indenter.shape = Box{{H * in(0.4, 1.5), H * in(0.4, 1.5)}, 0};
      break;
    case 7:
      indenter.shape = Box{{H * in(0.4, 1.5), H * in(0.4, 1.5)}, H * log_in(0.05, 0.5)};
      break;
    default:
      indenter.shape = Cone{in(65, 85)};
  }
  indenter.position = {H * in(-0.5, 0.5), H * in(-0.5, 0.5)};
  indenter.yaw = in(0, 180);
  scene.friction = log_in(0.1, 1.5);
  scene.load.indentation = {d};
  // Drags as long as it takes to come from rest to sliding or somewhat beyond.
  const double step = d * scene.friction * log_in(0.05, 0.4), lever = in(0, 1) < 0.5 ? 0 : in(-2, 2) / H;
  const int way = static_cast<int>(in(0, 3));
  double angle = in(0, 2 * std::numbers::pi), x = 0, y = 0, twist = 0;
  for (int k = 0; k < 8; ++k) {
    const double sign = way == 2 && k >= 4 ? -1 : 1;
    if (way == 1) angle += 0.25;
    x += sign * step * std::cos(angle);
    y += sign * step * std::sin(angle);
    twist += sign * step * lever;
    scene.load.drags.push_back({x, y, twist});
  }
  return scene;
}

}  // namespace tactel::fem
