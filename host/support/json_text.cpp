// SPDX-License-Identifier: Apache-2.0
#include "host/support/json_text.h"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace tactel::host {
namespace {

using Json = nlohmann::ordered_json;

bool on_one_line(const Json& value) {
  return !value.is_structured() || value.empty() ||
         (value.is_array() && std::ranges::none_of(value, [](const Json& entry) { return entry.is_structured(); }));
}

/// Bytes that are no UTF-8, as in a file's name, become U+FFFD.
std::string dumped(const Json& value) { return value.dump(-1, ' ', false, Json::error_handler_t::replace); }

std::string flat(const Json& value) {
  if (!value.is_array()) return dumped(value);
  std::string out = "[";
  for (std::size_t i = 0; i < value.size(); ++i) out += (i > 0 ? ", " : "") + dumped(value[i]);
  return out + "]";
}

void append(std::string& out, const Json& value, const std::string& indent) {
  if (on_one_line(value)) {
    out += flat(value);
    return;
  }
  const std::string inner = indent + "  ";
  out += value.is_object() ? "{" : "[";
  bool first = true;
  for (const auto& [key, entry] : value.items()) {
    out += (first ? "\n" : ",\n") + inner;
    if (value.is_object()) out += dumped(Json(key)) + ": ";
    append(out, entry, inner);
    first = false;
  }
  out += "\n" + indent + (value.is_object() ? "}" : "]");
}

}  // namespace

std::string json_text(const Json& value) {
  std::string out;
  append(out, value, "");
  return out + "\n";
}

}  // namespace tactel::host
