// SPDX-License-Identifier: Apache-2.0
/* Gauss-Seidel sweeps over the elements. Device only. */
#ifndef TACTEL_PATCH_SWEEP_H
#define TACTEL_PATCH_SWEEP_H
#include "patch/compliance.h"

#define DAMPED_AFTER 60

/* Where the indenter is, and which lanes iterate. */
typedef struct {
  vreal mu, d, x, x_last; /* mm */
  vint active;
  vint held; /* lanes that are where they were at the last increment */
} Indenter;

typedef struct {
  real tolerance;
  int most_sweeps;
} Rules;

/* Rows are unrolled up to 16 elements; more would not fit the compiler's limits, and C is in the second-level cache
   there. A row's sums start at its own element when unrolled: the one that was updated last comes last, and its latency
   hides behind the others. */
#if N <= 16
#define EACH_ROW(i) EACH(i, N)
#define COLUMN(i, k) (((i) + (k)) % N)
#define OWN(k, factor) \
  (!SYMMETRIC && (k) == 0 ? ALL_LANES(1 - RELAXATION) : (factor)) /* of the element itself it needs no load */
#else
#define EACH_ROW(i) ROLLED for (int i = 0; i < N; ++i)
#define COLUMN(i, k) (k)
#define OWN(k, factor) (factor)
#endif

/* Factors of n_j and t_j in the rows of element i, and what finishes a row: its sum becomes the free force without the
   constant part. */
#if SYMMETRIC
#define N_BY_N(c, i, j) (c)->yy[PAIR(i, j)]
#define N_BY_T(c, i, j) (c)->xy[j][i]
#define T_BY_N(c, i, j) (c)->xy[i][j]
#define T_BY_T(c, i, j) (c)->xx[PAIR(i, j)]
#define FINISH_N(c, i, sum, n_old) fma((c)->wy[i], sum, n_old)
#define FINISH_T(c, i, sum, t_old) fma((c)->wx[i], sum, t_old)
#define START(constant) ALL_LANES(0)
#define CONSTANT(constant) (constant)
#else
#define N_BY_N(c, i, j) (c)->c[i][j][0]
#define N_BY_T(c, i, j) (c)->c[i][j][1]
#define T_BY_N(c, i, j) (c)->c[i][j][2]
#define T_BY_T(c, i, j) (c)->c[i][j][3]
#define FINISH_N(c, i, sum, n_old) (sum)
#define FINISH_T(c, i, sum, t_old) (sum)
#define START(constant) (constant)
#define CONSTANT(constant) ALL_LANES(0)
#endif

/* One Gauss-Seidel sweep. Returns the active lanes whose largest change was above tolerance times their largest
   pressure force. Forces are in registers up to 12 elements; those of the last sweep stay in memory until all rows are
   done, and the change is found then. */
INLINE vint sweep(Contact *c, const Indenter *in, vreal tolerance) {
  vreal n[N], t[N];
  EACH(i, N) {
    n[i] = c->n[i];
    t[i] = FRICTION ? c->t[i] : ALL_LANES(0);
  }
  vreal late = t[0];
  EACH_ROW(i) {
    vreal yn = START(c->b[i]);
    const vreal n_old = n[i];
#if FRICTION
    vreal yt = 0, xn = START(c->bt[i]), xt = 0;
    const vreal t_old = t[i];
    EACH(k, N) {
      const int j = COLUMN(i, k);
      yn = fma(OWN(k, N_BY_N(c, i, j)), n[j], yn);
      yt = fma(N_BY_T(c, i, j), t[j], yt);
    }
    if (i > 0) t[i - 1] = late;
    EACH(k, N) {
      const int j = COLUMN(i, k);
      xn = fma(T_BY_N(c, i, j), n[j], xn);
      xt = fma(OWN(k, T_BY_T(c, i, j)), t[j], xt);
    }
    const vreal n_free = FINISH_N(c, i, yn + yt, n_old + CONSTANT(c->b[i]));
    n[i] = PICK(in->active, LARGER(n_free, ALL_LANES(0)), n_old);
    const vreal t_free = FINISH_T(c, i, fma(T_BY_N(c, i, i), n[i] - n_old, xn + xt), t_old + CONSTANT(c->bt[i]));
    const vreal cone = in->mu * n[i];
    late = PICK(in->active, SMALLER(LARGER(t_free, -cone), cone), t_old);
#else
    vreal odd = 0;
    EACH(k, N / 2) {
      const int j = COLUMN(i, 2 * k), next = COLUMN(i, 2 * k + 1);
      yn = fma(N_BY_N(c, i, j), n[j], yn);
      odd = fma(N_BY_N(c, i, next), n[next], odd);
    }
    const vreal n_free = FINISH_N(c, i, yn + odd, n_old + CONSTANT(c->b[i]));
    n[i] = PICK(in->active, LARGER(n_free, ALL_LANES(0)), n_old);
#endif
#if N > 12
    ROW_BARRIER;
#endif
  }
  t[N - 1] = late;
  ROW_BARRIER;
  vreal change = 0, largest = 0;
  EACH(i, N) {
    change = LARGER(change, fabs(n[i] - c->n[i]));
    largest = LARGER(largest, n[i]);
    c->n[i] = n[i];
    if (FRICTION) {
      change = LARGER(change, fabs(t[i] - c->t[i]));
      c->t[i] = t[i];
    }
  }
  return in->active & (change > tolerance * largest);
}

