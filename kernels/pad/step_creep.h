// SPDX-License-Identifier: Apache-2.0
/* Steps of rubber that creeps (fem/pad/creep.h): what is done before and after the contact of a step, which is an elastic
   one on heights above what has crept, with tractions that are `softer` times larger. Device only. */
#ifndef TACTEL_PAD_STEP_CREEP_H
#define TACTEL_PAD_STEP_CREEP_H
#include "pad/nearby.h"
#include "pad/splitting.h"

/* What number k of a cell has crept to, of x, y, z, and its tractions: `w` is its memory. */
static inline vreal crept_to(global const real *creep, global const vreal *w, int k) {
  vreal m = 0;
  EACH(t, CREEP_TERMS) {
    global const real *number = creep + 1 + CREEP_NUMBERS * t;
    const vreal v = w[(CREEP_FIELDS * (1 + t) + k) * COUNT];
    m = fma(ALL_LANES(number[CREEP_C]), v + (number[CREEP_LAST] * w[k * COUNT] - number[CREEP_FADES] * v), m);
  }
  return m;
}

/* Field by field: few streams at once. Returns the heights of the step, in the place of STEP_UZ. */
OUTLINE global const vreal *begin_creep(const Influence *influence, global const real *creep,
                                        global const vreal *heights, global vreal *state) {
  global vreal *crept = state + STEP_UZ * COUNT;
  ROLLED for (int v = 0; v < VECTORS; ++v) {
    global vreal *own = state + v * STATE_ROWS, *w = own + CREEP_AT;
    ROLLED for (int i = 0; i < 2 * COUNT; ++i) own[STEP_GX * COUNT + i] -= crept_to(creep, w + i % COUNT, i / COUNT);
    ROLLED for (int i = 0; i < COUNT; ++i) {
      const vreal h = heights[v * COUNT + i];
      crept[v * STATE_ROWS + i] = PICK(h >= PAD_OPEN, h, h - crept_to(creep, w + i, 2) * influence->root_zz);
    }
  }
  return crept;
}

/* What all cells remember, after the step is stored. Where cells near any indenter are, it has summed, but those that
   split contacts have elsewhere. A contact that is not valid stays under its tractions. */
OUTLINE void end_creep(const Influence *influence, global const real *creep, const Split *split, Cells *c,
                       const State *s, global vreal *state) {
  const real softer = creep[0], stiffer = 1 / softer;
  list_pressing(c);
  ROLLED for (int i = 0; i < COUNT; ++i) {
    const vint known = any_of(&c->near[i]) ? ~(vint)0 : (vint)0;
    Lanes u[3];
    Masks asks;
    EACH_VECTOR(v) { asks.v[v] = NOT(c->near[i].v[v] | (known & NOT(split->wide.v[v]))); }
    if (!any_of(&asks)) continue;
    displacement(influence, c, i / CELLS_Y, i % CELLS_Y, &u[0], &u[1], &u[2]);
    add_own(c, i, &u[0], &u[1], &u[2]);
    EACH_VECTOR(v) {
      c->gx[i].v[v] = PICK(asks.v[v], u[0].v[v], c->gx[i].v[v]);
      c->gy[i].v[v] = PICK(asks.v[v], u[1].v[v], c->gy[i].v[v]);
      c->uz[i].v[v] = PICK(asks.v[v], u[2].v[v], c->uz[i].v[v]);
    }
  }
  ROLLED for (int v = 0; v < VECTORS; ++v, state += STATE_ROWS) {
    const vint valid = s->valid.v[v];
    ROLLED for (int k = 0; k < CREEP_FIELDS; ++k) {
      const Lanes *summed = k == 0 ? c->gx : k == 1 ? c->gy : k == 2 ? c->uz : k == 3 ? c->n : k == 4 ? c->tx : c->ty;
      const int to = k < 2 ? (STEP_GX + k) * COUNT : STRAINING_AT + (k - 3) * COUNT;
      ROLLED for (int i = 0; i < COUNT; ++i) {
        global vreal *w = state + CREEP_AT + i;
        const vreal last = w[k * COUNT], u = PICK(valid, summed[i].v[v], softer * last),
                    now = PICK(valid, u * stiffer, last);
        if (k != 2) state[to + i] = u + crept_to(creep, w, k);
        EACH(t, CREEP_TERMS) {
          global const real *number = creep + 1 + CREEP_NUMBERS * t;
          global vreal *late = w + (CREEP_FIELDS * (1 + t) + k) * COUNT;
          *late += number[CREEP_LAST] * last + (number[CREEP_NEW] * now - number[CREEP_FADES] * *late);
        }
        w[k * COUNT] = now;
      }
    }
  }
}

#endif
