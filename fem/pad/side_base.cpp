// SPDX-License-Identifier: Apache-2.0
#include "fem/pad/side_base.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "fem/numbers/array_cache.h"
#include "fem/numbers/cache_directory.h"
#include "fem/numbers/number_text.h"
#include "fem/numbers/processor.h"
#include "fem/pad/brick.h"
#include "fem/pad/layer_means.h"
#include "fem/pad/pad_layers.h"
#include "fem/pad/parity.h"

namespace tactel::fem {
namespace {

/// Four places around one and their weights in the cubic through them; the last place itself beyond it.
struct Cubic {
  int first;
  std::array<double, 4> weight;

  Cubic(double at, const std::vector<double>& places) {
    at = std::clamp(at, places.front(), places.back());
    const auto count = static_cast<int>(places.size());
    const auto after = static_cast<int>(std::ranges::upper_bound(places, at) - places.begin());
    first = std::clamp(after - 2, 0, count - 4);
    for (int k = 0; k < 4; ++k) {
      weight[k] = 1;
      for (int l = 0; l < 4; ++l)
        if (l != k) weight[k] *= (at - places[first + l]) / (places[first + k] - places[first + l]);
    }
  }
};

BaseMesh base_mesh(const std::array<double, 2>& sides, const BaseGrading& grading) {
  const double finest = grading.finest * std::min({1.0, sides[0] / 2, sides[1] / 2});
  const auto along = [&](double length, double widest) {
    return graded_edges(length, finest, grading.growth, [=](double from_side) {
      return from_side < BaseGrading::far ? widest : BaseGrading::far_width;
    });
  };
  BaseMesh mesh{along(sides[0] / 2, grading.widest), along(sides[1] / 2, grading.widest), {}};
  for (const double edge : along(1, grading.highest)) mesh.z.push_back(1 - edge);
  std::ranges::reverse(mesh.z);
  return mesh;
}

/// What is left of the sides' part so far from them: all, then less from 2 H, where it has died out to a 20th, to twice
/// that. Beyond, the bricks' own errors would remain.
double left_at(double from_side) {
  constexpr double dies_out = 2;
  const double way = std::clamp(from_side / dies_out - 1, 0.0, 1.0);
  return 1 - way * way * (3 - 2 * way);
}

CacheFile file_of(const SideGrid& grid, double poisson, const BaseGrading& grading,
                  const std::filesystem::path& folder) {
  std::string key = "tactel pad base\nbuild " TACTEL_BASE_FINGERPRINT "\nprocessor " + processor_text() + "\nsides";
  for (const int axis : {0, 1}) key += " " + number_text(grid.sides[axis]) + " " + std::to_string(grid.cells[axis]);
  for (const double number : {poisson, grading.finest, grading.growth, grading.widest, grading.highest})
    key += " " + number_text(number);
  return cache_file(folder, "pad", "base", key);
}

}  // namespace

double SideBase::work(const SideGrid& grid, double poisson, const BaseGrading& grading) {
  const CacheFile file = file_of(grid, std::min(poisson, most_poisson_of_bricks), grading, default_cache_directory());
  if (std::filesystem::exists(file.path)) return 0;
  const BaseMesh mesh = base_mesh(grid.sides, grading);
  const auto bricks = [](const std::vector<double>& edges) { return static_cast<double>(edges.size()) - 1; };
  const double plane = 3 * (2 * bricks(mesh.y) + 1) * 2 * bricks(mesh.z),
               sources = 0.75 * grid.cells[0] * grid.cells[1];
  return 2 * bricks(mesh.x) * plane * plane * (10 * plane + 12 * sources);
}

SideBase::SideBase(const SideGrid& grid, double poisson, const BaseGrading& grading,
                   const std::filesystem::path& cache_directory, const std::function<void()>& between)
    : grid_(grid) {
  const double nu = std::min(poisson, most_poisson_of_bricks);
  const BaseMesh mesh = base_mesh(grid.sides, grading);
  places_ = {gauss_places(mesh.x), gauss_places(mesh.y)};
  rows_.resize(static_cast<Eigen::Index>(3 * places_[0].size() * places_[1].size()),
               3 * grid.cells[0] * grid.cells[1] / 4);
  const CacheFile file = file_of(grid, nu, grading, cache_directory);
  const auto size = static_cast<std::size_t>(rows_.size());
  if (read_arrays(file, std::array{std::span<double>(rows_.data(), size)})) return;
  make(nu, mesh, between);
  write_arrays(file, std::array{std::span<const double>(rows_.data(), size)});
}

void SideBase::make(double poisson, const BaseMesh& mesh, const std::function<void()>& between) {
  const PadLayer layer = pad_layer(poisson);
  const std::array<double, 2> c{grid_.cell(0), grid_.cell(1)};
  const std::array<int, 2> quarter{grid_.cells[0] / 2, grid_.cells[1] / 2};
  rows_ = base_block(mesh, quarter, poisson, between);
  const auto places_y = static_cast<int>(places_[1].size());
  for (int place = 0; place < static_cast<int>(places_[0].size()) * places_y; ++place) {
    const double x = places_[0][place / places_y], y = places_[1][place % places_y];
    const double left = left_at(std::min(grid_.sides[0] / 2 - std::abs(x), grid_.sides[1] / 2 - std::abs(y)));
    for (int source = 0; source < quarter[0] * quarter[1]; ++source) {
      const int i = source / quarter[1], j = source % quarter[1];
      const PadBaseStress endless =
          uniform_base_stress(layer, 1, c[0], c[1], x - (i + 0.5) * c[0], y - (j + 0.5) * c[1]);
      for (int to = 0; to < 3; ++to) {
        auto row = rows_.block<1, 3>(3 * place + to, 3 * source);
        row = left / (c[0] * c[1]) * (row - endless.row((to + 1) % 3));
      }
    }
  }
}

Eigen::MatrixXd SideBase::stress(double x, double y) const {
  const auto [nx, ny] = grid_.cells;
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(3, 3 * nx * ny);
  if (std::abs(x) > grid_.sides[0] / 2 || std::abs(y) > grid_.sides[1] / 2) return rows;
  const auto places_y = static_cast<int>(places_[1].size());
  constexpr std::array row_of{1, 2, 0};  // of tau_x, tau_y, sigma_z
  for (const bool in_x : {false, true})
    for (const bool in_y : {false, true}) {
      const Cubic cx(in_x ? -x : x, places_[0]), cy(in_y ? -y : y, places_[1]);
      Eigen::MatrixXd at = Eigen::MatrixXd::Zero(3, rows_.cols());
      for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j)
          at += cx.weight[i] * cy.weight[j] * rows_.middleRows(3 * ((cx.first + i) * places_y + cy.first + j), 3);
      for (int source = 0; source < nx * ny / 4; ++source) {
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

}  // namespace tactel::fem
