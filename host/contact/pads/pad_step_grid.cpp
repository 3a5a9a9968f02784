// SPDX-License-Identifier: Apache-2.0
#include "host/contact/pads/pad_step_grid.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "fem/numbers/value_error.h"
#include "fem/pad/pad_markers.h"
#include "fem/pad/pad_surface.h"
#include "fem/pad/side_kernel.h"
#include "host/contact/pads/pad_contact.h"

namespace tactel::host {
namespace {

constexpr int least_grid = 4, most_grid = 24;
constexpr AlongXY<int> usual_grid = 16;
constexpr double usual_cell = 0.5;  ///< mm

/// mm of a side of a pad with free ones over which a grid may extend: all of it, or what lies 2 H from the ends of the
/// block that stands for a longer pad.
double gridded(double side, double thickness) {
  constexpr double within_block = fem::longest_block - 4;
  return side <= fem::longest_block * thickness ? side : within_block * thickness;
}

/// Some 256 nearly square cells over the pad.
AlongXY<int> cells_over(double length, double width) {
  const double side = std::sqrt(length * width / (usual_grid.x * usual_grid.y));
  const auto along = [side](double whole) {
    return std::clamp(static_cast<int>(std::lround(whole / side)), least_grid, most_grid);
  };
  return {along(length), along(width)};
}

/// Options with a grid, as the pad asks where none is given.
StepOptions with_grid(const fem::PadSensor& pad, StepOptions options) {
  const auto [whole_length, whole_width, thickness, poisson] = free_block(pad);
  if (!(whole_length > 0) || options.cell.given) {
    if (!options.cells.given) options.cells = usual_grid;
    if (!options.cell.given) options.cell = usual_cell;
    return options;
  }
  const double length = gridded(whole_length, thickness), width = gridded(whole_width, thickness);
  if (!options.cells.given) options.cells = cells_over(length, width);
  options.cell = {length / options.cells.x, width / options.cells.y};
  return options;
}

}  // namespace

void check_size(const char* key, std::size_t size, std::size_t allowed) {
  if (size != allowed) throw ValueError(key, fmt::format("{} numbers", size), fmt::format("{} numbers", allowed));
}

void check_step_options(const StepOptions& options) {
  const auto need = [](bool holds, const char* key, auto number, const char* allowed) {
    if (!holds) throw ValueError(key, fmt::format("{}", number), allowed);
  };
  for (const int cells : {options.cells.x, options.cells.y})
    need(cells >= least_grid && cells <= most_grid, "cells", cells, "4 to 24");
  for (const double cell : {options.cell.x, options.cell.y})
    need(cell > 0 && std::isfinite(cell), "cell", cell, "above 0 mm");
  for (const auto& [key, number] :
       {std::pair{"tolerance", options.tolerance}, {"force_tolerance", options.force_tolerance}})
    need(number > 0 && number <= 0.1, key, number, "above 0 and at most 0.1");
  const double young = options.object_young, poisson = options.object_poisson, dt = options.dt;
  need(young == 0 || (young >= 1e-9 && young <= 1e12), "object_young", young, "1e-9 to 1e12 MPa, or 0 (rigid)");
  need(dt >= 0 && dt <= 1e12, "dt", dt, "seconds, 0 to 1e12");
  need(poisson >= 0 && poisson <= 0.5, "object_poisson", poisson, "0 to 0.5");
  need(options.most_sweeps >= 1, "most_sweeps", options.most_sweeps, "1 or more");
  need(options.most_solves >= 1, "most_solves", options.most_solves, "1 or more");
}

void check_within_pad(const fem::PadSensor& pad, const StepOptions& options) {
  const auto check = [&](double side, int cells, double cell) {
    const double most = gridded(side, pad.thickness);
    if (cells * cell > most * (1 + 1e-9))
      throw ValueError("cell", fmt::format("{}", cell),
                       fmt::format("{:.6g} mm at most, as {} cells lie within {}", most / cells, cells,
                                   most < side ? "8 thicknesses of a pad longer than 12" : "the pad"));
  };
  check(*pad.length, options.cells.x, options.cell.x), check(*pad.width, options.cells.y, options.cell.y);
}

fem::PadCells step_grid(const fem::PadSensor& pad, StepOptions& options) {
  fem::validate(pad);
  options = with_grid(pad, options);
  check_step_options(options);
  const fem::PadCells cells = fem::fixed_cells({options.cells.x, options.cells.y}, {options.cell.x, options.cell.y});
  const fem::Interval solvable = fem::solvable_sides(pad.thickness, 0.1 * pad.thickness);
  for (const double cell : {cells.hx, cells.hy})
    if (cell < solvable.left || cell > solvable.right)
      throw ValueError("cell", fmt::format("{}", cell),
                       fmt::format("{} to {} mm on this rubber", solvable.left, solvable.right));
  if (options.markers) fem::validate(*options.markers, pad);
  if (options.camera) fem::validate(*options.camera);
  if (options.camera && !options.markers) throw ValueError("camera", "without markers", "given with markers");
  return cells;
}

}  // namespace tactel::host
