// SPDX-License-Identifier: Apache-2.0
/* Cells under an indenter on a pad, a scene a lane: their tractions and history, and what they do to the surface.
   kernels/pad_contact.cl states the laws and the rules of all files here. Device only. */
#ifndef TACTEL_PAD_CELLS_H
#define TACTEL_PAD_CELLS_H
#include "patch/numbers.h"
#include "shared/elementary.h"
#include "shared/pad_layout.h"

/* STEPPED 1 (kernels/pad_step.cl): cells are fixed to the pad, so that most lie far from the indenter, and those that it
   covers in part give way on their own. */
#ifndef STEPPED
#define STEPPED 0
#endif
/* DENSE 1, of steps alone: the table has an entry for each pair of cells, of rubber with sides. */
#ifndef DENSE
#define DENSE 0
#endif

/* FREE_SIDES 1, of contacts: each scene has a table of all pairs of its own cells, and is a work-item (free_sides.h). */
#ifndef FREE_SIDES
#define FREE_SIDES 0
#endif
/* FRICTION_MAP 1: each cell has its own mu. They stand behind the other rows of a lane's input. */
#ifndef FRICTION_MAP
#define FRICTION_MAP 0
#endif
#define MU(cell, vector) s->mu[FRICTION_MAP ? (cell) : 0].v[vector]
/* CREEP_TERMS, of rubber that creeps: 1 to 4. Contacts have what it has crept to in their cells (pad/creep.h), steps in
   their heights and history. */
#ifndef CREEP_TERMS
#define CREEP_TERMS 0
#endif
#define CREEPING (CREEP_TERMS > 0 && !STEPPED)
#if CREEPING
#define CREEPS 6 /* numbers of a cell that creep */
#define CREPT(c, k, i, v) (c)->crept[(k)*COUNT + (i)].v[v]
#define LESS_CREPT(c, i, v) -CREPT(c, 2, i, v)
#else
#define LESS_CREPT(c, i, v)
#endif
#define OWN_ROWS (STEPPED || FREE_SIDES) /* cells differ in what they do to themselves */

/* CELLS_Y, of steps alone: cells along y where they are not CELLS, as along x. Cell (i, j) has index i CELLS_Y + j. */
#ifndef CELLS_Y
#define CELLS_Y CELLS
#endif
#define COUNT (CELLS * CELLS_Y)
#define MUS (FRICTION_MAP ? COUNT : 1)
#define SPAN (2 * CELLS_Y + 1) /* offsets -CELLS_Y to CELLS_Y: those of the ring, too */
#define RING (CELLS + 2)
#define RING_PLACES (4 * (CELLS + 1))
#define EACH_VECTOR(v) EACH(v, VECTORS)
#define TURN(sum) sum.v[0] = -sum.v[0]
#define TURN_X(s) TURN(s.zx), TURN(s.xn), TURN(s.xy), TURN(s.yx)
#define TURN_Y(s) TURN(s.zy), TURN(s.yn), TURN(s.xy), TURN(s.yx)
#define INSIDE_CONE (REAL_IS_DOUBLE ? (real)(1 - 1e-12) : (real)(1 - 1e-6)) /* a shorter traction sticks */

/* Place k of the ring, once round. */
static inline void ring_place(int k, int *ix, int *iy) {
  const int side = k / (CELLS + 1), along = k % (CELLS + 1);
  *ix = side == 0 ? along - 1 : side == 1 ? CELLS : side == 2 ? CELLS - along : -1;
  *iy = side == 0 ? -1 : side == 1 ? along - 1 : side == 2 ? CELLS : CELLS - along;
}

#if FREE_SIDES
#include "pad/free_sides.h"
#endif

/* One number of each scene. */
typedef struct {
  vreal v[VECTORS];
} Lanes;
typedef struct {
  vint v[VECTORS];
} Masks;

