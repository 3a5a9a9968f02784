// SPDX-License-Identifier: Apache-2.0
#include "nn/presentation_order.h"

#include <array>
#include <numeric>
#include <string>
#include <utility>

#include "fem/numbers/value_error.h"
#include "nn/philox.h"

namespace tactel::nn {

const char* name(PresentationOrder order) { return order == PresentationOrder::permuted ? "permuted" : "sequential"; }

PresentationOrder parse_order(std::string_view text) {
  if (text == "permuted") return PresentationOrder::permuted;
  if (text == "sequential") return PresentationOrder::sequential;
  throw ValueError("order", std::string(text), "permuted or sequential");
}

std::vector<std::uint32_t> presentation_order(PresentationOrder order, std::uint64_t seed, std::uint32_t cycle,
                                              std::uint32_t rows) {
  std::vector<std::uint32_t> shown(rows);
  std::iota(shown.begin(), shown.end(), 0u);
  if (order == PresentationOrder::sequential) return shown;
  constexpr std::uint32_t ahead = 16;  // counters at once, for the processor's vectors
  std::array<PhiloxCounter, ahead> words{};
  for (std::uint32_t step = 0; step + 1 < rows; ++step) {
    if (step % (4 * ahead) == 0)
      for (std::uint32_t k = 0; k < ahead; ++k) words[k] = random_words(seed, RandomStream::order, step / 4 + k, cycle);
    const std::uint32_t i = rows - 1 - step;
    const std::uint64_t j = (std::uint64_t{words[step / 4 % ahead][step % 4]} * (std::uint64_t{i} + 1)) >> 32;
    std::swap(shown[i], shown[j]);
  }
  return shown;
}

}  // namespace tactel::nn
