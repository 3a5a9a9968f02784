// SPDX-License-Identifier: Apache-2.0

// Peak arithmetic of the device: independent fused multiply-adds.
#include "shared/group.h"
#include "shared/lanes.h"

/* Twelve accumulators hide the latency of two FMA units (4 cycles each). Every a moves half-way to 1 in each of
   `rounds` rounds: out [groups][lane] = their sum, 12 after a while. 24 LANES flops a round. */
kernel void fma_peak(uint first_group, global vreal *out, int rounds) {
  TAKE_GROUP(group);
  const vreal h = ALL_LANES((REAL)0.5);
  vreal a0 = ALL_LANES(0), a1 = h, a2 = a1 * h, a3 = a2 * h, a4 = a3 * h, a5 = a4 * h;
  vreal a6 = a5 * h, a7 = a6 * h, a8 = a7 * h, a9 = a8 * h, a10 = a9 * h, a11 = a10 * h;
  for (int i = 0; i < rounds; ++i) {
    a0 = fma(a0, h, h);
    a1 = fma(a1, h, h);
    a2 = fma(a2, h, h);
    a3 = fma(a3, h, h);
    a4 = fma(a4, h, h);
    a5 = fma(a5, h, h);
    a6 = fma(a6, h, h);
    a7 = fma(a7, h, h);
    a8 = fma(a8, h, h);
    a9 = fma(a9, h, h);
    a10 = fma(a10, h, h);
    a11 = fma(a11, h, h);
  }
  out[group] = a0 + a1 + a2 + a3 + a4 + a5 + a6 + a7 + a8 + a9 + a10 + a11;
}
