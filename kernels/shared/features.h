// SPDX-License-Identifier: Apache-2.0
/* The fixed layer of networks with features, with frames in the lanes: nn/features.h, operation by operation. Device
   only. Built with -D FEATURES (1: line, 2: pad), SHOWN (scaled frames), GRID_COLUMNS, GRID_ROWS (tactels along x and y),
   SQUARE (1: they lie along x as along y), RESTED (1: there is no peak). */
#ifndef TACTEL_SHARED_FEATURES_H
#define TACTEL_SHARED_FEATURES_H

#define FEATURES_PAD (FEATURES == 2)
#define GRID_TACTELS (GRID_COLUMNS * GRID_ROWS)
#define FEATURE_AXES (FEATURES_PAD ? 3 : 2)
#define FEATURE_SUMS (FEATURES_PAD ? 17 : 8)

INLINE void swap_where(vint where, vreal *a, vreal *b) {
  const vreal was = *a;
  *a = PICK(where, *b, *a);
  *b = PICK(where, was, *b);
}

/* Brings all frames to the image that the newest frame's Q chooses. */
INLINE void make_canonical(int v, vreal (*x)[FRAME_VECTORS]) {
  vreal qx = 0, qy = 0;
  ROLLED for (int k = 0; k < GRID_TACTELS; ++k) qx = qx + x[GRID_TACTELS + k][v];
#if FEATURES_PAD
  ROLLED for (int k = 0; k < GRID_TACTELS; ++k) qy = qy + x[2 * GRID_TACTELS + k][v];
#endif
  const vint to_left = qx < ALL_LANES(0), downward = qy < ALL_LANES(0);
  ROLLED for (int frame = 0; frame < SHOWN; ++frame, x += FRAME_NUMBERS) {
    ROLLED for (int row = 0; row < FEATURE_AXES * GRID_ROWS; ++row) {
      for (int i = 0; i < GRID_COLUMNS / 2; ++i)
        swap_where(to_left, &x[row * GRID_COLUMNS + i][v], &x[row * GRID_COLUMNS + GRID_COLUMNS - 1 - i][v]);
    }
    ROLLED for (int k = GRID_TACTELS; k < 2 * GRID_TACTELS; ++k) x[k][v] = PICK(to_left, -x[k][v], x[k][v]);
#if FEATURES_PAD
    ROLLED for (int plane = 0; plane < 3; ++plane) {
      for (int k = 0; k < GRID_ROWS / 2 * GRID_COLUMNS; ++k)
        swap_where(downward, &x[plane * GRID_TACTELS + k][v],
                   &x[plane * GRID_TACTELS + (GRID_ROWS - 1 - k / GRID_COLUMNS) * GRID_COLUMNS + k % GRID_COLUMNS][v]);
    }
    ROLLED for (int k = 2 * GRID_TACTELS; k < 3 * GRID_TACTELS; ++k) x[k][v] = PICK(downward, -x[k][v], x[k][v]);
#if SQUARE
    const vint turn = fabs(qy) > fabs(qx);
    ROLLED for (int plane = 0; plane < 3; ++plane) {
      for (int j = 0; j < GRID_ROWS; ++j)
        for (int i = 0; i < j; ++i)
          swap_where(turn, &x[plane * GRID_TACTELS + j * GRID_COLUMNS + i][v],
                     &x[plane * GRID_TACTELS + i * GRID_COLUMNS + j][v]);
    }
    ROLLED for (int k = GRID_TACTELS; k < 2 * GRID_TACTELS; ++k) swap_where(turn, &x[k][v], &x[k + GRID_TACTELS][v]);
#endif
#endif
  }
}

#if FEATURES_PAD
#define SHEAR_OF(k)                                          \
  sqrt(x[GRID_TACTELS + (k)][v] * x[GRID_TACTELS + (k)][v] + \
       x[2 * GRID_TACTELS + (k)][v] * x[2 * GRID_TACTELS + (k)][v])
#else
#define SHEAR_OF(k) fabs(x[GRID_TACTELS + (k)][v])
#endif

