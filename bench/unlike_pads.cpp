// SPDX-License-Identifier: Apache-2.0
#include "bench/unlike_pads.h"

#include <cmath>
#include <numbers>
#include <random>

namespace tactel::host {
namespace {

using std::numbers::pi;

struct Draw {
  std::mt19937 random;
  double in(double from, double to) { return std::uniform_real_distribution<double>(from, to)(random); }
  double log_in(double from, double to) { return std::exp(in(std::log(from), std::log(to))); }
  bool chance(double share) { return in(0, 1) < share; }
};

/// A map over some 2 a x 2 a: a ball under ridges, under bumps, or a stamp of flat bars with steep sides up to its
/// border.
fem::HeightMap height_map(Draw& draw, int kind, double a, double d) {
  constexpr int points = 61;
  fem::HeightMap map{.pitch = 2 * a * draw.in(0.9, 1.6) / (points - 1), .heights = {}};
  const double periods = draw.in(2, 6), relief = d * draw.in(0.2, 1.5), phase = draw.in(0, 2 * pi);
  const double curvature = draw.chance(0.7) ? d / (a * a) : 0, along = draw.in(0, pi);
  std::array<std::array<double, 3>, 6> bumps{};
  for (auto& [x, y, size] : bumps) x = a * draw.in(-1, 1), y = a * draw.in(-1, 1), size = a * draw.in(0.15, 0.5);
  map.heights = Eigen::MatrixXd::NullaryExpr(points, points, [&](Eigen::Index i, Eigen::Index j) {
    const double x = (static_cast<double>(i) - (points - 1) / 2.0) * map.pitch;
    const double y = (static_cast<double>(j) - (points - 1) / 2.0) * map.pitch;
    const double wave = std::sin(phase + pi * periods / a * (x * std::cos(along) + y * std::sin(along)));
    if (kind == 2) return wave > 0 ? 0 : 2 * d;
    double height = curvature * (x * x + y * y);
    if (kind == 0) height += relief * (1 + wave) / 2;
    if (kind == 1)
      for (const auto& [bx, by, size] : bumps)
        height -= relief * std::exp(-((x - bx) * (x - bx) + (y - by) * (y - by)) / (size * size));
    return height;
  });
  map.heights.array() -= map.heights.minCoeff();
  return map;
}

fem::PadIndenter indenter(Draw& draw, int kind, double H, double a, double d) {
  fem::PadIndenter made;
  const double b = a * draw.log_in(0.5, 2), edge = H * draw.log_in(0.05, 0.5);
  const auto tilt = [&] {
    made.tilt = std::atan(draw.in(0.05, 0.8) * d / a) * 180 / pi, made.tilt_direction = draw.in(0, 360);
  };
  if (kind < 2) made.shape = fem::Sphere{std::max(a * a / d, 1.2 * a)};
  if (kind == 2) made.shape = fem::Paraboloid{{a * a / d, b * b / d}};
  if (kind == 3) made.shape = fem::LyingCylinder{std::max(a * a / d, 1.2 * a), b};
  if (kind == 4 || kind == 5) made.shape = fem::Punch{a, kind == 5 ? edge : 0};
  if (kind == 6 || kind == 7) made.shape = fem::Box{{a, b}, kind == 7 ? edge : 0};
  if (kind == 8) made.shape = fem::Cone{std::clamp(std::atan(a / d) * 180 / pi, 45.0, 88.0)};
  if (kind > 8) made.shape = height_map(draw, kind - 9, a, d);
  if (kind >= 5 && kind <= 7 && draw.chance(kind == 5 ? 0.5 : kind == 6 ? 0.3 : 0.6)) tilt();
  made.position = {H * draw.in(-0.5, 0.5), H * draw.in(-0.5, 0.5)};
  made.yaw = draw.in(0, 180);
  return made;
}

/// Drags in 2 to 8 steps. `slip`: the way, mm, on which a contact begins to slide as a whole, roughly.
std::vector<std::array<double, 3>> drags(Draw& draw, PadWay way, double slip, double a) {
  const int steps = 2 + static_cast<int>(draw.in(0, 7));
  const double length =
      std::min(1.5 * a, slip * (way == PadWay::long_drag ? draw.log_in(3, 10) : draw.log_in(0.3, 2.5)));
  const double step = length / steps, turn = draw.in(0.2, 0.6), spin = draw.in(-2, 2) / a;
  double angle = draw.in(0, 2 * pi), x = 0, y = 0, twist = 0;
  std::vector<std::array<double, 3>> all;
  for (int k = 0; k < steps; ++k) {
    const double sign = way == PadWay::back && k >= (steps + 1) / 2 ? -1 : 1;
    if (way == PadWay::curved) angle += turn;
    if (way == PadWay::loop) angle += 2 * pi / steps;
    if (way != PadWay::twist) x += sign * step * std::cos(angle), y += sign * step * std::sin(angle);
    if (way == PadWay::twist) twist += 1.5 * step / a;
    if (way == PadWay::twisting_drag) twist += step * spin;
    all.push_back({x, y, twist});
  }
  return all;
}

}  // namespace

const char* name(PadWay way) {
  static constexpr const char* names[pad_ways] = {"straight", "long", "curved", "back", "loop", "twist", "twist, drag"};
  return names[static_cast<int>(way)];
}

UnlikePad unlike_pad(unsigned seed, int k, bool wide) {
  std::seed_seq seeds{seed, static_cast<unsigned>(k), static_cast<unsigned>(wide)};
  Draw draw{std::mt19937(seeds)};
  UnlikePad made{{}, static_cast<PadWay>((k + k / pad_kinds) % pad_ways)};
  fem::PadScene& scene = made.scene;
  const double H = draw.in(1, 4), d = H * draw.log_in(wide ? 0.01 : 0.02, 0.2);
  const double a = H * (!wide ? draw.log_in(0.2, 1.5) : draw.log_in(0.15, draw.chance(0.5) ? 1.5 : 10));
  scene.sensor.thickness = H, scene.sensor.young = 1, scene.sensor.pitch = {0.75 * H, 0.75 * H};
  scene.sensor.poisson = draw.in(0.3, 0.5);
  if (wide) scene.sensor.poisson = draw.chance(0.4) ? draw.in(0.45, 0.5) : draw.in(0, 0.45);
  scene.indenter = indenter(draw, k % pad_kinds, H, a, d);
  scene.friction = draw.log_in(wide ? 0.05 : 0.1, 1.5);
  scene.load.indentation = {d};
  // Wide contacts on thin rubber slide later: shear of the layer by mu times the pressure, which nu near 1/2 raises.
  const double nu = scene.sensor.poisson, stiff = 1 / std::max(1 - 2 * nu, std::pow(H / (a + H), 2));
  scene.load.drags = drags(draw, made.way, scene.friction * d * (a < H ? 1 : std::min(stiff, 8.0)), a);
  if (wide && draw.chance(0.1)) scene.load.normal_force = {a * d}, scene.load.indentation = {};
  return made;
}

UnlikePad unlike_marked_pad(unsigned seed, int k) {
  std::seed_seq seeds{seed, static_cast<unsigned>(k), 3u};
  Draw draw{std::mt19937(seeds)};
  UnlikePad made = unlike_pad(seed, k, true);
  fem::PadScene& scene = made.scene;
  const double H = scene.sensor.thickness;
  scene.markers = Markers{.depth = H * draw.log_in(0.02, 0.5)};
  // About as wide as a ball of this depth touches.
  const fem::PadBox section = fem::rigid_section(scene.indenter, 0.2 * H);
  const double x = std::min(1.5 * section.x.right, 12 * H), y = std::min(1.5 * section.y.right, 12 * H);
  const auto [at_x, at_y] = scene.indenter.position;
  for (int i = -3; i <= 3; ++i)
    for (int j = -3; j <= 3; ++j) scene.markers->places.push_back({at_x + i * x / 3, at_y + j * y / 3});
  return made;
}

UnlikePad unlike_layered_pad(unsigned seed, int k) {
  std::seed_seq seeds{seed, static_cast<unsigned>(k), 4u};
  Draw draw{std::mt19937(seeds)};
  UnlikePad made = unlike_pad(seed, k, true);
  fem::PadSensor& sensor = made.scene.sensor;
  const int count = 1 + k % 3;
  double all = 0, soft = 0;
  for (int layer = 0; layer < count; ++layer)
    sensor.layers.push_back({draw.in(0.1, 1), layer + 1 < count ? draw.log_in(0.1, 10) : 1, draw.in(0.3, 0.5)});
  for (const auto& layer : sensor.layers) all += layer.thickness;
  for (auto& layer : sensor.layers) {
    layer.thickness = sensor.thickness * (0.1 + (1 - 0.1 * count) * layer.thickness / all);
    soft += layer.thickness / layer.young / sensor.thickness;
  }
  sensor.thickness = fem::PadSensor().thickness, sensor.young = fem::PadSensor().young;
  sensor.poisson = fem::PadSensor().poisson, sensor = with_layers(sensor);
  for (double& force : made.scene.load.normal_force) force /= soft;
  return made;
}

UnlikePad unlike_free_pad(unsigned seed, int k) {
  std::seed_seq seeds{seed, static_cast<unsigned>(k), 2u};
  Draw draw{std::mt19937(seeds)};
  UnlikePad made{{}, static_cast<PadWay>((k + k / pad_kinds) % pad_ways)};
  fem::PadScene& scene = made.scene;
  constexpr double side = 19;
  constexpr std::array<std::array<double, 2>, 5> rubbers{{{2, 0.45}, {3, 0.3}, {4.5, 0.48}, {4.5, 0.4}, {6, 0.4999}}};
  const auto [H, nu] = rubbers[static_cast<std::size_t>(k) % rubbers.size()];
  const double d = H * draw.log_in(0.01, 0.1), a = draw.log_in(1.5, 14);
  scene.sensor.thickness = H, scene.sensor.young = 1, scene.sensor.poisson = nu;
  scene.sensor.length = scene.sensor.width = side;
  scene.indenter = indenter(draw, k % pad_kinds, H, a, d);
  scene.indenter.position = {side / 2 * draw.in(-0.95, 0.95), side / 2 * draw.in(-0.95, 0.95)};
  scene.friction = draw.log_in(0.1, 1.5);
  scene.load.indentation = {d};
  scene.load.drags = drags(draw, made.way, scene.friction * d * 1.5, std::min(a, side / 2));
  return made;
}

}  // namespace tactel::host
