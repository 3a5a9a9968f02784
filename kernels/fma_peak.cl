// What this device can do at most: fused multiply-adds that depend on nothing but themselves.
#include "shared/group.h"
#include "shared/lanes.h"

/* Twelve accumulators hide the latency of two FMA units (4 cycles each). Every a moves half-way to 1 in each of `rounds` rounds:
   out [groups][lane] = their sum, 12 after a while. 24 LANES flops a round. */
kernel void fma_peak(uint first_group, global vreal *out, int rounds) {
  TAKE_GROUP(group);
  const vreal half = ALL_LANES((REAL)0.5);
  vreal a0 = ALL_LANES(0), a1 = half, a2 = a1 * half, a3 = a2 * half, a4 = a3 * half, a5 = a4 * half;
  vreal a6 = a5 * half, a7 = a6 * half, a8 = a7 * half, a9 = a8 * half, a10 = a9 * half, a11 = a10 * half;
  for (int i = 0; i < rounds; ++i) {
    a0 = fma(a0, half, half);
    a1 = fma(a1, half, half);
    a2 = fma(a2, half, half);
    a3 = fma(a3, half, half);
    a4 = fma(a4, half, half);
    a5 = fma(a5, half, half);
    a6 = fma(a6, half, half);
    a7 = fma(a7, half, half);
    a8 = fma(a8, half, half);
    a9 = fma(a9, half, half);
    a10 = fma(a10, half, half);
    a11 = fma(a11, half, half);
  }
  out[group] = a0 + a1 + a2 + a3 + a4 + a5 + a6 + a7 + a8 + a9 + a10 + a11;
}
