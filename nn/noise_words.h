#pragma once
#include "nn/philox.h"

namespace tactel::nn {

/// Returns the words of values 4 quad ... 4 quad + 3 of a set's noise (with_noise). The low half of `quad` is the
/// first word of the counter, the high half the second. No two values of a set therefore share their words; sets
/// below 2^34 values keep the words of earlier versions.
constexpr PhiloxCounter noise_words(std::uint64_t seed, std::uint64_t quad) {
  return random_words(seed, RandomStream::noise, static_cast<std::uint32_t>(quad),
                      static_cast<std::uint32_t>(quad >> 32));
}

}  // namespace tactel::nn
