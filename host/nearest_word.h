#pragma once
#include <span>
#include <string>
#include <string_view>

namespace tactel::host {

/// The known word that a misspelt one most likely meant: fewest edits (insert, delete, replace, swap of neighbours),
/// and few enough for the length; empty when none is near.
std::string nearest_word(std::string_view word, std::span<const std::string> known);

/// "a, b, c".
std::string listed(std::span<const std::string> words);

}  // namespace tactel::host
