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
  int press = 20;          ///< frames before the rest: the first half presses, the other takes up the weight
  bool by_motion = false;  ///< the object's place is given, not the force on it
  Distribution rest = UniformDraw{20, 60};                 ///< frames before the first move
  Distribution weight = LogUniformDraw{0.15, 0.95};        ///< load at rest
  Distribution direction = UniformDraw{0, 360};            ///< degrees, of the weight and of each move
  Distribution moves = ChoiceDraw{{1, 2, 3}, {1, 1, 1}};   ///< number of moves
  Distribution size = LogUniformDraw{0.05, 1.5};           ///< load of a move; by motion 0.1 to 30
  Distribution turn = UniformDraw{-1, 1};                  ///< share of a move that turns the object, -1 to 1
  Distribution move_frames = LogUniformDraw{4, 60};        ///< frames of a move
  Distribution pause = UniformDraw{0, 40};                 ///< frames behind it
  double back = 0.6;                                       ///< probability that a move goes back, behind another pause
  Distribution relax = UniformDraw{0, 0.06};               ///< share of P that the grip loses in time
  Distribution loss = NormalDraw{0.01, 0.03, -0.08, 0.1};  ///< share of P that it loses as the object slides a mm
  /// How far the face rises half a pad from its axis at the limit mu P, over its depth at rest.
  Distribution tilt = NormalDraw{0, 0.4, -1.6, 1.6};
  Distribution tilt_direction = UniformDraw{0, 360};  ///< degrees, from the load

  double rate = 0;  ///< frames a second; 0: not given, and none of what follows
  /// Rms of the force of a hand's tremor along the pad, and of P, over P. It is a tone along a drawn line, one across
  /// it and one of P; those have what the first leaves of the variance, half each.
  Distribution tremor = UniformDraw{0, 0};
  Distribution tremor_frequency = UniformDraw{5, 12};   ///< Hz, of each tone
  Distribution tremor_share = UniformDraw{0.6, 0.75};   ///< of the variance, along the line
  Distribution squeeze = UniformDraw{1, 1};             ///< P behind a move over P before it
  Distribution squeeze_start = UniformDraw{0, 0};       ///< frames from the beginning of the move
  Distribution squeeze_frames = LogUniformDraw{6, 30};  ///< frames until P is that
  double squeeze_alone = 0;                             ///< probability that a move is a squeeze alone
  Distribution swing = UniformDraw{0, 0};               ///< degrees by which a move turns the object, to either side
  Distribution swing_radius = UniformDraw{0, 0};        ///< mm from the object's axis to the point that it turns about
  Distribution roll = UniformDraw{0, 0};                ///< mm a degree of a swing by which the contact rolls on
  Distribution added_weight = UniformDraw{0, 0};        ///< load that the weight gains with a move
  double regrip = 0;                                    ///< probability that a move is another grip of the object
  Distribution regrip_shift = UniformDraw{0, 0};        ///< mm by which the object then lies elsewhere

  /// Returns a bound of the numbers that a hold draws, and of those of them that do not need the rate.
  std::uint32_t most_draws() const;
  std::uint32_t most_draws_without_rate() const;
};

/// The grip of one contact.
struct Hold {
  struct Frame {
    double P = 0;                    ///< over the preload; 0: open
    std::array<double, 3> load{};    ///< x, y and turn, over the limit
    double swing = 0;                ///< rad by which the object has turned about the pivot
    std::array<double, 2> shift{};   ///< mm: where another grip has the object
    std::array<double, 2> tremor{};  ///< x, y over P
  };
  std::vector<Frame> frames{};
  int press = 0;  ///< as HoldLoad
  bool by_motion = false;
  double loss = 0, tilt = 0, tilt_direction = 0;  ///< 1/mm, 1, rad
  std::array<double, 2> pivot{}, roll{};          ///< mm from the axis; mm/rad of a swing
  double rate = 0;                                ///< Hz, as HoldLoad
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
