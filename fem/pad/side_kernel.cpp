// SPDX-License-Identifier: Apache-2.0
#include "fem/pad/side_kernel.h"

#include <algorithm>
#include <cmath>
#include <future>
#include <span>
#include <tuple>

#include "fem/numbers/array_cache.h"
#include "fem/numbers/cache_directory.h"
#include "fem/numbers/last_used.h"
#include "fem/numbers/number_text.h"
#include "fem/numbers/processor.h"
#include "fem/pad/brick_block.h"
#include "fem/pad/endless_bricks.h"
#include "fem/pad/parity.h"

namespace tactel::fem {
namespace {

BrickMesh bricks(const std::array<double, 2>& sides, const SideMesh& mesh) {
  return {.nx = mesh.cells[0],
          .ny = mesh.cells[1],
          .hx = sides[0] / mesh.cells[0],
          .hy = sides[1] / mesh.cells[1],
          .along = mesh.along,
          .levels = brick_levels(1, mesh.layers, mesh.growth)};
}

CacheFile file_of(const std::array<double, 2>& sides, double poisson, const SideMesh& mesh,
                  const std::filesystem::path& folder) {
  std::string key = "tactel pad sides\nbuild " TACTEL_SIDES_FINGERPRINT "\nprocessor " + processor_text() + "\nsides";
  for (const double number : {sides[0], sides[1], poisson, mesh.growth}) key += " " + number_text(number);
  for (const int number : {mesh.cells[0], mesh.cells[1], mesh.along, mesh.layers, mesh.period[0], mesh.period[1]})
    key += " " + std::to_string(number);
  return cache_file(folder, "pad", "sides", key);
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
  for (const int axis : {0, 1}) {
    const double step = sides[axis] / (mesh.cells[axis] * mesh.along), reach = std::max(sides[0], sides[1]) + 12;
    while (mesh.period[axis] * step < reach && mesh.period[axis] < 512) mesh.period[axis] *= 2;
    mesh.period[axis] = std::max(mesh.period[axis], 2 * static_cast<int>(std::ceil(reach / step / 2)));
  }
  return mesh;
}

double SideKernel::work(const std::array<double, 2>& sides, double poisson, const SideMesh& mesh) {
  const CacheFile file = file_of(sides, std::min(poisson, most_poisson_of_bricks), mesh, default_cache_directory());
  if (std::filesystem::exists(file.path)) return 0;
  constexpr double a_wave = 1e5;
  const bool square = mesh.cells[0] == mesh.cells[1] && sides[0] == sides[1];
  const double planes = mesh.cells[0] / 2.0 * mesh.along + 1,
               plane = 3 * (mesh.cells[1] / 2.0 * mesh.along + 1) * mesh.layers,
               sources = 0.75 * mesh.cells[0] * mesh.cells[1], waves = 0.25 * mesh.period[0] * mesh.period[1];
  return (square ? 3 : 4) * planes * plane * plane * (2.4 * plane + 4 * sources) + a_wave * waves / (square ? 2 : 1);
}

SideKernel::SideKernel(const std::array<double, 2>& sides, double poisson, const SideMesh& mesh,
                       const std::filesystem::path& cache_directory, const std::function<void()>& between)
    : sides_(sides), mesh_(mesh) {
  const double nu = std::min(poisson, most_poisson_of_bricks);
  quarter_.resize(3 * nodes(), 3 * quarter());
  const CacheFile file = file_of(sides, nu, mesh, cache_directory);
  const auto size = static_cast<std::size_t>(quarter_.size());
  if (!read_arrays(file, std::array{std::span<double>(quarter_.data(), size)})) {
    make(nu, between);
    write_arrays(file, std::array{std::span<const double>(quarter_.data(), size)});
  }
  unfold();
}

void SideKernel::make(double poisson, const std::function<void()>& between) {
  const BrickMesh mesh = bricks(sides_, mesh_);
  quarter_ = brick_block(mesh, poisson, between);
  const EndlessResponse endless = endless_bricks(mesh, poisson, mesh_.period, between);
  const auto [nx, ny] = mesh_.cells;
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
          quarter_(3 * node + to, 3 * source + by) -= sign * endless[of[to][by]](std::abs(dx), std::abs(dy));
        }
    }
  }
  quarter_ /= mesh.hx * mesh.hy;
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

