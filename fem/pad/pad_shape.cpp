// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include "fem/numbers/angles.h"
#include "fem/numbers/number_text.h"
#include "fem/numbers/value_error.h"
#include "fem/pad/pad_mix.h"
#include "fem/pad/pad_scene.h"
#include "fem/scenes/measured_profile.h"
#include "fem/scenes/shape_numbers.h"

namespace tactel::fem {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// height of a circle of this radius at distance r from its lowest point.
double circle(double radius, double r) {
  return r <= radius ? r * r / (radius + std::sqrt(radius * radius - r * r)) : infinity;
}

/// Half the width of a circle's section at a depth.
double section_of_circle(double radius, double depth) {
  return depth < radius ? std::sqrt(depth * (2 * radius - depth)) : radius;
}

/// (distance beyond a flat)^2 / (2 edge); a sharp edge is ignored.
double rounding(double beyond, double edge) { return beyond > 0 && edge > 0 ? beyond * beyond / (2 * edge) : 0; }

/// Half a section through a flat with a rounded edge. A tilted edge is touched `slope * edge` farther out; the search
/// finds how far inwards the bottom is touched.
double section_of_flat(double flat, double edge, double depth, double slope) {
  return flat + slope * edge + std::sqrt(2 * edge * depth);
}

/// How far the lowest point of a tilted flat lies below its axis; on a rounded edge `slope * edge` beyond the flat.
double below_axis(double slope, double flat, double edge) { return slope * flat + slope * slope * edge / 2; }

double far(double x, double y) { return std::sqrt(x * x + y * y); }

PadBox centred(double x, double y) { return {{-x, x}, {-y, y}}; }

/// Slope of a tilted bottom, and along x and y.
struct Tilt {
  explicit Tilt(const PadIndenter& indenter) : slope(std::tan(radians(indenter.tilt))) {
    const double direction = radians(indenter.tilt_direction);
    x = slope * std::cos(direction), y = slope * std::sin(direction);
  }
  double slope, x, y;
};

/// What a shape is besides its numbers, in its own frame, lengths in mm. These are most shapes; one that differs says
/// so in its own Geometry.
struct AnyShape {
  static constexpr bool round = false;  ///< about its axis
  static constexpr bool tilts = false;  ///< has a flat bottom; then below(shape, Tilt) is needed
  static PadEdge edge(const auto&) { return PadEdge::none; }
  static PadBox edges(const auto&) { return centred(infinity, infinity); }  ///< where it ends sharply
};

/// height(shape): a function of (x, y), above the lowest point. section(shape, depth, slope of its tilt): a box around
/// what lies below a depth. check(shape): throws ValueError. draws: random ones on a layer H thick, for PadMix.
template <class S>
struct Geometry;

template <>
struct Geometry<Sphere> : AnyShape {
  static constexpr bool round = true;
  static auto height(const Sphere& s) {
    return [&s](double x, double y) { return circle(s.radius, far(x, y)); };
  }
  static PadBox section(const Sphere& s, double depth, double) {
    return centred(section_of_circle(s.radius, depth), section_of_circle(s.radius, depth));
  }
  static void check(const Sphere& s) { check_length("indenter.radius", s.radius); }
  static void draw(PadIndenter& indenter, double H, RandomNumbers& random) {
    indenter.shape = Sphere{H * random.log_in(1, 8)};
  }
  static constexpr PadDraw draws[] = {draw, draw};
};

template <>
struct Geometry<Paraboloid> : AnyShape {
  static auto height(const Paraboloid& p) {
    return [&p](double x, double y) { return x * x / (2 * p.radii[0]) + y * y / (2 * p.radii[1]); };
  }
  static PadBox section(const Paraboloid& p, double depth, double) {
    return centred(std::sqrt(2 * p.radii[0] * depth), std::sqrt(2 * p.radii[1] * depth));
  }
  static void check(const Paraboloid& p) {
    for (const double radius : p.radii) check_length("indenter.radii", radius);
  }
  static void draw(PadIndenter& indenter, double H, RandomNumbers& random) {
    indenter.shape = Paraboloid{{H * random.log_in(1, 8), H * random.log_in(1, 8)}};
  }
  static constexpr PadDraw draws[] = {draw};
};

template <>
struct Geometry<LyingCylinder> : AnyShape {
  static PadEdge edge(const LyingCylinder&) { return PadEdge::ends; }
  static PadBox edges(const LyingCylinder& c) { return centred(infinity, c.half_length); }
  static auto height(const LyingCylinder& c) {
    return [&c](double x, double) { return circle(c.radius, std::abs(x)); };
  }
  static PadBox section(const LyingCylinder& c, double depth, double) {
    return centred(section_of_circle(c.radius, depth), c.half_length);
  }
  static void check(const LyingCylinder& c) {
    check_length("indenter.radius", c.radius);
    check_length("indenter.half_length", c.half_length);
  }
  static void draw(PadIndenter& indenter, double H, RandomNumbers& random) {
    indenter.shape = LyingCylinder{H * random.log_in(1, 6), H * random.in(0.5, 2)};
  }
  static constexpr PadDraw draws[] = {draw};
};

void check_edge(double edge) {
  if (edge != 0) check_length("indenter.edge", edge, "a radius in mm, 0 (sharp) to 1e6");
}

PadEdge edge_of_flat(double edge) { return edge > 0 ? PadEdge::rounded : PadEdge::sharp; }

template <>
struct Geometry<Punch> : AnyShape {
  static constexpr bool round = true, tilts = true;
  static PadEdge edge(const Punch& p) { return edge_of_flat(p.edge); }
  static PadBox edges(const Punch& p) { return p.edge > 0 ? centred(infinity, infinity) : centred(p.radius, p.radius); }
  static auto height(const Punch& p) {
    return [&p](double x, double y) { return rounding(far(x, y) - p.radius, p.edge); };
  }
  static PadBox section(const Punch& p, double depth, double slope) {
    const double half = section_of_flat(p.radius, p.edge, depth, slope);
    return centred(half, half);
  }
  static double below(const Punch& p, const Tilt& t) { return below_axis(t.slope, p.radius, p.edge); }
  static void check(const Punch& p) {
    check_length("indenter.radius", p.radius);
    check_edge(p.edge);
  }
  static void draw(PadIndenter& indenter, double H, RandomNumbers& random) {
    indenter.shape = Punch{H * random.in(0.4, 1.5), 0};
  }
  static void draw_rounded(PadIndenter& indenter, double H, RandomNumbers& random) {
    const double radius = H * random.in(0.4, 1.5);
    indenter.shape = Punch{radius, H * random.in(0.1, 0.5)};
    indenter.tilt = random.in(0, 5);
    indenter.tilt_direction = random.in(0, 360);
  }
  static constexpr PadDraw draws[] = {draw, draw_rounded};
};

template <>
struct Geometry<Box> : AnyShape {
  static constexpr bool tilts = true;
  static PadEdge edge(const Box& b) { return edge_of_flat(b.edge); }
  static PadBox edges(const Box& b) {
    return b.edge > 0 ? centred(infinity, infinity) : centred(b.half_widths[0], b.half_widths[1]);
  }
  static auto height(const Box& b) {
    return [&b](double x, double y) {
      return rounding(std::abs(x) - b.half_widths[0], b.edge) + rounding(std::abs(y) - b.half_widths[1], b.edge);
    };
  }
  static PadBox section(const Box& b, double depth, double slope) {
    return centred(section_of_flat(b.half_widths[0], b.edge, depth, slope),
                   section_of_flat(b.half_widths[1], b.edge, depth, slope));
  }
  static double below(const Box& b, const Tilt& t) {
    return below_axis(std::abs(t.x), b.half_widths[0], b.edge) + below_axis(std::abs(t.y), b.half_widths[1], b.edge);
  }
  static void check(const Box& b) {
    for (const double width : b.half_widths) check_length("indenter.half_widths", width);
    check_edge(b.edge);
  }
  static void draw(PadIndenter& indenter, double H, RandomNumbers& random) {
    indenter.shape = Box{{H * random.in(0.4, 1.5), H * random.in(0.4, 1.5)}, 0};
  }
  static void draw_rounded(PadIndenter& indenter, double H, RandomNumbers& random) {
    indenter.shape = Box{{H * random.in(0.4, 1.5), H * random.in(0.4, 1.5)}, H * random.log_in(0.05, 0.5)};
  }
  static constexpr PadDraw draws[] = {draw, draw_rounded};
};

template <>
struct Geometry<Cone> : AnyShape {
  static constexpr bool round = true;
  static auto height(const Cone& c) {
    return [wide = std::tan(radians(c.angle))](double x, double y) { return far(x, y) / wide; };
  }
  static PadBox section(const Cone& c, double depth, double) {
    const double half = depth * std::tan(radians(c.angle));
    return centred(half, half);
  }
  static void check(const Cone& c) {
    if (!(c.angle > 0 && c.angle < 90))
      throw ValueError("indenter.angle", number_text(c.angle), "degrees, above 0 and below 90");
  }
  static void draw(PadIndenter& indenter, double, RandomNumbers& random) { indenter.shape = Cone{random.in(65, 85)}; }
  static constexpr PadDraw draws[] = {draw};
};

template <>
struct Geometry<HeightMap> : AnyShape {
  static PadEdge edge(const HeightMap&) { return PadEdge::measured; }
  static PadBox edges(const HeightMap& m) {
    const auto half = [&m](Eigen::Index points) { return m.pitch * static_cast<double>(points - 1) / 2; };
    return centred(half(m.heights.rows()), half(m.heights.cols()));
  }
  static auto height(const HeightMap& m) {
    return [&m](double x, double y) { return between(m, x, y); };
  }
  static double between(const HeightMap& map, double x, double y) {
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
  static PadBox section(const HeightMap& m, double depth, double) {
    PadBox box{{infinity, -infinity}, {infinity, -infinity}};
    for (Eigen::Index i = 0; i < m.heights.rows(); ++i)
      for (Eigen::Index j = 0; j < m.heights.cols(); ++j) {
        if (m.heights(i, j) > depth) continue;
        const double x = m.pitch * (static_cast<double>(i) - static_cast<double>(m.heights.rows() - 1) / 2);
        const double y = m.pitch * (static_cast<double>(j) - static_cast<double>(m.heights.cols() - 1) / 2);
        box = {{std::min(box.x.left, x - m.pitch), std::max(box.x.right, x + m.pitch)},
               {std::min(box.y.left, y - m.pitch), std::max(box.y.right, y + m.pitch)}};
      }
    return box;
  }
  static void check(const HeightMap& m) {
    check_length("indenter.pitch", m.pitch);
    const bool grid = m.heights.rows() >= 2 && m.heights.cols() >= 2 && m.heights.allFinite();
    const char* key = m.file.empty() ? "indenter.heights" : "indenter.file";
    if (!grid || m.heights.minCoeff() != 0 || m.heights.maxCoeff() > 1e6)
      throw ValueError(key, number_text(static_cast<double>(m.heights.size())),
                       "a grid of 2 x 2 heights at least, the lowest 0, the highest below 1e6 mm");
    const auto longest = static_cast<double>(std::max(m.heights.rows(), m.heights.cols()) - 1);
    check_range(key, m.heights.maxCoeff(), m.pitch * longest);
  }
  static constexpr std::array<PadDraw, 0> draws{};  ///< drawn elsewhere
};

/// visit(Geometry<S>, shape) for the shape S that it is.
template <class Visit>
auto with_geometry(const PadShape& shape, Visit visit) {
  return std::visit([&visit]<class S>(const S& kind) { return visit(Geometry<S>{}, kind); }, shape);
}

/// How far the lowest point of a tilted bottom lies below its axis.
double below(const PadShape& shape, const Tilt& tilt) {
  return with_geometry(shape, [&tilt](auto geometry, const auto& kind) {
    if constexpr (geometry.tilts)
      return geometry.below(kind, tilt);
    else
      return 0.0;
  });
}

}  // namespace

const char* shape_name(const PadShape& shape) {
  static_assert(pad_shapes.size() == std::variant_size_v<PadShape>);
  return pad_shapes[shape.index()].key;
}

bool tilts(const PadShape& shape) {
  return with_geometry(shape, [](auto geometry, const auto&) { return geometry.tilts; });
}

bool is_round(const PadIndenter& indenter) {
  return indenter.tilt == 0 && with_geometry(indenter.shape, [](auto geometry, const auto&) { return geometry.round; });
}

PadEdge pad_edge(const PadShape& shape) {
  return with_geometry(shape, [](auto geometry, const auto& kind) { return geometry.edge(kind); });
}

void check_shape(const PadShape& shape) {
  with_geometry(shape, [](auto geometry, const auto& kind) { geometry.check(kind); });
}

namespace {

/// How far a curved skin lies below its middle at a place of the own frame, mm, less `touch`.
double fall(const PadIndenter& indenter, double x, double y) {
  if (indenter.curvature == 0) return 0;
  const double cosine = std::cos(radians(indenter.yaw)), sine = std::sin(radians(indenter.yaw));
  const double r = far(indenter.position[0] + cosine * x - sine * y, indenter.position[1] + sine * x + cosine * y);
  return indenter.curvature * r * r / 2 - indenter.touch;
}

/// The least height: of all points of a map, else on ever finer grids about the least so far, for shapes are convex.
double least_height(const PadIndenter& indenter) {
  constexpr int points = 16, rounds = 12;
  double least = infinity;
  Eigen::Vector2d lowest(0, 0);
  const auto look = [&](double x, double y) {
    if (const double height = pad_height(indenter, x, y); height < least) least = height, lowest = {x, y};
  };
  if (const auto* map = std::get_if<HeightMap>(&indenter.shape)) {
    const PadBox edges = pad_edges(*map);
    for (Eigen::Index i = 0; i < map->heights.rows(); ++i)
      for (Eigen::Index j = 0; j < map->heights.cols(); ++j)
        look(edges.x.left + map->pitch * static_cast<double>(i), edges.y.left + map->pitch * static_cast<double>(j));
    return least;
  }
  PadBox box = rigid_section(indenter, pad_height(indenter, 0, 0));
  for (int round = 0; round < rounds; ++round) {
    const double hx = (box.x.right - box.x.left) / points, hy = (box.y.right - box.y.left) / points;
    for (int i = 0; i <= points; ++i)
      for (int j = 0; j <= points; ++j) look(box.x.left + i * hx, box.y.left + j * hy);
    box = {{lowest[0] - 2 * hx, lowest[0] + 2 * hx}, {lowest[1] - 2 * hy, lowest[1] + 2 * hy}};
  }
  return least;
}

}  // namespace

PadIndenter over_skin(PadIndenter indenter, const PadSensor& sensor) {
  indenter.curvature = sensor.curvature_radius ? 1 / *sensor.curvature_radius : 0, indenter.touch = 0;
  if (indenter.curvature > 0) indenter.touch = least_height(indenter);
  return indenter;
}

double pad_height(const PadIndenter& indenter, double x, double y, bool beyond_edges) {
  const auto inside = [](const Interval& edges, double at) { return at >= edges.left && at <= edges.right; };
  const double height = with_geometry(indenter.shape, [&](auto geometry, const auto& shape) {
    if (!beyond_edges) {
      const PadBox edges = geometry.edges(shape);
      if (!(geometry.round ? inside(edges.x, std::hypot(x, y)) : inside(edges.x, x) && inside(edges.y, y)))
        return infinity;
    }
    return geometry.height(shape)(x, y);
  });
  const double above = height + fall(indenter, x, y);
  if (indenter.tilt == 0) return above;
  const Tilt tilt(indenter);
  return above + tilt.x * x + tilt.y * y + below(indenter.shape, tilt);
}

Eigen::MatrixXd pad_heights(const PadIndenter& indenter, const Eigen::ArrayXd& x, const Eigen::ArrayXd& y) {
  Eigen::MatrixXd heights(x.size(), y.size());
  with_geometry(indenter.shape, [&](auto geometry, const auto& shape) {
    const auto height = geometry.height(shape);
    for (Eigen::Index j = 0; j < y.size(); ++j)
      for (Eigen::Index i = 0; i < x.size(); ++i) heights(i, j) = height(x[i], y[j]);
  });
  for (Eigen::Index j = 0; j < y.size() && indenter.curvature != 0; ++j)
    for (Eigen::Index i = 0; i < x.size(); ++i) heights(i, j) += fall(indenter, x[i], y[j]);
  if (indenter.tilt == 0) return heights;
  const Tilt tilt(indenter);
  heights.array().colwise() += tilt.x * x + below(indenter.shape, tilt);
  heights.array().rowwise() += tilt.y * y.transpose();
  return heights;
}

PadBox pad_edges(const PadShape& shape) {
  return with_geometry(shape, [](auto geometry, const auto& kind) { return geometry.edges(kind); });
}

PadBox rigid_section(const PadIndenter& indenter, double depth) {
  const double slope = std::tan(radians(std::abs(indenter.tilt)));
  const double deep = std::max(depth, 0.0) + indenter.touch;
  PadBox box = with_geometry(indenter.shape,
                             [&](auto geometry, const auto& shape) { return geometry.section(shape, deep, slope); });
  if (indenter.curvature == 0) return box;
  const double half = std::sqrt(2 * deep / indenter.curvature);  // where the skin has fallen by less
  const Eigen::Vector2d middle =
      Eigen::Rotation2Dd(-radians(indenter.yaw)) * Eigen::Vector2d(-indenter.position[0], -indenter.position[1]);
  box.x = {std::max(box.x.left, middle[0] - half), std::min(box.x.right, middle[0] + half)};
  box.y = {std::max(box.y.left, middle[1] - half), std::min(box.y.right, middle[1] + half)};
  return box;
}

std::vector<PadDraw> pad_draws() {
  std::vector<PadDraw> all;
  const auto add = [&all]<class S>(std::type_identity<S>) {
    all.insert(all.end(), std::begin(Geometry<S>::draws), std::end(Geometry<S>::draws));
  };
  [&]<class... S>(std::type_identity<std::variant<S...>>) {
    (add(std::type_identity<S>{}), ...);
  }(std::type_identity<PadShape>{});
  return all;
}

}  // namespace tactel::fem
