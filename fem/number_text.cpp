#include "fem/number_text.h"

#include <algorithm>
#include <array>
#include <charconv>

namespace tactel::fem {

std::string number_text(double value) {
  std::array<char, 32> text;  // the longest double, -2.2250738585072014e-308, takes 24
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  return {text.data(), end};
}

std::string number_text(const double* values, std::size_t count, std::size_t most) {
  std::string text = "[";
  for (std::size_t i = 0; i < std::min(count, most); ++i) text += (i ? ", " : "") + number_text(values[i]);
  return text + (count > most ? ", ...]" : "]");
}

}  // namespace tactel::fem
