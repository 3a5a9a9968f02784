// SPDX-License-Identifier: Apache-2.0
/* The profile of the rigid indenter. Device only. */
#ifndef TACTEL_PATCH_PROFILE_H
#define TACTEL_PATCH_PROFILE_H
#include "patch/numbers.h"

#define FAR ((real)NO_GAP_ELEMENT) /* mm: height where there is no indenter or no rubber */

/* The indenter's shape in every lane; kinds that no lane has cost nothing. */
typedef struct {
  global const real *shapes;
  vreal left, right, flat, c[5], radius, exp_height, exp_rate;
  int cylinders, exponentials, terms, points; /* whether any lane has them */
  int term_count[LANES], terms_at[LANES], point_count[LANES], points_at[LANES];
} Profile;

static inline vreal term_heights(const Profile *p, vreal q) {
  vreal sum = 0;
  int most = 0;
  EACH(l, LANES) { most = max(most, p->term_count[l]); }
  for (int k = 0; k < most; ++k) {
    real coefficient[LANES], power[LANES], per_scale[LANES];
    EACH(l, LANES) {
      const int has = k < p->term_count[l];
      global const real *term = p->shapes + p->terms_at[l] + 3 * k;
      coefficient[l] = has ? term[0] : 0;
      power[l] = has ? term[1] : 0;
      per_scale[l] = has ? term[2] : 0;
    }
    vreal square = q * LOAD(per_scale), product = LOAD(coefficient), left = LOAD(power);
    for (int bit = 0; bit < 7; ++bit) {
      const vreal halved = TO_VREAL(TO_VINT(left * (real)0.5));
      product = PICK(left - 2 * halved > (real)0.5, product * square, product);
      square = PICK(halved > 0, square * square, square);
      left = halved;
    }
    sum += product;
  }
  return sum;
}

/* Linear between the points of a measured profile: (x, height, slope to the next). */
static inline vreal point_heights(const Profile *p, vreal x, vreal y) {
  real at[LANES], height[LANES];
  STORE(x, at);
  STORE(y, height);
  for (int l = 0; l < LANES; ++l) {
    if (p->point_count[l] == 0) continue;
    global const real *points = p->shapes + p->points_at[l];
    int low = 0, high = p->point_count[l] - 1;
    while (high - low > 1) {
      const int middle = (low + high) / 2;
      if (points[3 * middle] <= at[l])
        low = middle;
      else
        high = middle;
    }
    height[l] = fma(points[3 * low + 2], at[l] - points[3 * low], points[3 * low + 1]);
  }
  return LOAD(height);
}

/* Height of the profile at x, mm; beyond the limits that of the limit. */
OUTLINE vreal profile_height(const Profile *p, vreal x) {
  x = SMALLER(LARGER(x, p->left), p->right);
  const vreal r = fabs(x), q = LARGER(r - p->flat, ALL_LANES(0));
  vreal y = q * fma(fma(fma(fma(p->c[4], q, p->c[3]), q, p->c[2]), q, p->c[1]), q, p->c[0]);
  if (p->cylinders) {
    const vreal inside = SMALLER(r, p->radius);
    const vreal below = p->radius + sqrt((p->radius - inside) * (p->radius + inside));
    y += PICK(p->radius > 0, inside * inside / below, ALL_LANES(0));
  }
  if (p->exponentials) y = fma(p->exp_height, exp_minus_1(p->exp_rate * r), y);
  if (p->terms) y += term_heights(p, q);
  if (p->points) y = point_heights(p, x, y);
  return SMALLER(y, ALL_LANES(FAR));
}

static inline int store_counts(vreal count, vreal at, int *counts, int *places) {
  real number[LANES], place[LANES];
  STORE(count, number);
  STORE(at, place);
  int any = 0;
  EACH(l, LANES) {
    counts[l] = (int)number[l];
    places[l] = (int)place[l];
    any |= counts[l] > 0;
  }
  return any;
}

static inline void take_profile(const vreal *in, global const real *shapes, Profile *p) {
  p->shapes = shapes;
  p->left = in[PATCH_LEFT];
  p->right = in[PATCH_RIGHT];
  p->flat = in[PATCH_FLAT];
  EACH(k, 5) { p->c[k] = in[PATCH_C1 + k]; }
  p->radius = in[PATCH_RADIUS];
  p->exp_height = in[PATCH_EXP_HEIGHT];
  p->exp_rate = in[PATCH_EXP_RATE];
  p->cylinders = ANY(p->radius > 0);
  p->exponentials = ANY(p->exp_height > 0);
  p->terms = store_counts(in[PATCH_TERMS], in[PATCH_TERMS_AT], p->term_count, p->terms_at);
  p->points = store_counts(in[PATCH_POINTS], in[PATCH_POINTS_AT], p->point_count, p->points_at);
}

#endif
