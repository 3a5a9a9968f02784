// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstdint>

namespace tactel::nn {

/// Philox4x32-10, a counter-based generator: 128 random bits as a function of a counter and a key, without state.
/// Any implementation in any order therefore draws the same numbers (Salmon, Moraes, Dror, Shaw, "Parallel random
/// numbers: as easy as 1, 2, 3", SC'11, section 3.3).
using PhiloxCounter = std::array<std::uint32_t, 4>;
using PhiloxKey = std::array<std::uint32_t, 2>;

constexpr PhiloxCounter philox4x32(PhiloxCounter counter, PhiloxKey key) {
  for (int round = 0; round < 10; ++round) {
    const std::uint64_t a = std::uint64_t{0xD2511F53u} * counter[0];
    const std::uint64_t b = std::uint64_t{0xCD9E8D57u} * counter[2];
    counter = {static_cast<std::uint32_t>(b >> 32) ^ counter[1] ^ key[0], static_cast<std::uint32_t>(b),
               static_cast<std::uint32_t>(a >> 32) ^ counter[3] ^ key[1], static_cast<std::uint32_t>(a)};
    key[0] += 0x9E3779B9u;
    key[1] += 0xBB67AE85u;
  }
  return counter;
}

/// Purpose of a draw. It is the third word of the counter and separates the streams of one seed.
enum class RandomStream : std::uint32_t {
  weights = 1,
  order = 2,
  noise = 3,
  contact = 4,
  sensor = 5,
  reading = 6,   ///< noise of a reading
  gain = 7,      ///< gain and offset of a transducer
  instance = 8,  ///< sensor that a contact meets
  path = 9,      ///< numbers of an irregular load path
  spread = 10,   ///< how much a sensor's transducers spread
  fault = 11,    ///< place, crosstalk, mixing and failure of a transducer
  frame = 12,    ///< drift and repeated frames of a contact
  pixel = 13,    ///< noise of a camera
};

/// Returns four random words. `index` and `outer` count inside the stream: the weight; the step and the cycle;
/// the value.
constexpr PhiloxCounter random_words(std::uint64_t seed, RandomStream stream, std::uint32_t index,
                                     std::uint32_t outer = 0) {
  return philox4x32({index, outer, static_cast<std::uint32_t>(stream), 0},
                    {static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)});
}

}  // namespace tactel::nn
