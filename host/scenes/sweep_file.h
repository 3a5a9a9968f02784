// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "host/scenes/paper_sets.h"

namespace tactel::host {

/// Contents of a sweep file.
struct Sweep {
  std::string text;  ///< the file as it was read
  AnySource source;

  ContactSource& contacts() { return common(source); }
  const ContactSource& contacts() const { return common(source); }
  /// Returns the source of lines. Throws ConfigError for that of pads.
  const SceneSource& lines(const std::string& file) const;
};

/// Reads a sweep file: either that of a SceneSource, or one of the paper's sets, with the optional tables [sensor],
/// [contact] and [load] of a scene file, and
///   [sweep]
///   set = "paper-learning" | "paper-recall"
///   scale = 10.0, height = 10.0    # mm, of the Taylor shapes of paper-learning
///   seed = 0                       # of the noise, where there is a [transducer]
/// `seed`: takes the place of the file's. Throws ConfigError as read_scene does.
Sweep read_sweep(const std::filesystem::path& path, std::optional<std::uint64_t> seed = {});
/// The same from a text, as a set keeps it; errors name `path`, whose folder holds the files that the text names.
Sweep read_sweep_text(const std::filesystem::path& path, std::string text, std::optional<std::uint64_t> seed = {});
/// The same with another number of tactels and thickness (mm) of the sensor, where given.
Sweep read_sweep_of_sensor(const std::filesystem::path& path, std::optional<std::uint64_t> seed,
                           std::optional<int> tactels, std::optional<double> thickness);

}  // namespace tactel::host
