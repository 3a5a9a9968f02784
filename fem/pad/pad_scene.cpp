// SPDX-License-Identifier: Apache-2.0
#include "fem/pad/pad_scene.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "fem/angles.h"
#include "fem/measured_profile.h"
#include "fem/number_text.h"
#include "fem/overloaded.h"
#include "fem/shape_numbers.h"
#include "fem/value_error.h"

namespace tactel::fem {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// height of a circle of this radius at distance r from its lowest point.
double circle(double radius, double r) {
  return r <= radius ? r * r / (radius + std::sqrt(radius * radius - r * r)) : infinity;
}

/// Half the width of a circle's section at a depth.
double section(double radius, double depth) {
  return depth < radius ? std::sqrt(depth * (2 * radius - depth)) : radius;
}

/// (distance beyond a flat)^2 / (2 edge); a sharp edge is ignored.
double rounding(double beyond, double edge) { return beyond > 0 && edge > 0 ? beyond * beyond / (2 * edge) : 0; }

double between(const HeightMap& map, double x, double y) {
  const Eigen::Index rows = map.heights.rows(), columns = map.heights.cols();
  const double i = x / map.pitch + static_cast<double>(rows - 1) / 2;
  const double j = y / map.pitch + static_cast<double>(columns - 1) / 2;
  if (!(i >= 0 && j >= 0 && i <= static_cast<double>(rows - 1) && j <= static_cast<double>(columns - 1)))
    return infinity;
  const Eigen::Index k = std::min(static_cast<Eigen::Index>(i), rows - 2),
                     l = std::min(static_cast<Eigen::Index>(j), columns - 2);
  const double p = i - static_cast<double>(k), q = j - static_cast<double>(l);
  const auto h = map.heights.block<2, 2>(k, l);
  return (1 - p) * ((1 - q) * h(0, 0) + q * h(0, 1)) + p * ((1 - q) * h(1, 0) + q * h(1, 1));
}

/// Returns use(h): h(x, y) is the height of the upright shape. What does not depend on the place is worked out once.
template <class Use>
auto with_heights(const PadShape& shape, Use use) {
  const auto far = [](double x, double y) { return std::sqrt(x * x + y * y); };
  return std::visit(
      Overloaded{
          [&](const Sphere& s) { return use([&](double x, double y) { return circle(s.radius, far(x, y)); }); },
          [&](const Paraboloid& p) {
            return use([&](double x, double y) { return x * x / (2 * p.radii[0]) + y * y / (2 * p.radii[1]); });
          },
          [&](const LyingCylinder& c) { return use([&](double x, double) { return circle(c.radius, std::abs(x)); }); },
          [&](const Punch& p) {
            return use([&](double x, double y) { return rounding(far(x, y) - p.radius, p.edge); });
          },
          [&](const Box& b) {
            return use([&](double x, double y) {
              return rounding(std::abs(x) - b.half_widths[0], b.edge) +
                     rounding(std::abs(y) - b.half_widths[1], b.edge);
            });
          },
          [&](const Cone& c) {
            return use([wide = std::tan(radians(c.angle)), &far](double x, double y) { return far(x, y) / wide; });
          },
          [&](const HeightMap& m) { return use([&m](double x, double y) { return between(m, x, y); }); }},
      shape);
}

/// The tilted bottom as a plane: slopes along x and y, and how far its lowest point lies below the axis. On a rounding
/// edge it lies slope * edge beyond the flat.
struct Tilt {
  explicit Tilt(const PadIndenter& indenter) {
    const double slope = std::tan(radians(indenter.tilt)), direction = radians(indenter.tilt_direction);
    x = slope * std::cos(direction), y = slope * std::sin(direction);
    const auto lowest = [](double t, double flat, double edge) { return t * flat + t * t * edge / 2; };
    if (const auto* punch = std::get_if<Punch>(&indenter.shape)) below = lowest(slope, punch->radius, punch->edge);
    if (const auto* box = std::get_if<Box>(&indenter.shape))
      below = lowest(std::abs(x), box->half_widths[0], box->edge) + lowest(std::abs(y), box->half_widths[1], box->edge);
  }
  double x, y, below = 0;
};

PadBox centred(double x, double y) { return {{-x, x}, {-y, y}}; }

}  // namespace

