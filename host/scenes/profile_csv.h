// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>

#include "fem/pad/pad_scene.h"
#include "fem/scenes/indenter.h"

namespace tactel::host {

/// Reads a measured profile: lines of numbers (NumberLines), two a line, mm, x increasing. A header may name them
/// ("x,y", "x [mm];y [mm]"). The file must be regular and hold at most 16 MiB. Errors quote its content only where the
/// first line is that of a profile. Throws ConfigError naming the file and the line.
void read_profile_csv(const std::filesystem::path& path, fem::Profile& profile);

inline constexpr std::size_t longest_height_map = 1000;  ///< heights along a side

/// Reads the heights of a height map, mm: a line holds those at one y, with x increasing; y increases from line to
/// line. The lowest height becomes 0. Throws ConfigError naming the file and the line: all lines have equally many
/// heights, 2 to longest_height_map of them, and so many lines.
void read_heights_csv(const std::filesystem::path& path, fem::HeightMap& map);

/// Reads a map of friction: a line holds mu at one y, with x increasing; y increases from line to line. Throws
/// ConfigError naming the file and the line.
void read_friction_csv(const std::filesystem::path& path, FrictionMap& map);

/// Reads places on a pad: lines of x and y, mm. Throws ConfigError naming the file and the line.
void read_places_csv(const std::filesystem::path& path, std::vector<std::array<double, 2>>& places);

}  // namespace tactel::host
