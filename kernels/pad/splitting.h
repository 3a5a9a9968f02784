// SPDX-License-Identifier: Apache-2.0
/* Contacts of objects that cover most of the grid, by splitting (alternating directions of multipliers; D. Gabay and
   B. Mercier, Comput. Math. Appl. 2, 1976, 17-40): the rubber of all cells is solved at once, the laws cell by cell. With z
   the tractions n, t_x, t_y, B what they do to the surface, D what a cell gives way on its own, and b where the surface
   would be if it touched and stuck,
     v = (B + rho)^-1 (b + rho (z - y)),   a = z + ALPHA (v - z) + y,
     z = rho / (rho + D) a, n cut at 0, t shortened to mu n,   y = a - z;
   where v = z the laws hold. rho y is what the laws leave of the gap and the slip: it starts from those of rubber that
   stays where it was.

   (B + rho)^-1 is made by the host once a table. B of a grid that is its own image along x and along y falls into four
   blocks, of fields even or odd along x and along y, each of a quarter of the cells: an iteration takes 9/4 products of a
   pair of cells, whatever touches, where a sweep takes 9 of each pair in the window. Device only. */
#ifndef TACTEL_PAD_SPLITTING_H
#define TACTEL_PAD_SPLITTING_H
#include "pad/sweep.h"
#include "shared/pad_step_layout.h"

#define ALPHA ((real)1.8)
#define SETTLED ((real)0.35) /* tolerance of iterations over that of sweeps: errors are then no larger */
#define MOST_ITERATIONS 60   /* then sweeps go on */
#define HALF_X ((CELLS + 1) / 2)
#define HALF_Y ((CELLS_Y + 1) / 2)
#define BLOCK_ROWS (3 * HALF_X * HALF_Y)
#define BLOCK_ROUNDS ((BLOCK_ROWS + STEP_ROUND - 1) / STEP_ROUND)
#define BLOCKS_NUMBERS (4 * BLOCK_ROUNDS * BLOCK_ROWS * STEP_ROUND)

typedef struct {
  Lanes y[3][COUNT];
  Lanes gives_n[COUNT], gives_t[COUNT]; /* rho / (rho + D); 0: the cell is far */
  Lanes u[3][COUNT];                    /* a product's vector, and what comes out */
  Lanes from[4][BLOCK_ROWS];            /* even and odd fields of it on a quarter */
  Lanes to[4][BLOCK_ROUNDS * STEP_ROUND];
  Masks wide; /* lanes that are split */
  real rho_n, rho_t;
} Split;

/* The block to which n, t_x, t_y belong (part 0, 1, 2) where they are odd along x or y: n even along x acts on t_x odd. */
#define BLOCK_OF(part, odd_x, odd_y) (2 * ((odd_x) ^ ((part) == 1)) + ((odd_y) ^ ((part) == 2)))

/* Cell i, j of a quarter, and its images along x, y and both. */
static inline void images(int i, int j, int *at) {
  const int across = CELLS - 1 - i, along = CELLS_Y - 1 - j;
  at[0] = i * CELLS_Y + j, at[1] = across * CELLS_Y + j;
  at[2] = i * CELLS_Y + along, at[3] = across * CELLS_Y + along;
}

/* w->u becomes its product with a matrix of four blocks, [4][BLOCK_ROUNDS][BLOCK_ROWS][STEP_ROUND]. */
OUTLINE void multiply(global const real *matrix, Split *w) {
  int at[4];
  ROLLED for (int part = 0; part < 3; ++part) ROLLED for (int i = 0; i < HALF_X; ++i)
      ROLLED for (int j = 0; j < HALF_Y; ++j) {
    const int row = (part * HALF_X + i) * HALF_Y + j;
    images(i, j, at);
    EACH_VECTOR(v) {
      const Lanes *u = w->u[part];
      const vreal even = u[at[0]].v[v] + u[at[1]].v[v], odd = u[at[0]].v[v] - u[at[1]].v[v],
                  even_y = u[at[2]].v[v] + u[at[3]].v[v], odd_y = u[at[2]].v[v] - u[at[3]].v[v];
      w->from[BLOCK_OF(part, 0, 0)][row].v[v] = (real)0.25 * (even + even_y);
      w->from[BLOCK_OF(part, 0, 1)][row].v[v] = (real)0.25 * (even - even_y);
      w->from[BLOCK_OF(part, 1, 0)][row].v[v] = (real)0.25 * (odd + odd_y);
      w->from[BLOCK_OF(part, 1, 1)][row].v[v] = (real)0.25 * (odd - odd_y);
    }
  }
  ROLLED for (int block = 0; block < 4; ++block) ROLLED for (int round = 0; round < BLOCK_ROUNDS; ++round) {
    vreal sum[STEP_ROUND][VECTORS];
    EACH(r, STEP_ROUND) EACH_VECTOR(v) { sum[r][v] = 0; }
    ROLLED for (int k = 0; k < BLOCK_ROWS; ++k, matrix += STEP_ROUND) EACH(r, STEP_ROUND) EACH_VECTOR(v) {
      sum[r][v] = fma(ALL_LANES(matrix[r]), w->from[block][k].v[v], sum[r][v]);
    }
    EACH(r, STEP_ROUND) EACH_VECTOR(v) { w->to[block][round * STEP_ROUND + r].v[v] = sum[r][v]; }
  }
  ROLLED for (int part = 0; part < 3; ++part) ROLLED for (int i = 0; i < HALF_X; ++i)
      ROLLED for (int j = 0; j < HALF_Y; ++j) {
    const int row = (part * HALF_X + i) * HALF_Y + j;
    images(i, j, at);
    EACH_VECTOR(v) {
      Lanes *u = w->u[part];
      const vreal ee = w->to[BLOCK_OF(part, 0, 0)][row].v[v], eo = w->to[BLOCK_OF(part, 0, 1)][row].v[v],
                  oe = w->to[BLOCK_OF(part, 1, 0)][row].v[v], oo = w->to[BLOCK_OF(part, 1, 1)][row].v[v];
      u[at[0]].v[v] = (ee + eo) + (oe + oo);
      u[at[1]].v[v] = (ee + eo) - (oe + oo);
      u[at[2]].v[v] = (ee - eo) + (oe - oo);
      u[at[3]].v[v] = (ee - eo) - (oe - oo);
    }
  }
}

