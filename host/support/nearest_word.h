// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <span>
#include <string>
#include <string_view>

namespace tactel::host {

/// Returns the known word nearest to a misspelt one: fewest edits (insert, delete, replace, swap of neighbours),
/// and few enough for the length. Returns an empty text where none is near.
std::string nearest_word(std::string_view word, std::span<const std::string> known);

/// Returns "a, b, c".
std::string listed(std::span<const std::string> words);

}  // namespace tactel::host
