// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "fem/numbers/angles.h"
#include "fem/scenes/scene.h"
#include "host/scenes/toml_table.h"
#include "nn/transducer_chain.h"

namespace tactel::host {

/// Model of contacts whose file asks for none and names no mesh.
inline constexpr fem::SurfaceModel usual_model = fem::SurfaceModel::patch;

/// Values of sensor.kind.
inline const std::vector<std::string> sensor_kinds = {"line", "pad"};
/// What errors say of keys of the other kind.
inline constexpr const char* of_a_pad = "belongs to a pad (sensor.kind = \"pad\")";
inline constexpr const char* of_a_line = "belongs to a line, and sensor.kind is \"pad\"";

using fem::radians;

/// Read what scene files and sweep files share, each strictly. Absent keys leave `out` unchanged.
void read_title(TomlTable& root, std::string& title);
/// Reads the sensor and the model of the contact. `usual` is the model where the file asks for none and names no mesh.
void read_sensor(const TomlFile& file, fem::Scene& out, fem::SurfaceModel usual);
void read_contact(const TomlFile& file, double& friction);
/// Reads the load. With `defaults`, the load in `out` is the default. Otherwise an indentation or a force is
/// required.
void read_load(const TomlFile& file, fem::Load& out, bool defaults);

/// Reads the table [transducer] of a sweep file, which may be absent. `seed` is the default of transducer.seed.
/// Throws ConfigError.
nn::Transducer read_transducer(const TomlFile& file, std::uint64_t seed);

}  // namespace tactel::host