/* Minus the gap of a cell over rubber at rest. More than twice the depth counts as that: it would only take digits away.
 */
INLINE vreal overlap_of(const Influence *influence, const Cells *c, const State *s, int i, int v) {
  return -SMALLER(c->open[i].v[v], 2 * LARGER(s->d.v[v] - s->lowest.v[v], ALL_LANES(0)) / influence->root_zz);
}

/* From w->u = v to the next z and y of wide lanes that are active. */
OUTLINE void apply_laws(int most_sweeps, Cells *c, State *s, Split *w) {
  Lanes change, largest;
  Masks mine;
  EACH_VECTOR(v) {
    change.v[v] = largest.v[v] = 0;
    mine.v[v] = s->active.v[v] & w->wide.v[v];
    const vreal more = PICK(mine.v[v], ALL_LANES(1), ALL_LANES(0));
    s->sweeps.v[v] += more;
    s->trial_sweeps.v[v] += more;
  }
  ROLLED for (int i = 0; i < COUNT; ++i) EACH_VECTOR(v) {
    const vint on = mine.v[v];
    const vreal n0 = c->n[i].v[v], x0 = c->tx[i].v[v], y0 = c->ty[i].v[v];
    const vreal vn = w->u[0][i].v[v], vx = w->u[1][i].v[v], vy = w->u[2][i].v[v], gives_t = w->gives_t[i].v[v];
    const vreal an = fma(ALPHA, vn - n0, n0) + w->y[0][i].v[v], ax = fma(ALPHA, vx - x0, x0) + w->y[1][i].v[v],
                ay = fma(ALPHA, vy - y0, y0) + w->y[2][i].v[v];
    const vreal n = LARGER(w->gives_n[i].v[v] * an, ALL_LANES(0));
    vreal x = gives_t * ax, y = gives_t * ay;
    const vreal cone = MU(i, v) * n, q = fma(x, x, y * y);
    const vint slips = q > cone * cone;
    const vreal shorter = cone / sqrt(q);
    x = PICK(slips, x * shorter, x);
    y = PICK(slips, y * shorter, y);
    const vreal moved = LARGER(fabs(n - n0), LARGER(fabs(x - x0), fabs(y - y0))),
                apart = LARGER(fabs(vn - n), LARGER(fabs(vx - x), fabs(vy - y)));
    change.v[v] = LARGER(LARGER(moved, apart), change.v[v]);
    largest.v[v] = LARGER(n, largest.v[v]);
    c->n[i].v[v] = PICK(on, n, n0);
    c->tx[i].v[v] = PICK(on, x, x0);
    c->ty[i].v[v] = PICK(on, y, y0);
    w->y[0][i].v[v] = PICK(on, an - n, w->y[0][i].v[v]);
    w->y[1][i].v[v] = PICK(on, ax - x, w->y[1][i].v[v]);
    w->y[2][i].v[v] = PICK(on, ay - y, w->y[2][i].v[v]);
  }
  EACH_VECTOR(v) {
    const vint settled = mine.v[v] & (change.v[v] <= SETTLED * s->tolerance.v[v] * largest.v[v]);
    const vint out = mine.v[v] & NOT(settled) &
                     (s->trial_sweeps.v[v] >= SMALLER(ALL_LANES((real)most_sweeps), ALL_LANES(MOST_ITERATIONS)));
    s->active.v[v] &= NOT(settled);
    w->wide.v[v] &= NOT(out);
    s->trial_sweeps.v[v] = PICK(out, ALL_LANES(0), s->trial_sweeps.v[v]);
  }
}

static inline int any_wide(const State *s, const Split *w) {
  vint any = s->active.v[0] & w->wide.v[0];
  for (int v = 1; v < VECTORS; ++v) any |= s->active.v[v] & w->wide.v[v];
  return ANY(any);
}

