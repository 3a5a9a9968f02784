// SPDX-License-Identifier: Apache-2.0
#include "host/contact/pads/pad_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "fem/numbers/angles.h"
#include "fem/numbers/last_used.h"
#include "fem/numbers/overloaded.h"
#include "fem/pad/pad_layers.h"
#include "host/contact/contact_batch.h"
#include "kernels/shared/pad_layout.h"

namespace tactel::host {
namespace {

using Rest = std::array<double, PAD_SEARCH_TERMS>;

/// Coefficients of z0 / u by interpolation at Chebyshev's nodes in 2 u - 1.
Rest rest_of(double poisson) {
  constexpr int terms = PAD_SEARCH_TERMS;
  const fem::PadIntegrals integrals(poisson);
  const auto angle = [](int k) { return std::numbers::pi * (k + 0.5) / terms; };
  Rest at{}, a{};
  for (int k = 0; k < terms; ++k) {
    const double u = (std::cos(angle(k)) + 1) / 2, rho = PAD_SEARCH_LENGTH * std::sqrt(1 / (u * u) - 1);
    at[k] = (rho < fem::PadLayer::range ? integrals.at(rho).value[fem::pad_z0] : -1 / rho) / u;
  }
  for (int m = 0; m < terms; ++m)
    for (int k = 0; k < terms; ++k) a[m] += (m == 0 ? 1.0 : 2.0) / terms * at[k] * std::cos(m * angle(k));
  return a;
}

using Rows = std::array<double, PAD_SEARCH_ROWS>;

/// A circle of this radius along x, or round, and its section.
void put_circle(Rows& rows, double radius, bool round) {
  rows[PAD_SHAPE_ROUND] = round;
  rows[PAD_SHAPE_CIRCLE] = 1 / radius, rows[PAD_SHAPE_RIM] = rows[PAD_SECTION_MOST] = radius;
  rows[PAD_SECTION_WIDE_X] = 2 * radius, rows[PAD_SECTION_LESS_X] = 1;
  if (round) rows[PAD_SECTION_WIDE_Y] = 2 * radius, rows[PAD_SECTION_LESS_Y] = 1;
}

/// A flat with a rounded or sharp edge in a direction: half its section.
void put_flat(Rows& rows, int direction, double flat, double edge, double slope) {
  rows[PAD_SECTION_X + direction] = flat + slope * edge, rows[PAD_SECTION_WIDE_X + direction] = 2 * edge;
}

/// Profile and section of an indenter, lengths over H. The rows are 0 before.
void put_shape(const fem::PadIndenter& indenter, double H, Rows& rows) {
  const fem::PadBox edges = fem::pad_edges(indenter.shape);
  const auto half = [H](double edge) { return std::min(edge / H, static_cast<double>(PAD_OPEN)); };
  rows[PAD_SHAPE_EDGE_X] = half(edges.x.right), rows[PAD_SHAPE_EDGE_Y] = half(edges.y.right);
  rows[PAD_SHAPE_RIM] = rows[PAD_SECTION_MOST] = PAD_OPEN;
  const double slope = std::tan(fem::radians(indenter.tilt));
  std::visit(
      fem::Overloaded{[&](const Sphere& s) { put_circle(rows, s.radius / H, true); },
                      [&](const LyingCylinder& c) {
                        put_circle(rows, c.radius / H, false);
                        rows[PAD_SECTION_Y] = c.half_length / H;
                      },
                      [&](const Paraboloid& p) {
                        rows[PAD_SHAPE_CURVE_X] = H / (2 * p.radii[0]), rows[PAD_SHAPE_CURVE_Y] = H / (2 * p.radii[1]);
                        rows[PAD_SECTION_WIDE_X] = 2 * p.radii[0] / H, rows[PAD_SECTION_WIDE_Y] = 2 * p.radii[1] / H;
                      },
                      [&](const Punch& p) {
                        rows[PAD_SHAPE_ROUND] = 1, rows[PAD_SHAPE_FLAT] = p.radius / H;
                        if (p.edge > 0) rows[PAD_SHAPE_CURVE] = H / (2 * p.edge);
                        if (p.edge == 0) rows[PAD_SHAPE_RIM] = p.radius / H;
                        for (const int direction : {0, 1}) put_flat(rows, direction, p.radius / H, p.edge / H, slope);
                      },
                      [&](const Box& b) {
                        rows[PAD_SHAPE_FLAT_X] = b.half_widths[0] / H, rows[PAD_SHAPE_FLAT_Y] = b.half_widths[1] / H;
                        if (b.edge > 0) rows[PAD_SHAPE_CURVE_X] = rows[PAD_SHAPE_CURVE_Y] = H / (2 * b.edge);
                        for (const int direction : {0, 1})
                          put_flat(rows, direction, b.half_widths[direction] / H, b.edge / H, slope);
                      },
                      [&](const Cone& c) {
                        const double wide = std::tan(fem::radians(c.angle));
                        rows[PAD_SHAPE_ROUND] = 1, rows[PAD_SHAPE_SLOPE] = 1 / wide, rows[PAD_SECTION_SLOPE] = wide;
                      },
                      [&](const fem::HeightMap& m) {
                        rows[PAD_MAP_ROWS] = static_cast<double>(m.heights.rows());
                        rows[PAD_MAP_COLUMNS] = static_cast<double>(m.heights.cols());
                        rows[PAD_MAP_PER_PITCH] = H / m.pitch, rows[PAD_MAP_UNIT] = 1 / H;
                      }},
      indenter.shape);
  if (indenter.tilt == 0) return;
  const double direction = fem::radians(indenter.tilt_direction);
  rows[PAD_SHAPE_TILT_X] = slope * std::cos(direction), rows[PAD_SHAPE_TILT_Y] = slope * std::sin(direction);
  // On the axis the plane lies as high as its lowest point on the shape asks.
  rows[PAD_SHAPE_BELOW] = fem::pad_height(indenter, 0, 0) / H;
}

bool mirrored(const fem::PadIndenter& indenter) {
  return indenter.tilt == 0 && pad_edge(indenter.shape) != fem::PadEdge::measured;
}

/// Measured heights, [rows][columns] mm, one after the other; equal ones stand once.
template <class Real>
class Maps {
 public:
  /// Returns the place of the first height.
  std::int32_t place(const fem::HeightMap& map) {
    for (const auto& [known, at] : known_)
      if (known->rows() == map.heights.rows() && known->cols() == map.heights.cols() && *known == map.heights)
        return at;
    const auto at = static_cast<std::int32_t>(numbers.size());
    known_.emplace_back(&map.heights, at);
    for (Eigen::Index i = 0; i < map.heights.rows(); ++i)
      for (Eigen::Index j = 0; j < map.heights.cols(); ++j) numbers.push_back(static_cast<Real>(map.heights(i, j)));
    return at;
  }
  std::vector<Real> numbers;

