// SPDX-License-Identifier: Apache-2.0
#include "fem/pad/side_kernel.h"

#include <algorithm>
#include <cmath>
#include <list>
#include <mutex>
#include <span>
#include <tuple>

#include "fem/array_cache.h"
#include "fem/number_text.h"
#include "fem/pad/brick_block.h"
#include "fem/pad/endless_bricks.h"
#include "fem/processor.h"

namespace tactel::fem {
namespace {

constexpr double most_poisson = 0.49999;  // the bricks of nu = 1/2 are 0.1 % stiffer

BrickMesh bricks(const std::array<double, 2>& sides, const SideMesh& mesh) {
  return {.nx = mesh.cells[0],
          .ny = mesh.cells[1],
          .hx = sides[0] / mesh.cells[0],
          .hy = sides[1] / mesh.cells[1],
          .along = mesh.along,
          .levels = brick_levels(1, mesh.layers, mesh.growth)};
}

/// Four equally spaced nodes around a place and their weights in the cubic through them; `at` in steps from node 0.
struct Cubic {
  int first;
  std::array<double, 4> weight;

  Cubic(double at, int count) : first(std::clamp(static_cast<int>(std::floor(at)) - 1, 0, count - 4)) {
    for (int k = 0; k < 4; ++k) {
      weight[k] = 1;
      for (int l = 0; l < 4; ++l)
        if (l != k) weight[k] *= (at - first - l) / (k - l);
    }
  }
};

/// Sign of a component where it is mirrored: in x, or in y.
double mirrored(int component, bool in_x, bool in_y) {
  return (in_x && component == 0 ? -1 : 1) * (in_y && component == 1 ? -1 : 1);
}

std::string key_of(const std::array<double, 2>& sides, double poisson, const SideMesh& mesh) {
  std::string key = "tactel pad sides\nbuild " TACTEL_SIDES_FINGERPRINT "\nprocessor " + processor_text() + "\nsides";
  for (const double number : {sides[0], sides[1], poisson, mesh.growth}) key += " " + number_text(number);
  for (const int number : {mesh.cells[0], mesh.cells[1], mesh.along, mesh.layers, mesh.period})
    key += " " + std::to_string(number);
  return key;
}

/// Takes from the tractions of the base's nodes what alternates from node to node, which bricks of mean dilatation have
/// beside a free side: by (-1 4 10 4 -1) / 16 along x and y, which leaves cubics as they are; (1 2 1) / 4 next to the
/// sides.
void smooth(Eigen::MatrixXd& tractions, int bx, int by) {
  const auto along = [&](int nodes, Eigen::Index step, Eigen::Index first) {
    Eigen::MatrixXd old(nodes, tractions.cols());
    for (int k = 0; k < nodes; ++k) old.row(k) = tractions.row(first + k * step);
    for (int k = 1; k + 1 < nodes; ++k)
      if (k == 1 || k + 2 == nodes)
        tractions.row(first + k * step) = (old.row(k - 1) + 2 * old.row(k) + old.row(k + 1)) / 4;
      else
        tractions.row(first + k * step) =
            (10 * old.row(k) + 4 * (old.row(k - 1) + old.row(k + 1)) - old.row(k - 2) - old.row(k + 2)) / 16;
  };
  for (int c = 0; c < 3; ++c) {
    for (int j = 0; j < by; ++j) along(bx, 3 * by, 3 * j + c);
    for (int i = 0; i < bx; ++i) along(by, 3, 3 * i * by + c);
  }
}

}  // namespace

SideMesh side_mesh(const std::array<double, 2>& sides, SideBricks bricks) {
  SideMesh mesh;
  for (const int axis : {0, 1}) {
    const int least = bricks == SideBricks::usual ? 12 : 16,
              wanted = 2 * static_cast<int>(std::ceil(sides[axis] - 1e-9));
    mesh.cells[axis] = std::clamp(wanted, least, 24);
  }
  if (bricks == SideBricks::finest)
    mesh.layers = 8, mesh.growth = 1.12, mesh.along = std::max(mesh.cells[0], mesh.cells[1]) <= 16 ? 3 : 2;
  // A period holds the block and twelve thicknesses, beyond which an image does nothing (1e-7).
  double step = 1e300, reach = 0;
  for (const int axis : {0, 1}) {
    step = std::min(step, sides[axis] / (mesh.cells[axis] * mesh.along));
    reach = std::max(reach, sides[axis] + 12);
  }
  while (mesh.period * step < reach && mesh.period < 1024) mesh.period *= 2;
  return mesh;
}

SideKernel::SideKernel(const std::array<double, 2>& sides, double poisson, const SideMesh& mesh,
                       const std::filesystem::path& cache_directory)
    : sides_(sides), mesh_(mesh) {
  const double nu = std::min(poisson, most_poisson);
  const auto [bx, by] = base_nodes();
  quarter_.resize(3 * nodes(), 3 * quarter());
  base_.resize(static_cast<Eigen::Index>(3) * bx * by, 3 * quarter());
  const CacheFile file = cache_file(cache_directory, "pad", "sides", key_of(sides, nu, mesh));
  const auto arrays = [&]<class Span>(std::vector<Span> all) {
    for (Eigen::MatrixXd* m : {&quarter_, &base_}) all.emplace_back(m->data(), static_cast<std::size_t>(m->size()));
    return all;
  };
  if (!read_arrays(file, arrays(std::vector<std::span<double>>()))) {
    make(nu);
    write_arrays(file, arrays(std::vector<std::span<const double>>()));
  }
  unfold();
}

void SideKernel::make(double poisson) {
  const BrickMesh mesh = bricks(sides_, mesh_);
  BrickResponse block = brick_block(mesh, poisson);
  const EndlessResponse endless = endless_bricks(mesh, poisson, mesh_.period);
  const auto [nx, ny] = mesh_.cells;
  const auto [bx, by] = base_nodes();
  const double cell = mesh.hx * mesh.hy, brick = mesh.dx() * mesh.dy();
  constexpr std::array<std::array<int, 3>, 3> of{{{1, 3, 4}, {3, 2, 5}, {4, 5, 0}}};  // plane of (to, by)
  const auto sign_of = [](int to, int by, double dx, double dy) {
    return ((to == 0) != (by == 0) && dx < 0 ? -1 : 1) * ((to == 1) != (by == 1) && dy < 0 ? -1 : 1);
  };
  for (int source = 0; source < quarter(); ++source) {
    const int si = nx / 2 + source / (ny / 2), sj = ny / 2 + source % (ny / 2);
    for (int node = 0; node < nodes(); ++node) {
      const int dx = node / ny - si, dy = node % ny - sj;
      for (int to = 0; to < 3; ++to)
        for (int by = 0; by < 3; ++by) {
          const double sign = sign_of(to, by, dx, dy) * (to == 2 && by < 2 ? -1 : 1);
          block.surface(3 * node + to, 3 * source + by) -=
              sign * endless.surface[of[to][by]](std::abs(dx), std::abs(dy));
        }
    }
    for (int node = 0; node < bx * by; ++node) {
      // From the cell's middle, in bricks; doubled, so that it is whole.
      const int i = node / by, j = node % by, x = 2 * i - (2 * si + 1) * mesh.along,
                y = 2 * j - (2 * sj + 1) * mesh.along;
      const double share = (i == 0 || i == bx - 1 ? 0.5 : 1) * (j == 0 || j == by - 1 ? 0.5 : 1);
      for (int to = 0; to < 3; ++to)
        for (int c = 0; c < 3; ++c) {
          double& force = block.base(3 * node + to, 3 * source + c);
          force = force / share - sign_of(to, c, x, y) * endless.base[3 * to + c](std::abs(x) / 2, std::abs(y) / 2);
        }
    }
  }
  smooth(block.base, bx, by);
  quarter_ = block.surface / cell;
  base_ = block.base / (cell * brick);
}

/// Columns of the other quarters, by mirror images.
void SideKernel::unfold() {
  const int nx = mesh_.cells[0], ny = mesh_.cells[1];
  displacement_.resize(3 * nodes(), 3 * nodes());
  for (int source = 0; source < quarter(); ++source)
    for (const bool in_x : {false, true})
      for (const bool in_y : {false, true}) {
        const auto image = [&](int i, int j) { return (in_x ? nx - 1 - i : i) * ny + (in_y ? ny - 1 - j : j); };
        const int by = image(nx / 2 + source / (ny / 2), ny / 2 + source % (ny / 2));
        for (int node = 0; node < nodes(); ++node)
          for (int to = 0; to < 3; ++to)
            for (int c = 0; c < 3; ++c)
              displacement_(3 * image(node / ny, node % ny) + to, 3 * by + c) =
                  mirrored(to, in_x, in_y) * mirrored(c, in_x, in_y) * quarter_(3 * node + to, 3 * source + c);
      }
  displacement_ = (displacement_ + displacement_.transpose()).eval() / 2;  // symmetric but for rounding
  normal_ = displacement_(Eigen::seqN(2, nodes(), 3), Eigen::seqN(2, nodes(), 3));
}

SideKernel::Shares SideKernel::shares(double x, double y) const {
  constexpr double rounding = 1e-9;
  Shares all{};
  if (std::abs(x) > sides_[0] / 2 + rounding || std::abs(y) > sides_[1] / 2 + rounding) return all;
  const auto [nx, ny] = mesh_.cells;
  const Cubic in_x((x / sides_[0] + 0.5) * nx - 0.5, nx), in_y((y / sides_[1] + 0.5) * ny - 0.5, ny);
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) {
      all.node[all.count] = (in_x.first + i) * ny + in_y.first + j;
      all.share[all.count++] = in_x.weight[i] * in_y.weight[j];
    }
  return all;
}