typedef struct {
  Lanes n[COUNT], tx[COUNT], ty[COUNT]; /* tractions, scaled */
  Lanes gx[COUNT], gy[COUNT];           /* where a cell would be if it stuck, over sqrt(tt0) */
  Lanes open[COUNT];                    /* h - d, over sqrt(zz0) */
  Masks window[COUNT];
  Lanes ux[COUNT], uy[COUNT], uz[COUNT];               /* fresh sums, over sqrt(tt0), sqrt(zz0) */
  Lanes n_last[COUNT], tx_last[COUNT], ty_last[COUNT]; /* an increment earlier */
  int list[COUNT], at[COUNT], listed; /* cells in the window of lanes that sweep: index, place in a shared table */
  int from[CELLS], to[CELLS];         /* of a column: the first of them, and behind the last */
#if OWN_ROWS
  Lanes per_own_n[COUNT], per_own_t[COUNT]; /* 1 / all that a cell does to itself: rows of a sweep are divided by it */
#endif
#if CREEPING
  Lanes crept[CREEPS * COUNT]; /* before the increment */
#endif
#if FREE_SIDES
  int block[BLOCKS], blocks; /* of SUMMANDS cells, those with cells in the list */
#endif
#if STEPPED
  Lanes soft[COUNT];           /* compliance of its own that a cell adds, over that of a cell on itself */
  Masks near[COUNT];           /* of each lane: cells that the indenter may touch */
  int near_list[COUNT], nears; /* those of any lane */
#endif
} Cells;

/* Cells at which fresh sums are made: k below SUMMED(c). */
#if STEPPED
#define SUMMED(c) ((c)->nears)
#define CELL_SUMMED(c, k) ((c)->near_list[k])
#else
#define SUMMED(c) COUNT
#define CELL_SUMMED(c, k) (k)
#endif

/* The height of cell i of vector v. Without a ring around the cells where they are fixed to the pad. */
#if STEPPED
#define HEIGHT(heights, v, i) heights[(v)*COUNT + (i)]
#else
#define HEIGHT(heights, v, i) heights[((v)*RING + (i) / CELLS + 1) * RING + (i) % CELLS + 1]
#endif

/* Numbers that belong to a table. */
#if OWN_TABLES
typedef vreal side;
#else
typedef real side;
#endif

typedef struct {
  global const side *table; /* the entry of a source at offset 0 */
  side root_zz, root_tt, hx, hy;
} Influence;

/* What changes from increment to increment, and the lane's constants. */
typedef struct {
  Lanes d, x, y, twist;                             /* where the indenter is */
  Lanes change_d, change_x, change_y, change_twist; /* of the last increment; the twist times the half size */
  Lanes mu[MUS];                                    /* of scaled tractions */
  Lanes lowest, x_middle, y_middle;
  Lanes slid;                 /* sum over the increments without a sticking cell of the rms slide of those that touch */
  Lanes slip_path;            /* the same over all increments */
  Lanes sweeps, trial_sweeps; /* of this increment, and since the indenter last moved */
  Lanes tolerance, first_tolerance;                       /* of the sweeps; those of an increment begin with */
  Lanes target, low, high, power, last_d, last_P, trials; /* the search for the depth that gives a force */
  Masks valid, running, active, failed, lost, by_force, searching;
#if CREEPING
  Lanes softer; /* the rubber in the increment, over elastic one */
#endif
#if STEPPED
  Lanes deep;  /* up to which depth `near` holds */
  Masks anew;  /* heights, covers or mu are not those of the last increment: the lane solves, wherever it moves */
  Masks below; /* the depth asked for is beyond the rubber */
#endif
  side half_size;
} State;

static inline side x_of(const Influence *c, int i) { return ((real)(i / CELLS_Y) - (real)0.5 * (CELLS - 1)) * c->hx; }
static inline side y_of(const Influence *c, int i) { return ((real)(i % CELLS_Y) - (real)0.5 * (CELLS_Y - 1)) * c->hy; }

