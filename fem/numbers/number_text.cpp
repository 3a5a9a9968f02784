// SPDX-License-Identifier: Apache-2.0
#include "fem/numbers/number_text.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "fem/numbers/value_error.h"

namespace tactel::fem {

std::string number_text(double value) {
  std::array<char, 32> text;  // the longest double, -2.2250738585072014e-308, takes 24
  char* const last = text.data() + text.size();
  // Whole numbers in full: "1000000", not "1e+06".
  const bool whole = std::abs(value) < 1e15 && value == std::trunc(value);
  const auto end = whole ? std::to_chars(text.data(), last, static_cast<long long>(value)).ptr
                         : std::to_chars(text.data(), last, value).ptr;
  return {text.data(), end};
}

std::string number_text(const double* values, std::size_t count, std::size_t most) {
  std::string text = "[";
  for (std::size_t i = 0; i < std::min(count, most); ++i) text += (i ? ", " : "") + number_text(values[i]);
  return text + (count > most ? ", ...]" : "]");
}

void require(bool good, std::string_view key, double value, const char* allowed) {
  if (!good) throw ValueError(std::string(key), number_text(value), allowed);
}

}  // namespace tactel::fem