const char* name(Sides sides) { return sides == Sides::free ? "free" : "held"; }

const char* shape_name(const PadShape& shape) {
  static_assert(pad_shapes.size() == std::variant_size_v<PadShape>);
  return pad_shapes[shape.index()];
}

double pad_height(const PadIndenter& indenter, double x, double y, bool beyond_edges) {
  const auto inside = [](const Interval& edges, double at) { return at >= edges.left && at <= edges.right; };
  if (!beyond_edges) {
    const PadBox edges = pad_edges(indenter.shape);
    const bool round = std::holds_alternative<Punch>(indenter.shape);
    if (!(round ? inside(edges.x, std::hypot(x, y)) : inside(edges.x, x) && inside(edges.y, y))) return infinity;
  }
  const double height = with_heights(indenter.shape, [x, y](const auto& h) { return h(x, y); });
  if (indenter.tilt == 0) return height;
  const Tilt tilt(indenter);
  return height + tilt.x * x + tilt.y * y + tilt.below;
}

Eigen::MatrixXd pad_heights(const PadIndenter& indenter, const Eigen::ArrayXd& x, const Eigen::ArrayXd& y) {
  Eigen::MatrixXd heights(x.size(), y.size());
  with_heights(indenter.shape, [&](const auto& height) {
    for (Eigen::Index j = 0; j < y.size(); ++j)
      for (Eigen::Index i = 0; i < x.size(); ++i) heights(i, j) = height(x[i], y[j]);
  });
  if (indenter.tilt == 0) return heights;
  const Tilt tilt(indenter);
  heights.array().colwise() += tilt.x * x + tilt.below;
  heights.array().rowwise() += tilt.y * y.transpose();
  return heights;
}

PadBox pad_edges(const PadShape& shape) {
  return std::visit(
      Overloaded{[](const LyingCylinder& c) { return centred(infinity, c.half_length); },
                 [](const Punch& p) { return p.edge > 0 ? centred(infinity, infinity) : centred(p.radius, p.radius); },
                 [](const Box& b) {
                   return b.edge > 0 ? centred(infinity, infinity) : centred(b.half_widths[0], b.half_widths[1]);
                 },
                 [](const HeightMap& m) {
                   const auto half = [&m](Eigen::Index points) {
                     return m.pitch * static_cast<double>(points - 1) / 2;
                   };
                   return centred(half(m.heights.rows()), half(m.heights.cols()));
                 },
                 [](const auto&) { return centred(infinity, infinity); }},
      shape);
}

PadBox rigid_section(const PadIndenter& indenter, double depth) {
  const double d = std::max(depth, 0.0);
  // A tilted edge is touched that much farther out; the search finds how far inwards the bottom is touched.
  const double steep = std::tan(radians(std::abs(indenter.tilt)));
  const auto rounded = [&](double flat, double edge) { return flat + steep * edge + std::sqrt(2 * edge * d); };
  return std::visit(
      Overloaded{
          [&](const Sphere& s) { return centred(section(s.radius, d), section(s.radius, d)); },
          [&](const Paraboloid& p) { return centred(std::sqrt(2 * p.radii[0] * d), std::sqrt(2 * p.radii[1] * d)); },
          [&](const LyingCylinder& c) { return centred(section(c.radius, d), c.half_length); },
          [&](const Punch& p) { return centred(rounded(p.radius, p.edge), rounded(p.radius, p.edge)); },
          [&](const Box& b) { return centred(rounded(b.half_widths[0], b.edge), rounded(b.half_widths[1], b.edge)); },
          [&](const Cone& c) { return centred(d * std::tan(radians(c.angle)), d * std::tan(radians(c.angle))); },
          [&](const HeightMap& m) {
            PadBox box{{infinity, -infinity}, {infinity, -infinity}};
            for (Eigen::Index i = 0; i < m.heights.rows(); ++i)
              for (Eigen::Index j = 0; j < m.heights.cols(); ++j) {
                if (m.heights(i, j) > d) continue;
                const double x = m.pitch * (static_cast<double>(i) - static_cast<double>(m.heights.rows() - 1) / 2);
                const double y = m.pitch * (static_cast<double>(j) - static_cast<double>(m.heights.cols() - 1) / 2);
                box = {{std::min(box.x.left, x - m.pitch), std::max(box.x.right, x + m.pitch)},
                       {std::min(box.y.left, y - m.pitch), std::max(box.y.right, y + m.pitch)}};
              }
            return box;
          }},
      indenter.shape);
}

