// SPDX-License-Identifier: Apache-2.0
/* Cells under an indenter on a pad, a scene a lane: their tractions and history, and what they do to the surface.
   kernels/pad_contact.cl states the laws and the rules of all files here. Device only. */
#ifndef TACTEL_PAD_CELLS_H
#define TACTEL_PAD_CELLS_H
#include "patch/numbers.h"
#include "shared/elementary.h"
#include "shared/pad_layout.h"
#include "shared/pad_step_layout.h"

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
/* OWN_TABLES 1, of contacts: each lane has a table. */
#ifndef OWN_TABLES
#define OWN_TABLES 0
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
#define CREEPS 6                                           /* numbers of a cell that creep */
#define CREPT(c, k, i, v) (c)->crept[(k)*COUNT + (i)].v[v] /* where CREEPING */
#define OWN_ROWS (STEPPED || FREE_SIDES)                   /* cells differ in what they do to themselves */

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
#define INSIDE_CONE (REAL_IS_DOUBLE ? (real)(1 - 1e-12) : (real)(1 - 1e-6)) /* a shorter traction sticks */

/* Place k of the ring, once round. */
static inline void ring_place(int k, int *ix, int *iy) {
  const int side = k / (CELLS + 1), along = k % (CELLS + 1);
  *ix = side == 0 ? along - 1 : side == 1 ? CELLS : side == 2 ? CELLS - along : -1;
  *iy = side == 0 ? -1 : side == 1 ? along - 1 : side == 2 ? CELLS : CELLS - along;
}

#define SUMMANDS 16                                     /* of sums over rows of a table of pairs */
#define BLOCKS (COUNT / SUMMANDS)                       /* of a row */
#define WHERE(variant, count) ((variant) ? (count) : 1) /* members that a variant alone has */

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
  /* 1 / all that a cell does to itself: rows of a sweep are divided by it */
  Lanes per_own_n[WHERE(OWN_ROWS, COUNT)], per_own_t[WHERE(OWN_ROWS, COUNT)];
  Lanes crept[WHERE(CREEPING, CREEPS *COUNT)];  /* before the increment */
  int block[WHERE(FREE_SIDES, BLOCKS)], blocks; /* of SUMMANDS cells, those with cells in the list */
  Lanes soft[WHERE(STEPPED, COUNT)];            /* compliance of its own that a cell adds, over that of one on itself */
  Masks near[WHERE(STEPPED, COUNT)];            /* of each lane: cells that the indenter may touch */
  int near_list[WHERE(STEPPED, COUNT)], nears;  /* those of any lane */
} Cells;

/* Cells at which fresh sums are made: k below SUMMED(c). */
#define SUMMED(c) (STEPPED ? (c)->nears : COUNT)
#define CELL_SUMMED(c, k) (STEPPED ? (c)->near_list[k] : (k))
#define NEAR(c, i, v) (STEPPED ? (c)->near[i].v[v] : ~(vint)0)

/* MARKED 1, of steps: there are markers. */
#ifndef MARKED
#define MARKED 0
#endif
/* Of a state of steps (shared/pad_step_layout.h). */
#define CREEP_AT (STEP_FIELDS * COUNT + STEP_NUMBERS)
#define CREEP_FIELDS (MARKED ? 6 : 3) /* numbers of a cell that creep */
#define STRAINING_AT (CREEP_AT + CREEP_FIELDS * (1 + CREEP_TERMS) * COUNT)
#define STATE_ROWS (CREEP_TERMS == 0 ? CREEP_AT : STRAINING_AT + (MARKED ? 3 * COUNT : 0))
/* The height of cell i of vector v. Without a ring around the cells where they are fixed to the pad; those of a step on
   rubber that creeps lie in its state. */
#define HEIGHT_ROWS (CREEP_TERMS > 0 ? STATE_ROWS : COUNT)
#define HEIGHT(heights, v, i) \
  heights[STEPPED ? (v)*HEIGHT_ROWS + (i) : ((v)*RING + (i) / CELLS + 1) * RING + (i) % CELLS + 1]

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
  side half_size;
  Lanes softer; /* the rubber in the increment, over elastic one: where it creeps */
  /* Of steps. */
  Lanes deep;  /* up to which depth `near` holds */
  Masks anew;  /* heights, covers or mu are not those of the last increment: the lane solves, wherever it moves */
  Masks below; /* the depth asked for is beyond the rubber */
} State;

static inline side x_of(const Influence *c, int i) { return ((real)(i / CELLS_Y) - (real)0.5 * (CELLS - 1)) * c->hx; }
static inline side y_of(const Influence *c, int i) { return ((real)(i % CELLS_Y) - (real)0.5 * (CELLS_Y - 1)) * c->hy; }

/* Where the entry of source i lies from the first of a place. */
#define AT_TABLE(i) (DENSE ? PAD_PAIR * (i) : PAD_INFLUENCE * ((i) / CELLS_Y * SPAN + (i) % CELLS_Y))

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
  c->blocks = 0;
  for (int k = 0, last = -1; k < (FREE_SIDES ? listed : 0); ++k) {
    const int block = c->list[k] / SUMMANDS;
    if (block > last) c->block[c->blocks++] = last = block;
  }
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

/* Adds to a cell's displacement what it gives way on its own, in steps. */
static inline void add_own(const Cells *c, int i, Lanes *x, Lanes *y, Lanes *z) {
  for (int v = 0; v < (STEPPED ? VECTORS : 0); ++v) {
    x->v[v] += c->soft[i].v[v] * c->tx[i].v[v];
    y->v[v] += c->soft[i].v[v] * c->ty[i].v[v];
    z->v[v] -= c->soft[i].v[v] * c->n[i].v[v];
  }
}

#endif
