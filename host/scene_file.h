#pragma once
#include <filesystem>

#include "fem/scene.h"

namespace tactel::host {

/// Reads a scene file (docs/scenes.md: every key, unit and default), strictly: an unknown key, a wrong type, a
/// key of another shape, two keys that exclude each other, or a value that the model refuses throws ConfigError with
/// file, line, key, value and what is allowed.
fem::Scene read_scene(const std::filesystem::path& path);

/// What `preset = "paper"` stands for: the choice for all that the paper leaves open (E, nu, grading, element,
/// parabola, friction, steps) with which Table I comes out within a few percent. A fit, no identification.
fem::Scene paper_preset();

}  // namespace tactel::host
