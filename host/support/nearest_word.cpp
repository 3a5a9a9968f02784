// SPDX-License-Identifier: Apache-2.0
#include "host/support/nearest_word.h"

#include <algorithm>
#include <vector>

namespace tactel::host {
namespace {

/// Optimal string alignment distance (Damerau 1964 without repeated edits of one place).
int edits(std::string_view a, std::string_view b) {
  std::vector<std::vector<int>> d(a.size() + 1, std::vector<int>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) {
    for (std::size_t j = 0; j <= b.size(); ++j) {
      if (i == 0 || j == 0) {
        d[i][j] = static_cast<int>(i + j);
        continue;
      }
      const int replace = d[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      d[i][j] = std::min({replace, d[i - 1][j] + 1, d[i][j - 1] + 1});
      const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (swapped) d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  }
  return d[a.size()][b.size()];
}

std::string in_small_letters(std::string_view word) {
  std::string text(word);
  for (char& letter : text)
    if (letter >= 'A' && letter <= 'Z') letter = static_cast<char>(letter - 'A' + 'a');
  return text;
}

}  // namespace

std::string did_you_mean(std::string_view word, std::span<const std::string> words) {
  std::string nearest;
  const std::string typed = in_small_letters(word);
  int fewest = std::max(1, static_cast<int>(word.size()) / 3) + 1;  // a third of the letters may be wrong
  for (const std::string& candidate : words) {
    const bool begun = typed.size() >= 3 && candidate.starts_with(typed);
    const int count = begun ? 1 : edits(typed, in_small_letters(candidate));
    if (count < fewest) {
      fewest = count;
      nearest = candidate;
    }
  }
  return nearest.empty() ? "" : "; did you mean " + nearest + "?";
}

std::string listed(std::span<const std::string> words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

}  // namespace tactel::host
