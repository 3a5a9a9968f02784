// SPDX-License-Identifier: Apache-2.0
/* Gauss-Seidel sweeps over the cells in the window, and fresh sums beyond it. Device only. */
#ifndef TACTEL_PAD_SWEEP_H
#define TACTEL_PAD_SWEEP_H
#include "pad/cells.h"

#define RELAXATION ((real)0.85)
#define DAMPED_AFTER 300

/* One sweep over the window. A lane whose tractions changed by no more than the tolerance has settled. */
OUTLINE void sweep(const Influence *influence, int most_sweeps, Cells *c, State *s) {
  Lanes change, largest, w;
  EACH_VECTOR(v) {
    change.v[v] = largest.v[v] = 0;
    w.v[v] = PICK(s->trial_sweeps.v[v] >= ALL_LANES(DAMPED_AFTER), ALL_LANES(RELAXATION / 2), ALL_LANES(RELAXATION));
    const vreal more = PICK(s->active.v[v], ALL_LANES(1), ALL_LANES(0));
    s->sweeps.v[v] += more;
    s->trial_sweeps.v[v] += more;
  }
  ROLLED for (int k = 0; k < c->listed; ++k) {
    const int i = c->list[k];
    Lanes ux, uy, uz;
    displacement(influence, c, i / CELLS_Y, i % CELLS_Y, &ux, &uy, &uz);
    add_own(c, i, &ux, &uy, &uz);
    EACH_VECTOR(v) {
      const vreal step = OWN_ROWS ? w.v[v] * c->per_own_n[i].v[v] : w.v[v],
                  step_t = OWN_ROWS ? w.v[v] * c->per_own_t[i].v[v] : w.v[v];
      const vint mine = s->active.v[v] & c->window[i].v[v];
      const vreal n0 = c->n[i].v[v], x0 = c->tx[i].v[v], y0 = c->ty[i].v[v];
      const vreal n = LARGER(fma(step, uz.v[v] - c->open[i].v[v], n0), ALL_LANES(0));
      vreal x = fma(step_t, c->gx[i].v[v] - ux.v[v], x0), y = fma(step_t, c->gy[i].v[v] - uy.v[v], y0);
      const vreal cone = MU(i, v) * n, q = fma(x, x, y * y);
      const vint slips = q > cone * cone;
      const vreal shorter = cone / sqrt(q);
      x = PICK(slips, x * shorter, x);
      y = PICK(slips, y * shorter, y);
      c->n[i].v[v] = PICK(mine, n, n0);
      c->tx[i].v[v] = PICK(mine, x, x0);
      c->ty[i].v[v] = PICK(mine, y, y0);
      const vreal dt = LARGER(fabs(x - x0), fabs(y - y0)), most = LARGER(fabs(n - n0), dt);
      change.v[v] = PICK(mine, LARGER(most, change.v[v]), change.v[v]);
      largest.v[v] = PICK(mine, LARGER(n, largest.v[v]), largest.v[v]);
    }
  }
  Masks left;
  EACH_VECTOR(v) {
    const vint settled = change.v[v] <= s->tolerance.v[v] * largest.v[v];
    const vreal usual = ALL_LANES((real)most_sweeps),
                most = PICK(s->lost.v[v], SMALLER(usual, ALL_LANES(DAMPED_AFTER)), usual);
    const vint out = s->active.v[v] & NOT(settled) & (s->trial_sweeps.v[v] >= most);
    s->failed.v[v] |= out;
    left.v[v] = s->active.v[v] & (settled | out);
    s->active.v[v] &= NOT(settled | out);
  }
  if (any_of(&left)) list_cells(&s->active, c);
}

/* Fresh sums at all cells, or at those nearby, by the cells listed. */
OUTLINE void sum_afresh(const Influence *influence, Cells *c) {
  ROLLED for (int k = 0; k < SUMMED(c); ++k) {
    const int i = CELL_SUMMED(c, k);
    displacement(influence, c, i / CELLS_Y, i % CELLS_Y, &c->ux[i], &c->uy[i], &c->uz[i]);
    add_own(c, i, &c->ux[i], &c->uy[i], &c->uz[i]);
  }
}

/* Cells of lanes that solve which are penetrated outside their window join it; these lanes go on. */
OUTLINE void widen(const Influence *influence, const Masks *solving, Cells *c, State *s) {
  ROLLED for (int k = 0; k < SUMMED(c); ++k) EACH_VECTOR(v) {
    const int i = CELL_SUMMED(c, k);
    const vreal gap = c->open[i].v[v] - c->uz[i].v[v];
    const vint joins = solving->v[v] & NOT(s->failed.v[v]) & NOT(c->window[i].v[v]) &
                       (gap * influence->root_zz < -s->tolerance.v[v] * s->d.v[v]) & NEAR(c, i, v);
    c->window[i].v[v] |= joins;
    s->active.v[v] |= joins;
  }
}

static vreal pressing(const Influence *influence, const Cells *c, int v) {
  vreal sum = 0;
  for (int k = 0; k < c->listed; ++k) sum += c->n[c->list[k]].v[v];
  return sum * (influence->hx * influence->hy / influence->root_zz);
}

#endif