/* The nine sums of a displacement, each a chain of its own: additions do not wait for each other. */
typedef struct {
  Lanes zn, zx, zy, xx, xy, xn, yx, yy, yn;
} Sums;

#if DENSE
#define NUMBER_ZX PAD_PAIR_ZX
#define NUMBER_ZY PAD_PAIR_ZY
#define NUMBER_YX PAD_PAIR_YX
#define AT_TABLE(i) (PAD_PAIR * (i)) /* where the entry of source i lies from the first of a place */
#else
#define NUMBER_ZX PAD_XZ
#define NUMBER_ZY PAD_YZ
#define NUMBER_YX PAD_XY
#define AT_TABLE(i) (PAD_INFLUENCE * ((i) / CELLS_Y * SPAN + (i) % CELLS_Y))
#endif

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

#if FREE_SIDES
/* Displacement along z at place k of the ring by the cells listed. */
INLINE real displacement_of_ring(const Influence *influence, const Cells *c, int k) {
  global const real *row = influence->table + RING_AT + (size_t)3 * COUNT * k;
  wide sum[PARTS];
  EACH(p, PARTS) { sum[p] = 0; }
  ROLLED for (int b = 0; b < c->blocks; ++b) EACH(p, PARTS) {
    const int j = SUMMANDS * c->block[b] + p * WIDE;
    sum[p] = fma(LOAD_WIDE(row + PLANE_ZN * COUNT + j), LOAD_WIDE((const real *)c->n + j), sum[p]);
    sum[p] = fma(LOAD_WIDE(row + PLANE_ZX * COUNT + j), LOAD_WIDE((const real *)c->tx + j), sum[p]);
    sum[p] = fma(LOAD_WIDE(row + PLANE_ZY * COUNT + j), LOAD_WIDE((const real *)c->ty + j), sum[p]);
  }
  return -sum_of(sum);
}

/* Displacement at a cell by the cells listed. */
INLINE void displacement(const Influence *influence, const Cells *c, int ix, int iy, Lanes *x, Lanes *y, Lanes *z) {
  global const real *row = influence->table + (size_t)PAIR_PLANES * COUNT * (ix * CELLS + iy);
  wide z_sum[PARTS], x_sum[PARTS], y_sum[PARTS];
  wide zn[PARTS], zx[PARTS], zy[PARTS], xx[PARTS], xy[PARTS], xn[PARTS], yx[PARTS], yy[PARTS], yn[PARTS];
  EACH(p, PARTS) { zn[p] = zx[p] = zy[p] = xx[p] = xy[p] = xn[p] = yx[p] = yy[p] = yn[p] = 0; }
  ROLLED for (int b = 0; b < c->blocks; ++b) EACH(p, PARTS) {
    const int j = SUMMANDS * c->block[b] + p * WIDE;
    const wide n = LOAD_WIDE((const real *)c->n + j), tx = LOAD_WIDE((const real *)c->tx + j),
               ty = LOAD_WIDE((const real *)c->ty + j);
    zn[p] = fma(LOAD_WIDE(row + PLANE_ZN * COUNT + j), n, zn[p]);
    zx[p] = fma(LOAD_WIDE(row + PLANE_ZX * COUNT + j), tx, zx[p]);
    zy[p] = fma(LOAD_WIDE(row + PLANE_ZY * COUNT + j), ty, zy[p]);
    xx[p] = fma(LOAD_WIDE(row + PLANE_XX * COUNT + j), tx, xx[p]);
    xy[p] = fma(LOAD_WIDE(row + PLANE_XY * COUNT + j), ty, xy[p]);
    xn[p] = fma(LOAD_WIDE(row + PLANE_XN * COUNT + j), n, xn[p]);
    yx[p] = fma(LOAD_WIDE(row + PLANE_YX * COUNT + j), tx, yx[p]);
    yy[p] = fma(LOAD_WIDE(row + PLANE_YY * COUNT + j), ty, yy[p]);
    yn[p] = fma(LOAD_WIDE(row + PLANE_YN * COUNT + j), n, yn[p]);
  }
  EACH(p, PARTS) {
    x_sum[p] = xx[p] + xy[p] - xn[p];
    y_sum[p] = yx[p] + yy[p] - yn[p];
    z_sum[p] = zn[p] + zx[p] + zy[p];
  }
  x->v[0] = sum_of(x_sum);
  y->v[0] = sum_of(y_sum);
  z->v[0] = -sum_of(z_sum);
}
#else
/* Displacement at a cell by the cells listed. ix, iy from -1 to CELLS. A table of one quadrant lacks the signs of xy,
   xz and yz: where they change, the sums change theirs, which gives the bits of a whole table. There a column is walked
   from its first cell in a window to its last: those between without tractions add 0. */
