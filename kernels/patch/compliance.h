// SPDX-License-Identifier: Apache-2.0
/* Elements of the patch: their compliance, and their heights under the indenter. Device only. */
#ifndef TACTEL_PATCH_COMPLIANCE_H
#define TACTEL_PATCH_COMPLIANCE_H
#include "patch/search.h"

#define C_PARTS (FRICTION ? 4 : 1)
#define RELAXATION ((real)0.85)
#define OUTSIDE 3 /* rows beyond each end of the patch that the certificate looks at */

/* Whether elements may be touched within an increment: driven by depth, with a history. */
#define ENTRIES (FRICTION && !FORCE_CONTROL)

/* Compliance of 16 elements is kept once for each pair: dense, it would not fit the first-level cache. */
#define SYMMETRIC (N == 16)
#define PAIRS (N * (N + 1) / 2)
#define PAIR(i, j) ((i) > (j) ? (i) * ((i) + 1) / 2 + (j) : (j) * ((j) + 1) / 2 + (i))

typedef struct {
#if SYMMETRIC
  vreal yy[PAIRS]; /* - C_yy */
#if FRICTION
  vreal xx[PAIRS]; /* - C_xx */
  vreal xy[N][N];  /* C_xy: u_x of the first by f_y of the second, and u_y of the second by f_x of the first */
#endif
#else
  vreal c[N][N][C_PARTS]; /* A, B, D, E */
#endif
  vreal n[N], t[N]; /* pressure and traction force / E, mm */
  vreal n_last[N], t_last[N];
  vreal b[N], bt[N];  /* constant parts of the rows */
  vreal h[N];         /* profile heights, mm */
  vreal wy[N], wx[N]; /* RELAXATION / C_yy[i][i] and C_xx */
  vreal per_wy[N], per_wx[N];
  vreal ux_last[N]; /* wx times u_x at the last increment; of a sticking element what it should have been */
#if ENTRIES
  vreal ux[N], ux_before[N];   /* wx times u_x, as certify found it, and one increment before */
  vreal gap[N], gap_before[N]; /* mm: the same of the gap */
#endif
  vreal outside[2 * OUTSIDE][N][2]; /* u_y of the places beyond the ends, by n and by t */
  vreal h_outside[2 * OUTSIDE];     /* FAR where there is no indenter or no rubber */
} Contact;

/* Compliance of elements at distance k, C[k] of elements to the right of their source. */
typedef struct {
  vreal yy[N + OUTSIDE], xx[N + OUTSIDE], xy[N + OUTSIDE];
} LayerRows;

static inline void layer_rows(const Layer *layer, vreal width, LayerRows *rows) {
  const vreal over_h = width / layer->thickness, per = 1 / over_h, log_width = natural_log(over_h);
  vreal last[3] = {0, 0, 0};
  for (int k = 0; k < N + OUTSIDE; ++k) {
    vreal r[3];
    smooth_integrals(layer, width * ((real)k + (real)0.5), r);
    rows->yy[k] = layer->cy * even_part(log_width, k, r[0], k == 0 ? -r[0] : last[0], per);
    rows->xx[k] = layer->cy * even_part(log_width, k, r[1], k == 0 ? -r[1] : last[1], per);
    rows->xy[k] = k == 0 ? ALL_LANES(0) : layer->cx * fma(r[2] - last[2], per, OF_LANES(layer->jump));
    for (int a = 0; a < 3; ++a) last[a] = r[a];
  }
}

/* Adds the sides' part of u_y by f_y, u_x by f_x, u_x(i) by f_y(j) and u_x(j) by f_y(i). vi: weighted modes of place
   i. */
INLINE void add_sides(const vreal *vi, const vreal *vj, vreal *yy, vreal *xx, vreal *xy, vreal *yx) {
  EACH(m, MODES) {
    *yy = fma(vi[m], vj[m], *yy);
    *xx = fma(vi[MODES + m], vj[MODES + m], *xx);
    *xy = fma(vi[MODES + m], vj[m], *xy);
    *yx = fma(vi[m], vj[MODES + m], *yx);
  }
}

static inline vreal middle_of(const Patch *patch, int i) {
  return fma(patch->element, ALL_LANES((real)i + (real)0.5), patch->origin);
}

