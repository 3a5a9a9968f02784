// SPDX-License-Identifier: Apache-2.0
/* Sums over the lanes of vectors, in a fixed order: neighbours first, then neighbouring pairs, and so on. Device
   only. */
#ifndef TACTEL_SHARED_LANE_SUMS_H
#define TACTEL_SHARED_LANE_SUMS_H
#include "shared/lanes.h"
#include "shared/unroll.h"

/* How many vectors hold n numbers. */
#define VECTORS_OF(n) (((n) + LANES - 1) / LANES)

/* Of two vectors that hold sums in pieces of 2 n lanes, one with pieces of n: the halves of each piece are added.
   Clang's shuffle becomes one instruction, where a literal of OpenCL C becomes three or four. */
#if LANES == 2
static inline vreal add_halves(vreal a, vreal b) {
  return __builtin_shufflevector(a, b, 0, 2) + __builtin_shufflevector(a, b, 1, 3);
}
#elif LANES == 4
static inline vreal add_halves(vreal a, vreal b) {
  return __builtin_shufflevector(a, b, 0, 1, 4, 5) + __builtin_shufflevector(a, b, 2, 3, 6, 7);
}
static inline vreal add_pairs(vreal a, vreal b) {
  return __builtin_shufflevector(a, b, 0, 4, 2, 6) + __builtin_shufflevector(a, b, 1, 5, 3, 7);
}
#elif LANES == 8
static inline vreal add_halves(vreal a, vreal b) {
  return __builtin_shufflevector(a, b, 0, 1, 2, 3, 8, 9, 10, 11) +
         __builtin_shufflevector(a, b, 4, 5, 6, 7, 12, 13, 14, 15);
}
static inline vreal add_quads(vreal a, vreal b) {
  return __builtin_shufflevector(a, b, 0, 1, 8, 9, 4, 5, 12, 13) +
         __builtin_shufflevector(a, b, 2, 3, 10, 11, 6, 7, 14, 15);
}
static inline vreal add_pairs(vreal a, vreal b) {
  return __builtin_shufflevector(a, b, 0, 8, 2, 10, 4, 12, 6, 14) +
         __builtin_shufflevector(a, b, 1, 9, 3, 11, 5, 13, 7, 15);
}
#elif LANES == 16
static inline vreal add_halves(vreal a, vreal b) {
  return __builtin_shufflevector(a, b, 0, 1, 2, 3, 4, 5, 6, 7, 16, 17, 18, 19, 20, 21, 22, 23) +
         __builtin_shufflevector(a, b, 8, 9, 10, 11, 12, 13, 14, 15, 24, 25, 26, 27, 28, 29, 30, 31);
}
static inline vreal add_eights(vreal a, vreal b) {
  return __builtin_shufflevector(a, b, 0, 1, 2, 3, 16, 17, 18, 19, 8, 9, 10, 11, 24, 25, 26, 27) +
         __builtin_shufflevector(a, b, 4, 5, 6, 7, 20, 21, 22, 23, 12, 13, 14, 15, 28, 29, 30, 31);
}
static inline vreal add_quads(vreal a, vreal b) {
  return __builtin_shufflevector(a, b, 0, 1, 16, 17, 4, 5, 20, 21, 8, 9, 24, 25, 12, 13, 28, 29) +
         __builtin_shufflevector(a, b, 2, 3, 18, 19, 6, 7, 22, 23, 10, 11, 26, 27, 14, 15, 30, 31);
}
static inline vreal add_pairs(vreal a, vreal b) {
  return __builtin_shufflevector(a, b, 0, 16, 2, 18, 4, 20, 6, 22, 8, 24, 10, 26, 12, 28, 14, 30) +
         __builtin_shufflevector(a, b, 1, 17, 3, 19, 5, 21, 7, 23, 9, 25, 11, 27, 13, 29, 15, 31);
}
#endif

/* Vectors are taken as `piece` lanes wide pieces, LANES / piece of them. Piece i: the sum over the pieces of rows[i],
   lane by lane; halves first. Overwrites rows [LANES / piece]. */
INLINE vreal piece_sums(const int piece, vreal *rows) {
  const int pieces = LANES / piece;
  (void)pieces;
#if LANES >= 2
  if (pieces >= 2) EACH(i, pieces / 2) {
      rows[i] = add_halves(rows[i], rows[i + pieces / 2]);
    }
#endif
#if LANES >= 16
  if (pieces >= 4) EACH(i, pieces / 4) {
      rows[i] = add_eights(rows[i], rows[i + pieces / 4]);
    }
#endif
#if LANES >= 8
  if (2 * pieces >= LANES) EACH(i, 2 * pieces / LANES) {
      rows[i] = add_quads(rows[i], rows[i + 2 * pieces / LANES]);
    }
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
#elif LANES >= 4
  const JOIN(REAL, 4) quads = row;
#endif
#if LANES >= 4
  const JOIN(REAL, 2) pairs = quads.lo + quads.hi;
#else
  const JOIN(REAL, 2) pairs = row;
#endif
  return pairs.x + pairs.y;
#endif
}

#endif
