// SPDX-License-Identifier: Apache-2.0
/* The pose that gives a wrench: depth by secants of log P over log depth, motion along the pad by Broyden's method on the
   inverse (C. G. Broyden, Math. Comp. 19, 1965, 577-593). Every pose is solved from the history before the step. Beyond
   what friction bears the indenter slides: it moves by the sticking compliance times what is missing, and P alone is met.
   Unknowns are x, y and twist times the half size at the pressure's centre; forces Q and torque over the half size.
   Device only. */
#ifndef TACTEL_PAD_POSE_SEARCH_H
#define TACTEL_PAD_POSE_SEARCH_H
#include "pad/wrench.h"

#define FIRST_STEP ((real)0.03) /* depth tried first for a force */
#define OPEN_GAP ((real)0.01)   /* of an indenter without force */
#define BEARABLE ((real)0.995)  /* S of the wrench above which it slides */
#define SLIDING_SOLVES 6        /* after which a wrench beyond friction need not slide every cell */

/* The first pose of a step, from the state before it. A contact whose wrench is met and whose heights are the same stays
   as it is. `numbers`: those of the state, [vector][rows]; `missed` takes what the wrench lacks before the step. */
OUTLINE void first_pose(const Influence *influence, const Stiffness *stiff, global const vreal *input,
                        global const vreal *numbers, int rows, real force_tolerance, real travel, const Cells *c,
                        State *s, Search *w, Target *to, Lanes *missed) {
  Totals f;
  totals(influence, c, s, &f);
  take_centre(influence, s, c, w);
  EACH_VECTOR(v) {
    global const vreal *in = input + v * INPUT_ROWS + STEP_TO, *kept = numbers + v * rows;
    const vint mine = s->valid.v[v];
    const vreal T = PICK(mine, in[0], ALL_LANES(0)), X = PICK(mine, in[1], ALL_LANES(0)),
                Y = PICK(mine, in[2], ALL_LANES(0)), M = PICK(mine, in[3], ALL_LANES(0)), P = f.P.v[v];
    w->P.v[v] = T;
    w->W[0].v[v] = X;
    w->W[1].v[v] = Y;
    w->W[2].v[v] = (M - (w->arm_x.v[v] * Y - w->arm_y.v[v] * X)) / s->half_size;
    w->from[0].v[v] = s->d.v[v];
    w->from[1].v[v] = s->x.v[v];
    w->from[2].v[v] = s->y.v[v];
    w->from[3].v[v] = s->twist.v[v];
    vreal F[3], missing[3], motion[3];
    forces_of(w, s, &f, v, F);
    EACH(k, 3) { missing[k] = missed[k].v[v] = w->W[k].v[v] - F[k]; }
    const vreal within = force_tolerance * T;
    const vint met = (T > 0) & (P > 0) & (fabs(T - P) <= within) & (fabs(missing[0]) <= within) &
                     (fabs(missing[1]) <= within) & (fabs(missing[2]) <= within);
    w->met.v[v] = met;
    const vint presses = mine & (T > 0) & (s->lowest.v[v] < PAD_OPEN);
    s->searching.v[v] = presses & (NOT(met) | s->anew.v[v]);
    /* depth */
    w->power.v[v] = PICK(kept[STEP_POWER] > 0, kept[STEP_POWER], ALL_LANES((real)1.5));
    const vreal over = LARGER(s->d.v[v] - s->lowest.v[v], ALL_LANES((real)1e-6));
    const vreal deeper = SMALLER(over * depth_factor(T / LARGER(P, ALL_LANES(LEAST_FORCE)), w->power.v[v]),
                                 ALL_LANES((real)STEP_MOST_DEPTH));
    const vreal d =
        PICK(P > 0, PICK(fabs(T - P) <= within, s->d.v[v], s->lowest.v[v] + deeper), s->lowest.v[v] + FIRST_STEP);
    to->normal.v[v] = PICK(presses, PICK(s->searching.v[v], d, s->d.v[v]),
                           PICK(mine, SMALLER(s->lowest.v[v], ALL_LANES(0)) - OPEN_GAP, s->d.v[v]));
    w->low.v[v] = w->last_over.v[v] = w->last_P.v[v] = w->solves.v[v] = 0;
    w->high.v[v] = NO_BOUND;
    /* along the pad */
    const vreal a2 = LARGER(f.touch.v[v], ALL_LANES(4)) * (influence->hx * influence->hy * (real)0.318309886);
    const vreal a = sqrt(a2), sticking = 1 / (stiff->kt * a * (1 + a)),
                turning = s->half_size * s->half_size / (stiff->kr * a2 * a * (1 + a));
    w->beyond.v[v] = s->searching.v[v] & (P > 0) & (asked_margin(influence, c, s, w, v, P) > BEARABLE);
    const vreal along = missing[0] * kept[STEP_WAY] + missing[1] * kept[STEP_WAY + 1] + missing[2] * kept[STEP_WAY + 2];
    const vint keep = (along > 0) & (kept[STEP_INVERSE] > 0) & NOT(w->beyond.v[v]);
    EACH(k, 9) {
      w->inverse[k].v[v] = PICK(keep, kept[STEP_INVERSE + k],
                                k == 0 || k == 4 ? sticking
                                : k == 8         ? turning
                                                 : (vreal)0);
    }
    motion_for(w, v, missing, travel, motion);
    EACH(k, 3) {
      w->at[k].v[v] = PICK(s->searching.v[v] & (P > 0) & NOT(met), motion[k], ALL_LANES(0));
      w->last_at[k].v[v] = w->good[k].v[v] = 0;
      w->last_F[k].v[v] = F[k];
    }
    w->best.v[v] = NO_BOUND;
    pose_of(w, s, v, &to->x.v[v], &to->y.v[v], &to->twist.v[v]);
  }
}

