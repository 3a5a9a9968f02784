// SPDX-License-Identifier: Apache-2.0
/* The contact laws at every element, checked from the forces alone. Device only. */
#ifndef TACTEL_PATCH_CERTIFICATE_H
#define TACTEL_PATCH_CERTIFICATE_H
#include "patch/sweep.h"

/* Relative figures of fem/gap/contact_solution.h and the slip distance, mm, from the final forces alone. */
typedef struct {
  vreal penetration, cone, complementarity, drift, slip_distance;
  vreal largest_uy;
  vint sticks, slips; /* whether any element does */
} Certificate;

/* The contact laws at every element, from the forces alone, and the history for the next increment. A sticking element
   counts as having followed the indenter: what convergence left of it is then made good by the next increment instead
   of adding up over thousands of them. */
OUTLINE void certify(Contact *c, const Indenter *in, Certificate *k) {
  vreal largest_uy = 0, largest_n = 0, finite = 0;
  k->sticks = k->slips = 0;
  k->penetration = k->cone = k->complementarity = k->drift = k->slip_distance = 0;
  vreal all_n[N], all_t[N];
  EACH(i, N) {
    all_n[i] = c->n[i];
    all_t[i] = c->t[i];
  }
  ROLLED for (int i = 0; i < N; ++i) {
    vreal n_sum, t_sum;
    row_sums(c, all_n, all_t, i, &n_sum, &t_sum);
    const vreal n = c->n[i], t = c->t[i], cone = in->mu * n;
    const vint pressed = n > 0, sticks = pressed & (fabs(t) < cone);
    k->sticks |= sticks;
    k->slips |= pressed & NOT(sticks);
    const vreal uy = (n_sum - n) * c->per_wy[i];
    const vreal inside = uy - (c->h[i] - in->d);
#if ENTRIES
    c->gap_before[i] = c->gap[i];
    c->gap[i] = -inside;
#endif
    k->penetration = LARGER(inside, k->penetration);
    k->complementarity = LARGER(PICK(pressed, fabs(inside), ALL_LANES(0)), k->complementarity);
    largest_uy = LARGER(fabs(uy), largest_uy);
    largest_n = LARGER(n, largest_n);
    finite = finite_sum(finite, uy);
#if FRICTION
    const vreal per_wx = c->per_wx[i];
    const vreal ux = t - t_sum; /* wx times u_x */
    const vreal slip = PICK(in->held, ALL_LANES(0), (ux - c->bt[i]) * per_wx);
    const vreal along =
        PICK(t > 0, slip, PICK(t < 0, -slip, ALL_LANES(0))); /* slip with friction instead of against it */
    const vreal drift = PICK(pressed, PICK(fabs(t) < cone, fabs(slip), along), ALL_LANES(0));
    const vreal slid = PICK(pressed, fabs(fma(ux, per_wx, -in->x)), ALL_LANES(0));
    c->ux_last[i] = PICK(sticks, c->bt[i], ux);
#if ENTRIES
    c->ux_before[i] = c->ux[i];
    c->ux[i] = ux;
#endif
    k->drift = LARGER(drift, k->drift);
    k->cone = LARGER(fabs(t) - cone, k->cone);
    k->slip_distance = LARGER(slid, k->slip_distance);
    finite = finite_sum(finite, ux);
#else
    (void)t_sum;
    k->slip_distance = PICK(largest_n > 0, fabs(in->x), ALL_LANES(0));
#endif
  }
  k->largest_uy = largest_uy;
  const vreal per_uy = PICK(largest_uy > 0, 1 / largest_uy, ALL_LANES(0));
  k->penetration = fma(k->penetration, per_uy, finite);
  k->complementarity *= per_uy;
  k->drift *= per_uy;
  k->cone *= PICK(largest_n > 0, 1 / largest_n, ALL_LANES(0));
}

static inline void resultants(const vreal *n, const vreal *t, vreal *p, vreal *q) {
  *p = *q = 0;
  for (int i = 0; i < N; ++i) {
    *p += n[i];
    if (FRICTION) *q += t[i];
  }
}

#endif
