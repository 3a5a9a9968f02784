// SPDX-License-Identifier: Apache-2.0
#include <cstdlib>

#include "fem/condensation.h"

namespace tactel::fem {

std::filesystem::path default_cache_directory() {
  const auto variable = [](const char* name) {
    const char* value = std::getenv(name);
    return std::filesystem::path(value ? value : "");
  };
  if (std::filesystem::path own = variable("TACTEL_CACHE_DIR"); !own.empty()) return own;
  if (const std::filesystem::path cache = variable("XDG_CACHE_HOME"); !cache.empty()) return cache / "tactel";
  if (const std::filesystem::path home = variable("HOME"); !home.empty()) return home / ".cache" / "tactel";
  return {};
}

}  // namespace tactel::fem
