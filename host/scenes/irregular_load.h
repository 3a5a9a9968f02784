// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <optional>

#include "fem/pad/pad_scene.h"
#include "fem/scenes/scene.h"
#include "host/scenes/distribution.h"

namespace tactel::host {

/// A random load path, [load.irregular] of a sweep file. Each press takes random steps to its depth; strokes follow,
/// with pauses between their steps and partial releases before them; the next press begins after a full release. On
/// lines strokes go along x, on pads in any direction, and turn. Counts are drawn and rounded. The sizes of the steps
/// of a press, stroke or release have ratios of at most 10.
struct IrregularLoad {
  Distribution presses;        ///< number of presses
  Distribution press_depth;    ///< depth (or force) of a later press over that of the first
  Distribution press_steps;    ///< steps of a press, or of a full release
  Distribution strokes;        ///< strokes of a press
  Distribution stroke;         ///< mm: length of a stroke
  Distribution stroke_steps;   ///< steps of a stroke
  Distribution release_to;     ///< depth (or force) after a partial release, over that of the press
  Distribution release_steps;  ///< steps of a partial release
  double backward = 0;         ///< probability that the first stroke of a press goes toward -x, of lines
  double reversal = 0;         ///< probability that a stroke goes against the one before
  double pause = 0;            ///< probability that a step of a stroke is followed by one without a change
  double release = 0;          ///< probability that a partial release precedes a stroke
  /// The strokes of pads.
  struct Turning {
    Distribution direction;  ///< degrees from x: of a stroke that does not go against the one before
    Distribution twist;      ///< degrees about the indenter's axis, in a stroke
  };
  std::optional<Turning> turning{};

  /// Returns the load steps of the longest path.
  double most_steps() const;
  /// Returns the degrees by which the strokes of the longest path may turn the indenter.
  double most_twist() const;
  /// Returns a bound of the numbers that a path draws.
  std::uint32_t most_draws() const;
};

/// Reads the table of a line's or a pad's sweep. Throws ConfigError.
IrregularLoad read_irregular_load(const TomlFile& file, const toml::table& table, bool pad);

/// Replaces a load of one depth (or force) by an irregular path: the steps of the first press become its indentation,
/// the others its moves. The path is a function of the key's seed and contact, or its quantiles, and the load alone.
template <class Load>
void draw_irregular_load(const IrregularLoad& irregular, const DrawKey& key, Load& load);

}  // namespace tactel::host