/* The next depth, from those that were solved. */
static inline void next_depth_of(Search *w, const State *s, int v, vint goes_on, vint met, vreal P, real tolerance,
                                 vreal *d) {
  const vreal target = w->P.v[v], over = LARGER(s->d.v[v] - s->lowest.v[v], ALL_LANES((real)1e-9));
  const vint both = goes_on & (w->last_P.v[v] > 0) & (P > 0) & (fabs(over - w->last_over.v[v]) > (real)1e-6 * over);
  const vreal slope = natural_log(PICK(both, P / w->last_P.v[v], ALL_LANES(2))) /
                      natural_log(PICK(both, over / w->last_over.v[v], ALL_LANES(2)));
  w->power.v[v] = PICK(both, SMALLER(LARGER(slope, ALL_LANES((real)0.7)), ALL_LANES(3)), w->power.v[v]);
  w->last_over.v[v] = PICK(goes_on, over, w->last_over.v[v]);
  w->last_P.v[v] = PICK(goes_on, P, w->last_P.v[v]);
  w->low.v[v] = PICK(goes_on & (P < target), over, w->low.v[v]);
  w->high.v[v] = PICK(goes_on & NOT(P < target), over, w->high.v[v]);
  /* Empty, since motion along the pad has changed the force. */
  const vint stale = w->high.v[v] - w->low.v[v] <= (real)0.1 * tolerance * over;
  w->low.v[v] = PICK(stale, ALL_LANES(0), w->low.v[v]);
  w->high.v[v] = PICK(stale, ALL_LANES(NO_BOUND), w->high.v[v]);
  const vreal trial =
      over * PICK(P > 0, depth_factor(target / LARGER(P, ALL_LANES(LEAST_FORCE)), w->power.v[v]), ALL_LANES(4));
  const vreal halved = PICK(w->high.v[v] < NO_BOUND, (w->low.v[v] + w->high.v[v]) / 2, 2 * over);
  const vreal next =
      SMALLER(PICK((trial > w->low.v[v]) & (trial < w->high.v[v]), trial, halved), ALL_LANES((real)STEP_MOST_DEPTH));
  *d = PICK(goes_on & NOT(met), s->lowest.v[v] + next, s->d.v[v]);
}

