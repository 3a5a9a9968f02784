/* LANES vectors as a square matrix. Device only. */
#ifndef TACTEL_SHARED_TRANSPOSE_H
#define TACTEL_SHARED_TRANSPOSE_H
#include "shared/lanes.h"
#include "shared/unroll.h"

#if LANES > 1
/* Lanes of a[i] and of the vector half the matrix below it, by turns, fill to[2 i] and to[2 i + 1]. */
static inline void interleave(const vreal *a, vreal *to) {
  EACH(i, LANES / 2) {
    to[2 * i].even = a[i].lo;
    to[2 * i].odd = a[i + LANES / 2].lo;
    to[2 * i + 1].even = a[i].hi;
    to[2 * i + 1].odd = a[i + LANES / 2].hi;
  }
}
#endif

/* Rows become columns: lane i of r[k] is what lane k of r[i] was. Interleaving as often as LANES can be halved does it. */
static inline void transpose(vreal *r) {
#if LANES == 1
  (void)r;
#else
  vreal t[LANES];
  interleave(r, t);
#if LANES == 2
  EACH(i, LANES) { r[i] = t[i]; }
#else
  interleave(t, r);
#endif
#if LANES >= 8
  interleave(r, t);
#endif
#if LANES == 8
  EACH(i, LANES) { r[i] = t[i]; }
#elif LANES == 16
  interleave(t, r);
#endif
#endif
}

#endif