/* Index of the places beyond the ends: to the left from the patch on, then to the right. */
static inline int outside_place(int o) { return o < OUTSIDE ? -1 - o : N + o - OUTSIDE; }

/* Rows of the compliance, scaled, and those beyond the ends. */
OUTLINE void build_compliance(const Layer *layer, const Patch *patch, vreal position, Contact *c) {
  LayerRows rows;
  layer_rows(layer, patch->element, &rows);
  vreal v[N][2 * MODES];
  const int sides = layer->side_rows > 0;
  for (int i = 0; i < N; ++i) {
    vreal yy = rows.yy[0], xx = rows.xx[0];
    if (sides) {
      side_modes(layer, position + middle_of(patch, i), v[i]);
      vreal vi[2 * MODES];
      weighted_modes(layer, v[i], vi);
      EACH(m, MODES) {
        yy = fma(vi[m], v[i][m], yy);
        xx = fma(vi[MODES + m], v[i][MODES + m], xx);
      }
    }
    c->wy[i] = RELAXATION / yy;
    c->wx[i] = RELAXATION / xx;
    c->per_wy[i] = yy * (1 / RELAXATION);
    c->per_wx[i] = xx * (1 / RELAXATION);
  }
  for (int i = 0; i < N; ++i) {
    vreal vi[2 * MODES];
    if (sides) weighted_modes(layer, v[i], vi);
    for (int j = 0; j <= i; ++j) {
      vreal yy = rows.yy[i - j], xx = rows.xx[i - j], xy = rows.xy[i - j], yx = -rows.xy[i - j];
      if (sides) add_sides(vi, v[j], &yy, &xx, &xy, &yx);
#if SYMMETRIC
      c->yy[PAIR(i, j)] = -yy;
#if FRICTION
      c->xx[PAIR(i, j)] = -xx;
      c->xy[i][j] = xy;
      c->xy[j][i] = yx;
#endif
#else
      c->c[i][j][0] = -c->wy[i] * yy;
      c->c[j][i][0] = -c->wy[j] * yy;
#if FRICTION
      c->c[i][j][1] = c->wy[i] * yx;
      c->c[j][i][1] = c->wy[j] * xy;
      c->c[i][j][2] = c->wx[i] * xy;
      c->c[j][i][2] = c->wx[j] * yx;
      c->c[i][j][3] = -c->wx[i] * xx;
      c->c[j][i][3] = -c->wx[j] * xx;
#endif
#endif
    }
#if !SYMMETRIC
    c->c[i][i][0] = 1 - RELAXATION;
#if FRICTION
    c->c[i][i][3] = 1 - RELAXATION;
#endif
#endif
  }
  for (int o = 0; o < 2 * OUTSIDE; ++o) {
    const int place = outside_place(o);
    vreal vo[2 * MODES], weighted_vo[2 * MODES];
    if (sides) {
      side_modes(layer, position + middle_of(patch, place), vo);
      weighted_modes(layer, vo, weighted_vo);
    }
    for (int j = 0; j < N; ++j) {
      const int k = place < j ? j - place : place - j;
      vreal yy = rows.yy[k], yx = place < j ? rows.xy[k] : -rows.xy[k];
      if (sides) EACH(m, MODES) {
          yy = fma(weighted_vo[m], v[j][m], yy);
          yx = fma(weighted_vo[m], v[j][MODES + m], yx);
        }
      c->outside[o][j][0] = -yy;
      c->outside[o][j][1] = yx;
    }
  }
}

/* Returns the lowest height of an element. */
static inline vreal put_heights(const Profile *profile, const Patch *patch, Contact *c) {
  vreal lowest = FAR;
  for (int i = 0; i < N; ++i) {
    c->h[i] = profile_height(profile, middle_of(patch, i));
    lowest = SMALLER(c->h[i], lowest);
  }
  for (int o = 0; o < 2 * OUTSIDE; ++o) {
    const vreal x = middle_of(patch, outside_place(o));
    c->h_outside[o] = PICK((x >= profile->left) & (x <= profile->right), profile_height(profile, x), ALL_LANES(FAR));
  }
  return lowest;
}

#endif
