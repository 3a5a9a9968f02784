// SPDX-License-Identifier: Apache-2.0
#include "host/contact/limits.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "fem/gap/stress_field.h"
#include "fem/numbers/angles.h"
#include "fem/numbers/number_text.h"
#include "fem/numbers/value_error.h"
#include "fem/pad/pad_layers.h"
#include "fem/pad/pad_search.h"
#include "host/support/stop_scope.h"

namespace tactel::host {
namespace {

constexpr double share_of_contact = 0.1;  ///< of its width, over which the indenter may slide
constexpr double most_stress_work = 1e9;  ///< fem::base_stress_work
constexpr double at_edge = 1;             ///< thicknesses from an edge, below which contacts are refused
constexpr double least_from_block = 2;    ///< H, where an end of the rubber moves a contact by some 0.5 %

/// Error in S of lines without free sides, at a distance of the contact from the edge over the thickness: by the free
/// sides of lines, nu 0.3 to 0.499 and contacts 1.2 H wide, 0.06 to 0.12 at 0.7 and 0.005 to 0.018 at 2.1; between them
/// it falls exponentially.
double missing_at_edge(double distance, double at_near, double at_far) {
  constexpr double near = 0.7, far = 2.1;
  return at_near * std::pow(at_far / at_near, (distance - near) / (far - near));
}

fem::PadSides sides_below(const fem::PadScene& scene) {
  return fem::sides_at(scene.sensor, {scene.indenter.position[0], scene.indenter.position[1]}, fem::SideBricks::usual,
                       StopScope::checker());
}

/// Cells of a scene, as the solver lays them.
fem::PadLayout lay(const fem::PadScene& scene, int cells) {
  return fem::lay_cells(scene, fem::pad_layer(scene), cells, true, sides_below(scene));
}

}  // namespace

bool reaches_beyond_block(const fem::PadScene& scene, const fem::PadCells& laid) {
  const auto& position = scene.indenter.position;
  const fem::PadSides sides = sides_below(scene);
  if (!sides.free()) return false;
  const fem::PadBox box = laid.box();
  const double H = sides.thickness, angle = fem::radians(laid.frame(scene.indenter));
  const std::array whole{*scene.sensor.length, *scene.sensor.width};
  for (const int axis : {0, 1}) {
    const double half = sides.kernel->sides()[axis] * H / 2, middle = sides.middle[axis];
    if (whole[axis] / 2 - half < 1e-6 * H) continue;     // the block is the pad
    const auto ends_near = [&](double end, double at) {  // an end of the block that is none of the pad
      return std::abs(end) < whole[axis] / 2 - 1e-6 * H && std::abs(at - end) < least_from_block * H;
    };
    for (const double x : {box.x.left, box.x.right})
      for (const double y : {box.y.left, box.y.right}) {
        const double at = position[axis] + (axis == 0 ? std::cos(angle) * x - std::sin(angle) * y
                                                      : std::sin(angle) * x + std::cos(angle) * y);
        if (ends_near(middle - half, at) || ends_near(middle + half, at) || std::abs(at - middle) > half + 1e-6 * H)
          return true;
      }
  }
  return false;
}

bool too_deep(double thickness, double indentation) {
  constexpr double rounding = 1e-6;  // of a depth in fp32
  return indentation > fem::linear_strain_limit * (1 + rounding) * thickness;
}

double slip_limit(double contact_width) { return share_of_contact * contact_width; }

double slip_limit(const fem::Sensor& sensor, double contact_width) {
  return std::max(sensor.length / (sensor.columns - 1), slip_limit(contact_width));
}

void refuse_endless(const fem::PadScene& scene, int cells) {
  const double H = scene.sensor.thickness;
  const fem::PadLayout layout = lay(scene, cells);
  const fem::PadCells& laid = layout.cells;
  const auto [least, most] = fem::solvable_sides(H, layout.depth);
  if (!fem::solvable(laid, H, layout.depth))
    throw ValueError("indenter.shape", fem::shape_name(scene.indenter.shape),
                     fmt::format("one whose contact measures {:.2g} to {:.2g} mm along a side, not {:.3g} x {:.3g} mm",
                                 cells * least, cells * most, cells * laid.hx, cells * laid.hy));
  if (reaches_beyond_block(scene, laid))
    throw ValueError(
        "sensor.sides", "free",
        fmt::format("\"held\" here: on a pad longer than {:g} mm ({:g} thicknesses) contacts with "
                    "free sides extend over {:g} mm at most",
                    fem::longest_block * H, fem::longest_block, (fem::longest_block - 2 * least_from_block) * H));
  if (scene.sensor.tactel_size > 0 && fem::base_stress_work(scene, laid) > most_stress_work)
    throw ValueError("sensor.tactel_size", fem::number_text(scene.sensor.tactel_size),
                     fmt::format("a side of fewer thicknesses ({:.3g} mm): the stress under {} x {} tactels of {:.3g} "
                                 "thicknesses takes minutes",
                                 H, scene.sensor.tactels[0], scene.sensor.tactels[1], scene.sensor.tactel_size / H));
}

std::optional<double> distance_to_edge(const fem::PadSensor& sensor, const std::array<double, 2>& position,
                                       const fem::PadBox& reach) {
  const fem::PadBox rubber = fem::rubber_of(sensor);  // of the model
  double least = std::numeric_limits<double>::infinity();
  const auto along = [&](const std::optional<double>& side, double at, const fem::Interval& to, double end) {
    if (side && *side / 2 < end) least = std::min(least, *side / 2 - std::max(at + to.right, -at - to.left));
  };
  along(sensor.length, position[0], reach.x, rubber.x.right), along(sensor.width, position[1], reach.y, rubber.y.right);
  return reach.x.left < reach.x.right && std::isfinite(least) ? std::optional(least) : std::nullopt;
}

std::optional<double> distance_to_edge(const fem::PadScene& scene, const fem::PadSolution& solution) {
  fem::PadBox reach{fem::nowhere, fem::nowhere};
  for (const fem::PadStep& step : solution.steps) reach.cover(step.reach);
  return distance_to_edge(scene.sensor, scene.indenter.position, reach);
}

bool too_near_edge(const fem::PadSensor& sensor, const std::optional<double>& distance) {
  return distance && *distance < at_edge * sensor.thickness;
}

void refuse_at_edge(const fem::PadScene& scene, const std::optional<double>& distance) {
  if (!too_near_edge(scene.sensor, distance)) return;
  throw ValueError("indenter.position", fem::number_text(scene.indenter.position.data(), 2),
                   fmt::format("a place where the contact stays {:.3g} mm (the thickness) from the edges that "
                               "sensor.length and sensor.width give, not {:.3g} mm: the model has no free sides, which "
                               "puts S of lines off by {} at one thickness",
                               scene.sensor.thickness, *distance, error_at_edge(at_edge)));
}

int outside_model(const fem::PadSensor& sensor, const std::array<double, 2>& position, const fem::PadBox& reach,
                  double cell) {
  if (!(reach.x.left < reach.x.right)) return 0;
  int outside = cell > sensor.thickness ? outside_cells : 0;
  if (too_near_edge(sensor, distance_to_edge(sensor, position, reach))) outside += outside_edges;
  if (!wide_pitch(sensor)) return outside;
  double nearest = std::numeric_limits<double>::infinity();
  const Eigen::MatrixX2d tactels = fem::tactel_places(sensor);
  for (Eigen::Index i = 0; i < tactels.rows(); ++i) {
    const double x = tactels(i, 0) - position[0], y = tactels(i, 1) - position[1];
    nearest = std::min(nearest, std::hypot(x - std::clamp(x, reach.x.left, reach.x.right),
                                           y - std::clamp(y, reach.y.left, reach.y.right)));
  }
  return outside + (far_from_tactels(sensor, nearest) ? outside_tactels : 0);
}

std::string error_at_edge(double distance) {
  return fmt::format("{:.2g} to {:.2g}", missing_at_edge(distance, 0.06, 0.005),
                     missing_at_edge(distance, 0.12, 0.018));
}

bool wide_pitch(const fem::PadSensor& sensor) {
  return std::max(sensor.pitch[0], sensor.pitch[1]) > 2 * sensor.thickness;
}

bool far_from_tactels(const fem::PadSensor& sensor, double distance) {
  return std::isfinite(distance) && distance - sensor.tactel_size / 2 > sensor.thickness;
}

}  // namespace tactel::host
