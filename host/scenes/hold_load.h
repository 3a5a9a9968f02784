// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "fem/pad/uneven_face.h"
#include "host/scenes/distribution.h"

namespace tactel::host {

/// What rides along with an object's face, mm: `indenter.unevenness` of a sweep of holds.
struct Unevenness {
  Distribution rms, length;
};

/// A random grip that holds an object, [load.hold] of a pad's sweep file, frame by frame: it presses, takes up the
/// object's weight, rests, and moves. Loads along the pad are over the limit: by force over friction's limit mu P, by
/// motion over the elastic limit, the shear of a layer that bears mu times the mean pressure.
struct HoldLoad {
  int frames = 300;
  int press = 20;                   ///< frames before the rest: the first half presses, the other takes up the weight
  bool by_motion = false;           ///< the object's place is given, not the force on it
  Distribution rest;                ///< frames before the first move
  Distribution weight;              ///< load at rest
  Distribution direction;           ///< degrees, of the weight and of each move
  Distribution moves;               ///< number of moves
  Distribution size;                ///< load of a move
  Distribution turn;                ///< share of a move that turns the object, -1 to 1
  Distribution move_frames, pause;  ///< frames of a move, and behind it
  double back = 0.6;                ///< probability that a move goes back, behind another pause
  Distribution relax;               ///< share of P that the grip loses in time
  Distribution loss;                ///< share of P that it loses as the object slides a mm
  Distribution tilt;  ///< how far the face rises half a pad from its axis at the limit mu P, over its depth at rest
  Distribution tilt_direction;  ///< degrees, from the load

  /// Returns a bound of the numbers that a hold draws.
  std::uint32_t most_draws() const;
};

/// The grip of one contact.
struct Hold {
  struct Frame {
    double P = 0;                  ///< over the preload
    std::array<double, 3> load{};  ///< x, y and turn, over the limit
  };
  std::vector<Frame> frames{};
  int press = 0;  ///< as HoldLoad
  bool by_motion = false;
  double loss = 0, tilt = 0, tilt_direction = 0;  ///< 1/mm, 1, rad
  fem::UnevenFace face{};
  double rms = 0;  ///< mm, of the face

  /// Returns the frames in which P grows.
  int pressing() const { return press / 2; }
};

HoldLoad read_hold_load(const TomlFile& file, const toml::table& table);
/// { rms = ..., length = ... }, each a number of mm or a distribution. Throws ConfigError.
Unevenness read_unevenness(const TomlFile& file, const toml::node& node);

/// Returns a grip as a function of the key's seed and contact, or its quantiles, alone.
Hold draw_hold(const HoldLoad& from, const std::optional<Unevenness>& unevenness, const DrawKey& key);

}  // namespace tactel::host
