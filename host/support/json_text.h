// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace tactel::host {

/// Returns JSON text: a key a line, an array of plain values on one line. Numbers read back to the same bits,
/// with as many digits as needed, 17 at most.
std::string json_text(const nlohmann::ordered_json& value);

}  // namespace tactel::host
