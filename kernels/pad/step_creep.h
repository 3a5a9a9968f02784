// SPDX-License-Identifier: Apache-2.0
/* Steps of rubber that creeps (fem/pad/creep.h): what is done before and after the contact of a step, which is an elastic
   one on heights above what has crept, with tractions that are `softer` times larger. Device only. */
#ifndef TACTEL_PAD_STEP_CREEP_H
#define TACTEL_PAD_STEP_CREEP_H
#include "pad/nearby.h"

/* MARKED 1: it has markers. */
#ifndef MARKED
#define MARKED 0
#endif
#define CREEP_AT (STEP_FIELDS * COUNT + STEP_NUMBERS)
#define CREEP_FIELDS (MARKED ? 6 : 3) /* numbers of a cell that creep */
#define STRAINING_AT (CREEP_AT + CREEP_FIELDS * (1 + CREEP_TERMS) * COUNT)
#define STATE_ROWS (CREEP_TERMS == 0 ? CREEP_AT : STRAINING_AT + (MARKED ? 3 * COUNT : 0))

#if CREEP_TERMS
/* What the rubber of a cell has crept to, x, y, z, and its tractions: `own` is its state. */
static inline void crept_at(global const real *creep, global const vreal *own, vreal m[CREEP_FIELDS]) {
  global const vreal *w = own + CREEP_AT;
  EACH(k, CREEP_FIELDS) { m[k] = 0; }
  EACH(t, CREEP_TERMS) {
    global const real *number = creep + 1 + CREEP_NUMBERS * t;
    EACH(k, CREEP_FIELDS) {
      const vreal v = w[(CREEP_FIELDS * (1 + t) + k) * COUNT];
      m[k] = fma(ALL_LANES(number[CREEP_C]), v + (number[CREEP_LAST] * w[k * COUNT] - number[CREEP_FADES] * v), m[k]);
    }
  }
}

/* `crept_heights` takes the heights of the step. */
OUTLINE void begin_creep(const Influence *influence, global const real *creep, global const vreal *heights,
                         global vreal *crept_heights, global vreal *state) {
  ROLLED for (int i = 0; i < COUNT; ++i) EACH_VECTOR(v) {
    global vreal *own = state + v * STATE_ROWS + i;
    vreal m[CREEP_FIELDS];
    crept_at(creep, own, m);
    const vreal h = heights[v * COUNT + i];
    crept_heights[v * COUNT + i] = PICK(h >= PAD_OPEN, h, h - m[2] * influence->root_zz);
    own[STEP_GX * COUNT] -= m[0];
    own[STEP_GY * COUNT] -= m[1];
    own[STEP_UZ * COUNT] = creep[0] * own[CREEP_AT + 2 * COUNT];
  }
}

/* What all cells remember, after the step is stored. Where cells near the indenter are, it has summed. A contact that is
   not valid stays under its tractions. */
OUTLINE void end_creep(const Influence *influence, global const real *creep, Cells *c, const State *s,
                       global vreal *state) {
  const real softer = creep[0], stiffer = 1 / softer;
  list_pressing(c);
  ROLLED for (int i = 0; i < COUNT; ++i) {
    Lanes u[3];
    Masks far;
    EACH_VECTOR(v) { far.v[v] = s->valid.v[v] & NOT(c->near[i].v[v]); }
    if (any_of(&far)) {
      displacement(influence, c, i / CELLS_Y, i % CELLS_Y, &u[0], &u[1], &u[2]);
      add_own(c, i, &u[0], &u[1], &u[2]);
    }
    ROLLED for (int v = 0; v < VECTORS; ++v) {
      global vreal *own = state + v * STATE_ROWS + i, *w = own + CREEP_AT;
      const vint sums = s->valid.v[v];
      const vreal summed[3] = {c->gx[i].v[v], c->gy[i].v[v], c->uz[i].v[v]};
      vreal m[CREEP_FIELDS];
      crept_at(creep, own, m);
      EACH(k, 3) {
        const vreal valid = ANY(far.v[v]) ? PICK(far.v[v], u[k].v[v], summed[k]) : summed[k];
        u[k].v[v] = PICK(sums, valid, softer * w[k * COUNT]);
      }
      own[STEP_GX * COUNT] = u[0].v[v] + m[0];
      own[STEP_GY * COUNT] = u[1].v[v] + m[1];
#if MARKED
      own[STRAINING_AT] = c->n[i].v[v] + m[3];
      own[STRAINING_AT + COUNT] = c->tx[i].v[v] + m[4];
      own[STRAINING_AT + 2 * COUNT] = c->ty[i].v[v] + m[5];
#endif
      EACH(k, CREEP_FIELDS) {
        const vreal last = w[k * COUNT], now = k < 3 ? u[k % 3].v[v] * stiffer : own[(k - 3) * COUNT];
        EACH(t, CREEP_TERMS) {
          global const real *number = creep + 1 + CREEP_NUMBERS * t;
          global vreal *to = w + (CREEP_FIELDS * (1 + t) + k) * COUNT;
          *to += number[CREEP_LAST] * last + (number[CREEP_NEW] * now - number[CREEP_FADES] * *to);
        }
        w[k * COUNT] = now;
      }
    }
  }
}
#endif

#endif