Eigen::MatrixXd SideKernel::base_stress(double x, double y) const {
  const auto [nx, ny] = mesh_.cells;
  const auto [bx, by] = base_nodes();
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(3, 3 * nodes());
  if (std::abs(x) > sides_[0] / 2 || std::abs(y) > sides_[1] / 2) return rows;
  constexpr std::array row_of{1, 2, 0};  // of tau_x, tau_y, sigma_z
  for (const bool in_x : {false, true})
    for (const bool in_y : {false, true}) {
      const Cubic cx(((in_x ? -x : x) / sides_[0] + 0.5) * (bx - 1), bx);
      const Cubic cy(((in_y ? -y : y) / sides_[1] + 0.5) * (by - 1), by);
      Eigen::MatrixXd at = Eigen::MatrixXd::Zero(3, 3 * quarter());
      for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j)
          at += cx.weight[i] * cy.weight[j] * base_.middleRows(3 * ((cx.first + i) * by + cy.first + j), 3);
      for (int source = 0; source < quarter(); ++source) {
        const int i = nx / 2 + source / (ny / 2), j = ny / 2 + source % (ny / 2);
        const int node = (in_x ? nx - 1 - i : i) * ny + (in_y ? ny - 1 - j : j);
        for (int to = 0; to < 3; ++to)
          for (int c = 0; c < 3; ++c)
            rows(row_of[to], 3 * node + c) =
                mirrored(to, in_x, in_y) * mirrored(c, in_x, in_y) * at(to, 3 * source + c);
      }
    }
  return rows;
}

