#pragma once
#include <cstdint>

#include "host/toml_table.h"
#include "nn/transducer_chain.h"

namespace tactel::host {

/// The table [transducer] of a sweep file, which may be absent. `seed`: what transducer.seed is where it is left out.
/// Throws ConfigError.
nn::Transducer read_transducer(const TomlFile& file, std::uint64_t seed);

}  // namespace tactel::host
