#pragma once
#include <filesystem>

#include "fem/indenter.h"

namespace tactel::host {

/// Reads a measured profile: a header line `x,y`, then two numbers a line, mm, x increasing. Blank lines and lines that
/// begin with # are skipped. Throws ConfigError naming the file and the line.
void read_profile_csv(const std::filesystem::path& path, fem::Profile& profile);

}  // namespace tactel::host
