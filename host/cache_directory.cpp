#include "host/cache_directory.h"

#include <cstdlib>

namespace tactel::host {

std::filesystem::path default_cache_directory() {
  const auto set = [](const char* name) -> const char* {
    const char* value = std::getenv(name);
    return value && *value ? value : nullptr;
  };
  if (const char* own = set("TACTEL_CACHE_DIR")) return own;
  if (const char* cache = set("XDG_CACHE_HOME")) return std::filesystem::path(cache) / "tactel";
  if (const char* home = set("HOME")) return std::filesystem::path(home) / ".cache" / "tactel";
  return std::filesystem::temp_directory_path() / "tactel";
}

}  // namespace tactel::host
