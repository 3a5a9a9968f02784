// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string_view>

namespace tactel::infer {

/// Returns the file of a network that is part of the library, "uskin-4x4" (scripts/networks makes it); empty for other
/// names.
std::string_view built_in_network(std::string_view name) noexcept;

}  // namespace tactel::infer
