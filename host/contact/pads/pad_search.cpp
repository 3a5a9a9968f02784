// SPDX-License-Identifier: Apache-2.0
#include "host/contact/pads/pad_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <mutex>
#include <numbers>

#include "fem/numbers/angles.h"
#include "fem/numbers/overloaded.h"
#include "fem/pad/pad_layers.h"
#include "host/device/buffer.h"
#include "host/device/program.h"
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

  static Precision precision() { return sizeof(Real) == 4 ? Precision::fp32 : Precision::fp64; }

  const Program& program(bool mirrored) {
    const std::lock_guard lock(making);
    auto& program = programs[mirrored];
    if (!program)
      program = std::make_unique<Program>(executor.device(), "pad_search.cl",
                                          Defines{{"REAL", real_type(precision())},
                                                  {"LANES", std::to_string(executor.device().lanes(precision()))},
                                                  {"MIRRORED", std::to_string(mirrored)}});
    return *program;
  }

  Rest rest(double poisson) {
    const std::lock_guard lock(making);
    const auto known = [this](double nu) -> const Rest& {
      const auto found = rests.find(nu);
      return found != rests.end() ? found->second : rests.emplace(nu, rest_of(nu)).first->second;
    };
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
  std::mutex making;  ///< of what is made at first use
  std::unique_ptr<Program> programs[2];
  std::map<double, Rest> rests;  ///< by Poisson's ratio
};

template <class Real>
PadSearch<Real>::PadSearch(Executor& executor, bool any_poisson)
    : state_(std::make_shared<State>(executor, any_poisson)) {}

template <class Real>
std::vector<fem::PadSearch> PadSearch<Real>::find(std::span<const fem::PadScene> scenes,
                                                  std::span<const double> depths) const {
  std::vector<const fem::PadScene*> all;
  all.reserve(scenes.size());
  for (const fem::PadScene& scene : scenes) all.push_back(&scene);
  return find(all, depths);
}

template <class Real>
std::vector<fem::PadSearch> PadSearch<Real>::find(std::span<const fem::PadScene* const> scenes,
                                                  std::span<const double> depths) const {
  const auto forced = [&](std::size_t i) { return depths.empty() && by_force(*scenes[i]); };
  // Scenes of one program, and those that are driven by force, side by side.
  std::array<std::vector<std::size_t>, 2> order;  // not mirrored, mirrored
  for (const bool force : {true, false})
    for (std::size_t i = 0; i < scenes.size(); ++i)
      if (forced(i) == force) order[mirrored(scenes[i]->indenter)].push_back(i);
  const auto target = [&](std::size_t i) {
    const fem::PadLoad& load = scenes[i]->load;
    return !depths.empty() ? depths[i] : fem::largest_normal(load);
  };

  const Device& device = state_->executor.device();
  const auto lanes = static_cast<std::size_t>(device.lanes(State::precision()));
  Maps<Real> maps;
  std::array<Buffer<Real>, 2> inputs, outputs;
  std::array<Buffer<std::int32_t>, 2> map_at;
  for (const bool kind : {false, true}) {
    const std::size_t groups = (order[kind].size() + lanes - 1) / lanes;
    inputs[kind] = Buffer<Real>(device, groups * lanes * PAD_SEARCH_ROWS);
    outputs[kind] = Buffer<Real>(device, groups * lanes * PAD_FOUND_ROWS);
    map_at[kind] = Buffer<std::int32_t>(device, groups * lanes);
    if (groups == 0) continue;
    const auto input = inputs[kind].map(MapFor::writing);
    const auto at = map_at[kind].map(MapFor::writing);
    std::fill(input.view().begin(), input.view().end(), Real(0));
    std::fill(at.view().begin(), at.view().end(), 0);
    for (std::size_t lane = 0; lane < order[kind].size(); ++lane) {
      const fem::PadScene& scene = *scenes[order[kind][lane]];
      const double H = scene.sensor.thickness, nu = scene.sensor.poisson;
      const bool force = forced(order[kind][lane]);
      Rows rows{};
      rows[PAD_SEARCH_BY_FORCE] = force;
      rows[PAD_SEARCH_TARGET] = target(order[kind][lane]) / (force ? scene.sensor.young * H * H : H);
      const double normal = 1 - nu * nu, both = normal + fem::soft_object(scene.sensor, scene.indenter).normal();
      rows[PAD_SEARCH_NORMAL_FACTOR] = both / std::numbers::pi;
      put_shape(scene.indenter, H, rows);
      if (const auto* map = std::get_if<fem::HeightMap>(&scene.indenter.shape)) at[lane] = maps.place(*map);
      std::ranges::transform(state_->rest(nu), rows.begin() + PAD_SEARCH_REST,
                             [&](double of_layer) { return of_layer * (normal / both); });
      for (std::size_t row = 0; row < rows.size(); ++row)
        input[(lane / lanes * PAD_SEARCH_ROWS + row) * lanes + lane % lanes] = static_cast<Real>(rows[row]);
    }
  }
  maps.numbers.resize(std::max<std::size_t>(maps.numbers.size(), 1));
  const Buffer<Real> heights(device, std::span<const Real>(maps.numbers));
  for (const bool kind : {false, true}) {  // one by one: each may run beside another batch's
    if (order[kind].empty()) continue;
    const auto bind = [&](KernelArguments& kernel) {
      kernel.set("lane_input", inputs[kind]);
      kernel.set("maps", heights);
      kernel.set("map_at", map_at[kind]);
      kernel.set("found", outputs[kind]);
    };
    const Launch launch = state_->executor.prepare(state_->program(kind), "pad_search", bind);
    state_->executor.run(launch, (order[kind].size() + lanes - 1) / lanes);
  }

  std::vector<fem::PadSearch> found(scenes.size());
  for (const bool kind : {false, true}) {
    if (order[kind].empty()) continue;
    const auto output = outputs[kind].map(MapFor::reading);
    for (std::size_t lane = 0; lane < order[kind].size(); ++lane) {
      const std::size_t i = order[kind][lane];
      const auto number = [&](int row) {
        return static_cast<double>(output[(lane / lanes * PAD_FOUND_ROWS + row) * lanes + lane % lanes]);
      };
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