/* Free forces of element i from the forces n and t, without the constant parts. */
INLINE void row_sums(const Contact *c, const vreal *n, const vreal *t, int i, vreal *n_sum, vreal *t_sum) {
  vreal yn = 0, yt = 0, xn = 0, xt = 0;
  EACH(j, N) {
    yn = fma(N_BY_N(c, i, j), n[j], yn);
#if FRICTION
    yt = fma(N_BY_T(c, i, j), t[j], yt);
    xn = fma(T_BY_N(c, i, j), n[j], xn);
    xt = fma(T_BY_T(c, i, j), t[j], xt);
#endif
  }
  (void)t;
  *n_sum = FINISH_N(c, i, yn + yt, c->n[i]);
  *t_sum = FINISH_T(c, i, xn + xt, c->t[i]);
}

/* The same sweep with steps shortened to `part`, in a loop: it is rare. */
static inline vint damped_sweep(Contact *c, const Indenter *in, real part, vreal tolerance) {
  vreal change = 0, largest = 0, late = 0;
  for (int i = 0; i < N; ++i) {
    const vreal n_old = c->n[i];
    vreal n_sum, t_sum;
    row_sums(c, c->n, c->t, i, &n_sum, &t_sum);
    const vreal n_part = fma(part, (c->b[i] + n_sum) - n_old, n_old);
    const vreal n = PICK(in->active, LARGER(n_part, ALL_LANES(0)), n_old);
    c->n[i] = n;
    change = LARGER(change, fabs(n - n_old));
    largest = LARGER(largest, n);
#if FRICTION
    if (i > 0) c->t[i - 1] = late;
    row_sums(c, c->n, c->t, i, &n_sum, &t_sum);
    const vreal t_old = c->t[i], cone = in->mu * n;
    const vreal t_part = fma(part, (c->bt[i] + t_sum) - t_old, t_old);
    late = PICK(in->active, SMALLER(LARGER(t_part, -cone), cone), t_old);
    change = LARGER(change, fabs(late - t_old));
#endif
  }
  if (FRICTION) c->t[N - 1] = late;
  return in->active & (change > tolerance * largest);
}

/* Sweeps until every active lane has converged. Leaves in in->active the lanes that ran out of sweeps. */
OUTLINE void iterate(const Rules *rules, Contact *c, Indenter *in, vreal *sweeps) {
  const vreal tolerance = FRICTION ? sweep_tolerance(rules->tolerance, in->mu) : ALL_LANES(rules->tolerance);
  int k = 0;
  for (; k < min(rules->most_sweeps, DAMPED_AFTER) && ANY(in->active); ++k) {
    *sweeps += PICK(in->active, ALL_LANES(1), ALL_LANES(0));
    in->active = sweep(c, in, tolerance);
  }
  for (; k < rules->most_sweeps && ANY(in->active); ++k) {
    *sweeps += PICK(in->active, ALL_LANES(1), ALL_LANES(0));
    in->active = damped_sweep(c, in, k < 4 * DAMPED_AFTER ? (real)0.5 : (real)0.2, tolerance);
  }
}

#endif
