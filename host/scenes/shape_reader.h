// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "fem/scenes/indenter.h"
#include "host/scenes/toml_table.h"

namespace tactel::host {

/// Reads the table [indenter]. It requires every number of the named shape, and rejects those of other shapes.
/// With `preset`, `indenter` provides the defaults. The file of a measured profile is searched beside the scene
/// file.
void read_indenter(const TomlFile& file, fem::Indenter& indenter, bool preset);

}  // namespace tactel::host
