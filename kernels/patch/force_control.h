// SPDX-License-Identifier: Apache-2.0
/* The place of the indenter that gives the forces asked for. Device only. */
#ifndef TACTEL_PATCH_FORCE_CONTROL_H
#define TACTEL_PATCH_FORCE_CONTROL_H
#include "patch/load_path.h"

#define SLIDING_MARGIN ((real)1e-5) /* share of Q = mu P within which a contact slides as a whole */
#define MOST_FORCE_TRIALS 60        /* trials of depth (and position) to reach given forces */

#if FORCE_CONTROL
/* Search for the indenter's place z = (d, x) that gives the forces asked for: f = (P - P_target, Q - (Q_target /
   P_target) P) = 0, by Broyden's inverse update (Broyden 1965). */
typedef struct {
  vreal b[2][2];    /* inverse Jacobian */
  vreal z[2], g[2]; /* last trial that did not slide: place; P and Q - (Q_target / P_target) P */
  vreal low, high;  /* bracket of d */
  vreal p_target, q_target;
} Search;

/* Inverse update with the trial (z, g) in the given lanes; b stays where the step was too small to tell anything. */
static inline void broyden_update(Search *s, const vreal *z, const vreal *g, vint lanes) {
  const vreal dz0 = z[0] - s->z[0], dz1 = z[1] - s->z[1];
  const vreal dg0 = g[0] - s->g[0], dg1 = g[1] - s->g[1];
  const vreal e0 = dz0 - fma(s->b[0][0], dg0, s->b[0][1] * dg1);
  const vreal e1 = dz1 - fma(s->b[1][0], dg0, s->b[1][1] * dg1);
  const vreal r0 = fma(dz0, s->b[0][0], dz1 * s->b[1][0]);
  const vreal r1 = fma(dz0, s->b[0][1], dz1 * s->b[1][1]);
  const vreal below = fma(r0, dg0, r1 * dg1);
  const vint use = lanes & (fabs(below) > (real)1e-2 * fma(dz0, dz0, dz1 * dz1));
  const vreal per = PICK(use, 1 / below, ALL_LANES(0));
  s->b[0][0] = fma(e0 * r0, per, s->b[0][0]);
  s->b[0][1] = fma(e0 * r1, per, s->b[0][1]);
  s->b[1][0] = fma(e1 * r0, per, s->b[1][0]);
  s->b[1][1] = fma(e1 * r1, per, s->b[1][1]);
  for (int a = 0; a < 2; ++a) {
    s->z[a] = PICK(lanes, z[a], s->z[a]);
    s->g[a] = PICK(lanes, g[a], s->g[a]);
  }
}

/* A trial inside the bracket: where Broyden's step leaves it, halfway to the bound, or twice as deep where there is no
   bound yet. */
static inline vreal bracketed(vreal trial, vreal now, vreal low, vreal high) {
  const vreal deeper = PICK(high < FAR, (real)0.5 * (now + high), 2 * now);
  return PICK(trial >= high, deeper, PICK(trial <= low, (real)0.5 * (now + low), trial));
}

/* Moves the indenter of the active lanes towards the forces asked for. Leaves in in->active those that were not there
   yet. Forces do not change with x where the contact slides as a whole: such a trial teaches nothing, and the next one
   lies halfway to the last that did not slide. */
static inline void update_force_control(Search *s, const Contact *c, Indenter *in, vint both, real tolerance) {
  vreal p, q;
  resultants(c->n, c->t, &p, &q);
  const vreal ratio = PICK(both & (s->p_target > 0), s->q_target / s->p_target, ALL_LANES(0));
  const vreal z[2] = {in->d, in->x};
  const vreal g[2] = {p, PICK(both, fma(-ratio, p, q), ALL_LANES(0))};
  const vreal miss[2] = {p - s->p_target, g[1]};
  const vreal enough = tolerance * s->p_target;
  const vint slides = both & (p > 0) & (fabs(q) >= (1 - SLIDING_MARGIN) * in->mu * p);
  broyden_update(s, z, g, in->active & NOT(slides));
  in->active &= (fabs(miss[0]) > enough) | (fabs(miss[1]) > enough);
  in->held &= NOT(in->active);
  const vreal step[2] = {fma(s->b[0][0], miss[0], s->b[0][1] * miss[1]),
                         fma(s->b[1][0], miss[0], s->b[1][1] * miss[1])};
  s->low = PICK(miss[0] < 0, LARGER(z[0], s->low), s->low);
  s->high = PICK(miss[0] > 0, SMALLER(z[0], s->high), s->high);
  /* P grows with d alone where x is given: keep inside the bracket. With both unknown the bracket moves: bound the step
     instead. */
  const vreal far_d = (real)0.5 * z[0], far_x = LARGER(fabs(z[1]), far_d);
  const vreal bounded = SMALLER(LARGER(z[0] - step[0], z[0] - far_d), z[0] + 2 * far_d);
  const vreal near_x = SMALLER(LARGER(z[1] - step[1], z[1] - far_x), z[1] + far_x);
  const vreal next[2] = {PICK(both, bounded, bracketed(z[0] - step[0], z[0], s->low, s->high)),
                         PICK(slides, (real)0.5 * (z[1] + s->z[1]), near_x)};
  in->d = PICK(in->active, next[0], in->d);
  in->x = PICK(in->active & both, next[1], in->x);
}

static inline void start_search(const LoadStepping *w, Search *s) {
  s->b[0][0] = (real)0.3; /* thickness / width, about: a start that the first trial corrects */
  s->b[1][1] = 1;
  s->z[0] = w->nearest;
  s->b[0][1] = s->b[1][0] = s->z[1] = s->g[0] = s->g[1] = 0;
}

/* Keeps the targets in the search, and puts the indenter where it is, or to a first guess, instead. */
static inline void first_trial(Search *s, const Indenter *in, const LoadStepping *w, vreal *d, vreal *x) {
  const vreal guess = PICK(in->d > w->nearest, in->d, fma(s->b[0][0], *d, w->nearest));
  s->p_target = *d;
  s->q_target = *x;
  s->low = 0;
  s->high = FAR;
  *d = PICK(*d > 0, guess, ALL_LANES(0));
  *x = PICK(w->both, in->x, *x);
}

static inline void reach_forces(const Rules *rules, Search *s, Contact *c, Indenter *in, LoadStepping *w) {
  in->active = w->running & (s->p_target > 0);
  for (int trial = 0; trial < MOST_FORCE_TRIALS; ++trial) {
    update_force_control(s, c, in, w->both, 10 * rules->tolerance); /* 10 times what the sweeps leave */
    if (!ANY(in->active)) return;
    const vint searching = in->active;
    set_indenter(c, in);
    iterate(rules, c, in, &w->sweeps);
    w->failed = (w->failed & NOT(searching)) | in->active;
    in->active = searching;
  }
  w->failed |= in->active;
}
#endif

#endif
