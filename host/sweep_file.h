#pragma once
#include <filesystem>
#include <string>

#include "host/paper_sets.h"

namespace tactel::host {

/// What a sweep file asks for.
struct Sweep {
  std::string text;  ///< the file as it was read
  std::string set;   ///< "paper-learning" or "paper-recall"
  SceneFamily family;
};

/// Reads a sweep file: a scene file's [sensor], [contact] and [load] tables, which may be left out, and
///   [sweep]
///   set = "paper-learning" | "paper-recall"
///   scale = 10.0, height = 10.0    # mm, of the Taylor shapes of paper-learning
/// Throws ConfigError as read_scene does.
Sweep read_sweep(const std::filesystem::path& path);

}  // namespace tactel::host
