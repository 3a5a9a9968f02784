#pragma once
#include <filesystem>

#include "fem/indenter.h"

namespace tactel::host {

/// Reads a measured profile: two numbers a line, mm, x increasing; columns separated by comma, semicolon or tab. A
/// header may name them ("x,y", "x [mm];y [mm]"). With semicolon or tab a decimal comma is read, too. Only a regular
/// file of up to 16 MiB is read, and nothing of it is quoted before it proves to be a profile. Blank lines and lines
/// that begin with # are skipped. Throws ConfigError naming the file and the line.
void read_profile_csv(const std::filesystem::path& path, fem::Profile& profile);

}  // namespace tactel::host
