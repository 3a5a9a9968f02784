// SPDX-License-Identifier: Apache-2.0
#include "host/contact/pads/pad_sums.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "fem/pad/pad_markers.h"
#include "kernels/shared/pad_layout.h"

namespace tactel::host {
namespace {

constexpr double uniform_part = 0.4;  ///< H: of a cell under which two Gauss points give the base stress
using Shares = std::vector<fem::PadLayer::Share>;

/// Gauss's points of a side in so many equal parts.
Shares gauss_points(int parts) {
  Shares all;
  for (int k = 0; k < parts; ++k)
    for (const double at : {-0.5 / std::numbers::sqrt3, 0.5 / std::numbers::sqrt3})
      all.push_back({at / parts + (k - (parts - 1) / 2.0) / parts, 0.5 / parts});
  return all;
}

/// Takes where the cells of each lane lie, with the tables of the rubbers and the points of the cells. `shares_of(side
/// of a cell, PadLayer::soft_thickness)`, both over H.
template <class Real>
void take_cells(const LaneState<Real>& lanes, const std::vector<PadOnCells>& scenes, PadRubbers& rubbers,
                const auto& table_of, const auto& shares_of, const auto& unit, PadSums<Real>& sums) {
  Distinct<Real, fem::Rubber> tables;
  Distinct<Real, std::pair<double, double>> shares;
  const auto cells_of = [&](std::size_t i) {
    const auto& [scene, cells, size] = std::tie(scenes[i].scene, scenes[i].cells, scenes[i].size);
    const fem::Rubber rubber = fem::rubber(scene.sensor);
    const auto table = tables.take(rubber, [&] {
      std::vector<double> numbers = table_of(rubber);
      numbers.resize(static_cast<std::size_t>(sums.rows) * PAD_BLOCK);
      return numbers;
    });
    const double soft_thickness = rubber.layers.empty() ? 1 : rubbers.tables(rubber)->layer()->soft_thickness();
    const auto shares_along = [&](double side) {
      return shares.take({side, soft_thickness}, [&] {
        std::vector<double> numbers;
        for (const auto& [place, share] : shares_of(side, soft_thickness))
          numbers.insert(numbers.end(), {place, share});
        return numbers;
      });
    };
    const auto along_x = shares_along(size.hx), along_y = shares_along(size.hy);
    const double H = scene.sensor.thickness, yaw = scenes[i].frame();
    std::array<double, PAD_PLACE_ROWS> place{};
    place[PAD_PLACE_X] = scene.indenter.position[0] / H, place[PAD_PLACE_Y] = scene.indenter.position[1] / H;
    place[PAD_PLACE_COSINE] = std::cos(yaw), place[PAD_PLACE_SINE] = std::sin(yaw);
    place[PAD_PLACE_X_MIDDLE] = cells.x_middle / H, place[PAD_PLACE_Y_MIDDLE] = cells.y_middle / H;
    place[PAD_PLACE_HX] = cells.hx / H, place[PAD_PLACE_HY] = cells.hy / H;
    place[PAD_PLACE_THICKNESS] = 1 / H, place[PAD_PLACE_STRESS] = unit(scene.sensor);
    place[PAD_PLACE_SHARES_X] = along_x.first / 2.0, place[PAD_PLACE_COUNT_X] = along_x.count / 2.0;
    place[PAD_PLACE_SHARES_Y] = along_y.first / 2.0, place[PAD_PLACE_COUNT_Y] = along_y.count / 2.0;
    place[PAD_PLACE_STEPS] = lanes.scenes[i].steps;
    const auto layer = table.first / PAD_BLOCK;
    place[PAD_PLACE_LAYER] = static_cast<double>(layer);
    return place;
  };
  sums.cells = lanes.array(1, 1, PAD_PLACE_ROWS, 0, cells_of);  // others have no steps
  sums.tables = buffer_of<Real>(lanes.device(), tables.numbers);
  sums.shares = buffer_of<Real>(lanes.device(), shares.numbers);
}

/// Takes the points of places, [blocks of lanes][points of a place][x, y][lane].
template <class Real>
void take_points(const LaneState<Real>& lanes, const Eigen::MatrixX2d& places, const std::vector<double>& weights,
                 std::size_t width, PadSums<Real>& sums) {
  sums.parts = static_cast<int>(weights.size());
  sums.count = static_cast<int>(places.rows()) / sums.parts;
  const std::size_t blocks = (static_cast<std::size_t>(sums.count) + width - 1) / width;
  const LaneArray<Real> array(lanes.device(), blocks * width, width, sums.parts, 2);
  const auto all = array.numbers.map(MapFor::writing);
  std::ranges::fill(all.view(), Real(0));
  for (Eigen::Index k = 0; k < places.rows(); ++k)
    for (std::size_t axis = 0; axis < 2; ++axis)
      all[array.at(k / sums.parts, k % sums.parts, axis)] = static_cast<Real>(places(k, axis));
  sums.points = array.numbers, sums.weights = buffer_of<Real>(lanes.device(), weights);
  sums.groups = lanes.lanes * blocks;
}

}  // namespace

template <class Real>
PadSums<Real> PadSums<Real>::stress(const LaneState<Real>& lanes, const std::vector<PadOnCells>& scenes,
                                    PadRubbers& rubbers, std::size_t width) {
  const fem::PadSensor& pad = scenes.front().scene.sensor;
  const double deep = 1 - pad.depth / pad.thickness;
  PadSums sums{.rows = PadTables::stress_rows, .rows_a_thickness = PadTables::stress_rows_at(deep)};
  for (const PadOnCells& of : scenes)
    if (const fem::Rubber rubber = fem::rubber(of.scene.sensor); !rubber.layers.empty())
      sums.rows = std::max(sums.rows, PadTables::stress_rows_of(*rubbers.tables(rubber)->layer()));
  const auto shares_of = [&, free = scenes.front().sides.kernel != nullptr](double side, double soft_thickness) {
    if (free) return gauss_points(static_cast<int>(std::ceil(side / uniform_part)));
    Shares all = fem::PadLayer::shares(side / soft_thickness);
    if (pad.depth == 0) return all.size() == 1 ? gauss_points(1) : all;
    const double part = 1.0 / fem::PadLayer::parts(side / soft_thickness);
    const Shares within = gauss_points(static_cast<int>(std::ceil(part * side / (uniform_part * deep))));
    Shares finer;
    for (const auto& [place, share] : all)
      for (const auto& [at, of] : within) finer.push_back({place + part * at, share * of});
    return finer;
  };
  take_cells(
      lanes, scenes, rubbers, [&](const fem::Rubber& rubber) { return rubbers.tables(rubber)->stress(); }, shares_of,
      [](const fem::PadSensor& pad) { return 1 / (2 * std::numbers::pi * pad.thickness * pad.thickness); }, sums);
  const fem::TactelPoints points(scenes.front().scene.sensor);
  take_points(lanes, points.places, points.weights, width, sums);
  return sums;
}

template <class Real>
PadSums<Real> PadSums<Real>::markers(const LaneState<Real>& lanes, const std::vector<PadOnCells>& scenes,
                                     PadRubbers& rubbers, std::size_t width) {
  constexpr double least_depth = 0.02;
  const fem::PadScene& scene = scenes.front().scene;
  const double depth = marker_depth(scene);
  if (depth < least_depth) return {};
  PadSums sums{.rows = marker_rows(depth), .rows_a_thickness = marker_rows_a_thickness(depth)};
  const auto shares_of = [depth](double side, double) {
    Shares all;
    const double part = 1.0 / fem::PadLayer::parts(side);
    const int along = std::clamp(static_cast<int>(std::ceil(part * side / depth)), 3, 12);
    for (const auto& [place, share] : fem::PadLayer::shares(side))
      for (int k = 0; k < along; ++k) all.push_back({place + part * ((k + 0.5) / along - 0.5), share / along});
    return all;
  };
  take_cells(
      lanes, scenes, rubbers, [&](const fem::Rubber& rubber) { return rubbers.markers(rubber.poisson, depth); },
      shares_of, [](const fem::PadSensor& pad) { return 1 / (pad.young * pad.thickness); }, sums);
  const auto places = fem::marker_places(*scene.markers);
  take_points(lanes, Eigen::Map<const Eigen::Matrix2Xd>(places.front().data(), 2, std::ssize(places)).transpose(), {1},
              width, sums);
  return sums;
}

template struct PadSums<float>;
template struct PadSums<double>;

}  // namespace tactel::host