/* The sums of one frame x into out, [FEATURE_SUMS]. */
INLINE void put_sums(int v, const vreal (*x)[FRAME_VECTORS], vreal (*out)[FRAME_VECTORS]) {
  const vreal zero = 0, least = ALL_LANES(LEAST_DIVISOR);
  const real middle_x = (real)(GRID_COLUMNS - 1) / 2, middle_y = (real)(GRID_ROWS - 1) / 2;
  vreal P = 0, Qx = 0, Qy = 0, w = 0, wx = 0, wy = 0, T = 0;
  ROLLED for (int k = 0; k < GRID_TACTELS; ++k) {
    const vreal p = LARGER(-x[k][v], zero);
    P = P - x[k][v];
    w = w + p;
    wx = wx + p * ALL_LANES((real)(k % GRID_COLUMNS) - middle_x);
    wy = wy + p * ALL_LANES((real)(k / GRID_COLUMNS) - middle_y);
    Qx = Qx + x[GRID_TACTELS + k][v];
#if FEATURES_PAD
    Qy = Qy + x[2 * GRID_TACTELS + k][v];
#endif
    T = T + SHEAR_OF(k);
  }
  const vreal by_p = LARGER(P, least), by_w = LARGER(w, least), by_t = LARGER(T, least);
  const vreal cx = wx / by_w, cy = wy / by_w;
  vreal pxx = 0, txx = 0, ax = 0;
#if FEATURES_PAD
  const vreal q = sqrt(Qx * Qx + Qy * Qy), by_q = LARGER(q, least);
  const vreal ux = Qx / by_q, uy = Qy / by_q;
  vreal M = 0, pyy = 0, pxy = 0, tyy = 0, ay = 0;
#endif
  ROLLED for (int k = 0; k < GRID_TACTELS; ++k) {
    const vreal dx = ALL_LANES((real)(k % GRID_COLUMNS) - middle_x) - cx;
    const vreal p = LARGER(-x[k][v], zero), t = SHEAR_OF(k), tx = x[GRID_TACTELS + k][v];
    pxx = pxx + p * dx * dx;
    txx = txx + t * dx * dx;
#if FEATURES_PAD
    const vreal dy = ALL_LANES((real)(k / GRID_COLUMNS) - middle_y) - cy, ty = x[2 * GRID_TACTELS + k][v];
    M = M + (dx * ty - dy * tx);
    pyy = pyy + p * dy * dy;
    pxy = pxy + p * dx * dy;
    tyy = tyy + t * dy * dy;
    const vreal along = tx * ux + ty * uy;
    ax = ax + along * dx;
    ay = ay + along * dy;
#else
    ax = ax + tx * dx;
#endif
  }
#if FEATURES_PAD
  const vreal all[FEATURE_SUMS] = {P,        Qx,         Qy,         q / by_p,   Qx / by_p,  Qy / by_p,
                                   M / by_p, cx,         cy,         pxx / by_w, pyy / by_w, pxy / by_w,
                                   T / by_p, txx / by_t, tyy / by_t, ax,         ay};
#else
  (void)Qy, (void)wy, (void)cy;
  const vreal all[FEATURE_SUMS] = {P, Qx, Qx / by_p, cx, pxx / by_w, T / by_p, txx / by_t, ax};
#endif
  ROLLED for (int k = 0; k < FEATURE_SUMS; ++k) out[k][v] = all[k];
}

/* From scaled frames to their image, its sums and the share of the peak [MPa] in itself and the usual one. */
INLINE void add_features(int v, vreal peak, real usual, vreal (*x)[FRAME_VECTORS]) {
  make_canonical(v, x);
  ROLLED for (int frame = 0; frame < SHOWN; ++frame)
      put_sums(v, x + frame * FRAME_NUMBERS, x + SHOWN * FRAME_NUMBERS + frame * FEATURE_SUMS);
#if RESTED
  (void)peak, (void)usual;
#else
  x[INPUTS - TOLD - 1][v] = peak / (peak + ALL_LANES(usual));
#endif
}

#endif
