// SPDX-License-Identifier: Apache-2.0
/* How an increment starts, and what friction remembers of it. Device only. */
#ifndef TACTEL_PAD_INCREMENT_H
#define TACTEL_PAD_INCREMENT_H
#include "pad/sweep.h"

#define FIRST_DEPTH ((real)0.05) /* tried first for a force */
#define NO_BOUND ((real)1e30)

/* Where an increment ends. */
typedef struct {
  Lanes normal, x, y, twist; /* as PadPathRow */
} Target;

/* How far the indenter would be above the rubber if nothing pressed. */
static inline void set_open(const Influence *influence, global const vreal *heights, const State *s, int i, int v,
                            Cells *c) {
  c->open[i].v[v] = (HEIGHT(heights, v, i) - s->d.v[v]) / influence->root_zz;
  if (CREEPING) c->open[i].v[v] -= CREPT(c, 2, i, v);
}

/* The next target, the first guess and the window. Lanes without a next target, or that it leaves where they are, do
   not solve. */
OUTLINE void start_increment(const Influence *influence, const Target *target, global const vreal *heights, Cells *c,
                             State *s, Masks *solving) {
  Lanes ratio, dx, dy, dtwist, touches;
  EACH_VECTOR(v) {
    const vint running = s->running.v[v];
    const vint by_force = running & s->by_force.v[v];
    const vreal normal = PICK(running, target->normal.v[v], s->d.v[v]), P = pressing(influence, c, v);
    const vreal first = PICK(P > 0, s->d.v[v] * depth_factor(normal / LARGER(P, ALL_LANES((real)1e-30)), s->power.v[v]),
                             ALL_LANES(FIRST_DEPTH));
    const vreal d = PICK(by_force, PICK(normal > 0, first, ALL_LANES(0)), normal);
    s->searching.v[v] = by_force & (normal > 0);
    s->target.v[v] = normal;
    s->low.v[v] = s->last_d.v[v] = s->last_P.v[v] = s->trials.v[v] = s->trial_sweeps.v[v] = 0;
    s->high.v[v] = NO_BOUND;
    dx.v[v] = PICK(running, target->x.v[v], s->x.v[v]) - s->x.v[v];
    dy.v[v] = PICK(running, target->y.v[v], s->y.v[v]) - s->y.v[v];
    dtwist.v[v] = PICK(running, target->twist.v[v], s->twist.v[v]) - s->twist.v[v];
    const vreal change_d = d - s->d.v[v], change_twist = s->half_size * dtwist.v[v];
    const vint anew = STEPPED ? running & s->anew.v[v] : CREEPING ? running : (vint)(0);
    const vint moves =
        anew | s->searching.v[v] | (running & ((change_d != 0) | (dx.v[v] != 0) | (dy.v[v] != 0) | (dtwist.v[v] != 0)));
    const vreal along =
        fma(change_d, s->change_d.v[v],
            fma(dx.v[v], s->change_x.v[v], fma(dy.v[v], s->change_y.v[v], change_twist * s->change_twist.v[v])));
    const vreal last = fma(s->change_d.v[v], s->change_d.v[v],
                           fma(s->change_x.v[v], s->change_x.v[v],
                               fma(s->change_y.v[v], s->change_y.v[v], s->change_twist.v[v] * s->change_twist.v[v])));
    ratio.v[v] = PICK(last > 0, SMALLER(LARGER(along / last, ALL_LANES(0)), ALL_LANES(2)), ALL_LANES(0));
    solving->v[v] = s->active.v[v] = moves;
    s->failed.v[v] = 0;
    s->sweeps.v[v] = 0;
    s->tolerance.v[v] = s->first_tolerance.v[v];
    s->d.v[v] = d;
    s->x.v[v] += dx.v[v];
    s->y.v[v] += dy.v[v];
    s->twist.v[v] += dtwist.v[v];
    s->change_d.v[v] = PICK(running, change_d, s->change_d.v[v]);
    s->change_x.v[v] = PICK(running, dx.v[v], s->change_x.v[v]);
    s->change_y.v[v] = PICK(running, dy.v[v], s->change_y.v[v]);
    s->change_twist.v[v] = PICK(running, change_twist, s->change_twist.v[v]);
    touches.v[v] = PICK(d > s->lowest.v[v], ALL_LANES(1), ALL_LANES(0));
  }
  ROLLED for (int i = 0; i < COUNT; ++i) EACH_VECTOR(v) {
    const vint moves = solving->v[v];
    const side per_tt = 1 / influence->root_tt;
    const vreal n0 = c->n[i].v[v], x0 = c->tx[i].v[v], y0 = c->ty[i].v[v], r = ratio.v[v];
    const vreal n = touches.v[v] * LARGER(fma(r, n0 - c->n_last[i].v[v], n0), ALL_LANES(0));
    vreal x = fma(r, x0 - c->tx_last[i].v[v], x0), y = fma(r, y0 - c->ty_last[i].v[v], y0);
    const vreal cone = MU(i, v) * n, q = fma(x, x, y * y);
    const vint outside = q > cone * cone;
    const vreal shorter = cone / sqrt(q);
    x = PICK(outside, x * shorter, x);
    y = PICK(outside, y * shorter, y);
    c->n_last[i].v[v] = PICK(moves, n0, c->n_last[i].v[v]);
    c->tx_last[i].v[v] = PICK(moves, x0, c->tx_last[i].v[v]);
    c->ty_last[i].v[v] = PICK(moves, y0, c->ty_last[i].v[v]);
    c->n[i].v[v] = PICK(moves, n, n0);
    c->tx[i].v[v] = PICK(moves, x, x0);
    c->ty[i].v[v] = PICK(moves, y, y0);
    set_open(influence, heights, s, i, v, c);
    c->gx[i].v[v] =
        fma(dx.v[v] - dtwist.v[v] * (s->y_middle.v[v] + y_of(influence, i)), ALL_LANES(per_tt), c->gx[i].v[v]);
    c->gy[i].v[v] =
        fma(dy.v[v] + dtwist.v[v] * (s->x_middle.v[v] + x_of(influence, i)), ALL_LANES(per_tt), c->gy[i].v[v]);
    const vint pressed = (c->n[i].v[v] > 0) | (moves & (touches.v[v] > 0) & (c->open[i].v[v] < c->uz[i].v[v]));
    c->window[i].v[v] = pressed;
  }
}

/* Ends an increment: where a cell sticks from next. */
static void remember(Cells *c, const State *s) {
  ROLLED for (int k = 0; k < SUMMED(c); ++k) EACH_VECTOR(v) {
    const int i = CELL_SUMMED(c, k);
    const vreal x = c->tx[i].v[v], y = c->ty[i].v[v], cone = INSIDE_CONE * MU(i, v) * c->n[i].v[v];
    const vint sticks = (c->n[i].v[v] > 0) & (fma(x, x, y * y) < cone * cone);
    c->gx[i].v[v] = PICK(sticks, c->gx[i].v[v], c->ux[i].v[v]);
    c->gy[i].v[v] = PICK(sticks, c->gy[i].v[v], c->uy[i].v[v]);
  }
}

#endif
