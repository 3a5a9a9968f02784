// SPDX-License-Identifier: Apache-2.0
#include "host/scenes/hold_load.h"

#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fem/angles.h"
#include "host/scenes/path_draws.h"

namespace tactel::host {
namespace {

constexpr std::size_t waves = 24;  ///< of an uneven face
constexpr int most_frames = 1000, most_moves = 20;

double smooth(double s) { return s * s * (3 - 2 * s); }

fem::UnevenFace draw_face(PathDraws& draws, double rms, double length) {
  std::vector<double> normal(2 * waves), phase(waves);
  for (double& number : normal) number = draws.number(NormalDraw{0, 1, -4, 4});
  for (double& number : phase) number = draws.number(UniformDraw{0, 2 * std::numbers::pi});
  return fem::UnevenFace::of(rms, length, normal, phase);
}

/// Adds frames to a grip; those beyond its end are dropped.
class Frames {
 public:
  explicit Frames(Hold& hold) : hold_(hold) {}

  void go(std::array<double, 3> to, int count) {
    const std::array<double, 3> from = at_;
    for (int i = 1; i <= count && next_ < hold_.frames.size(); ++i, ++next_)
      for (std::size_t k = 0; k < 3; ++k)
        hold_.frames[next_].load[k] = std::lerp(from[k], to[k], smooth(static_cast<double>(i) / count));
    at_ = to;
  }
  void stay(int count) { go(at_, count); }
  void stay_to_the_end() { stay(static_cast<int>(hold_.frames.size() - next_)); }
  const std::array<double, 3>& at() const { return at_; }

 private:
  Hold& hold_;
  std::size_t next_ = 0;
  std::array<double, 3> at_{};
};

/// A load of this size: a part of it turns.
std::array<double, 3> load_of(double size, double direction, double turn) {
  const double along = size * std::sqrt(1 - turn * turn);
  return {along * std::cos(direction), along * std::sin(direction), size * turn};
}

}  // namespace

std::uint32_t HoldLoad::most_draws() const {
  return static_cast<std::uint32_t>(10 + 3 * waves + 7 * static_cast<std::size_t>(std::lround(ends(moves).second)));
}

HoldLoad read_hold_load(const TomlFile& file, const toml::table& table) {
  constexpr const char *frames = "a number of frames, 0 to 1000", *degrees = "degrees, -360 to 360";
  DrawTable in(file, table, "load.hold");
  HoldLoad load;
  load.frames = in.whole("frames", 300, 20, most_frames, "a whole number of frames, 20 to 1000");
  load.press = in.whole("press", 20, 2, most_frames, "a whole number of frames, 2 to load.hold.frames");
  if (load.press > load.frames)
    throw file.error("load.hold.press", table.get("press"), "a whole number of frames, 2 to load.hold.frames");
  load.by_motion = in.second("by", "force", "motion", false);
  const Distribution usual = load.by_motion ? LogUniformDraw{0.1, 30} : LogUniformDraw{0.05, 1.5};
  load.rest = in.distribution("rest", UniformDraw{20, 60}, 0, most_frames, frames);
  load.weight = in.distribution("weight", LogUniformDraw{0.15, 0.95}, 0, 10, "a load over mu P, 0 to 10");
  load.direction = in.distribution("direction", UniformDraw{0, 360}, -360, 360, degrees);
  load.moves = in.distribution("moves", ChoiceDraw{{1, 2, 3}, {1, 1, 1}}, 0, most_moves, "a number of moves, 0 to 20");
  load.size = in.distribution("size", usual, 0, 100, "a load over mu P, 0 to 100");
  load.turn = in.distribution("turn", UniformDraw{-1, 1}, -1, 1, "a share, -1 to 1");
  load.move_frames =
      in.distribution("move_frames", LogUniformDraw{4, 60}, 1, most_frames, "a number of frames, 1 to 1000");
  load.pause = in.distribution("pause", UniformDraw{0, 40}, 0, most_frames, frames);
  load.back = in.probability("back", 0.6);
  load.relax = in.distribution("relax", UniformDraw{0, 0.06}, -0.9, 0.9, "a share of the force, -0.9 to 0.9");
  load.loss = in.distribution("loss", NormalDraw{0.01, 0.03, -0.08, 0.1}, -1, 1, "a share of the force a mm, -1 to 1");
  load.tilt = in.distribution("tilt", NormalDraw{0, 0.4, -1.6, 1.6}, -10, 10, "a share of the depth, -10 to 10");
  load.tilt_direction = in.distribution("tilt_direction", UniformDraw{0, 360}, -360, 360, degrees);
  in.finish();
  return load;
}

Unevenness read_unevenness(const TomlFile& file, const toml::node& node) {
  constexpr const char* both = "{ rms = ..., length = ... }, each a number of mm or a distribution";
  const toml::table* table = node.as_table();
  if (table == nullptr || !table->contains("rms") || !table->contains("length"))
    throw file.error("indenter.unevenness", &node, both);
  DrawTable in(file, *table, "indenter.unevenness");
  Unevenness read{in.distribution("rms", always(0), 0, 10, "an rms height, 0 to 10 mm"),
                  in.distribution("length", always(1), 1e-3, 1e3, "a length, 0.001 to 1000 mm")};
  in.finish();
  return read;
}

Hold draw_hold(const HoldLoad& from, const std::optional<Unevenness>& unevenness, const DrawKey& key) {
  PathDraws draws(key);
  Hold hold{.frames = std::vector<Hold::Frame>(static_cast<std::size_t>(from.frames)),
            .press = from.press,
            .by_motion = from.by_motion};
  const double relax = draws.number(from.relax);
  hold.loss = draws.number(from.loss);
  hold.tilt = draws.number(from.tilt);
  hold.tilt_direction = fem::radians(draws.number(from.tilt_direction));
  const int pressing = hold.pressing();
  const double fades = std::max(from.frames - from.press, 1) / 3.0;
  for (int k = 0; k < from.frames; ++k)
    hold.frames[static_cast<std::size_t>(k)].P =
        k < pressing ? (k + 1.0) / pressing : 1 - relax * (1 - std::exp(-std::max(k - from.press, 0) / fades));
  Frames frames(hold);
  frames.stay(pressing);
  const double weight = draws.number(from.weight);
  frames.go(load_of(weight, fem::radians(draws.number(from.direction)), 0), from.press - pressing);
  frames.stay(draws.count(from.rest));
  const std::array<double, 3> at_rest = frames.at();
  const int moves = draws.count(from.moves);
  for (int k = 0; k < moves; ++k) {
    const std::array<double, 3> before = frames.at();
    std::array<double, 3> to = from.by_motion ? before : at_rest;
    const double size = draws.number(from.size), direction = fem::radians(draws.number(from.direction));
    const std::array<double, 3> more = load_of(size, direction, draws.number(from.turn));
    for (std::size_t axis = 0; axis < 3; ++axis) to[axis] += more[axis];
    const int count = draws.count(from.move_frames), pause = draws.count(from.pause);
    frames.go(to, count);
    frames.stay(pause);
    if (!draws.happens(from.back)) continue;
    frames.go(before, count);
    frames.stay(pause);
  }
  frames.stay_to_the_end();
  if (unevenness) {
    hold.rms = draws.number(unevenness->rms);
    hold.face = draw_face(draws, hold.rms, draws.number(unevenness->length));
  }
  return hold;
}

}  // namespace tactel::host
