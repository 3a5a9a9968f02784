// SPDX-License-Identifier: Apache-2.0
#include "host/scenes/hold_load.h"

#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "fem/numbers/angles.h"
#include "host/scenes/path_draws.h"

namespace tactel::host {
namespace {

constexpr std::size_t waves = 24;  ///< of an uneven face
constexpr int most_frames = 1000, most_moves = 20;
constexpr double least_grip = 0.2, most_grip = 10;  ///< P behind squeezes, over the preload

constexpr const char *some_frames = "a number of frames, 0 to 1000", *some_degrees = "degrees, -360 to 360",
                     *some_load = "a load over mu P, 0 to 10", *some_mm = "a number of mm, 0 to 100";

/// A number of [load.hold] that differs between grips.
struct HoldNumber {
  const char* key;
  Distribution HoldLoad::*member;
  double least, most;
  const char* allowed;
};
constexpr std::array hold_numbers{
    HoldNumber{"rest", &HoldLoad::rest, 0, most_frames, some_frames},
    HoldNumber{"weight", &HoldLoad::weight, 0, 10, some_load},
    HoldNumber{"direction", &HoldLoad::direction, -360, 360, some_degrees},
    HoldNumber{"moves", &HoldLoad::moves, 0, most_moves, "a number of moves, 0 to 20"},
    HoldNumber{"size", &HoldLoad::size, 0, 100, "a load over mu P, 0 to 100"},
    HoldNumber{"turn", &HoldLoad::turn, -1, 1, "a share, -1 to 1"},
    HoldNumber{"move_frames", &HoldLoad::move_frames, 1, most_frames, "a number of frames, 1 to 1000"},
    HoldNumber{"pause", &HoldLoad::pause, 0, most_frames, some_frames},
    HoldNumber{"relax", &HoldLoad::relax, -0.9, 0.9, "a share of the force, -0.9 to 0.9"},
    HoldNumber{"loss", &HoldLoad::loss, -1, 1, "a share of the force a mm, -1 to 1"},
    HoldNumber{"tilt", &HoldLoad::tilt, -10, 10, "a share of the depth, -10 to 10"},
    HoldNumber{"tilt_direction", &HoldLoad::tilt_direction, -360, 360, some_degrees}};
/// Those that need the rate.
constexpr std::array hand_numbers{
    HoldNumber{"tremor", &HoldLoad::tremor, 0, 0.3, "a share of the force, 0 to 0.3"},
    HoldNumber{"tremor_frequency", &HoldLoad::tremor_frequency, 0.01, 1000, "a frequency, 0.01 Hz to half the rate"},
    HoldNumber{"tremor_share", &HoldLoad::tremor_share, 0, 1, "a share of the variance, 0 to 1"},
    HoldNumber{"squeeze", &HoldLoad::squeeze, 0.1, 10, "a ratio of two forces, 0.1 to 10"},
    HoldNumber{"squeeze_start", &HoldLoad::squeeze_start, -100, 100, "a number of frames, -100 to 100"},
    HoldNumber{"squeeze_frames", &HoldLoad::squeeze_frames, 1, most_frames, "a number of frames, 1 to 1000"},
    HoldNumber{"swing", &HoldLoad::swing, 0, 180, "degrees, 0 to 180"},
    HoldNumber{"swing_radius", &HoldLoad::swing_radius, 0, 100, some_mm},
    HoldNumber{"roll", &HoldLoad::roll, 0, 10, "a number of mm a degree, 0 to 10"},
    HoldNumber{"added_weight", &HoldLoad::added_weight, 0, 10, some_load},
    HoldNumber{"regrip_shift", &HoldLoad::regrip_shift, 0, 100, some_mm}};

double smooth(double s) { return s * s * (3 - 2 * s); }

fem::UnevenFace draw_face(PathDraws& draws, double rms, double length) {
  std::vector<double> normal(2 * waves), phase(waves);
  for (double& number : normal) number = draws.number(NormalDraw{0, 1, -4, 4});
  for (double& number : phase) number = draws.number(UniformDraw{0, 2 * std::numbers::pi});
  return fem::UnevenFace::of(rms, length, normal, phase);
}

/// x, y and turn over the limit, and the swing, rad.
using Place = std::array<double, 4>;

/// Adds frames to a grip; those beyond its end are dropped.
class Frames {
 public:
  explicit Frames(Hold& hold) : hold_(hold) {}

  void go(const Place& to, int count) {
    const Place from = at_;
    for (int i = 1; i <= count && next_ < hold_.frames.size(); ++i, ++next_) {
      Hold::Frame& frame = hold_.frames[next_];
      const double s = smooth(static_cast<double>(i) / count);
      for (std::size_t k = 0; k < 3; ++k) frame.load[k] = std::lerp(from[k], to[k], s);
      frame.swing = std::lerp(from[3], to[3], s);
    }
    at_ = to;
  }
  void stay(int count) { go(at_, count); }
  void stay_to_the_end() { stay(static_cast<int>(hold_.frames.size() - next_)); }
  const Place& at() const { return at_; }
  int next() const { return static_cast<int>(next_); }

