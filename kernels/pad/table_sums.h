// SPDX-License-Identifier: Apache-2.0
/* Displacements by tables of influence that scenes share, or by one of each lane. Device only. */
#ifndef TACTEL_PAD_TABLE_SUMS_H
#define TACTEL_PAD_TABLE_SUMS_H
#include "pad/cells.h"

/* The nine sums of a displacement, each a chain of its own: additions do not wait for each other. */
typedef struct {
  Lanes zn, zx, zy, xx, xy, xn, yx, yy, yn;
} Sums;

#define TURN(sum) sum.v[0] = -sum.v[0]
#define TURN_X(s) TURN(s.zx), TURN(s.xn), TURN(s.xy), TURN(s.yx)
#define TURN_Y(s) TURN(s.zy), TURN(s.yn), TURN(s.xy), TURN(s.yx)
#define NUMBER_ZX (DENSE ? PAD_PAIR_ZX : PAD_XZ)
#define NUMBER_ZY (DENSE ? PAD_PAIR_ZY : PAD_YZ)
#define NUMBER_YX (DENSE ? PAD_PAIR_YX : PAD_XY)

/* Adds the products of cell j and its entry of the table. */
INLINE void add_products(global const side *t, const Cells *c, int j, Sums *s) {
  EACH_VECTOR(v) {
    const vreal n = c->n[j].v[v], tx = c->tx[j].v[v], ty = c->ty[j].v[v];
    s->zn.v[v] = fma(ALL_LANES(t[PAD_ZZ]), n, s->zn.v[v]);
    s->zx.v[v] = fma(ALL_LANES(t[NUMBER_ZX]), tx, s->zx.v[v]);
    s->zy.v[v] = fma(ALL_LANES(t[NUMBER_ZY]), ty, s->zy.v[v]);
    s->xx.v[v] = fma(ALL_LANES(t[PAD_XX]), tx, s->xx.v[v]);
    s->xy.v[v] = fma(ALL_LANES(t[PAD_XY]), ty, s->xy.v[v]);
    s->xn.v[v] = fma(ALL_LANES(t[PAD_XZ]), n, s->xn.v[v]);
    s->yx.v[v] = fma(ALL_LANES(t[NUMBER_YX]), tx, s->yx.v[v]);
    s->yy.v[v] = fma(ALL_LANES(t[PAD_YY]), ty, s->yy.v[v]);
    s->yn.v[v] = fma(ALL_LANES(t[PAD_YZ]), n, s->yn.v[v]);
  }
}

/* Displacement at a cell by the cells listed. ix, iy from -1 to CELLS. A table of one quadrant lacks the signs of xy,
   xz and yz: where they change, the sums change theirs, which gives the bits of a whole table. There a column is walked
   from its first cell in a window to its last: those between without tractions add 0. */
INLINE void displacement(const Influence *influence, const Cells *c, int ix, int iy, Lanes *x, Lanes *y, Lanes *z) {
  Sums s;
  EACH_VECTOR(v) {
    s.zn.v[v] = s.zx.v[v] = s.zy.v[v] = s.xx.v[v] = s.xy.v[v] = s.xn.v[v] = s.yx.v[v] = s.yy.v[v] = s.yn.v[v] = 0;
  }
  if (OWN_TABLES) {
    ROLLED for (int jx = 0; jx < CELLS; ++jx) {
      const int end = c->to[jx], here = jx * CELLS + iy;
      global const side *column = influence->table + PAD_OWN_INFLUENCE * abs(ix - jx) * (CELLS + 1), *t;
      if (jx == ix + 1) TURN_X(s);
      int j = c->from[jx];
      t = column + PAD_OWN_INFLUENCE * (here - j);
      ROLLED for (; j < end && j <= here; ++j, t -= PAD_OWN_INFLUENCE) add_products(t, c, j, &s);
      if (j == end) continue;
      TURN_Y(s);
      t = column + PAD_OWN_INFLUENCE * (j - here);
      ROLLED for (; j < end; ++j, t += PAD_OWN_INFLUENCE) add_products(t, c, j, &s);
      TURN_Y(s);
    }
    if (ix < CELLS - 1) TURN_X(s);
  } else {
    global const side *row = DENSE ? influence->table + (size_t)PAD_PAIR * COUNT * (ix * CELLS_Y + iy)
                                   : influence->table - PAD_INFLUENCE * (ix * SPAN + iy);
    ROLLED for (int k = 0; k < c->listed; ++k) add_products(row + c->at[k], c, c->list[k], &s);
  }
  EACH_VECTOR(v) {
    x->v[v] = s.xx.v[v] + s.xy.v[v] - s.xn.v[v];
    y->v[v] = s.yx.v[v] + s.yy.v[v] - s.yn.v[v];
    z->v[v] = -(s.zn.v[v] + s.zx.v[v] + s.zy.v[v]);
  }
}

/* The same along z at place k of the ring, (ix, iy). Returns whether there is rubber. */
INLINE int displacement_of_ring(const Influence *influence, global const vreal *heights, const Cells *c, int k, int ix,
                                int iy, Lanes *z) {
  Lanes x, y;
  (void)heights, (void)k;
  displacement(influence, c, ix, iy, &x, &y, z);
  return 1;
}

/* Cells do the same to themselves, 1 as they are scaled. */
INLINE void set_own(const Influence *influence, Cells *c) { (void)influence, (void)c; }

#endif
