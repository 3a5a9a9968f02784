// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <span>

#include "nn/philox.h"

namespace tactel::nn {

/// Returns the words of values 4 quad ... 4 quad + 3 of a set's noise (with_noise). The low half of `quad` is the
/// first word of the counter, the high half the second. No two values of a set therefore share their words; sets
/// below 2^34 values keep the words of earlier versions.
constexpr PhiloxCounter noise_words(std::uint64_t seed, std::uint64_t quad) {
  return random_words(seed, RandomStream::noise, static_cast<std::uint32_t>(quad),
                      static_cast<std::uint32_t>(quad >> 32));
}

/// Adds Gaussian noise of the standard deviation `deviation` to consecutive values of a set, the first of which is
/// value `first`. Value i takes normal number i % 4 of noise_words(seed, i / 4) by Box and Muller (1958).
void add_noise(std::span<float> values, double deviation, std::uint64_t seed, std::uint64_t first);

}  // namespace tactel::nn
