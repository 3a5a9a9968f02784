// SPDX-License-Identifier: Apache-2.0
/* Philox4x32-10 (Salmon, Moraes, Dror, Shaw, SC'11): the same numbers as nn/philox.h, LANES counters at once. Device
   only. */
#ifndef TACTEL_SHARED_PHILOX_H
#define TACTEL_SHARED_PHILOX_H
#include "shared/lanes.h"

#if LANES == 1
typedef uint vuint;
#else
typedef JOIN(uint, LANES) vuint;
#endif

/* Four words for each of LANES counters; under a 64-bit seed. */
typedef struct {
  vuint word[4];
} RandomWords;

static inline RandomWords philox(RandomWords c, ulong seed) {
  uint key0 = (uint)seed, key1 = (uint)(seed >> 32);
  for (int round = 0; round < 10; ++round) {
    const vuint a = c.word[0], b = c.word[2];
    c.word[0] = mul_hi(b, (vuint)(0xCD9E8D57u)) ^ c.word[1] ^ (vuint)(key0);
    c.word[1] = b * (vuint)(0xCD9E8D57u);
    c.word[2] = mul_hi(a, (vuint)(0xD2511F53u)) ^ c.word[3] ^ (vuint)(key1);
    c.word[3] = a * (vuint)(0xD2511F53u);
    key0 += 0x9E3779B9u;
    key1 += 0xBB67AE85u;
  }
  return c;
}

/* Counters {index, outer, stream, 0}. */
static inline RandomWords random_words(ulong seed, uint stream, vuint index, uint outer) {
  const RandomWords counter = {{index, (vuint)(outer), (vuint)(stream), (vuint)(0)}};
  return philox(counter, seed);
}

/* Counters {item, item's upper half, stream, which}. */
static inline RandomWords words_of_item(ulong seed, uint stream, ulong item, vuint which) {
  const RandomWords counter = {{(vuint)((uint)item), (vuint)((uint)(item >> 32)), (vuint)(stream), which}};
  return philox(counter, seed);
}

#endif
