// SPDX-License-Identifier: Apache-2.0
/* Cells fixed to the pad that an indenter may touch. The rubber of the others is not summed; what it did meanwhile is
   made good when the indenter comes near: it is a function of the tractions before the step. Device only. */
#ifndef TACTEL_PAD_NEARBY_H
#define TACTEL_PAD_NEARBY_H
#include "pad/increment.h"
#include "shared/pad_step_layout.h"

/* Cells that press in any lane, in the order of their index. */
static void list_pressing(Cells *c) {
  c->listed = 0;
  for (int i = 0; i < COUNT; ++i) {
    vint any = c->n[i].v[0] > 0;
    for (int v = 1; v < VECTORS; ++v) any |= c->n[i].v[v] > 0;
    c->list[c->listed] = i;
    c->at[c->listed] = AT_TABLE(i);
    c->listed += ANY(any);
  }
}

static void swap_with_last(Cells *c) {
  ROLLED for (int i = 0; i < COUNT; ++i) EACH_VECTOR(v) {
    const vreal n = c->n[i].v[v], x = c->tx[i].v[v], y = c->ty[i].v[v];
    c->n[i].v[v] = c->n_last[i].v[v];
    c->tx[i].v[v] = c->tx_last[i].v[v];
    c->ty[i].v[v] = c->ty_last[i].v[v];
    c->n_last[i].v[v] = n;
    c->tx_last[i].v[v] = x;
    c->ty_last[i].v[v] = y;
  }
}

/* Takes the cells near each indenter at its depth s->deep, and their history into `kept`, [vector][rows]. Within a step
   the tractions before it are the last ones, of lanes that are active. */
OUTLINE void come_near(const Influence *influence, global const vreal *heights, global vreal *kept, int rows,
                       real reach, int in_step, Cells *c, const State *s) {
  int unknown[COUNT], unknowns = 0;
  c->nears = 0;
  ROLLED for (int i = 0; i < COUNT; ++i) {
    vint any = 0, lacks = 0;
    EACH_VECTOR(v) {
      const vreal over = LARGER(s->deep.v[v] - s->lowest.v[v], ALL_LANES((real)1e-6));
      const vint near = (HEIGHT(heights, v, i) - s->deep.v[v] < reach * over) | (c->n[i].v[v] > 0);
      /* Whatever other lanes have summed there: the cell has no sum of this step yet. */
      if (in_step) c->uz[i].v[v] = PICK(near & NOT(c->near[i].v[v]), ALL_LANES(-PAD_OPEN), c->uz[i].v[v]);
      c->near[i].v[v] = in_step ? c->near[i].v[v] | near : near;
      const vint asks = in_step ? s->active.v[v] & c->near[i].v[v] : c->near[i].v[v];
      any |= c->near[i].v[v];
      lacks |= asks & (kept[v * rows + STEP_UZ * COUNT + i] >= (real)STEP_UNKNOWN);
    }
    if (ANY(any)) c->near_list[c->nears++] = i;
    if (ANY(lacks)) unknown[unknowns++] = i;
  }
  if (unknowns == 0) return;
  if (in_step) swap_with_last(c);
  list_pressing(c);
  ROLLED for (int k = 0; k < unknowns; ++k) {
    const int i = unknown[k];
    Lanes ux, uy, uz;
    displacement(influence, c, i / CELLS_Y, i % CELLS_Y, &ux, &uy, &uz);
    EACH_VECTOR(v) {
      global vreal *own = kept + v * rows;
      const vint asks = (in_step ? s->active.v[v] & c->near[i].v[v] : c->near[i].v[v]) &
                        (own[STEP_UZ * COUNT + i] >= (real)STEP_UNKNOWN);
      own[STEP_UZ * COUNT + i] = PICK(asks, uz.v[v], own[STEP_UZ * COUNT + i]);
      own[STEP_GX * COUNT + i] = PICK(asks, ux.v[v], own[STEP_GX * COUNT + i]);
      own[STEP_GY * COUNT + i] = PICK(asks, uy.v[v], own[STEP_GY * COUNT + i]);
      c->uz[i].v[v] = PICK(asks, uz.v[v], c->uz[i].v[v]);
    }
  }
  if (in_step) swap_with_last(c);
}

#endif