/* The next motion along the pad. */
static inline void next_motion(Search *w, int v, vint goes_on, vint slides, const vreal *F, const vreal *missing,
                               real travel) {
  vreal change[3], answer[3], predicted[3], row[3], motion[3];
  EACH(k, 3) {
    change[k] = w->at[k].v[v] - w->last_at[k].v[v];
    answer[k] = F[k] - w->last_F[k].v[v];
  }
  EACH(k, 3) {
    predicted[k] = w->inverse[3 * k].v[v] * answer[0] + w->inverse[3 * k + 1].v[v] * answer[1] +
                   w->inverse[3 * k + 2].v[v] * answer[2];
    row[k] = change[0] * w->inverse[k].v[v] + change[1] * w->inverse[3 + k].v[v] + change[2] * w->inverse[6 + k].v[v];
  }
  const vreal along = change[0] * predicted[0] + change[1] * predicted[1] + change[2] * predicted[2];
  const vreal size2 = change[0] * change[0] + change[1] * change[1] + change[2] * change[2];
  const vint updates = goes_on & NOT(w->beyond.v[v]) & (along > (real)0.05 * size2) & (size2 > 0);
  const vreal per_along = 1 / PICK(updates, along, ALL_LANES(1));
  EACH(k, 3) {
    EACH(m, 3) {
      const vreal old = w->inverse[3 * k + m].v[v];
      w->inverse[3 * k + m].v[v] = PICK(updates, old + (change[k] - predicted[k]) * row[m] * per_along, old);
    }
  }
  const vreal miss = length_of(missing);
  const vint worse = goes_on & (miss > w->best.v[v]) & NOT(w->beyond.v[v]), better = goes_on & (miss <= w->best.v[v]);
  const vint moves = goes_on & NOT(w->beyond.v[v] & slides);
  motion_for(w, v, missing, travel, motion);
  EACH(k, 3) {
    const vreal at = w->at[k].v[v];
    w->last_at[k].v[v] = PICK(goes_on, at, w->last_at[k].v[v]);
    w->last_F[k].v[v] = PICK(goes_on, F[k], w->last_F[k].v[v]);
    w->at[k].v[v] = PICK(moves, PICK(worse, (real)0.5 * (at + w->good[k].v[v]), at + motion[k]), at);
    w->good[k].v[v] = PICK(better, at, w->good[k].v[v]);
  }
  w->best.v[v] = PICK(better, miss, w->best.v[v]);
}

/* Judges the wrench of lanes that search, and moves those that miss it: they solve again, from the history in `kept`,
   [vector][rows]. */
