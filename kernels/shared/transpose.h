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
static inline vreal high_by_turns(vreal a, vreal b) { return __builtin_shufflevector(a, b, 4, 12, 5, 13, 6, 14, 7, 15); }
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

/* Rows become columns: lane i of r[k] is what lane k of r[i] was. Interleaving as often as LANES can be halved does it. */
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
#if LANES >= 8
  interleave(LANES, r, t);
#endif
#if LANES == 8
  EACH(i, LANES) { r[i] = t[i]; }
#elif LANES == 16
  interleave(LANES, t, r);
#endif
#endif
}

#endif