namespace {

void check(bool good, const std::string& key, double value, const char* allowed) {
  if (!good) throw ValueError(key, number_text(value), allowed);
}

/// A length that any product with others leaves finite.
void check_length(const char* member, double value) {
  check(value >= 1e-6 && value <= 1e6, member, value, "a length in mm, between 1e-6 and 1e6");
}

void check_edge(double value) {
  check(value == 0 || (value >= 1e-6 && value <= 1e6), "indenter.edge", value, "a radius in mm, 0 (sharp) to 1e6");
}

}  // namespace

void validate(const PadSensor& sensor) {
  check_length("sensor.thickness", sensor.thickness);
  check(sensor.young >= 1e-9 && sensor.young <= 1e12, "sensor.young", sensor.young,
        "a Young's modulus in MPa, 1e-9 to 1e12");
  check(sensor.poisson >= 0 && sensor.poisson <= 0.5, "sensor.poisson", sensor.poisson,
        "a Poisson's ratio, 0 <= poisson <= 0.5");
  for (const int count : sensor.tactels)
    check(count >= 1 && count <= 100, "sensor.tactels", count, "numbers of tactels along x and y, 1 to 100 each");
  for (const double p : sensor.pitch) check_length("sensor.pitch", p);
  check(sensor.tactel_size >= 0 && sensor.tactel_size <= std::min(sensor.pitch[0], sensor.pitch[1]),
        "sensor.tactel_size", sensor.tactel_size, "a side in mm, 0 (a point) to the pitch");
  check(sensor.axes == 1 || sensor.axes == 3, "sensor.axes", sensor.axes, "3, or 1 (normal stress only)");
  const auto check_side = [&](const char* member, const std::optional<double>& side, int axis) {
    if (!side) return;
    check_length(member, *side);
    const double array = std::round(1e6 * ((sensor.tactels[axis] - 1) * sensor.pitch[axis] + sensor.tactel_size)) / 1e6;
    check(*side >= array, member, *side,
          ("a length in mm that holds the tactels, " + number_text(array) + " or more").c_str());
  };
  check_side("sensor.length", sensor.length, 0);
  check_side("sensor.width", sensor.width, 1);
  constexpr double tallest = 4;
  if (sensor.sides == Sides::free && sensor.length && sensor.width)
    check(sensor.thickness <= tallest * std::min(*sensor.length, *sensor.width), "sensor.thickness", sensor.thickness,
          "4 times the shorter side or less where sides are free; or sensor.sides = \"held\"");
}

void PadIndenter::validate() const {
  std::visit(
      Overloaded{[](const Sphere& s) { check_length("indenter.radius", s.radius); },
                 [](const Paraboloid& p) {
                   for (const double radius : p.radii) check_length("indenter.radii", radius);
                 },
                 [](const LyingCylinder& c) {
                   check_length("indenter.radius", c.radius);
                   check_length("indenter.half_length", c.half_length);
                 },
                 [](const Punch& p) {
                   check_length("indenter.radius", p.radius);
                   check_edge(p.edge);
                 },
                 [](const Box& b) {
                   for (const double width : b.half_widths) check_length("indenter.half_widths", width);
                   check_edge(b.edge);
                 },
                 [](const Cone& c) {
                   check(c.angle > 0 && c.angle < 90, "indenter.angle", c.angle, "degrees, above 0 and below 90");
                 },
                 [](const HeightMap& m) {
                   check_length("indenter.pitch", m.pitch);
                   const bool grid = m.heights.rows() >= 2 && m.heights.cols() >= 2 && m.heights.allFinite();
                   const char* key = m.file.empty() ? "indenter.heights" : "indenter.file";
                   check(grid && m.heights.minCoeff() == 0 && m.heights.maxCoeff() <= 1e6, key,
                         static_cast<double>(m.heights.size()),
                         "a grid of 2 x 2 heights at least, the lowest 0, the highest below 1e6 mm");
                   check_range(key, m.heights.maxCoeff(), m.pitch * (std::max(m.heights.rows(), m.heights.cols()) - 1));
                 }},
      shape);
  for (const double p : position)
    check(std::abs(p) <= 1e6, "indenter.position", p, "a place in mm, at most 1e6 from the middle");
  check(std::abs(yaw) <= 360, "indenter.yaw", yaw, "degrees, -360 to 360");
  check(tilt == 0 || (tilts(shape) && tilt > 0 && tilt <= 45), "indenter.tilt", tilt,
        "degrees, 0 to 45, and 0 but for punch and box");
  check(std::abs(tilt_direction) <= 360, "indenter.tilt_direction", tilt_direction, "degrees, -360 to 360");
}

