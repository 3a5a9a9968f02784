// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>

#include "host/scenes/toml_table.h"
#include "nn/transducer_chain.h"

namespace tactel::host {

/// Reads the table [transducer] of a sweep file, which may be absent. `seed` is the default of transducer.seed.
/// Throws ConfigError.
nn::Transducer read_transducer(const TomlFile& file, std::uint64_t seed);

}  // namespace tactel::host
