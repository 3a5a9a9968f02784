// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "host/support/log.h"

namespace tactel::host {

/// Damaged rows of a dataset, or what is not as written of the file itself.
struct SetDamage {
  std::string dataset{};              ///< empty: the file itself
  std::uint64_t first = 0, last = 0;  ///< first and last row, inclusive
  std::string what;
};

struct SetCheck {
  std::uint64_t rows = 0, chunks = 0, bytes = 0;  ///< read
  bool finished = true;                           ///< false: stopped by progress
  std::vector<SetDamage> damage;
};

/// Compares every chunk of every dataset of a set with its checksum, then each dataset and the file with their seals.
/// `progress` counts chunks. Throws ConfigError where the file is not a set, or has no seal.
SetCheck check_contact_set(const std::filesystem::path& path, const Progress& progress);

}  // namespace tactel::host
