// SPDX-License-Identifier: Apache-2.0
#include "host/contact/pad_judge.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "fem/pad/pad_layers.h"
#include "host/contact/pad_stream.h"

namespace tactel::host {
namespace {

using Errors = fem::PadReferenceSolution::Errors;

constexpr std::size_t most_steps = 100;
constexpr double finer_tolerance = 1e-4;  ///< of its sweeps
/// Errors over differences. Cells converge at order 1.5, which pressure and P show; increments at the first, so that
/// twice as many show half of what slip leaves. A fifth or fourth more covers 95 % of scenes (bench/pad_study.cpp).
constexpr double order = 1.5, more = 1.2, by_increments = 2.5;
/// Two answers may agree by chance; of pressure below a height map, whose sides cells meet or miss, more often.
constexpr double least = 0.004, least_of_map = 0.2;  ///< this over the cells along a side

int finer_cells(const PadRung& rung) { return std::max(24, 4 * rung.cells / 3); }
int finer_increments(int cells) { return cells / 3 * 2; }

}  // namespace

const fem::PadSolution& PadJudge::finer(int cells) {
  if (const auto made = finer_.find(cells); made != finer_.end()) return made->second;
  const fem::PadOptions options{.cells = cells,
                                .tolerance = finer_tolerance,
                                .pressing_increments = finer_increments(cells),
                                .drag_increments = 2,
                                .whole_path = false};
  const fem::PadLayer layer = fem::pad_layer(scene_.sensor.poisson);
  return finer_.emplace(cells, fem::PadSolver(layer, options).solve(scene_)).first->second;
}

std::optional<PadError> PadJudge::error(const PadRung& rung, const fem::PadSolution& answer) {
  if (answer.steps.size() > most_steps) return {};
  const fem::PadSolution& other = finer(finer_cells(rung));
  if (!every_step_converged(other)) return {};
  PadError error{.most95 = fem::pad_difference(answer, other),
                 .scenes = "this scene",
                 .outside = outside(measured_judge, scene_, deepest(answer))};
  const double by_cells = more / (1 - std::pow(static_cast<double>(rung.cells) / other.cells.n, order));
  const bool map = std::holds_alternative<fem::HeightMap>(scene_.indenter.shape);
  for (const auto member : fem::pad_error_members) {
    double& e = error.most95.*member;
    if (!std::isfinite(e)) return {};
    if (e == 0) continue;  // without friction
    const bool of_pressure = member == &Errors::P || member == &Errors::sigma;
    e = least + e * (of_pressure ? by_cells : std::max(by_cells, by_increments));
    if (of_pressure && map) e += least_of_map / rung.cells;
  }
  error.most95.slip_index = std::min(1.0, error.most95.slip_index);
  error.largest = std::min(1.0, 2 * error.most95.slip_index);
  error.from = fmt::format("{0} x {0} cells", other.cells.n);
  return error;
}

}  // namespace tactel::host
