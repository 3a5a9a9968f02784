// SPDX-License-Identifier: Apache-2.0
/* Increments of the load path: targets, first guesses, and the indenter on its way. Device only. */
#ifndef TACTEL_PATCH_LOAD_PATH_H
#define TACTEL_PATCH_LOAD_PATH_H
#include "patch/certificate.h"

/* Constant parts of the rows for the indenter where it is. */
static inline void set_indenter(Contact *c, const Indenter *in) {
  for (int i = 0; i < N; ++i) {
    c->b[i] = (in->d - c->h[i]) * c->wy[i];
#if FRICTION
    c->bt[i] = fma(in->x - in->x_last, c->wx[i], c->ux_last[i]);
#endif
  }
}

#if ENTRIES
/* While the indenter presses only, an open element whose gap would close within this increment, `part` of the last
   change from now, sticks from where it would be then. Without that it would stick from where the last increment left
   it. */
static inline void touch_within(Contact *c, const Indenter *in, vreal ratio) {
  const vint presses = in->active & (in->x == in->x_last) & (ratio > 0);
  if (!ANY(presses)) return;
  for (int i = 0; i < N; ++i) {
    const vreal gap = c->gap[i], closed = c->gap_before[i] - gap;
    const vint closes = presses & NOT(c->n[i] > 0) & (gap > 0) & (gap < ratio * closed);
    const vreal part = PICK(closes, gap / closed, ALL_LANES(0));
    c->ux_last[i] = PICK(closes, fma(part, c->ux[i] - c->ux_before[i], c->ux_last[i]), c->ux_last[i]);
  }
}
#endif

/* A first guess: the last change of the forces goes on in proportion to the load. */
static inline void extrapolate(Contact *c, const Indenter *in, vreal ratio) {
  for (int i = 0; i < N; ++i) {
    const vreal n = c->n[i], n_guess = LARGER(fma(ratio, n - c->n_last[i], n), ALL_LANES(0));
    c->n_last[i] = n;
    c->n[i] = PICK(in->active, n_guess, n);
#if FRICTION
    const vreal t = c->t[i], cone = in->mu * n_guess;
    const vreal t_guess = SMALLER(LARGER(fma(ratio, t - c->t_last[i], t), -cone), cone);
    c->t_last[i] = t;
    c->t[i] = PICK(in->active, t_guess, t);
#endif
  }
}

/* A lane on its way along its load path. */
typedef struct {
  vint valid, running;
  vint both;                /* P and Q are both given */
  vint failed;              /* this increment did not converge, or not at the forces asked for */
  vint failed_before;       /* one of those before it */
  vreal nearest;            /* depth at which an element's middle is touched, mm */
  vreal d_change, x_change; /* of the last increment's target, mm */
  vreal sweeps;             /* since the last report */
} LoadStepping;

/* Lanes in `none` bear no forces. */
static inline void release(Contact *c, vint none) {
  if (!ANY(none)) return;
  for (int i = 0; i < N; ++i) {
    c->n[i] = PICK(none, ALL_LANES(0), c->n[i]);
    if (FRICTION) c->t[i] = PICK(none, ALL_LANES(0), c->t[i]);
  }
}

/* Target of increment k: (d, x), mm, or forces; lanes beyond their path stop and stay where they are. ratio: this
   change of the target over the last one, 0 where both d and x change, or the way turns, or the load is a force. */
static inline void next_target(const vreal *lane, global const vreal *path, int k, const Indenter *in, LoadStepping *w,
                               vreal *d, vreal *x, vreal *ratio) {
  global const vreal *target = path + AT(k * PATCH_PATH_ROWS);
  w->running &= lane[PATCH_STEPS] > (real)k;
  *d = PICK(w->running, target[AT(PATCH_NORMAL)], in->d);
  *x = PICK(w->running, target[AT(PATCH_TANGENTIAL)], in->x);
  const vreal d_now = *d - in->d, x_now = *x - in->x;
  const vint same_d = (d_now == 0) & (w->d_change == 0), same_x = (x_now == 0) & (w->x_change == 0);
  const vreal along_d = PICK(same_x & (w->d_change != 0), d_now / w->d_change, ALL_LANES(0));
  const vreal along = PICK(same_d & (w->x_change != 0), x_now / w->x_change, along_d);
  *ratio = FORCE_CONTROL ? ALL_LANES(0) : PICK((along > 0) & (along <= 2), along, ALL_LANES(0));
  w->d_change = d_now;
  w->x_change = x_now;
}

/* Lanes whose target is where they are rest as they are: that is a solution, and so a held contact does not creep by
   rounding. */
static inline void move_to(Indenter *in, const LoadStepping *w, vreal d, vreal x) {
  in->held = d == in->d;
  if (FRICTION) in->held &= x == in->x;
  in->active = w->running & NOT(in->held);
  in->x_last = in->x;
  in->d = d;
  in->x = x;
}

static inline void start(const vreal *lane, Contact *c, Indenter *in, LoadStepping *w) {
  for (int i = 0; i < N; ++i) c->n[i] = c->t[i] = c->n_last[i] = c->t_last[i] = c->ux_last[i] = 0;
#if ENTRIES
  for (int i = 0; i < N; ++i) {
    c->ux[i] = c->ux_before[i] = 0;
    c->gap[i] = c->gap_before[i] = c->h[i];
  }
#endif
  in->mu = lane[PATCH_MU];
  in->d = in->x = in->x_last = 0;
  w->both = lane[PATCH_CONTROL] >= FORCE_BOTH;
  w->d_change = w->x_change = w->sweeps = 0;
  w->running = w->valid;
  w->failed = w->failed_before = 0;
}

#endif