void PadLoad::validate() const {
  const bool force = !normal_force.empty();
  const std::vector<double>& normal = force ? normal_force : indentation;
  if (normal.empty()) throw ValueError("load.indentation", "[]", "at least one depth in mm (or give normal_force)");
  for (const double value : normal) {
    if (force)
      check(value >= 0 && value <= 1e9, "load.normal_force", value, "a force in N, 0 to 1e9");
    else
      check(value >= 0 && value <= 1e6, "load.indentation", value, "a depth in mm, 0 to 1e6");
  }
  check(indentation_steps >= 1 && indentation_steps <= 1000, "load.indentation_steps", indentation_steps, "1 to 1000");
  if (normal.size() * indentation_steps > most_pad_targets)
    throw ValueError(indentation_steps > 1 ? "load.indentation_steps"
                     : force               ? "load.normal_force"
                                           : "load.indentation",
                     std::to_string(indentation_steps > 1 ? indentation_steps : static_cast<int>(normal.size())),
                     "so few that the pressing takes 1000 increments at most");
  check(drags.size() <= 1000, "load.tangential", static_cast<double>(drags.size()), "at most 1000 positions");
  check(moves.size() <= 1000, "load.moves", static_cast<double>(moves.size()), "at most 1000 moves");
  if (!moves.empty() && !drags.empty())
    throw ValueError("load.moves", std::to_string(moves.size()) + " moves", "left out where drags are given");
  for (const PadTarget& move : moves) {
    check(move.normal >= 0 && move.normal <= 1e6, "load.moves", move.normal, "a depth or force, 0 to 1e6");
    check(std::abs(move.x) <= 1e6 && std::abs(move.y) <= 1e6, "load.moves", std::hypot(move.x, move.y),
          "places in mm, at most 1e6 away");
    check(std::abs(move.twist) <= 2 * std::numbers::pi, "load.moves", degrees(move.twist),
          "twists in degrees, -360 to 360");
  }
  for (const auto& drag : drags) {
    for (int axis = 0; axis < 2; ++axis)
      check(std::abs(drag[axis]) <= 1e6, "load.tangential", drag[axis], "a place in mm, at most 1e6 away");
    check(std::abs(drag[2]) <= 2 * std::numbers::pi, "load.twist", clean_degrees(drag[2]), "degrees, -360 to 360");
  }
}

void PadScene::validate() const {
  check_title(title);
  fem::validate(sensor);
  indenter.validate();
  load.validate();
  check(friction >= 0 && friction <= 100, "contact.friction", friction, "a coefficient of friction, 0 to 100");
}

std::vector<PadTarget> pad_targets(const PadLoad& load) {
  const std::vector<double>& normal = load.normal_force.empty() ? load.indentation : load.normal_force;
  std::vector<PadTarget> targets;
  double from = 0;
  for (const double to : normal) {
    for (int k = 1; k <= load.indentation_steps; ++k)
      targets.push_back({from + (to - from) * k / load.indentation_steps, 0, 0, 0});
    from = to;
  }
  for (const auto& drag : load.drags) targets.push_back({from, drag[0], drag[1], drag[2]});
  targets.insert(targets.end(), load.moves.begin(), load.moves.end());
  return targets;
}

std::size_t pressing_targets(const PadLoad& load) {
  return (load.normal_force.empty() ? load.indentation : load.normal_force).size() *
         static_cast<std::size_t>(load.indentation_steps);
}

double largest_normal(const PadLoad& load) {
  double largest = 0;
  for (const PadTarget& target : pad_targets(load)) largest = std::max(largest, target.normal);
  return largest;
}

}  // namespace tactel::fem
