#pragma once
#include <filesystem>

namespace tactel::host {

/// $TACTEL_CACHE_DIR, else $XDG_CACHE_HOME/tactel, else $HOME/.cache/tactel.
std::filesystem::path default_cache_directory();

}  // namespace tactel::host
