#pragma once
#include <filesystem>
#include <string>

#include "host/paper_sets.h"

namespace tactel::host {

/// What a sweep file asks for.
struct Sweep {
  std::string text;  ///< the file as it was read
  SceneSource source;
};

/// Reads a sweep file: SceneSource says what it may hold; or one of the paper's sets, with a scene file's [sensor],
/// [contact] and [load] tables, which may be left out, and
///   [sweep]
///   set = "paper-learning" | "paper-recall"
///   scale = 10.0, height = 10.0    # mm, of the Taylor shapes of paper-learning
///   seed = 0                       # of the noise, where there is a [transducer]
/// Throws ConfigError as read_scene does.
Sweep read_sweep(const std::filesystem::path& path);

}  // namespace tactel::host
