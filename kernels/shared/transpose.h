/* LANES vectors as a square matrix. Device only. */
#ifndef TACTEL_SHARED_TRANSPOSE_H
#define TACTEL_SHARED_TRANSPOSE_H
#include "shared/lanes.h"

/* Rows become columns: lane i of r[k] is what lane k of r[i] was. */
static inline void transpose(vreal *r) {
#if LANES == 1
  (void)r;
#else
  for (int n = 1; n < LANES; n *= 2) {
    vreal t[LANES];
    _Pragma("unroll") for (int i = 0; i < LANES; ++i) t[i] = r[i];
    _Pragma("unroll") for (int i = 0; i < LANES / 2; ++i) {
      r[2 * i].even = t[i].lo;
      r[2 * i].odd = t[i + LANES / 2].lo;
      r[2 * i + 1].even = t[i].hi;
      r[2 * i + 1].odd = t[i + LANES / 2].hi;
    }
  }
#endif
}

#endif
