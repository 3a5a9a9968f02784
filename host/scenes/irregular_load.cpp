// SPDX-License-Identifier: Apache-2.0
#include "host/scenes/irregular_load.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/scenes/path_draws.h"
#include "host/scenes/scene_tables.h"

namespace tactel::host {
namespace {

constexpr double smallest_share = 0.1;  ///< of a step, over the largest possible one
constexpr double most_share = 2;        ///< of a later press or a partial release, over the first press

double rounded_most(const Distribution& count) { return std::round(ends(count).second); }

/// Returns `steps` increasing shares; the last is 1.
std::vector<double> shares(PathDraws& draws, int steps) {
  std::vector<double> sums;
  sums.reserve(static_cast<std::size_t>(steps));
  double sum = 0;
  for (int i = 0; i < steps; ++i) sums.push_back(sum += draws.number(UniformDraw{smallest_share, 1}));
  for (double& share : sums) share /= sum;
  sums.back() = 1;
  return sums;
}

/// Where a stroke goes: a unit vector, and its twist, rad.
struct Stroke {
  double x = 1, y = 0, twist = 0;

  /// Draws the next: of a line the same again, of a pad any. A reversal goes, and twists, against the one before.
  void turn(PathDraws& draws, const IrregularLoad& irregular, bool reversed) {
    if (reversed) x = -x, y = -y;
    if (!irregular.turning) return;
    const double direction = radians(draws.number(irregular.turning->direction)),
                 drawn = radians(draws.number(irregular.turning->twist));
    if (!reversed) x = std::cos(direction), y = std::sin(direction);
    twist = reversed ? std::copysign(drawn, -twist) : drawn;
  }
};

void put(std::vector<fem::LoadMove>& moves, const fem::PadTarget& at) { moves.push_back({at.normal, at.x}); }
void put(std::vector<fem::PadTarget>& moves, const fem::PadTarget& at) { moves.push_back(at); }

}  // namespace

double IrregularLoad::most_steps() const {
  const double of_stroke = 2 * rounded_most(stroke_steps) + (release > 0 ? rounded_most(release_steps) : 0);
  return rounded_most(presses) * (2 * rounded_most(press_steps) + rounded_most(strokes) * of_stroke);
}

double IrregularLoad::most_twist() const {
  if (!turning) return 0;
  const auto [low, high] = ends(turning->twist);
  return rounded_most(presses) * rounded_most(strokes) * std::max(std::abs(low), std::abs(high));
}

std::uint32_t IrregularLoad::most_draws() const {
  const double of_stroke = 8 + rounded_most(release_steps) + 2 * rounded_most(stroke_steps);
  return static_cast<std::uint32_t>(1 + rounded_most(presses) *
                                            (5 + 2 * rounded_most(press_steps) + rounded_most(strokes) * of_stroke));
}

IrregularLoad read_irregular_load(const TomlFile& file, const toml::table& table, bool pad) {
  constexpr const char* some = "a number of them, 1 to 100";
  constexpr const char* share = "a share of the first press, 0 to 2";
  DrawTable in(file, table, "load.irregular");
  IrregularLoad load{.presses = in.distribution("presses", always(1), 1, 100, some),
                     .press_depth = in.distribution("press_depth", always(1), smallest_share, most_share,
                                                    "a share of the first press, 0.1 to 2"),
                     .press_steps = in.distribution("press_steps", always(4), 1, 100, some),
                     .strokes = in.distribution("strokes", always(1), 1, 100, some),
                     .stroke = in.distribution("stroke", always(0.2), 0, std::numeric_limits<double>::max(),
                                               "a length in mm, 0 or more"),
                     .stroke_steps = in.distribution("stroke_steps", always(6), 1, 100, some),
                     .release_to = in.distribution("release_to", always(0.5), 0, most_share, share),
                     .release_steps = in.distribution("release_steps", always(2), 1, 100, some),
                     .backward = pad ? 0 : in.probability("backward", 0),
                     .reversal = in.probability("reversal", 0),
                     .pause = in.probability("pause", 0),
                     .release = in.probability("release", 0)};
  if (pad)
    load.turning = {in.distribution("direction", always(0), -360, 360, "degrees from x, -360 to 360"),
                    in.distribution("twist", always(0), -360, 360, "degrees, -360 to 360")};
  in.finish();
  if (const double most = load.most_twist(); most > 360)
    throw file.error("load.irregular.twist", table.get("twist"),
                     fmt::format("twists of at most 360 degrees in a path; its strokes together may have {:g}", most));
  if (const double most = load.most_steps(); most > fem::most_tangential_steps)
    throw file.error(
        "load.irregular", &table,
        fmt::format("a path of at most {} load steps; the largest counts give {}", fem::most_tangential_steps, most));
  return load;
}

template <class Load>
void draw_irregular_load(const IrregularLoad& irregular, const DrawKey& key, Load& load) {
  PathDraws draws(key);
  std::vector<double>& first = load.normal_force.empty() ? load.indentation : load.normal_force;
  const double nominal = first.front();
  fem::PadTarget at;  // of a line x alone
  const auto go = [&](const fem::PadTarget& to, int steps, double pause) {
    const fem::PadTarget from = at;
    for (const double share : shares(draws, steps)) {
      at = {std::lerp(from.normal, to.normal, share), std::lerp(from.x, to.x, share), std::lerp(from.y, to.y, share),
            std::lerp(from.twist, to.twist, share)};
      put(load.moves, at);
      if (pause > 0 && draws.happens(pause)) put(load.moves, at);
    }
  };
  const auto press_to = [&](double normal, int steps) { go({normal, at.x, at.y, at.twist}, steps, 0); };
  const int presses = draws.count(irregular.presses);
  for (int press = 0; press < presses; ++press) {
    const double depth = press == 0 ? nominal : nominal * draws.number(irregular.press_depth);
    const int press_steps = draws.count(irregular.press_steps);
    if (press == 0) {
      first.clear();
      for (const double share : shares(draws, press_steps)) first.push_back(nominal * share);
      at.normal = nominal;
    } else {
      press_to(depth, press_steps);
    }
    Stroke stroke;
    if (!irregular.turning && draws.happens(irregular.backward)) stroke.x = -1;
    const int strokes = draws.count(irregular.strokes);
    for (int k = 0; k < strokes; ++k) {
      if (draws.happens(irregular.release)) {
        const int steps = draws.count(irregular.release_steps);
        press_to(depth * draws.number(irregular.release_to), steps);
      }
      stroke.turn(draws, irregular, k > 0 && draws.happens(irregular.reversal));
      const double length = draws.number(irregular.stroke);
      go({at.normal, at.x + stroke.x * length, at.y + stroke.y * length, at.twist + stroke.twist},
         draws.count(irregular.stroke_steps), irregular.pause);
    }
    if (press + 1 < presses) press_to(0, draws.count(irregular.press_steps));
  }
  load.indentation_steps = 1;
}

template void draw_irregular_load(const IrregularLoad&, const DrawKey&, fem::Load&);
template void draw_irregular_load(const IrregularLoad&, const DrawKey&, fem::PadLoad&);

}  // namespace tactel::host
