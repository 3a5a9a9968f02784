// SPDX-License-Identifier: Apache-2.0
/* Writes the answers. Device only. */
#ifndef TACTEL_PATCH_ANSWERS_H
#define TACTEL_PATCH_ANSWERS_H
#include "patch/base_stress.h"

/* Adds penetration of places beyond the ends to the certificate. out: how many elements beyond the left and the right
   end are penetrated by more than `accept`. */
static inline void look_outside(const Contact *c, const Solved *s, real accept, Certificate *k, vreal *out) {
  vreal uy[2 * OUTSIDE];
  EACH(o, 2 * OUTSIDE) { uy[o] = 0; }
  for (int j = 0; j < N; ++j) EACH(o, 2 * OUTSIDE) {
      uy[o] = fma(c->outside[o][j][0], s->n[j], uy[o]);
      if (FRICTION) uy[o] = fma(c->outside[o][j][1], s->t[j], uy[o]);
    }
  out[0] = out[1] = 0;
  EACH(o, 2 * OUTSIDE) {
    const vreal inside = uy[o] - (c->h_outside[o] - s->d);
    out[o / OUTSIDE] = PICK(inside > accept * k->largest_uy, ALL_LANES(o % OUTSIDE + 1), out[o / OUTSIDE]);
    k->penetration = LARGER(PICK(k->largest_uy > 0, inside / k->largest_uy, ALL_LANES(0)), k->penetration);
  }
}

/* Results and forces of one increment go to its place among the reported ones. */
static inline void write_report(const vreal *lane, const Contact *c, const Solved *s, const Answers *answers,
                                Reports *to) {
  const real accept = answers->accept;
  Certificate said = s->certificate;
  const vreal young = lane[PATCH_YOUNG], mu = lane[PATCH_MU];
  vreal p, q, sticking = 0, slipping = 0, out[2];
  resultants(s->n, s->t, &p, &q);
  for (int i = 0; i < N; ++i) {
    const vint pressed = s->n[i] > 0, sticks = pressed & (fabs(s->t[i]) < mu * s->n[i]);
    sticking += PICK(sticks, ALL_LANES(1), ALL_LANES(0));
    slipping += PICK(pressed & NOT(sticks), ALL_LANES(1), ALL_LANES(0));
  }
  look_outside(c, s, accept, &said, out);
  const vreal cone = mu * p;
  const vint reports = s->slot >= 0;
  const vint finite = finite_sum(0, (p + fabs(q)) * young) == 0;
  const vint within =
      (said.penetration <= accept) & (said.cone <= accept) & (said.complementarity <= accept) & (said.drift <= accept);
  const vint solved = NOT(to->lost | s->failed) & finite & within;
  const vreal good = PICK(s->slides, ALL_LANES(LANE_SLIDING), ALL_LANES(LANE_SOLVED));
  to->out_left = PICK(reports, LARGER(out[0], to->out_left), to->out_left);
  to->out_right = PICK(reports, LARGER(out[1], to->out_right), to->out_right);
  to->slots = PICK(reports, s->slot + 1, to->slots);
  to->lost |= reports & NOT(solved);

  real place[LANES];
  long row_at[LANES];
  const size_t first_lane = answers->group * LANES;
  STORE(s->slot, place);
  vreal rows[FORCE_ROWS];
  EACH(r, PATCH_BLOCK) { rows[r] = 0; }
  rows[RESULT_DEPTH] = s->d;
  rows[LANE_TANGENTIAL] = s->x;
  rows[RESULT_P] = p * young;
  rows[LANE_Q] = q * young;
  rows[RESULT_S] = PICK(cone > 0, q / cone, ALL_LANES(0));
  rows[RESULT_STICKING] = sticking;
  rows[RESULT_SLIPPING] = slipping;
  rows[RESULT_SWEEPS] = s->sweeps;
  rows[RESULT_STATUS] = PICK(solved, good, ALL_LANES(LANE_UNSOLVED));
  rows[RESULT_PENETRATION] = said.penetration;
  rows[RESULT_CONE] = said.cone;
  rows[RESULT_COMPLEMENTARITY] = said.complementarity;
  rows[RESULT_DRIFT] = said.drift;
  rows[RESULT_SLIP_DISTANCE] = said.slip_distance;
  EACH(l, LANES) {
    row_at[l] = place[l] < 0 ? -1 : (long)answer_at(first_lane + l, answers->slots, (long)place[l], PATCH_BLOCK);
  }
  store_rows(rows, row_at, answers->result);
  if (!answers->write_forces) return;
  EACH(i, FORCE_ROWS) { rows[i] = i < N ? s->n[i % N] : i < 2 * N ? s->t[i % N] : ALL_LANES(0); }
  EACH(l, LANES) {
    row_at[l] = place[l] < 0 ? -1 : (long)answer_at(first_lane + l, answers->slots, (long)place[l], FORCE_ROWS);
  }
  EACH(b, FORCE_ROWS / PATCH_BLOCK) {
    store_rows(rows + b * PATCH_BLOCK, row_at, answers->forces + AT(b * PATCH_BLOCK));
  }
}

