// SPDX-License-Identifier: Apache-2.0
/* Forces of a contact in the unknowns of the search for a pose, and motions by forces. Device only. */
#ifndef TACTEL_PAD_WRENCH_H
#define TACTEL_PAD_WRENCH_H
#include "pad/nearby.h"
#include "pad/slip_margin.h"
#include "shared/pad_step_layout.h"

#define LEAST_FORCE ((real)1e-20)

/* Stiffness of a contact of radius a that sticks: kt a (1 + a), kr a^3 (1 + a). */
typedef struct {
  real kt, kr;
} Stiffness;

typedef struct {
  Lanes P, X, Y, M, stick, touch; /* over E H^2, M about the middle of the cells over E H^3; numbers of cells */
} Totals;

typedef struct {
  Lanes P, W[3];            /* asked */
  Lanes arm_x, arm_y;       /* from the axis to the pressure's centre */
  Lanes centre_x, centre_y; /* from the middle of the cells */
  Lanes from[4];            /* the pose before the step */
  Lanes inverse[9], power, low, high, last_over, last_P;
  Lanes at[3], last_at[3], last_F[3]; /* motion in this step, and of the solve before with its force */
  Lanes good[3], best;                /* the motion that missed least, and by how much */
  Lanes solves;
  Masks beyond, met;
} Search;

OUTLINE void totals(const Influence *influence, const Cells *c, const State *s, Totals *f) {
  const real n_unit = influence->hx * influence->hy / influence->root_zz,
             t_unit = influence->hx * influence->hy / influence->root_tt;
  EACH_VECTOR(v) {
    vreal P = 0, X = 0, Y = 0, M = 0, stick = 0, touch = 0;
    for (int k = 0; k < c->listed; ++k) {
      const int i = c->list[k];
      const vreal n = c->n[i].v[v], x = c->tx[i].v[v], y = c->ty[i].v[v], edge = INSIDE_CONE * MU(i, v) * n;
      P += n;
      X += x;
      Y += y;
      M = fma(ALL_LANES(x_of(influence, i)), y, fma(ALL_LANES(-y_of(influence, i)), x, M));
      touch += PICK(n > 0, ALL_LANES(1), ALL_LANES(0));
      stick += PICK((n > 0) & (fma(x, x, y * y) < edge * edge), ALL_LANES(1), ALL_LANES(0));
    }
    f->P.v[v] = P * n_unit;
    f->X.v[v] = X * t_unit;
    f->Y.v[v] = Y * t_unit;
    f->M.v[v] = M * t_unit;
    f->stick.v[v] = stick;
    f->touch.v[v] = touch;
  }
}

/* S that the asked wrench would have under the present pressures, times their sum over the asked force. */
static vreal asked_margin(const Influence *influence, const Cells *c, const State *s, const Search *w, int v, vreal P) {
  const real unit = influence->root_tt / (influence->hx * influence->hy);
  const vreal X = w->W[0].v[v], Y = w->W[1].v[v];
  const vreal M = w->W[2].v[v] * s->half_size + (w->centre_x.v[v] * Y - w->centre_y.v[v] * X);
  const vreal margin = margin_of(influence, c, s, v, unit * X, unit * Y, unit * M);
  vreal grip = FRICTION_MAP ? PICK(P > 0, ALL_LANES(0), ALL_LANES(1)) : MU(0, v);
  for (int k = 0; k < FRICTION_MAP * c->listed; ++k) grip += MU(c->list[k], v) * c->n[c->list[k]].v[v];
  return PICK(grip > 0, margin * P / LARGER(w->P.v[v], ALL_LANES(LEAST_FORCE)), ALL_LANES(NO_BOUND));
}

/* Forces in the search's unknowns. */
static inline void forces_of(const Search *w, const State *s, const Totals *f, int v, vreal *F) {
  const vreal X = f->X.v[v], Y = f->Y.v[v];
  F[0] = X;
  F[1] = Y;
  F[2] = (f->M.v[v] - (w->centre_x.v[v] * Y - w->centre_y.v[v] * X)) / s->half_size;
}

static inline vreal length_of(const vreal *a) { return sqrt(fma(a[0], a[0], fma(a[1], a[1], a[2] * a[2]))); }

/* The motion that the inverse gives for a missing force, no longer than `travel`. */
static inline void motion_for(const Search *w, int v, const vreal *missing, real travel, vreal *motion) {
  EACH(k, 3) {
    motion[k] = w->inverse[3 * k].v[v] * missing[0] + w->inverse[3 * k + 1].v[v] * missing[1] +
                w->inverse[3 * k + 2].v[v] * missing[2];
  }
  const vreal cut = SMALLER(ALL_LANES(1), travel / LARGER(length_of(motion), ALL_LANES((real)1e-12)));
  EACH(k, 3) { motion[k] *= cut; }
}

/* The pose of the axis after the motion w->at of the centre. */
static inline void pose_of(const Search *w, const State *s, int v, vreal *x, vreal *y, vreal *twist) {
  const vreal turn = w->at[2].v[v] / s->half_size;
  *x = w->from[1].v[v] + (w->at[0].v[v] + turn * w->arm_y.v[v]);
  *y = w->from[2].v[v] + (w->at[1].v[v] - turn * w->arm_x.v[v]);
  *twist = w->from[3].v[v] + turn;
}

/* The centre of the pressures, or the middle of the cells that are lowest. */
static void take_centre(const Influence *influence, const State *s, const Cells *c, Search *w) {
  EACH_VECTOR(v) {
    vreal sum = 0, x = 0, y = 0;
    for (int k = 0; k < c->listed; ++k) {
      const int i = c->list[k];
      sum += c->n[i].v[v];
      x = fma(ALL_LANES(x_of(influence, i)), c->n[i].v[v], x);
      y = fma(ALL_LANES(y_of(influence, i)), c->n[i].v[v], y);
    }
    const vreal per = PICK(sum > 0, 1 / LARGER(sum, ALL_LANES(LEAST_FORCE)), ALL_LANES(0));
    /* None presses: about the axis. */
    w->centre_x.v[v] = PICK(sum > 0, x * per, -s->x_middle.v[v]);
    w->centre_y.v[v] = PICK(sum > 0, y * per, -s->y_middle.v[v]);
    w->arm_x.v[v] = w->centre_x.v[v] + s->x_middle.v[v];
    w->arm_y.v[v] = w->centre_y.v[v] + s->y_middle.v[v];
  }
}

#endif
