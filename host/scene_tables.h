#pragma once
#include "fem/scene.h"
#include "host/toml_table.h"

namespace tactel::host {

/// The tables that scene files and sweep files share, each read strictly. Keys that are absent leave `out` as it is.
void read_sensor(const TomlFile& file, fem::Sensor& out);
void read_contact(const TomlFile& file, double& friction);
/// `defaults`: the load in `out` stands where the file says nothing; otherwise an indentation or a force must be given.
void read_load(const TomlFile& file, fem::Load& out, bool defaults);

}  // namespace tactel::host