 private:
  std::vector<std::pair<const Eigen::MatrixXd*, std::int32_t>> known_;
};

}  // namespace

template <class Real>
struct PadSearch<Real>::State {
  State(Executor& executor, bool any_poisson) : executor(executor), any_poisson(any_poisson) {}

  std::size_t lanes() const { return static_cast<std::size_t>(executor.device().lanes(precision_of<Real>)); }

  Program program(bool mirrored) {
    return programs.get(mirrored, [&] {
      return Program(executor.device(), "pad_search.cl",
                     {{"REAL", real_type(precision_of<Real>)},
                      {"LANES", std::to_string(lanes())},
                      {"MIRRORED", std::to_string(mirrored)}});
    });
  }

  Rest rest(double poisson) {
    const auto known = [this](double nu) { return rests.get(nu, [nu] { return rest_of(nu); }); };
    if (!any_poisson) return known(poisson);
    const std::vector<double> shares = fem::poisson_shares(poisson);
    Rest sum{};
    for (int p = 0; p < fem::poisson_points; ++p)
      for (std::size_t k = 0; k < sum.size(); ++k)
        sum[k] += shares[static_cast<std::size_t>(p)] * known(fem::poisson_point(p))[k];
    return sum;
  }

  Executor& executor;
  bool any_poisson;
  fem::LastUsed<bool, Program> programs{2};
  fem::LastUsed<double, Rest> rests{256};  ///< by Poisson's ratio
};

template <class Real>
PadSearch<Real>::PadSearch(Executor& executor, bool any_poisson)
    : state_(std::make_shared<State>(executor, any_poisson)) {}

template <class Real>
std::vector<fem::PadSearch> PadSearch<Real>::find(std::span<const fem::PadScene* const> scenes,
                                                  std::span<const double> depths) const {
  const auto forced = [&](std::size_t i) { return depths.empty() && by_force(*scenes[i]); };
  const auto target = [&](std::size_t i) { return !depths.empty() ? depths[i] : fem::largest_normal(scenes[i]->load); };
  const Device& device = state_->executor.device();
  const std::size_t lanes = state_->lanes();
  std::vector<fem::PadSearch> found(scenes.size());
  for (const bool kind : {false, true}) {  // one by one: each may run beside another batch's
    // Scenes of one program, those that are driven by force side by side.
    std::vector<std::size_t> order;
    for (const bool force : {true, false})
      for (std::size_t i = 0; i < scenes.size(); ++i)
        if (mirrored(scenes[i]->indenter) == kind && forced(i) == force) order.push_back(i);
    if (order.empty()) continue;
    const std::size_t groups = (order.size() + lanes - 1) / lanes;
    const LaneArray<Real> input(device, groups * lanes, lanes, 1, PAD_SEARCH_ROWS);
    const LaneArray<Real> output(device, groups * lanes, lanes, 1, PAD_FOUND_ROWS);
    std::vector<std::int32_t> map_at(groups * lanes);
    Maps<Real> maps;
    {
      const auto all = input.numbers.map(MapFor::writing);
      std::ranges::fill(all.view(), Real(0));
      for (std::size_t lane = 0; lane < order.size(); ++lane) {
        const fem::PadScene& scene = *scenes[order[lane]];
        const double H = scene.sensor.thickness, nu = scene.sensor.poisson;
        const bool force = forced(order[lane]);
        Rows rows{};
        rows[PAD_SEARCH_BY_FORCE] = force;
        rows[PAD_SEARCH_TARGET] = target(order[lane]) / (force ? scene.sensor.young * H * H : H);
        const double normal = 1 - nu * nu, both = normal + fem::soft_object(scene.sensor, scene.indenter).normal();
        rows[PAD_SEARCH_NORMAL_FACTOR] = both / std::numbers::pi;
        put_shape(scene.indenter, H, rows);
        if (const auto* map = std::get_if<fem::HeightMap>(&scene.indenter.shape)) map_at[lane] = maps.place(*map);
        std::ranges::transform(state_->rest(nu), rows.begin() + PAD_SEARCH_REST,
                               [&](double of_layer) { return of_layer * (normal / both); });
        input.put(all.view(), lane, rows);
      }
    }
    const Buffer<Real> heights = buffer_of<Real>(device, maps.numbers);
    const Buffer<std::int32_t> at = buffer_of<std::int32_t>(device, map_at);
    state_->executor.run(state_->program(kind), "pad_search", groups, [&](KernelArguments& kernel) {
      kernel.set("lane_input", input.numbers);
      kernel.set("maps", heights);
      kernel.set("map_at", at);
      kernel.set("found", output.numbers);
    });

    const auto all = output.numbers.map(MapFor::reading);
    for (std::size_t lane = 0; lane < order.size(); ++lane) {
      const std::size_t i = order[lane];
      const auto number = [&](std::size_t row) { return static_cast<double>(all[output.at(lane, 0, row)]); };
      const fem::PadBox edges = fem::pad_edges(scenes[i]->indenter.shape);
      const double H = scenes[i]->sensor.thickness;
      found[i].contact = {
          {std::max(H * number(PAD_FOUND_LEFT), edges.x.left), std::min(H * number(PAD_FOUND_RIGHT), edges.x.right)},
          {std::max(H * number(PAD_FOUND_BELOW), edges.y.left), std::min(H * number(PAD_FOUND_ABOVE), edges.y.right)}};
      found[i].depth = forced(i) ? H * number(PAD_FOUND_DEPTH) : target(i);
      found[i].P = scenes[i]->sensor.young * H * H * number(PAD_FOUND_P);
    }
  }
  return found;
}

template class PadSearch<float>;
template class PadSearch<double>;

}  // namespace tactel::host
