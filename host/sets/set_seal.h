// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <hdf5.h>

#include <string>
#include <string_view>

namespace tactel::host {

/// The attribute of a dataset, and of the file, that holds its seal.
inline constexpr const char* seal_name = "checksum";

/// Returns the seal of an open dataset: the checksum of its name, of its other attributes and of `numbers`, which is
/// the checksum of its numbers.
std::string dataset_seal(hid_t dataset, std::string_view name, std::string_view numbers);

/// Returns the seal of an open file: the checksum of its other attributes, and of the name, the kind and the seal of
/// all that it holds.
std::string file_seal(hid_t file);

}  // namespace tactel::host