/* Writes the reports that wait. */
OUTLINE void write_reports(const vreal *lane, const Contact *c, const Patch *patch, const Answers *to,
                           Reports *reports) {
  if (reports->count == 0) return;
  for (int r = 0; r < reports->count; ++r) write_report(lane, c, &reports->solved[r], to, reports);
  for (int l = 0; l < LANES; ++l)
    write_stress(to, reports, l, NUMBER(lane[PATCH_POSITION], l) + NUMBER(patch->origin, l), NUMBER(patch->element, l),
                 NUMBER(lane[PATCH_YOUNG], l), to->group * LANES + l);
  reports->count = 0;
}

/* Takes this increment among the reports in lanes where it has a place. Lanes that slide as a whole may end their path
   with it. */
static inline void report(const vreal *lane, vreal slot, int k, const Contact *c, const Indenter *in,
                          const Certificate *said, LoadStepping *w, Reports *to) {
  const vint reports = w->running & (slot >= 0);
  const vint slides = w->running & NOT(said->sticks) & said->slips;
  w->failed_before |= w->failed;
  if (!ANY(reports)) return;
  Solved *s = &to->solved[to->count++];
  for (int i = 0; i < N; ++i) {
    s->n[i] = c->n[i];
    s->t[i] = FRICTION ? c->t[i] : ALL_LANES(0);
  }
  s->d = in->d;
  s->x = in->x;
  s->sweeps = w->sweeps;
  s->slot = PICK(reports, slot, ALL_LANES(-1));
  s->failed = w->failed_before;
  s->slides = slides;
  s->certificate = *said;
  w->sweeps = PICK(reports, ALL_LANES(0), w->sweeps);
  w->running &= NOT(reports & slides & (lane[PATCH_MAY_STOP] <= (real)k));
}

/* The patch of each lane, and a status for increments that did not run. */
static inline void finish(const Answers *answers, const Patch *patch, vint valid, const Reports *to,
                          global real *patches) {
  real done[LANES], idle[LANES];
  STORE(to->slots, done);
  STORE(PICK(valid, ALL_LANES(LANE_NOT_RUN), ALL_LANES(LANE_INVALID)), idle);
  vreal rows[PATCH_BLOCK];
  EACH(r, PATCH_BLOCK) { rows[r] = 0; }
  rows[PATCH_ORIGIN] = patch->origin;
  rows[PATCH_ELEMENT] = patch->element;
  rows[PATCH_OUT_LEFT] = to->out_left;
  rows[PATCH_OUT_RIGHT] = to->out_right;
  rows[PATCH_SEARCH_SWEEPS] = patch->sweeps;
  rows[PATCH_SLOTS] = to->slots;
  const size_t first_lane = answers->group * LANES;
  long at[LANES];
  EACH(l, LANES) { at[l] = (long)answer_at(first_lane + l, 1, 0, PATCH_BLOCK); }
  store_rows(rows, at, patches);
  for (int l = 0; l < LANES; ++l)
    for (int k = (int)done[l]; k < answers->slots; ++k) {
      global real *result = answers->result + answer_at(first_lane + l, answers->slots, k, PATCH_BLOCK);
      for (int r = 0; r < PATCH_BLOCK; ++r) result[AT(r)] = r == RESULT_STATUS ? idle[l] : 0;
    }
}

#endif
