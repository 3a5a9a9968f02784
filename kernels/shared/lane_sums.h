/* Sums over the lanes of vectors, in a fixed order: neighbours first, then neighbouring pairs, and so on. Device only. */
#ifndef TACTEL_SHARED_LANE_SUMS_H
#define TACTEL_SHARED_LANE_SUMS_H
#include "shared/lanes.h"
#include "shared/unroll.h"

/* How many vectors hold n numbers. */
#define VECTORS_OF(n) (((n) + LANES - 1) / LANES)

/* Of two vectors that hold sums in pieces of n lanes, one with pieces of n / 2: the halves of each piece are added. */
#if LANES >= 2
static inline vreal add_halves(vreal a, vreal b) { return (vreal)(a.lo, b.lo) + (vreal)(a.hi, b.hi); }
#endif
#if LANES == 4
static inline vreal add_pairs(vreal a, vreal b) { return (vreal)(a.s0, b.s0, a.s2, b.s2) + (vreal)(a.s1, b.s1, a.s3, b.s3); }
#elif LANES == 8
static inline vreal add_quads(vreal a, vreal b) { return (vreal)(a.s01, b.s01, a.s45, b.s45) + (vreal)(a.s23, b.s23, a.s67, b.s67); }
static inline vreal add_pairs(vreal a, vreal b) {
  return (vreal)(a.s0, b.s0, a.s2, b.s2, a.s4, b.s4, a.s6, b.s6) + (vreal)(a.s1, b.s1, a.s3, b.s3, a.s5, b.s5, a.s7, b.s7);
}
#elif LANES == 16
static inline vreal add_eights(vreal a, vreal b) {
  return (vreal)(a.s0123, b.s0123, a.s89ab, b.s89ab) + (vreal)(a.s4567, b.s4567, a.scdef, b.scdef);
}
static inline vreal add_quads(vreal a, vreal b) {
  return (vreal)(a.s01, b.s01, a.s45, b.s45, a.s89, b.s89, a.scd, b.scd) + (vreal)(a.s23, b.s23, a.s67, b.s67, a.sab, b.sab, a.sef, b.sef);
}
static inline vreal add_pairs(vreal a, vreal b) {
  return (vreal)(a.s0, b.s0, a.s2, b.s2, a.s4, b.s4, a.s6, b.s6, a.s8, b.s8, a.sa, b.sa, a.sc, b.sc, a.se, b.se) +
         (vreal)(a.s1, b.s1, a.s3, b.s3, a.s5, b.s5, a.s7, b.s7, a.s9, b.s9, a.sb, b.sb, a.sd, b.sd, a.sf, b.sf);
}
#endif

/* Lane i: the sum over the lanes of rows[i]; halves first. Overwrites rows [LANES]. */
static inline vreal lane_sums(vreal *rows) {
#if LANES >= 2
  UNROLL for (int i = 0; i < LANES / 2; ++i) rows[i] = add_halves(rows[i], rows[i + LANES / 2]);
#endif
#if LANES >= 16
  UNROLL for (int i = 0; i < 4; ++i) rows[i] = add_eights(rows[i], rows[i + 4]);
#endif
#if LANES >= 8
  UNROLL for (int i = 0; i < 2; ++i) rows[i] = add_quads(rows[i], rows[i + 2]);
#endif
#if LANES >= 4
  rows[0] = add_pairs(rows[0], rows[1]);
#endif
  return rows[0];
}

/* The sum over the lanes of one vector, in the same order. */
static inline real lane_sum(vreal row) {
#if LANES == 1
  return row;
#else
#if LANES >= 16
  const JOIN(REAL, 8) eights = row.lo + row.hi;
  const JOIN(REAL, 4) quads = eights.lo + eights.hi;
#elif LANES >= 8
  const JOIN(REAL, 4) quads = row.lo + row.hi;
#else
  const JOIN(REAL, 4) quads = row;
#endif
  const JOIN(REAL, 2) pairs = quads.lo + quads.hi;
  return pairs.x + pairs.y;
#endif
}

#endif
