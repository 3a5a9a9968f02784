// SPDX-License-Identifier: Apache-2.0
/* LANES vectors as a square matrix. Device only. */
#ifndef TACTEL_SHARED_TRANSPOSE_H
#define TACTEL_SHARED_TRANSPOSE_H
#include "shared/lanes.h"
#include "shared/unroll.h"

/* Lanes of a and b by turns: of their lower halves, of their upper halves. */
#if LANES == 2
static inline vreal low_by_turns(vreal a, vreal b) { return __builtin_shufflevector(a, b, 0, 2); }
static inline vreal high_by_turns(vreal a, vreal b) { return __builtin_shufflevector(a, b, 1, 3); }
#elif LANES == 4
static inline vreal low_by_turns(vreal a, vreal b) { return __builtin_shufflevector(a, b, 0, 4, 1, 5); }
static inline vreal high_by_turns(vreal a, vreal b) { return __builtin_shufflevector(a, b, 2, 6, 3, 7); }
#elif LANES == 8
static inline vreal low_by_turns(vreal a, vreal b) { return __builtin_shufflevector(a, b, 0, 8, 1, 9, 2, 10, 3, 11); }
static inline vreal high_by_turns(vreal a, vreal b) {
  return __builtin_shufflevector(a, b, 4, 12, 5, 13, 6, 14, 7, 15);
}
#elif LANES == 16
static inline vreal low_by_turns(vreal a, vreal b) {
  return __builtin_shufflevector(a, b, 0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23);
}
static inline vreal high_by_turns(vreal a, vreal b) {
  return __builtin_shufflevector(a, b, 8, 24, 9, 25, 10, 26, 11, 27, 12, 28, 13, 29, 14, 30, 15, 31);
}
#endif

#if LANES > 1
/* a[i] and the vector half of `count` below it, by turns, fill to[2 i] and to[2 i + 1]. */
INLINE void interleave(const int count, const vreal *a, vreal *to) {
  EACH(i, count / 2) {
    to[2 * i] = low_by_turns(a[i], a[i + count / 2]);
    to[2 * i + 1] = high_by_turns(a[i], a[i + count / 2]);
  }
}
#endif

#if LANES == 16
/* Of each quarter of four lanes of a and b: the lower halves by turns, the upper halves; the same of pairs of lanes.
   Quarters never mix, so that each is one instruction without a table of indices. */
#define QUARTERS(a, b, i, j, k, l)                                                                                  \
  __builtin_shufflevector(a, b, i, j, k, l, i + 4, j + 4, k + 4, l + 4, i + 8, j + 8, k + 8, l + 8, i + 12, j + 12, \
                          k + 12, l + 12)
static inline vreal low_lanes(vreal a, vreal b) { return QUARTERS(a, b, 0, 16, 1, 17); }
static inline vreal high_lanes(vreal a, vreal b) { return QUARTERS(a, b, 2, 18, 3, 19); }
static inline vreal low_pairs(vreal a, vreal b) { return QUARTERS(a, b, 0, 1, 16, 17); }
static inline vreal high_pairs(vreal a, vreal b) { return QUARTERS(a, b, 2, 3, 18, 19); }
/* Quarters i and j of a, then of b. */
#define TWO_QUARTERS(a, b, i, j)                                                                                \
  __builtin_shufflevector(a, b, 4 * i, 4 * i + 1, 4 * i + 2, 4 * i + 3, 4 * j, 4 * j + 1, 4 * j + 2, 4 * j + 3, \
                          4 * i + 16, 4 * i + 17, 4 * i + 18, 4 * i + 19, 4 * j + 16, 4 * j + 17, 4 * j + 18,   \
                          4 * j + 19)

/* Rows become columns: lane i of r[k] is what lane k of r[i] was. First blocks of 4 x 4 lanes, then 4 x 4 blocks. */
static inline void transpose(vreal *r) {
  EACH(g, 4) {
    vreal *a = r + 4 * g;
    const vreal low = low_lanes(a[0], a[1]), high = high_lanes(a[0], a[1]), low2 = low_lanes(a[2], a[3]),
                high2 = high_lanes(a[2], a[3]);
    a[0] = low_pairs(low, low2);
    a[1] = high_pairs(low, low2);
    a[2] = low_pairs(high, high2);
    a[3] = high_pairs(high, high2);
  }
  EACH(j, 4) {
    vreal *a = r + j;
    const vreal low = TWO_QUARTERS(a[0], a[4], 0, 1), high = TWO_QUARTERS(a[0], a[4], 2, 3);
    const vreal low2 = TWO_QUARTERS(a[8], a[12], 0, 1), high2 = TWO_QUARTERS(a[8], a[12], 2, 3);
    a[0] = TWO_QUARTERS(low, low2, 0, 2);
    a[4] = TWO_QUARTERS(low, low2, 1, 3);
    a[8] = TWO_QUARTERS(high, high2, 0, 2);
    a[12] = TWO_QUARTERS(high, high2, 1, 3);
  }
}
#else
/* Rows become columns: lane i of r[k] is what lane k of r[i] was. Interleaving as often as LANES can be halved does
   it. */
static inline void transpose(vreal *r) {
#if LANES == 1
  (void)r;
#else
  vreal t[LANES];
  interleave(LANES, r, t);
#if LANES == 2
  EACH(i, LANES) { r[i] = t[i]; }
#else
  interleave(LANES, t, r);
#endif
#if LANES == 8
  interleave(LANES, r, t);
  EACH(i, LANES) { r[i] = t[i]; }
#endif
#endif
}
#endif

#endif
