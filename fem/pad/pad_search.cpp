// SPDX-License-Identifier: Apache-2.0
#include "fem/pad/pad_search.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "fem/layer/patch_search.h"
#include "fem/numbers/angles.h"
#include "fem/pad/pad_layers.h"

namespace tactel::fem {
namespace {

constexpr int n = pad_search_cells;

/// Pressures without friction, [n n] over E, by Gauss-Seidel from zero. own(i): influence of a cell on itself;
/// hear(i, more, opening) tells the others of a change.
template <class Own, class Hear>
Eigen::ArrayXd press_by(const Own& own, const Hear& hear, const Eigen::ArrayXd& gap) {
  Eigen::ArrayXd p = Eigen::ArrayXd::Zero(n * n), opening = gap;
  for (int sweep = 0; sweep < search_most_sweeps; ++sweep) {
    double change = 0;
    for (int i = 0; i < n * n; ++i) {
      const double pressed = std::max(0.0, p[i] - opening[i] / own(i)), more = pressed - p[i];
      if (more == 0) continue;  // only cells that change are heard by the others
      hear(i, more, opening);
      change = std::max(change, std::abs(more));
      p[i] = pressed;
    }
    if (change <= search_tolerance * p.maxCoeff()) break;
  }
  return p;
}

/// `c` [n][n]: influence by the offset.
Eigen::ArrayXd press(const Eigen::MatrixXd& c, const Eigen::ArrayXd& gap) {
  // The influence, mirrored, so that the sources of a row of cells lie side by side.
  Eigen::MatrixXd mirrored(2 * n - 1, 2 * n - 1);  // [along y][along x]: columns lie side by side
  for (int i = 1 - n; i < n; ++i)
    for (int j = 1 - n; j < n; ++j) mirrored(j + n - 1, i + n - 1) = c(std::abs(i), std::abs(j));
  const auto hear = [&](int i, double more, Eigen::ArrayXd& opening) {
    for (int j = 0; j < n; ++j)
      opening.segment<n>(j * n) += more * mirrored.col(j - i / n + n - 1).segment<n>(n - 1 - i % n).array();
  };
  return press_by([&](int) { return c(0, 0); }, hear, gap);
}

/// `c` [n n][n n]: influence of each cell on each.
Eigen::ArrayXd press_by_pairs(const Eigen::MatrixXd& c, const Eigen::ArrayXd& gap) {
  const auto hear = [&](int i, double more, Eigen::ArrayXd& opening) { opening += more * c.col(i).array(); };
  return press_by([&](int i) { return c(i, i); }, hear, gap);
}

/// The window's cells, and where they lie on the pad.
struct Window {
  const PadBox& box;
  double hx = (box.x.right - box.x.left) / n, hy = (box.y.right - box.y.left) / n;
  Eigen::Vector2d place(int i) const {
    const int ix = i / n, iy = i % n;
    return {box.x.left + (ix + 0.5) * hx, box.y.left + (iy + 0.5) * hy};
  }
};

/// Normal influence of a window's cells with that of the free sides, [n n][n n].
Eigen::MatrixXd with_sides(const Eigen::MatrixXd& layer, const Window& window, const PadScene& scene,
                           const PadFrame& frame) {
  const SideKernel& kernel = *frame.sides.kernel;
  const Eigen::Rotation2Dd turn(radians(scene.indenter.yaw + frame.turn));
  const Eigen::Vector2d origin(scene.indenter.position[0], scene.indenter.position[1]);
  std::vector<SideKernel::Shares> at;
  for (int i = 0; i < n * n; ++i) {
    const Eigen::Vector2d place = frame.sides.in_block(origin + turn * window.place(i));
    at.push_back(kernel.shares(place[0], place[1]));
  }
  const double scale = window.hx * window.hy / frame.sides.thickness;
  Eigen::MatrixXd to_nodes = Eigen::MatrixXd::Zero(kernel.normal_displacement().rows(), n * n);
  for (int i = 0; i < n * n; ++i)
    for (int k = 0; k < at[i].count; ++k)
      to_nodes.col(i) += (scale * at[i].share[k]) * kernel.normal_displacement().col(at[i].node[k]);
  // Whole columns at once: by node, and what moves cell i in column i.
  const Eigen::MatrixXd by_node = to_nodes.transpose();
  Eigen::MatrixXd c(n * n, n * n);
  for (int i = 0; i < n * n; ++i) {
    for (int by = 0; by < n * n; ++by) c(by, i) = layer(std::abs(i / n - by / n), std::abs(i % n - by % n));
    for (int k = 0; k < at[i].count; ++k) c.col(i) += at[i].share[k] * by_node.col(at[i].node[k]);
  }
  return c.transpose();
}

/// A box around another one, turned by so many degrees.
PadBox turned(const PadBox& box, double degrees) {
  if (degrees == 0) return box;
  const Eigen::Matrix2d turn = Eigen::Rotation2Dd(radians(degrees)).toRotationMatrix();
  PadBox around{nowhere, nowhere};
  for (const double x : {box.x.left, box.x.right})
    for (const double y : {box.y.left, box.y.right}) {
      if (!std::isfinite(x) || !std::isfinite(y)) return everywhere;
      const Eigen::Vector2d at = turn * Eigen::Vector2d(x, y);
      around.cover({{at[0], at[0]}, {at[1], at[1]}});
    }
  return around;
}

Interval clipped(const Interval& a, const Interval& b) {
  return {std::max(a.left, b.left), std::min(a.right, b.right)};
}

/// The part of an interval that lies on the rubber; one of its ends, some cells wide, where little or none does.
Interval on_rubber(const Interval& a, const Interval& rubber, double least) {
  const Interval part = clipped(a, rubber);
  if (part.right - part.left >= std::min(least, a.right - a.left)) return part;
  const double middle = std::clamp((a.left + a.right) / 2, rubber.left + least / 2, rubber.right - least / 2);
  return {middle - least / 2, middle + least / 2};
}

/// A box around where measured heights, bilinear between their points, lie below a depth.
PadBox low_part(const HeightMap& map, double depth) {
  const Eigen::MatrixXd& h = map.heights;
  const auto place = [&](double index, Eigen::Index count) {
    return map.pitch * (index - static_cast<double>(count - 1) / 2);
  };
  PadBox box{nowhere, nowhere};
  const auto cover = [&](double i, double j) {
    const double x = place(i, h.rows()), y = place(j, h.cols());
    box.cover({{x, x}, {y, y}});
  };
  /// Between two points of which one lies below: where the depth is met.
  const auto share = [&](double from, double to) { return (depth - from) / (to - from); };
  for (Eigen::Index i = 0; i < h.rows(); ++i)
    for (Eigen::Index j = 0; j < h.cols(); ++j) {
      const auto x = static_cast<double>(i), y = static_cast<double>(j);
      if (h(i, j) <= depth) cover(x, y);
      if (i + 1 < h.rows() && (h(i, j) <= depth) != (h(i + 1, j) <= depth)) cover(x + share(h(i, j), h(i + 1, j)), y);
      if (j + 1 < h.cols() && (h(i, j) <= depth) != (h(i, j + 1) <= depth)) cover(x, y + share(h(i, j), h(i, j + 1)));
    }
  return box;
}

/// One direction of a round: first and last pressed cell.
struct Extent {
  int first = n, last = -1;
  void add(int i) { first = std::min(first, i), last = std::max(last, i); }
  Interval pressed(const Interval& window) const {
    const double h = (window.right - window.left) / n;
    return {window.left + first * h, window.right - (n - 1 - last) * h};
  }
  Interval next(const Interval& window) const {
    const Interval now = pressed(window);
    const double h = (window.right - window.left) / n, width = now.right - now.left;
    return {now.left - (first == 0 ? search_growth * width : search_margin * h),
            now.right + (last == n - 1 ? search_growth * width : search_margin * h)};
  }
};

Interval widened(const Interval& a, double part) {
  const double more = part * (a.right - a.left);
  return {a.left - more, a.right + more};
}

/// A flat with a rounded edge, of half a width and the rounding's radius; width 0: another shape.
struct RoundedFlat {
  double half_width = 0, edge = 0;

