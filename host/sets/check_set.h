// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "host/support/log.h"

namespace tactel::host {

/// Damaged rows of a dataset.
struct SetDamage {
  std::string dataset;
  std::uint64_t first = 0, last = 0;  ///< first and last row, inclusive
  std::string what;
};

struct SetCheck {
  std::uint64_t rows = 0, chunks = 0, bytes = 0;  ///< read
  bool checksums = false;  ///< false: a set of an older version, in which damage may remain unseen
  bool finished = true;    ///< false: stopped by progress
  std::vector<SetDamage> damage;
};

/// Compares every chunk of every dataset of a set with its checksum, then each dataset with its own. `progress`
/// counts chunks. Throws ConfigError where the file is not a set.
SetCheck check_contact_set(const std::filesystem::path& path, const Progress& progress);

}  // namespace tactel::host
