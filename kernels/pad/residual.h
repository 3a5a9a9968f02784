// SPDX-License-Identifier: Apache-2.0
/* How well the laws hold, and sweeps that go on where that is not accepted. Device only. */
#ifndef TACTEL_PAD_RESIDUAL_H
#define TACTEL_PAD_RESIDUAL_H
#include "pad/cells.h"

#define FINER ((real)0.25) /* tolerance of sweeps that go on, over that of those before */
#define LEAST_TOLERANCE (REAL_IS_DOUBLE ? (real)(16 * 0x1p-52) : (real)(16 * 0x1p-23))

/* Residual of the laws at the cells, relative as in fem/pad/pad_contact.h, from the tractions and the fresh sums alone.
 */
typedef struct {
  Lanes penetration, complementarity, cone, drift, angle;
} Residual;

OUTLINE void residual_of_cells(const Influence *influence, const Cells *c, const State *s, Residual *r) {
  Lanes per_d, per_moved, most;
  EACH_VECTOR(v) {
    per_d.v[v] = PICK(s->d.v[v] > 0, 1 / s->d.v[v], ALL_LANES(0));
    const vreal x = s->change_x.v[v], y = s->change_y.v[v];
    per_moved.v[v] = 1 / LARGER((real)0.1 * s->d.v[v], sqrt(fma(x, x, y * y)) + fabs(s->change_twist.v[v]));
    per_moved.v[v] = PICK(s->d.v[v] > 0, per_moved.v[v], ALL_LANES(0));
    r->penetration.v[v] = r->complementarity.v[v] = r->cone.v[v] = r->drift.v[v] = r->angle.v[v] = most.v[v] = 0;
  }
  ROLLED for (int k = 0; k < SUMMED(c); ++k) EACH_VECTOR(v) {
    most.v[v] = LARGER(c->n[CELL_SUMMED(c, k)].v[v], most.v[v]);
  }
  ROLLED for (int k = 0; k < SUMMED(c); ++k) EACH_VECTOR(v) {
    const int i = CELL_SUMMED(c, k);
    const vreal n = c->n[i].v[v], x = c->tx[i].v[v], y = c->ty[i].v[v],
                gap = (c->open[i].v[v] - c->uz[i].v[v]) * influence->root_zz * per_d.v[v];
    const vreal length = sqrt(fma(x, x, y * y)), edge = MU(i, v) * n;
    const vreal sx = c->gx[i].v[v] - c->ux[i].v[v], sy = c->gy[i].v[v] - c->uy[i].v[v];
    const vreal unit = influence->root_tt * per_moved.v[v], slip = sqrt(fma(sx, sx, sy * sy)) * unit;
    const vint pressed = n > 0, sticks = pressed & (length < INSIDE_CONE * edge),
               slips = pressed & NOT(sticks) & (length > 0);
    const vreal along = fma(sx, x, sy * y) / LARGER(length, ALL_LANES((real)1e-30)) * unit;
    const vreal inside = PICK(NEAR(c, i, v), -gap, ALL_LANES(0));
    r->penetration.v[v] = LARGER(inside, r->penetration.v[v]);
    r->complementarity.v[v] = PICK(pressed, LARGER(fabs(gap), r->complementarity.v[v]), r->complementarity.v[v]);
    r->cone.v[v] = PICK(pressed, LARGER((length - edge) / most.v[v], r->cone.v[v]), r->cone.v[v]);
    r->drift.v[v] = PICK(sticks, LARGER(slip, r->drift.v[v]), r->drift.v[v]);
    r->angle.v[v] = PICK(slips, LARGER(slip - along, r->angle.v[v]), r->angle.v[v]);
  }
}

/* The rms slide in this increment of the cells that touch, over H. */
static inline vreal rms_slide(const Influence *influence, const Cells *c, int v) {
  vreal sum = 0, touching = 0;
  for (int k = 0; k < c->listed; ++k) {
    const int i = c->list[k];
    const vreal slip_x = c->gx[i].v[v] - c->ux[i].v[v], slip_y = c->gy[i].v[v] - c->uy[i].v[v];
    sum += PICK(c->n[i].v[v] > 0, fma(slip_x, slip_x, slip_y * slip_y), ALL_LANES(0));
    touching += PICK(c->n[i].v[v] > 0, ALL_LANES(1), ALL_LANES(0));
  }
  return sqrt(sum / LARGER(touching, ALL_LANES(1))) * influence->root_tt;
}

/* Lanes that have settled, but whose residual is not accepted yet, go on with a finer tolerance. */
OUTLINE void refine(const Influence *influence, const Masks *solving, real accept, const Cells *c, State *s) {
  Residual r;
  residual_of_cells(influence, c, s, &r);
  EACH_VECTOR(v) {
    const vreal gap = LARGER(r.penetration.v[v], r.complementarity.v[v]), slip = LARGER(r.drift.v[v], r.angle.v[v]);
    const vint goes_on = solving->v[v] & NOT(s->failed.v[v] | s->active.v[v] | s->searching.v[v]) &
                         (LARGER(LARGER(gap, slip), r.cone.v[v]) > accept) &
                         (s->tolerance.v[v] > ALL_LANES(LEAST_TOLERANCE));
    s->tolerance.v[v] = PICK(goes_on, FINER * s->tolerance.v[v], s->tolerance.v[v]);
    s->trial_sweeps.v[v] = PICK(goes_on, ALL_LANES(0), s->trial_sweeps.v[v]);
    s->active.v[v] |= goes_on;
    s->searching.v[v] |= goes_on & s->by_force.v[v];
  }
}

#endif
