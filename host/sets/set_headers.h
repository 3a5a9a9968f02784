// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "host/sets/contact_set.h"
#include "host/sets/placed_rows.h"

namespace tactel::host {

/// Makes an open file with the rows `placed` up to `end` a set file: HDF5's headers behind the rows, and the attributes
/// of `set`. Returns the new end, or none where the file cannot be written.
std::optional<std::uint64_t> write_headers(int file, std::uint64_t end, const SetColumns& columns,
                                           const std::vector<const PlacedRows*>& placed, const ContactSet& set);

}  // namespace tactel::host
