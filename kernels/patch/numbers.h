// SPDX-License-Identifier: Apache-2.0
/* Vectors of numbers, one of each lane: rows of tables for each lane, places of answers. Device only. */
#ifndef TACTEL_PATCH_NUMBERS_H
#define TACTEL_PATCH_NUMBERS_H
#include "shared/contact_layout.h"
#include "shared/elementary.h"
#include "shared/group.h"
#include "shared/lanes.h"
#include "shared/patch_layout.h"
#include "shared/transpose.h"
#include "shared/unroll.h"

/* Row r of an array of vectors, and number r of an answer: of a group with vectors, next to each other. */
#define AT(r) ((r)*INTERLEAVED)

/* A function of its own: what is unrolled in it exists once. */
#define OUTLINE static __attribute__((noinline))

/* Keeps the compiler from holding loaded numbers of one row for the next, which spills. Empty on GPUs, and in oclgrind
   (SPIR), whose builder crashes at inline assembly. */
#if LANES > 1 && !defined(__SPIR__)
#define ROW_BARRIER __asm__ volatile("" ::: "memory")
#else
#define ROW_BARRIER
#endif

/* Cells of a table: the cell of each lane, and how far inside it. */
typedef struct {
  int cell[LANES];
  vreal q;
} Place;

/* Every place is in the table, numbers that are none too. */
static inline Place place_in(vreal at, int cells) {
  const vreal inside = SMALLER(LARGER(at, ALL_LANES(0)), ALL_LANES((real)cells));
  const vreal whole = SMALLER(TO_VREAL(TO_VINT(inside)), ALL_LANES((real)(cells - 1)));
  Place place;
  place.q = inside - whole;
  real cell[LANES];
  STORE(whole, cell);
  EACH(l, LANES) { place.cell[l] = (int)cell[l]; }
  return place;
}

/* Row rows[l] of a table of PATCH_BLOCK columns for each lane: column k of all lanes in to[k]. */
INLINE void gather_rows(global const real *table, const int *rows, vreal *to) {
  EACH(b, PATCH_BLOCK / LANES) {
    vreal r[LANES];
    EACH(l, LANES) { r[l] = LOAD(table + (size_t)rows[l] * PATCH_BLOCK + b * LANES); }
    transpose(r);
    EACH(l, LANES) { to[b * LANES + l] = r[l]; }
  }
}

INLINE vreal cubic(const vreal *c, vreal q) { return fma(fma(fma(c[3], q, c[2]), q, c[1]), q, c[0]); }

/* Where a lane's answer of `numbers` numbers begins in [lanes / INTERLEAVED][slots][numbers][INTERLEAVED], the lane
   counted over all groups. */
static inline size_t answer_at(size_t lane, int slots, long slot, int numbers) {
  return AT((lane / INTERLEAVED * (size_t)slots + (size_t)slot) * (size_t)numbers) + lane % INTERLEAVED;
}

/* Block b of PATCH_BLOCK vectors as a row of numbers for each lane, at[l] numbers into `out`; lanes with at[l] < 0 are
   left out. */
INLINE void store_rows(const vreal *rows, const long *at, global real *out) {
  EACH(b, PATCH_BLOCK / LANES) {
    vreal r[LANES];
    EACH(l, LANES) { r[l] = rows[b * LANES + l]; }
    transpose(r);
    for (int l = 0; l < LANES; ++l)
      if (at[l] >= 0) STORE_AWAY(r[l], out + at[l] + AT(b * LANES));
  }
}

#endif