  explicit RoundedFlat(const PadShape& shape) {
    if (const auto* punch = std::get_if<Punch>(&shape)) half_width = punch->radius, edge = punch->edge;
    if (const auto* box = std::get_if<Box>(&shape))
      half_width = std::sqrt(box->half_widths[0] * box->half_widths[1]), edge = box->edge;
  }
};

/// How far the rounding of a flat is touched beyond its end under the force that the search found, mm; 0 for other
/// shapes, and for flats so tilted that they may touch on one side alone.
double rim_reach(const PadSearch& found, const PadIndenter& indenter, const PadSensor& sensor) {
  constexpr double round_more = 1.1, box_more = 1.2;  // strength that counts over its mean: a box has corners
  const RoundedFlat flat(indenter.shape);
  const double skin = std::hypot(indenter.position[0], indenter.position[1]) + flat.half_width / 4;
  const double rise = 2 * flat.half_width * (std::tan(radians(indenter.tilt)) + indenter.curvature * skin);
  if (!(flat.edge > 0 && found.P > 0 && rise < found.depth / 2)) return 0;
  const bool round = std::holds_alternative<Punch>(indenter.shape);
  const auto& [x, y] = found.contact;
  const double area = (round ? std::numbers::pi / 4 : 1) * (x.right - x.left) * (y.right - y.left);
  const double normal = 1 - sensor.poisson * sensor.poisson + soft_object(sensor, indenter).normal();
  const double force = found.P * normal / sensor.young, depth = found.depth - rise / 2;
  const double stiffening = std::max(1.0, force / (2 * std::sqrt(area / std::numbers::pi) * depth));
  const double squared = force / area * depth * (1 - 0.5 / stiffening) / (2 * std::numbers::pi);
  const double strength = (round ? round_more : box_more) * std::sqrt(squared);
  return std::cbrt(std::pow(1.5 * std::numbers::pi * flat.edge * strength, 2));
}

/// Makes a punch sharp to its cells where they do not resolve its rounding.
void sharpen(PadIndenter& indenter, double reach, int cells) {
  auto* punch = std::get_if<Punch>(&indenter.shape);
  if (punch == nullptr || !(reach > 0 && reach < round_rim * 2 * punch->radius / cells)) return;
  *punch = {punch->radius + rim_end * reach, 0};
}

/// Sets the sides of the contact of a box to where cells should end for the right force. Returns whether it did.
bool fit_to_rim(PadBox& contact, double reach, const PadIndenter& indenter, int cells) {
  const auto* box = std::get_if<Box>(&indenter.shape);
  if (box == nullptr) return false;
  bool any = false;
  const auto fit = [&](Interval& sides, double end) {
    const double h = (sides.right - sides.left) / cells;
    if (!(reach > 0 && reach < straight_rim * h)) return;
    const double outline = end + reach + straight_overhang * h - (1 - rim_end) * std::min(reach, rim_end * h);
    sides = {-outline, outline};
    any = true;
  };
  fit(contact.x, box->half_widths[0]);
  fit(contact.y, box->half_widths[1]);
  return any;
}

}  // namespace

PadIndenter aligned(PadIndenter indenter, const PadSensor& sensor) {
  if (std::holds_alternative<Punch>(indenter.shape)) {
    indenter.yaw += indenter.tilt_direction;
    indenter.tilt_direction = 0;
  }
  return over_skin(std::move(indenter), sensor);
}

namespace {

/// Makes a box sharp to shared cells, which do not resolve its rounding.
void sharpen_box(PadIndenter& indenter, double reach, const PadBox& contact, int cells) {
  auto* box = std::get_if<Box>(&indenter.shape);
  const double h = std::max(contact.x.right - contact.x.left, contact.y.right - contact.y.left) / cells;
  if (box == nullptr || !(reach > 0 && reach < straight_rim * h)) return;
  *box = {{box->half_widths[0] + rim_end * reach, box->half_widths[1] + rim_end * reach}, 0};
}

bool lies_on_pad(const PadCells& cells, const PadScene& scene) {
  const PadBox box = cells.box();
  for (const double x : {box.x.left, box.x.right})
    for (const double y : {box.y.left, box.y.right})
      if (!on_pad(scene.sensor, scene.indenter, cells.frame(scene.indenter), x, y)) return false;
  return true;
}

}  // namespace

PadLayout lay_cells(const PadScene& scene, const PadLayer& layer, int cells, bool ladder, const PadSides& sides) {
  PadScene seen = scene;
  seen.indenter = aligned(scene.indenter, scene.sensor);
  if (!sides.free()) return lay_cells(find_pad_contact(seen, layer), seen, cells, ladder);
  if (is_round(seen.indenter)) seen.indenter.yaw = 0;
  const auto lay = [&](double turn) {
    const PadFrame frame{turn, rubber_along(scene.sensor, seen.indenter, seen.indenter.yaw + turn), sides};
    PadSearch found = find_pad_contact(seen, layer, frame);
    PadLayout laid{seen.indenter, {}, found.depth};
    const double reach = rim_reach(found, seen.indenter, scene.sensor);
    sharpen(laid.indenter, reach, cells);
    if (turn != 0)
      sharpen_box(laid.indenter, reach, found.contact, cells);
    else
      fit_to_rim(found.contact, reach, laid.indenter, cells);
    laid.cells = pad_cells(found.contact, laid.indenter, cells, frame.rubber, turn);
    return laid;
  };
  const PadLayout own = lay(0);
  return lies_on_pad(own.cells, seen) ? own : lay(-seen.indenter.yaw);
}

PadLayout lay_cells(PadSearch found, const PadScene& scene, int cells, bool ladder) {
  PadLayout laid{scene.indenter, {}, found.depth};
  const double reach = rim_reach(found, scene.indenter, scene.sensor);
  sharpen(laid.indenter, reach, cells);
  const bool fitted = fit_to_rim(found.contact, reach, laid.indenter, cells);
  laid.cells = pad_cells(found.contact, laid.indenter, cells, scene.sensor.thickness, ladder && !fitted);
  return laid;
}

namespace {

constexpr double least_window = 0.01;  ///< H: where the rubber ends beside the indenter

/// Heights less the depth at the window's cells; +infinity beyond the pad.
Eigen::ArrayXd gaps(const Window& window, double depth, const PadScene& scene, const PadFrame& frame) {
  const Eigen::Rotation2Dd turn(radians(frame.turn));
  Eigen::ArrayXd gap(n * n);
  for (int i = 0; i < n * n; ++i) {
    const Eigen::Vector2d at = window.place(i), own = turn * at;
    const bool rubber = on_pad(scene.sensor, scene.indenter, scene.indenter.yaw + frame.turn, at[0], at[1]);
    gap[i] = rubber ? pad_height(scene.indenter, own[0], own[1]) - depth : nowhere.left;
  }
  return gap;
}

}  // namespace

PadSearch find_pad_contact_at(double depth, const PadScene& scene, const PadLayer& layer, const PadFrame& frame) {
  PadBox edges = turned(pad_edges(scene.indenter.shape), -frame.turn);
  const double H = scene.sensor.thickness;
  // An indenter that touches nothing: some cells below its lowest part.
  const PadBox section = turned(rigid_section(scene.indenter, depth > 0 ? depth : 1e-6 * H), -frame.turn);
  PadBox window{clipped(section.x, edges.x), clipped(section.y, edges.y)};
  if (frame.sides.free()) {
    window = {on_rubber(window.x, frame.rubber.x, least_window * H),
              on_rubber(window.y, frame.rubber.y, least_window * H)};
    edges = {on_rubber(edges.x, frame.rubber.x, least_window * H),
             on_rubber(edges.y, frame.rubber.y, least_window * H)};
  }
  PadBox contact = window;
  double P = 0;
  for (int round = 0; depth > 0 && round < search_rounds; ++round) {
    const double hx = (window.x.right - window.x.left) / n, hy = (window.y.right - window.y.left) / n;
    const Eigen::MatrixXd c = layer.normal_influence(H, hx, hy, n);
    Eigen::ArrayXd gap(n * n), p;
    if (frame.sides.free()) {
      gap = gaps({window}, depth, scene, frame);
      p = press_by_pairs(with_sides(c, {window}, scene, frame), gap);
    } else {
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j)
          gap[i * n + j] =
              pad_height(scene.indenter, window.x.left + (i + 0.5) * hx, window.y.left + (j + 0.5) * hy) - depth;
      p = press(c, gap);
    }
    Extent x, y;
    for (int i = 0; i < n * n; ++i)
      if (p[i] > 0) x.add(i / n), y.add(i % n);
    P = p.sum() * hx * hy;
    if (x.last < 0) {  // nothing presses: the section is below a cell of this window
      const auto* map = std::get_if<HeightMap>(&scene.indenter.shape);
      if (map == nullptr || round > 0) break;
      contact = window = turned(low_part(*map, depth), -frame.turn);
      continue;
    }
    contact = {x.pressed(window.x), y.pressed(window.y)};
    window = {clipped(x.next(window.x), edges.x), clipped(y.next(window.y), edges.y)};
  }
  contact = {clipped(widened(contact.x, patch_margin), edges.x), clipped(widened(contact.y, patch_margin), edges.y)};
  return {contact, depth, P * scene.sensor.young};
}