OUTLINE void next_pose(const Influence *influence, global const vreal *heights, global vreal *kept, int rows,
                       real reach, real tolerance, int most_solves, real travel, Cells *c, State *s, Search *w) {
  Totals f;
  totals(influence, c, s, &f);
  EACH_VECTOR(v) {
    const vreal P = f.P.v[v], target = w->P.v[v], within = tolerance * target;
    vreal F[3], missing[3];
    forces_of(w, s, &f, v, F);
    EACH(k, 3) { missing[k] = w->W[k].v[v] - F[k]; }
    s->searching.v[v] &= NOT(s->failed.v[v]);
    const vint searching = s->searching.v[v];
    w->solves.v[v] += PICK(searching, ALL_LANES(1), ALL_LANES(0));
    const vint met_P = fabs(target - P) <= within, slides = (f.stick.v[v] == 0) & (P > 0);
    const vint met_t = (fabs(missing[0]) <= within) & (fabs(missing[1]) <= within) & (fabs(missing[2]) <= within);
    const vint asks = searching & NOT(met_t);
    if (ANY(asks)) w->beyond.v[v] = PICK(asks, asked_margin(influence, c, s, w, v, P) > BEARABLE, w->beyond.v[v]);
    const vint ends = met_P & (met_t | (w->beyond.v[v] & (slides | (w->solves.v[v] >= ALL_LANES(SLIDING_SOLVES)))));
    w->met.v[v] = PICK(searching, met_P & met_t, w->met.v[v]);
    s->searching.v[v] &= NOT(ends);
    const vint out = s->searching.v[v] & (w->solves.v[v] >= ALL_LANES((real)most_solves));
    s->failed.v[v] |= out;
    s->searching.v[v] &= NOT(out);
    const vint goes_on = s->searching.v[v];
    vreal d, x, y, twist;
    next_depth_of(w, s, v, goes_on, met_P, P, tolerance, &d);
    next_motion(w, v, goes_on, slides, F, missing, travel);
    pose_of(w, s, v, &x, &y, &twist);
    s->active.v[v] = goes_on;
    s->trial_sweeps.v[v] = PICK(goes_on, ALL_LANES(0), s->trial_sweeps.v[v]);
    s->d.v[v] = PICK(goes_on, d, s->d.v[v]);
    s->x.v[v] = PICK(goes_on, x, s->x.v[v]);
    s->y.v[v] = PICK(goes_on, y, s->y.v[v]);
    s->twist.v[v] = PICK(goes_on, twist, s->twist.v[v]);
    s->change_d.v[v] = PICK(goes_on, s->d.v[v] - w->from[0].v[v], s->change_d.v[v]);
    s->change_x.v[v] = PICK(goes_on, s->x.v[v] - w->from[1].v[v], s->change_x.v[v]);
    s->change_y.v[v] = PICK(goes_on, s->y.v[v] - w->from[2].v[v], s->change_y.v[v]);
    s->change_twist.v[v] = PICK(goes_on, s->half_size * (s->twist.v[v] - w->from[3].v[v]), s->change_twist.v[v]);
  }
  if (!any_of(&s->active)) return;
  Masks deeper;
  EACH_VECTOR(v) {
    deeper.v[v] = s->active.v[v] & (s->d.v[v] > s->deep.v[v]);
    s->deep.v[v] = PICK(deeper.v[v], s->d.v[v], s->deep.v[v]);
  }
  if (any_of(&deeper)) come_near(influence, heights, kept, rows, reach, 1, c, s);
  const real per_tt = 1 / influence->root_tt;
  ROLLED for (int i = 0; i < COUNT; ++i) EACH_VECTOR(v) {
    const vint goes_on = s->active.v[v];
    global const vreal *history = kept + v * rows;
    const vreal dx = s->x.v[v] - w->from[1].v[v], dy = s->y.v[v] - w->from[2].v[v],
                turn = s->twist.v[v] - w->from[3].v[v];
    c->open[i].v[v] = PICK(goes_on, (HEIGHT(heights, v, i) - s->d.v[v]) / influence->root_zz, c->open[i].v[v]);
    const vreal gx =
        fma(dx - turn * (s->y_middle.v[v] + y_of(influence, i)), ALL_LANES(per_tt), history[STEP_GX * COUNT + i]);
    const vreal gy =
        fma(dy + turn * (s->x_middle.v[v] + x_of(influence, i)), ALL_LANES(per_tt), history[STEP_GY * COUNT + i]);
    c->gx[i].v[v] = PICK(goes_on, gx, c->gx[i].v[v]);
    c->gy[i].v[v] = PICK(goes_on, gy, c->gy[i].v[v]);
    const vint penetrated = goes_on & (s->d.v[v] > s->lowest.v[v]) & (c->open[i].v[v] < c->uz[i].v[v]);
    c->window[i].v[v] |= penetrated & c->near[i].v[v];
  }
}

#endif
