#pragma once
#include "nn/philox.h"

namespace tactel::nn {

/// The words of values 4 quad ... 4 quad + 3 of a set's noise (with_noise). The low half of `quad` counts as it did
/// when sets were small, the high half goes on in the second word of the counter: no two values of a set share their
/// words.
constexpr PhiloxCounter noise_words(std::uint64_t seed, std::uint64_t quad) {
  return random_words(seed, RandomStream::noise, static_cast<std::uint32_t>(quad),
                      static_cast<std::uint32_t>(quad >> 32));
}

}  // namespace tactel::nn
