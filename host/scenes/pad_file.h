// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "fem/pad/pad_scene.h"
#include "host/scenes/toml_table.h"

namespace tactel::host {

/// Returns true where sensor.kind is "pad".
bool is_pad(const TomlFile& file);

/// Reads a pad's scene strictly (docs/pads.md: every key, unit and default), as read_scene does a line's.
fem::PadScene read_pad(const TomlFile& file);

}  // namespace tactel::host
