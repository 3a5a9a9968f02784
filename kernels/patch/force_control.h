// SPDX-License-Identifier: Apache-2.0
/* The place of the indenter that gives the forces asked for. Device only. */
#ifndef TACTEL_PATCH_FORCE_CONTROL_H
#define TACTEL_PATCH_FORCE_CONTROL_H
#include "patch/load_path.h"
#include "shared/force_search.h"

#define SLIDING_MARGIN ((real)1e-5) /* share of Q = mu P within which a contact slides as a whole */
#define MOST_FORCE_TRIALS 60        /* trials of depth (and position) to reach given forces */

#if FORCE_CONTROL
/* Moves the indenter of the active lanes towards the forces asked for. Leaves in in->active those that were not there
   yet. Forces do not change with x where the contact slides as a whole: such a trial teaches nothing, and the next one
   lies halfway to the last that did not slide. */
static inline void update_force_control(ForceSearch *s, const Contact *c, Indenter *in, vint both, real tolerance) {
  vreal p, q;
  resultants(c->n, c->t, &p, &q);
  const vreal z[2] = {in->d, in->x};
  vreal next[2];
  const vint slides = both & (p > 0) & (fabs(q) >= (1 - SLIDING_MARGIN) * in->mu * p);
  in->active &= next_trial(s, z, p, q, in->active & NOT(slides), both, tolerance, next);
  in->held &= NOT(in->active);
  next[1] = PICK(slides, (real)0.5 * (z[1] + s->z[1]), next[1]);
  in->d = PICK(in->active, next[0], in->d);
  in->x = PICK(in->active & both, next[1], in->x);
}

/* Keeps the targets in the search, and puts the indenter where it is, or to a first guess, instead. */
static inline void first_trial(ForceSearch *s, const Indenter *in, const LoadStepping *w, vreal *d, vreal *x) {
  *d = first_depth(s, in->d, w->nearest, *d, *x);
  *x = PICK(w->both, in->x, *x);
}

static inline void reach_forces(const Rules *rules, ForceSearch *s, Contact *c, Indenter *in, LoadStepping *w) {
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
