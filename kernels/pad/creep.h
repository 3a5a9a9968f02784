// SPDX-License-Identifier: Apache-2.0
/* Rubber that creeps along the path of a contact (fem/pad/creep.h): what is done before and after each increment, whose
   contact is an elastic one. Device only. */
#ifndef TACTEL_PAD_CREEP_H
#define TACTEL_PAD_CREEP_H
#include "pad/cells.h"

/* What the rubber of each cell remembers: its displacement x, y, z and its tractions n, t_x, t_y, as they are scaled. The
   tractions tell what places below the surface have crept to. Where a scene is a work-item it lies in memory that a run
   is lent: GPUs have little for each. */
typedef struct {
  Lanes last[WHERE(CREEPING, CREEPS *COUNT)];              /* of elastic rubber, by the last tractions */
  Lanes late[WHERE(CREEPING, CREEPS *CREEP_TERMS *COUNT)]; /* what a term has crept towards */
} Memory;
#if LANES == 1
#define LENT global
#define MEMORY_IN(name, lent) global Memory *name = (global Memory *)(lent)
#else
#define LENT private
#define MEMORY_IN(name, lent) Memory own, *name = &own
#endif

static void forget(LENT Memory *m) {
  ROLLED for (int i = 0; i < CREEPS * COUNT; ++i) EACH_VECTOR(v) { m->last[i].v[v] = 0; }
  ROLLED for (int i = 0; i < CREEPS * CREEP_TERMS * COUNT; ++i) EACH_VECTOR(v) { m->late[i].v[v] = 0; }
}

static void scale_tractions(Cells *c, int i, int v, vreal by) {
  c->n[i].v[v] *= by;
  c->tx[i].v[v] *= by;
  c->ty[i].v[v] *= by;
  c->n_last[i].v[v] *= by;
  c->tx_last[i].v[v] *= by;
  c->ty_last[i].v[v] *= by;
}

/* `rows`: numbers of the increment, of vector v from v * stride on. The contact is one on rubber that lies where it has
   crept, with tractions that are `softer` times larger. */
OUTLINE void begin_creep(const Influence *influence, global const vreal *heights, global const vreal *rows, int stride,
                         LENT const Memory *m, Cells *c, State *s) {
  EACH_VECTOR(v) {
    s->softer.v[v] = PICK(s->running.v[v], rows[v * stride], ALL_LANES(1));
    s->lowest.v[v] = PAD_OPEN;
  }
  ROLLED for (int i = 0; i < COUNT; ++i) EACH_VECTOR(v) {
    global const vreal *number = rows + v * stride + 1;
    ROLLED for (int k = 0; k < CREEPS; ++k) {
      vreal crept = 0;
      EACH(t, CREEP_TERMS) {
        global const vreal *of = number + CREEP_NUMBERS * t;
        const vreal late = m->late[(CREEPS * t + k) * COUNT + i].v[v];
        crept = fma(of[CREEP_C], late + (of[CREEP_LAST] * m->last[k * COUNT + i].v[v] - of[CREEP_FADES] * late), crept);
      }
      c->crept[k * COUNT + i].v[v] = crept;
    }
    c->gx[i].v[v] -= CREPT(c, 0, i, v);
    c->gy[i].v[v] -= CREPT(c, 1, i, v);
    scale_tractions(c, i, v, s->softer.v[v]);
    s->lowest.v[v] = SMALLER(HEIGHT(heights, v, i) - CREPT(c, 2, i, v) * influence->root_zz, s->lowest.v[v]);
  }
}

OUTLINE void end_creep(global const vreal *rows, int stride, LENT Memory *m, Cells *c, const State *s) {
  ROLLED for (int i = 0; i < COUNT; ++i) EACH_VECTOR(v) {
    global const vreal *number = rows + v * stride + 1;
    const vreal stiffer = 1 / s->softer.v[v];
    c->gx[i].v[v] += CREPT(c, 0, i, v);
    c->gy[i].v[v] += CREPT(c, 1, i, v);
    scale_tractions(c, i, v, stiffer);
    const vreal now[CREEPS] = {c->ux[i].v[v] * stiffer, c->uy[i].v[v] * stiffer,
                               c->uz[i].v[v] * stiffer, c->n[i].v[v],
                               c->tx[i].v[v],           c->ty[i].v[v]};
    EACH(k, CREEPS) {
      const vreal last = m->last[k * COUNT + i].v[v];
      EACH(t, CREEP_TERMS) {
        global const vreal *of = number + CREEP_NUMBERS * t;
        LENT vreal *late = &m->late[(CREEPS * t + k) * COUNT + i].v[v];
        *late += of[CREEP_LAST] * last + (of[CREEP_NEW] * now[k] - of[CREEP_FADES] * *late);
      }
      m->last[k * COUNT + i].v[v] = now[k];
    }
  }
}

#endif
