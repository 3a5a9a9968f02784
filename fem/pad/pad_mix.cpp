// SPDX-License-Identifier: Apache-2.0
#include "fem/pad/pad_mix.h"

#include <cmath>
#include <numbers>

namespace tactel::fem {

double RandomNumbers::in(double from, double to) { return std::uniform_real_distribution<double>(from, to)(random_); }
double RandomNumbers::log_in(double from, double to) { return std::exp(in(std::log(from), std::log(to))); }

PadScene PadMix::operator()() {
  PadScene scene;
  if (sensor_) {
    scene.sensor = *sensor_;
  } else {
    scene.sensor.thickness = random_.in(1, 4);
    scene.sensor.poisson = random_.in(0.3, 0.5);
    scene.sensor.young = 1;
    scene.sensor.pitch = {0.75 * scene.sensor.thickness, 0.75 * scene.sensor.thickness};
  }
  const double H = scene.sensor.thickness, d = H * random_.log_in(0.02, 0.2);
  static const std::vector<PadDraw> draws = pad_draws();
  const int kinds = static_cast<int>(draws.size());
  kind_ = kind_ < 0 ? static_cast<int>(random_.in(0, kinds)) : (kind_ + 1) % kinds;
  PadIndenter& indenter = scene.indenter;
  draws[kind_](indenter, H, random_);
  indenter.position = {H * random_.in(-0.5, 0.5), H * random_.in(-0.5, 0.5)};
  indenter.yaw = random_.in(0, 180);
  scene.friction = random_.log_in(0.1, 1.5);
  scene.load.indentation = {d};
  // Drags as long as it takes to come from rest to sliding or somewhat beyond.
  const double step = d * scene.friction * random_.log_in(0.05, 0.4),
               lever = random_.in(0, 1) < 0.5 ? 0 : random_.in(-2, 2) / H;
  const int way = static_cast<int>(random_.in(0, 3));
  double angle = random_.in(0, 2 * std::numbers::pi), x = 0, y = 0, twist = 0;
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
