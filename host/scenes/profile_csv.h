// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>

#include "fem/indenter.h"

namespace tactel::host {

/// Reads a measured profile: two numbers a line, mm, x increasing; columns separated by comma, semicolon or tab. A
/// header may name them ("x,y", "x [mm];y [mm]"). With semicolon or tab, decimal commas are accepted. The file must
/// be regular and hold at most 16 MiB. Errors quote its content only where the first line is that of a profile.
/// Blank lines and lines that begin with # are skipped. Throws ConfigError naming the file and the line.
void read_profile_csv(const std::filesystem::path& path, fem::Profile& profile);

}  // namespace tactel::host
