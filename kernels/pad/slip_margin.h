// SPDX-License-Identifier: Apache-2.0
/* The slip index of a pad. Device only. */
#ifndef TACTEL_PAD_SLIP_MARGIN_H
#define TACTEL_PAD_SLIP_MARGIN_H
#include "pad/cells.h"

#define MARGIN_ROUNDS 4

/* S = 1 / lambda of fem/pad/slip_margin.h for vector v under a wrench, M about the middle of the cells: in the unit of the
   tractions as they are scaled, as the grip is. */
OUTLINE vreal margin_of(const Influence *influence, const Cells *c, const State *s, int v, vreal Wx, vreal Wy,
                        vreal M) {
  vreal grip = 0, centre_x = 0, centre_y = 0, r2 = 0;
  for (int k = 0; k < c->listed; ++k) {
    const int i = c->list[k];
    const vreal g = MU(i, v) * c->n[i].v[v];
    const side x = x_of(influence, i), y = y_of(influence, i);
    grip += g;
    centre_x = fma(g, ALL_LANES(x), centre_x);
    centre_y = fma(g, ALL_LANES(y), centre_y);
    r2 = fma(g, ALL_LANES(x * x + y * y), r2);
  }
  const vreal per_grip = 1 / LARGER(grip, ALL_LANES((real)1e-30));
  centre_x *= per_grip;
  centre_y *= per_grip;
  const vreal gyration2 = r2 * per_grip - fma(centre_x, centre_x, centre_y * centre_y);
  const vreal length = sqrt(LARGER(gyration2, ALL_LANES((real)1e-6 * influence->hx * influence->hy))),
              per_length = 1 / length;
  Wx *= per_grip;
  Wy *= per_grip;
  M = (M * per_grip - (centre_x * Wy - centre_y * Wx)) * per_length;
  const vreal W2 = fma(Wx, Wx, fma(Wy, Wy, M * M));
  const vint bears = (grip > 0) & (W2 > (real)1e-12);
  const vreal per_W2 = 1 / PICK(bears, W2, ALL_LANES(1));
  vreal vx = Wx * per_W2, vy = Wy * per_W2, w = M * per_W2, least = (real)1e30;
  for (int round = 0; round <= MARGIN_ROUNDS; ++round) {
    vreal lambda = 0, K = 0, Kx = 0, Ky = 0, Kw = 0;
    for (int k = 0; k < c->listed; ++k) {
      const int i = c->list[k];
      const vreal g = MU(i, v) * c->n[i].v[v] * per_grip;
      const vreal x = (x_of(influence, i) - centre_x) * per_length, y = (y_of(influence, i) - centre_y) * per_length;
      const vreal sx = fma(-w, y, vx), sy = fma(w, x, vy), slip = sqrt(fma(sx, sx, sy * sy));
      const vreal weight = g / LARGER(slip, ALL_LANES((real)1e-6));
      lambda = fma(g, slip, lambda);
      K += weight;
      Kx = fma(weight, x, Kx);
      Ky = fma(weight, y, Ky);
      Kw = fma(weight, fma(x, x, y * y), Kw);
    }
    least = SMALLER(lambda, least);
    /* K v - Ky w = Wx, K v + Kx w = Wy, eliminated: */
    const vreal per_K = 1 / LARGER(K, ALL_LANES((real)1e-30));
    const vreal inertia = LARGER(Kw - (Kx * Kx + Ky * Ky) * per_K, ALL_LANES((real)1e-6));
    w = (M + (Ky * Wx - Kx * Wy) * per_K) / inertia;
    vx = (Wx + Ky * w) * per_K;
    vy = (Wy - Kx * w) * per_K;
    const vreal power = fma(vx, Wx, fma(vy, Wy, w * M)), per_power = 1 / PICK(bears, power, ALL_LANES(1));
    vx *= per_power;
    vy *= per_power;
    w *= per_power;
  }
  return PICK(bears, 1 / least, ALL_LANES(0));
}

/* That of the tractions. */
static vreal slip_margin(const Influence *influence, const Cells *c, const State *s, int v) {
  vreal Wx = 0, Wy = 0, M = 0;
  for (int k = 0; k < c->listed; ++k) {
    const int i = c->list[k];
    const side x = x_of(influence, i), y = y_of(influence, i);
    Wx += c->tx[i].v[v];
    Wy += c->ty[i].v[v];
    M = fma(ALL_LANES(x), c->ty[i].v[v], fma(ALL_LANES(-y), c->tx[i].v[v], M));
  }
  return SMALLER(ALL_LANES(1), margin_of(influence, c, s, v, Wx, Wy, M)); /* which it is but for rounding */
}

#endif