PadBox rubber_along(const PadSensor& sensor, const PadIndenter& indenter, double degrees) {
  const double quarters = degrees / 90, whole = std::round(quarters);
  if (std::abs(quarters - whole) > 1e-9) return everywhere;
  const std::array middle{-indenter.position[0], -indenter.position[1]},
      half{sensor.length.value() / 2, sensor.width.value() / 2};
  const bool swapped = std::fmod(std::abs(whole), 2) == 1;
  const Eigen::Vector2d at = Eigen::Rotation2Dd(-radians(90 * whole)) * Eigen::Vector2d(middle[0], middle[1]);
  const double along_x = half[swapped], along_y = half[!swapped];
  return {{at[0] - along_x, at[0] + along_x}, {at[1] - along_y, at[1] + along_y}};
}

bool on_pad(const PadSensor& sensor, const PadIndenter& indenter, double degrees, double x, double y) {
  constexpr double rounding = 1e-9;
  const PadBox rubber = rubber_of(sensor);
  const Eigen::Vector2d at = Eigen::Rotation2Dd(radians(degrees)) * Eigen::Vector2d(x, y);
  return std::abs(at[0] + indenter.position[0]) <= (1 + rounding) * rubber.x.right &&
         std::abs(at[1] + indenter.position[1]) <= (1 + rounding) * rubber.y.right;
}

PadSearch find_pad_contact(const PadScene& scene, const PadLayer& layer, const PadFrame& frame) {
  const double wanted = largest_normal(scene.load);
  if (!by_force(scene) || !(wanted > 0)) return find_pad_contact_at(by_force(scene) ? 0 : wanted, scene, layer, frame);
  PadSearch now = find_pad_contact_at(0.1 * scene.sensor.thickness, scene, layer, frame), before = now;
  double power = 1.5;  // P ~ depth^power: 1 below a flat, 1.5 for a sphere on a thick layer, more on a thin one
  for (int trial = 1; trial < search_most_depths && std::abs(now.P - wanted) > search_force_error * wanted; ++trial) {
    if (trial > 1 && now.depth != before.depth && now.P > 0 && before.P > 0)
      power = std::clamp(std::log(now.P / before.P) / std::log(now.depth / before.depth), 0.5, 4.0);
    before = now;
    const double depth = now.depth * std::clamp(std::pow(wanted / now.P, 1 / power), 0.1, 10.0);
    now = find_pad_contact_at(depth, scene, layer, frame);
  }
  return now;
}

}  // namespace tactel::fem