/* Takes lanes with at least `wide_from` cells in their window as wide. */
OUTLINE void start_splitting(const Influence *influence, int wide_from, Cells *c, const State *s, Split *w) {
  EACH_VECTOR(v) {
    vreal cells = 0;
    for (int i = 0; i < COUNT; ++i) cells += PICK(c->window[i].v[v], ALL_LANES(1), ALL_LANES(0));
    w->wide.v[v] = cells >= ALL_LANES((real)wide_from);
  }
  if (!any_of(&w->wide)) return;
  ROLLED for (int i = 0; i < COUNT; ++i) EACH_VECTOR(v) {
    const vreal n = c->n[i].v[v], x = c->tx[i].v[v], y = c->ty[i].v[v], q = fma(x, x, y * y), cone = MU(i, v) * n,
                turn = s->change_twist.v[v] / s->half_size, unit = 1 / (w->rho_t * influence->root_tt);
    const vreal slip_x = (s->change_x.v[v] - turn * (s->y_middle.v[v] + y_of(influence, i))) * unit,
                slip_y = (s->change_y.v[v] + turn * (s->x_middle.v[v] + x_of(influence, i))) * unit;
    const vint near = c->near[i].v[v], sticks = q < INSIDE_CONE * INSIDE_CONE * cone * cone, free = cone <= 0;
    const vreal along = LARGER(fma(slip_x, x, slip_y * y), ALL_LANES(0)) / LARGER(q, ALL_LANES((real)1e-30));
    const vreal gap = SMALLER(c->uz[i].v[v] + overlap_of(influence, c, s, i, v), ALL_LANES(0)) / w->rho_n;
    const vreal own = c->soft[i].v[v], slides = own / w->rho_t + PICK(sticks, ALL_LANES(0), along);
    w->y[0][i].v[v] = PICK(near & NOT(n > 0), gap, own / w->rho_n * n);
    w->y[1][i].v[v] = PICK(near, PICK(free, slip_x, slides * x), ALL_LANES(0));
    w->y[2][i].v[v] = PICK(near, PICK(free, slip_y, slides * y), ALL_LANES(0));
  }
}

/* Iterates wide lanes that are active until they have settled, or are wide no more. `inverse`: (B + rho)^-1. */
OUTLINE void split(const Influence *influence, global const real *inverse, int most_sweeps, Cells *c, State *s,
                   Split *w) {
  if (!any_wide(s, w)) return;
  ROLLED for (int i = 0; i < COUNT; ++i) EACH_VECTOR(v) {
    const vint near = c->near[i].v[v];
    c->window[i].v[v] |= w->wide.v[v] & near;
    w->gives_n[i].v[v] = PICK(near, w->rho_n / (w->rho_n + c->soft[i].v[v]), ALL_LANES(0));
    w->gives_t[i].v[v] = PICK(near, w->rho_t / (w->rho_t + c->soft[i].v[v]), ALL_LANES(0));
  }
  do {
    ROLLED for (int i = 0; i < COUNT; ++i) EACH_VECTOR(v) {
      const vint near = c->near[i].v[v]; /* of far cells the history depends on other lanes */
      const vreal gx = PICK(near, c->gx[i].v[v], ALL_LANES(0)), gy = PICK(near, c->gy[i].v[v], ALL_LANES(0));
      w->u[0][i].v[v] = fma(w->rho_n, c->n[i].v[v] - w->y[0][i].v[v], overlap_of(influence, c, s, i, v));
      w->u[1][i].v[v] = fma(w->rho_t, c->tx[i].v[v] - w->y[1][i].v[v], gx);
      w->u[2][i].v[v] = fma(w->rho_t, c->ty[i].v[v] - w->y[2][i].v[v], gy);
    }
    multiply(inverse, w);
    apply_laws(most_sweeps, c, s, w);
  } while (any_wide(s, w));
}

/* Fresh sums of all lanes. */
static void sum_split(const Influence *influence, global const real *blocks, Cells *c, Split *w) {
  Masks narrow;
  EACH_VECTOR(v) { narrow.v[v] = NOT(w->wide.v[v]); }
  if (any_of(&narrow)) {
    list_cells(&narrow, c);
    sum_afresh(influence, c);
  }
  if (!any_of(&w->wide)) return;
  list_all(c);
  ROLLED for (int i = 0; i < COUNT; ++i) {
    w->u[0][i] = c->n[i];
    w->u[1][i] = c->tx[i];
    w->u[2][i] = c->ty[i];
  }
  multiply(blocks, w);
  ROLLED for (int i = 0; i < COUNT; ++i) EACH_VECTOR(v) {
    const vint wide = w->wide.v[v];
    const vreal own = c->soft[i].v[v];
    c->uz[i].v[v] = PICK(wide, -fma(own, c->n[i].v[v], w->u[0][i].v[v]), c->uz[i].v[v]);
    c->ux[i].v[v] = PICK(wide, fma(own, c->tx[i].v[v], w->u[1][i].v[v]), c->ux[i].v[v]);
    c->uy[i].v[v] = PICK(wide, fma(own, c->ty[i].v[v], w->u[2][i].v[v]), c->uy[i].v[v]);
  }
}

#endif
