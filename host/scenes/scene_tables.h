#pragma once
#include "fem/scene.h"
#include "host/scenes/toml_table.h"

namespace tactel::host {

/// Read the tables that scene files and sweep files share, each strictly. Absent keys leave `out` unchanged.
void read_sensor(const TomlFile& file, fem::Sensor& out);
void read_contact(const TomlFile& file, double& friction);
/// Reads the load. With `defaults`, the load in `out` is the default. Otherwise an indentation or a force is
/// required.
void read_load(const TomlFile& file, fem::Load& out, bool defaults);

}  // namespace tactel::host
