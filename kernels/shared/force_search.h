// SPDX-License-Identifier: Apache-2.0
/* Search for the indenter's position z = (d, x) that gives the target forces: f = (P - P_target, Q - (Q_target /
   P_target) P) = 0, by Broyden's inverse update (Broyden 1965). Device only. */
#ifndef TACTEL_SHARED_FORCE_SEARCH_H
#define TACTEL_SHARED_FORCE_SEARCH_H

typedef struct {
  vreal b[2][2];    /* inverse Jacobian */
  vreal z[2], g[2]; /* last trial that was learnt from: position; P and Q - (Q_target / P_target) P */
  vreal low, high;  /* bracket of d */
  vreal p_target, q_target;
} ForceSearch;

/* nearest: depth at which the undeformed surface is touched. */
static inline void start_force_search(ForceSearch *s, vreal nearest) {
  s->b[0][0] = (real)0.3; /* thickness / width, about: a start that the first trial corrects */
  s->b[1][1] = 1;
  s->z[0] = nearest;
  s->b[0][1] = s->b[1][0] = s->z[1] = s->g[0] = s->g[1] = 0;
}

/* Takes the targets. Returns the first trial of d: `now`, where the indenter is, or a guess. */
static inline vreal first_depth(ForceSearch *s, vreal now, vreal nearest, vreal p_target, vreal q_target) {
  const vreal guess = PICK(now > nearest, now, fma(s->b[0][0], p_target, nearest));
  s->p_target = p_target;
  s->q_target = q_target;
  s->low = 0;
  s->high = (real)NO_GAP_ELEMENT;
  return PICK(p_target > 0, guess, ALL_LANES(0));
}

/* Inverse update with the trial (z, g) in the given lanes; b is unchanged where the step was too small. */
static inline void broyden_update(ForceSearch *s, const vreal *z, const vreal *g, vint lanes) {
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
  const vreal deeper = PICK(high < (real)NO_GAP_ELEMENT, (real)0.5 * (now + high), 2 * now);
  return PICK(trial >= high, deeper, PICK(trial <= low, (real)0.5 * (now + low), trial));
}

/* Judges the trial z, whose forces are p and q, and learns from it in the lanes of `learns`. both: lanes whose
   tangential target is a force, too. Returns the lanes that miss their targets; next: their next trial. */
static inline vint next_trial(ForceSearch *s, const vreal *z, vreal p, vreal q, vint learns, vint both, real tolerance,
                              vreal *next) {
  const vreal ratio = PICK(both & (s->p_target > 0), s->q_target / s->p_target, ALL_LANES(0));
  const vreal g[2] = {p, PICK(both, fma(-ratio, p, q), ALL_LANES(0))};
  const vreal miss[2] = {p - s->p_target, g[1]};
  const vreal enough = tolerance * s->p_target;
  broyden_update(s, z, g, learns);
  const vreal step[2] = {fma(s->b[0][0], miss[0], s->b[0][1] * miss[1]),
                         fma(s->b[1][0], miss[0], s->b[1][1] * miss[1])};
  s->low = PICK(miss[0] < 0, LARGER(z[0], s->low), s->low);
  s->high = PICK(miss[0] > 0, SMALLER(z[0], s->high), s->high);
  /* P grows with d alone where x is given: keep inside the bracket. With both unknown the bracket moves: bound the
     step instead. */
  const vreal far_d = (real)0.5 * z[0], far_x = LARGER(fabs(z[1]), far_d);
  const vreal bounded = SMALLER(LARGER(z[0] - step[0], z[0] - far_d), z[0] + 2 * far_d);
  next[0] = PICK(both, bounded, bracketed(z[0] - step[0], z[0], s->low, s->high));
  next[1] = SMALLER(LARGER(z[1] - step[1], z[1] - far_x), z[1] + far_x);
  return (fabs(miss[0]) > enough) | (fabs(miss[1]) > enough);
}

#endif