bool has_free_sides(const PadSensor& sensor) {
  return sensor.sides == Sides::free && sensor.length.has_value() && sensor.width.has_value();
}

SideRules side_rules(const PadSensor& sensor) {
  return has_free_sides(sensor) ? SideRules{Sides::free, 32, 1, false} : SideRules{};
}

PadBox rubber_of(const PadSensor& sensor) {
  if (!has_free_sides(sensor)) return everywhere;
  return {{-*sensor.length / 2, *sensor.length / 2}, {-*sensor.width / 2, *sensor.width / 2}};
}

namespace {

/// Sides of the block that contacts on a pad see, over H.
std::array<double, 2> block_of(const PadSensor& sensor) {
  const auto over_H = [&](double side) { return std::min(side, longest_block * sensor.thickness) / sensor.thickness; };
  return {over_H(sensor.length.value()), over_H(sensor.width.value())};
}

BaseGrading grading_of(SideBricks bricks) {
  return bricks == SideBricks::finest ? BaseGrading{.finest = 0.05, .widest = 0.4, .highest = 0.35} : BaseGrading{};
}

}  // namespace

double seconds_for_sides(const PadSensor& sensor, SideBricks judge) {
  if (!has_free_sides(sensor)) return 0;
  constexpr double a_second = 1.2e10;  // operations of one core, about
  const std::array<double, 2> sides = block_of(sensor);
  double work = SideBase::work({sides, side_mesh(sides, SideBricks::usual).cells}, sensor.poisson, grading_of(judge));
  work += SideKernel::work(sides, sensor.poisson, side_mesh(sides, SideBricks::usual));
  if (judge != SideBricks::usual) work += SideKernel::work(sides, sensor.poisson, side_mesh(sides, judge));
  return work / a_second;
}

PadSides sides_at(const PadSensor& sensor, const Eigen::Vector2d& place, SideBricks bricks,
                  const std::function<void()>& between) {
  PadSides at{.thickness = sensor.thickness};
  if (!has_free_sides(sensor)) return at;
  const std::array<double, 2> sides = block_of(sensor);
  const std::array whole{sensor.length.value(), sensor.width.value()};
  for (const int axis : {0, 1}) {
    const double spare = (whole[axis] - std::min(whole[axis], longest_block * sensor.thickness)) / 2;
    at.middle[axis] = std::clamp(place[axis], -spare, spare);
  }
  const std::tuple surface(sides[0], sides[1], sensor.poisson, bricks);
  const std::tuple below(sides[0], sides[1], sensor.poisson, bricks == SideBricks::finest);
  constexpr std::size_t most_kept = 8;
  static LastUsed<std::tuple<double, double, double, SideBricks>, std::shared_ptr<const SideKernel>> kernels(most_kept);
  static LastUsed<std::tuple<double, double, double, bool>, std::shared_ptr<const SideBase>> bases(most_kept);
  std::future<std::shared_ptr<const SideBase>> made;  // ends before what it uses
  if (!(at.base = bases.find(below)))
    made = std::async(std::launch::async, [&] {
      return bases.get(below, [&] {
        return std::make_shared<const SideBase>(SideGrid{sides, side_mesh(sides, SideBricks::usual).cells},
                                                sensor.poisson, grading_of(bricks), default_cache_directory(), between);
      });
    });
  at.kernel = kernels.get(surface, [&] {
    return std::make_shared<const SideKernel>(sides, sensor.poisson, side_mesh(sides, bricks),
                                              default_cache_directory(), between);
  });
  if (made.valid()) at.base = made.get();
  return at;
}

}  // namespace tactel::fem