INLINE void displacement(const Influence *influence, const Cells *c, int ix, int iy, Lanes *x, Lanes *y, Lanes *z) {
  Sums s;
  EACH_VECTOR(v) {
    s.zn.v[v] = s.zx.v[v] = s.zy.v[v] = s.xx.v[v] = s.xy.v[v] = s.xn.v[v] = s.yx.v[v] = s.yy.v[v] = s.yn.v[v] = 0;
  }
#if OWN_TABLES
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
#else
#if DENSE
  global const real *row = influence->table + (size_t)PAD_PAIR * COUNT * (ix * CELLS_Y + iy);
#else
  global const real *row = influence->table - PAD_INFLUENCE * (ix * SPAN + iy);
#endif
  ROLLED for (int k = 0; k < c->listed; ++k) add_products(row + c->at[k], c, c->list[k], &s);
#endif
  EACH_VECTOR(v) {
    x->v[v] = s.xx.v[v] + s.xy.v[v] - s.xn.v[v];
    y->v[v] = s.yx.v[v] + s.yy.v[v] - s.yn.v[v];
    z->v[v] = -(s.zn.v[v] + s.zx.v[v] + s.zy.v[v]);
  }
}
#endif

/* Cells in the window of any of these lanes, in the order of their index. */
static void list_cells(const Masks *lanes, Cells *c) {
  int listed = 0;
  for (int x = 0; x < CELLS; ++x) {
    int from = 0, to = 0;
    for (int i = x * CELLS_Y; i < (x + 1) * CELLS_Y; ++i) {
      vint any = c->window[i].v[0] & lanes->v[0];
      for (int v = 1; v < VECTORS; ++v) any |= c->window[i].v[v] & lanes->v[v];
      const int found = ANY(any);
      c->list[listed] = i;
      c->at[listed] = AT_TABLE(i);
      listed += found;
      from = found && to == 0 ? i : from;
      to = found ? i + 1 : to;
    }
    c->from[x] = from;
    c->to[x] = to;
  }
  c->listed = listed;
#if FREE_SIDES
  c->blocks = 0;
  for (int k = 0, last = -1; k < listed; ++k) {
    const int block = c->list[k] / SUMMANDS;
    if (block > last) c->block[c->blocks++] = last = block;
  }
#endif
}

static void list_all(Cells *c) {
  Masks all;
  EACH_VECTOR(v) { all.v[v] = ~(vint)0; }
  list_cells(&all, c);
}

static inline int any_of(const Masks *m) {
  vint any = m->v[0];
  for (int v = 1; v < VECTORS; ++v) any |= m->v[v];
  return ANY(any);
}

#if STEPPED
/* Adds to a cell's displacement what it gives way on its own. */
static inline void add_own(const Cells *c, int i, Lanes *x, Lanes *y, Lanes *z) {
  EACH_VECTOR(v) {
    x->v[v] += c->soft[i].v[v] * c->tx[i].v[v];
    y->v[v] += c->soft[i].v[v] * c->ty[i].v[v];
    z->v[v] -= c->soft[i].v[v] * c->n[i].v[v];
  }
}
#endif

#endif
