#pragma once
#include <nlohmann/json.hpp>
#include <string>

namespace tactel::host {

/// JSON for people and programs: a key a line, an array of plain values on one line; numbers read back to the same bits
/// (as many digits as that takes, 17 at most).
std::string json_text(const nlohmann::ordered_json& value);

}  // namespace tactel::host
