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

/* Vectors are taken as `piece` lanes wide pieces, LANES / piece of them. Piece i: the sum over the pieces of rows[i], lane by lane; halves
   first. Overwrites rows [LANES / piece]. */
INLINE vreal piece_sums(const int piece, vreal *rows) {
  const int pieces = LANES / piece;
  (void)pieces;
#if LANES >= 2
  if (pieces >= 2) EACH(i, pieces / 2) { rows[i] = add_halves(rows[i], rows[i + pieces / 2]); }
#endif
#if LANES >= 16
  if (pieces >= 4) EACH(i, pieces / 4) { rows[i] = add_eights(rows[i], rows[i + pieces / 4]); }
#endif
#if LANES >= 8
  if (2 * pieces >= LANES) EACH(i, 2 * pieces / LANES) { rows[i] = add_quads(rows[i], rows[i + 2 * pieces / LANES]); }
#endif
#if LANES >= 4
  if (pieces == LANES) rows[0] = add_pairs(rows[0], rows[1]);
#endif
  return rows[0];
}

/* Lane i: the sum over the lanes of rows[i]; halves first. Overwrites rows [LANES]. */
static inline vreal lane_sums(vreal *rows) { return piece_sums(1, rows); }

/* Every piece: the sum over the pieces, lane by lane. */
INLINE vreal piece_sum(const int piece, vreal v) {
  (void)piece;
#if LANES >= 2
  if (piece <= LANES / 2) v += (vreal)(v.hi, v.lo);
#endif
#if LANES == 16
  if (piece <= 4) v += v.s45670123cdef89ab;
  if (piece <= 2) v += v.s23016745ab89efcd;
  if (piece == 1) v += v.s1032547698badcfe;
#elif LANES == 8
  if (piece <= 2) v += v.s23016745;
  if (piece == 1) v += v.s10325476;
#elif LANES == 4
  if (piece == 1) v += v.s1032;
#endif
  return v;
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