 private:
  Hold& hold_;
  std::size_t next_ = 0;
  Place at_{};
};

/// A load of this size: a part of it turns.
Place load_of(double size, double direction, double turn) {
  const double along = size * std::sqrt(1 - turn * turn);
  return {along * std::cos(direction), along * std::sin(direction), size * turn, 0};
}

/// A vector of this length, anywhere.
std::array<double, 2> draw_vector(PathDraws& hand, double length) {
  const double direction = hand.number(UniformDraw{0, 2 * std::numbers::pi});
  return {length * std::cos(direction), length * std::sin(direction)};
}

/// What a hand does with a move.
struct HandMove {
  bool regrip = false, alone = false;
  double squeeze = 1, swing = 0, weight = 0;  ///< swing: rad
  int start = 0, frames = 1;                  ///< of the squeeze, from the move on
  std::array<double, 2> shift{};              ///< mm
};

HandMove draw_hand_move(const HoldLoad& from, PathDraws& hand) {
  HandMove move{.regrip = hand.happens(from.regrip), .alone = hand.happens(from.squeeze_alone)};
  move.squeeze = hand.number(from.squeeze), move.start = hand.count(from.squeeze_start);
  move.frames = hand.count(from.squeeze_frames);
  move.swing = fem::radians(hand.number(from.swing));
  if (hand.happens(0.5)) move.swing = -move.swing;
  move.weight = hand.number(from.added_weight);
  move.shift = draw_vector(hand, hand.number(from.regrip_shift));
  return move;
}

/// P grows by a ratio, from a frame on.
void squeeze(Hold& hold, int first, int count, double ratio) {
  for (std::size_t k = static_cast<std::size_t>(std::max(first, hold.press)); k < hold.frames.size(); ++k)
    hold.frames[k].P *= std::lerp(1.0, ratio, smooth(std::min((static_cast<int>(k) - first + 1.0) / count, 1.0)));
}

/// The hand puts the object down, opens, grips it again where it lies elsewhere, and takes up its weight.
void grip_again(Hold& hold, Frames& frames, const Place& held, const Place& weight, int open,
                const std::array<double, 2>& shift) {
  const int pressing = hold.pressing(), lifting = hold.press - pressing;
  Place down = held;
  for (std::size_t k = 0; k < 3; ++k) down[k] -= weight[k];
  frames.go(down, lifting);
  const int opens = frames.next(), closes = opens + pressing + open;
  frames.stay(2 * pressing + open);
  for (std::size_t k = static_cast<std::size_t>(opens); k < hold.frames.size(); ++k) {
    const int i = static_cast<int>(k) + 1;
    hold.frames[k].P *= smooth(std::clamp(std::max(opens + pressing - i, i - closes) / (1.0 * pressing), 0.0, 1.0));
    if (i >= opens + pressing)
      for (std::size_t axis = 0; axis < 2; ++axis) hold.frames[k].shift[axis] += shift[axis];
  }
  frames.go(held, lifting);
}

/// A hand's tremor, in all frames that are stepped by motion.
void tremble(const HoldLoad& from, PathDraws& hand, Hold& hold) {
  struct Tone {
    double peak, frequency, phase;  ///< rad a frame, rad
    double at(std::size_t k) const { return peak * std::sin(frequency * static_cast<double>(k) + phase); }
  };
  const double rms = hand.number(from.tremor), share = hand.number(from.tremor_share);
  const std::array<double, 2> line = draw_vector(hand, 1);
  const auto tone = [&](double part) {
    const double frequency = 2 * std::numbers::pi * hand.number(from.tremor_frequency) / from.rate;
    return Tone{rms * std::sqrt(2 * part), frequency, hand.number(UniformDraw{0, 2 * std::numbers::pi})};
  };
  const Tone along = tone(share), across = tone((1 - share) / 2), of_P = tone((1 - share) / 2);
  for (std::size_t k = static_cast<std::size_t>(hold.pressing()); k < hold.frames.size(); ++k) {
    const double a = along.at(k), b = across.at(k);
    hold.frames[k].tremor = {line[0] * a - line[1] * b, line[1] * a + line[0] * b};
    hold.frames[k].P *= 1 + of_P.at(k);
  }
}

void read_numbers(DrawTable& in, std::span<const HoldNumber> table, HoldLoad& load) {
  for (const HoldNumber& number : table)
    load.*number.member = in.distribution(number.key, load.*number.member, number.least, number.most, number.allowed);
}

/// What a hand does needs the rate, and some of it a way to move.
void check_hand(const TomlFile& file, const toml::table& table, const HoldLoad& load) {
  const auto refuse = [&](const char* key, const char* allowed) {
    if (const toml::node* node = table.get(key)) throw file.error(std::string("load.hold.") + key, node, allowed);
  };
  const char* const with_rate = "given with load.hold.rate, in Hz";
  if (!(load.rate > 0)) {
    for (const HoldNumber& number : hand_numbers) refuse(number.key, with_rate);
    refuse("squeeze_alone", with_rate), refuse("regrip", with_rate);
  } else if (ends(load.tremor).second > 0 && ends(load.tremor_frequency).second > load.rate / 2) {
    throw file.error("load.hold.tremor_frequency", table.get("tremor_frequency"),
                     "a frequency, 0.01 Hz to half the rate");
  }
  if (load.by_motion)
    refuse("added_weight", "given with by = \"force\"");
  else
    for (const char* key : {"swing", "swing_radius", "roll"}) refuse(key, "given with by = \"motion\"");
}

}  // namespace

std::uint32_t HoldLoad::most_draws_without_rate() const {
  return static_cast<std::uint32_t>(10 + 3 * waves + 7 * static_cast<std::size_t>(std::lround(ends(moves).second)));
}
std::uint32_t HoldLoad::most_draws() const {
  const auto moved = static_cast<std::uint32_t>(std::lround(ends(moves).second));
  return most_draws_without_rate() + (rate > 0 ? 13 + 10 * moved : 0);
}

HoldLoad read_hold_load(const TomlFile& file, const toml::table& table) {
  DrawTable in(file, table, "load.hold");
  HoldLoad load;
  load.frames = in.whole("frames", load.frames, 20, most_frames, "a whole number of frames, 20 to 1000");
  load.press = in.whole("press", load.press, 2, most_frames, "a whole number of frames, 2 to load.hold.frames");
  if (load.press > load.frames)
    throw file.error("load.hold.press", table.get("press"), "a whole number of frames, 2 to load.hold.frames");
  load.by_motion = in.second("by", "force", "motion", false);
  if (load.by_motion) load.size = LogUniformDraw{0.1, 30};
  load.back = in.probability("back", load.back);
  read_numbers(in, hold_numbers, load);
  load.rate = in.number("rate", 0, 1, 1e5, "a rate in Hz, 1 to 100000");
  load.squeeze_alone = in.probability("squeeze_alone", 0), load.regrip = in.probability("regrip", 0);
  read_numbers(in, hand_numbers, load);
  in.finish();
  check_hand(file, table, load);
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
  PathDraws draws(key), hand(key, from.most_draws_without_rate());
  Hold hold{.frames = std::vector<Hold::Frame>(static_cast<std::size_t>(from.frames)),
            .press = from.press,
            .by_motion = from.by_motion,
            .rate = from.rate};
  const double relax = draws.number(from.relax);
  hold.loss = draws.number(from.loss);
  hold.tilt = draws.number(from.tilt);
  hold.tilt_direction = fem::radians(draws.number(from.tilt_direction));
  const int pressing = hold.pressing();
  const double fades = std::max(from.frames - from.press, 1) / 3.0;
  for (int k = 0; k < from.frames; ++k)
    hold.frames[static_cast<std::size_t>(k)].P =
        k < pressing ? (k + 1.0) / pressing : 1 - relax * (1 - std::exp(-std::max(k - from.press, 0) / fades));
  if (from.rate > 0) {
    tremble(from, hand, hold);
    hold.pivot = draw_vector(hand, hand.number(from.swing_radius));
    hold.roll = draw_vector(hand, fem::degrees(hand.number(from.roll)));
  }
  Frames frames(hold);
  frames.stay(pressing);
  const double weight = draws.number(from.weight), down = fem::radians(draws.number(from.direction));
  frames.go(load_of(weight, down, 0), from.press - pressing);
  frames.stay(draws.count(from.rest));
  Place at_rest = frames.at();
  const int moves = draws.count(from.moves);
  double grip = 1;  // P over that of a hand that squeezes nowhere
  for (int k = 0; k < moves; ++k) {
    const double size = draws.number(from.size), direction = fem::radians(draws.number(from.direction));
    const Place more = load_of(size, direction, draws.number(from.turn));
    const int count = draws.count(from.move_frames), pause = draws.count(from.pause);
    const bool back = draws.happens(from.back);
    const HandMove does = from.rate > 0 ? draw_hand_move(from, hand) : HandMove{};
    if (does.regrip) {
      grip_again(hold, frames, from.by_motion ? frames.at() : at_rest, at_rest, std::max(pause, 1), does.shift);
      frames.stay(pause);
      continue;
    }
    const double before_squeeze = grip;
    grip = std::clamp(grip * does.squeeze, least_grip, most_grip);
    squeeze(hold, frames.next() + does.start, does.frames, grip / before_squeeze);
    if (does.alone) {
      frames.stay(count + pause);
      continue;
    }
    Place before = frames.at();
    const Place gained = load_of(does.weight, down, 0);
    for (std::size_t axis = 0; axis < 2; ++axis) at_rest[axis] += gained[axis], before[axis] += gained[axis];
    Place to = from.by_motion ? before : at_rest;
    for (std::size_t axis = 0; axis < 3; ++axis) to[axis] += more[axis];
    to[3] += does.swing;
    frames.go(to, count);
    frames.stay(pause);
    if (!back) continue;
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
