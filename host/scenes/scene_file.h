// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <variant>

#include "fem/pad/pad_scene.h"
#include "fem/scenes/scene.h"

namespace tactel::host {

/// Reads a line's scene file strictly (docs/scenes.md: every key, unit and default). Throws ConfigError with file,
/// line, key, value and the allowed values. Errors are an unknown key, a wrong type, a key of another shape, two keys
/// that exclude each other, and a value that the model rejects.
fem::Scene read_scene(const std::filesystem::path& path);

/// The scenes of both kinds of sensors: lines, and pads (docs/pads.md).
using AnyScene = std::variant<fem::Scene, fem::PadScene>;
/// The same of a line's or of a pad's file, as its key sensor.kind says.
AnyScene read_any_scene(const std::filesystem::path& path);

/// Returns the scene of `preset = "paper"`. It chooses the parameters that the paper leaves open: E, nu, grading,
/// element, parabola, friction, steps. With them Table I is matched within a few percent: a fit, not an
/// identification.
fem::Scene paper_preset();

}  // namespace tactel::host
