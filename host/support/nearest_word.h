// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <span>
#include <string>
#include <string_view>

namespace tactel::host {

/// Returns "; did you mean X?" for the end of an error: X is the known word nearest to a misspelt one, of fewest edits
/// (insert, delete, replace, swap of neighbours), and few enough for the length. A beginning of three letters is near,
/// capitals count as small letters. Returns an empty text where none is near.
std::string did_you_mean(std::string_view word, std::span<const std::string> words);

/// Returns "a, b, c".
std::string listed(std::span<const std::string> words);

}  // namespace tactel::host