bool has_free_sides(const PadSensor& sensor) {
  return sensor.sides == Sides::free && sensor.length.has_value() && sensor.width.has_value();
}

PadSides sides_at(const PadSensor& sensor, const Eigen::Vector2d& place, SideBricks bricks) {
  PadSides at{nullptr, sensor.thickness, {0, 0}};
  std::array<double, 2> sides{};
  const std::array whole{sensor.length.value(), sensor.width.value()};
  for (const int axis : {0, 1}) {
    const double block = std::min(whole[axis], longest_block * sensor.thickness), spare = (whole[axis] - block) / 2;
    sides[axis] = block / sensor.thickness;
    at.middle[axis] = std::clamp(place[axis], -spare, spare);
  }
  using Key = std::tuple<double, double, double, SideBricks>;
  static std::mutex mutex;
  static std::list<std::pair<Key, std::shared_ptr<const SideKernel>>> kept;  // the last used first
  constexpr std::size_t most_kept = 8;
  const Key key(sides[0], sides[1], sensor.poisson, bricks);
  const std::lock_guard lock(mutex);
  const auto found = std::ranges::find(kept, key, &decltype(kept)::value_type::first);
  if (found != kept.end())
    kept.splice(kept.begin(), kept, found);
  else
    kept.emplace_front(key, std::make_shared<const SideKernel>(sides, sensor.poisson, side_mesh(sides, bricks)));
  if (kept.size() > most_kept) kept.pop_back();
  at.kernel = kept.front().second;
  return at;
}

}  // namespace tactel::fem
