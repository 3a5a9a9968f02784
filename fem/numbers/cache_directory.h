// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>

namespace tactel::fem {

/// Returns $TACTEL_CACHE_DIR, else $XDG_CACHE_HOME/tactel, else $HOME/.cache/tactel; empty where none is set.
std::filesystem::path named_cache_directory();

/// Returns the folder of caches, that one; empty where another user can have written to it.
std::filesystem::path default_cache_directory();

/// Returns why files of a folder may be another user's: it belongs to one, or others can write to it, or to a folder on
/// the way to it that is not sticky. Empty where only this user can have written them.
std::string distrust(const std::filesystem::path& folder);

}  // namespace tactel::fem
