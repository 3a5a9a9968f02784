// SPDX-License-Identifier: Apache-2.0
/* Scenes on their load paths, with their answers, by the displacements of pad/table_sums.h or pad/free_sides.h, which is
   included before. Device only. */
#ifndef TACTEL_PAD_PATH_H
#define TACTEL_PAD_PATH_H
#include "pad/creep.h"
#include "pad/increment.h"
#include "pad/residual.h"
#include "pad/slip_margin.h"
#include "pad/sweep.h"

#define INPUT_ROWS (PAD_INPUT_ROWS + FRICTION_MAP * COUNT)
#define PATH_ROWS (PAD_PATH_ROWS + (CREEPING ? 1 + CREEP_NUMBERS * CREEP_TERMS : 0))
/* n, t_x, t_y of each cell; of rubber that creeps then those that would strain elastic rubber as far. */
#define FORCE_PARTS (CREEPING ? 6 : 3)
#define MEMORY_VECTORS (CREEPS * (1 + CREEP_TERMS) * COUNT)
#define MOST_FORCE_TRIALS 60

/* Judges the force of lanes that search their depth, and moves those that miss it: they solve again. */
OUTLINE void next_depth(const Influence *influence, global const vreal *heights, real tolerance, Cells *c, State *s) {
  EACH_VECTOR(v) {
    const vreal P = pressing(influence, c, v), d = s->d.v[v], target = s->target.v[v];
    s->searching.v[v] &= NOT(s->failed.v[v] | (fabs(P - target) <= tolerance * target));
    const vint goes_on = s->searching.v[v], both = goes_on & (s->last_P.v[v] > 0) & (P > 0) & (d != s->last_d.v[v]);
    s->trials.v[v] += PICK(goes_on, ALL_LANES(1), ALL_LANES(0));
    const vint out = goes_on & (s->trials.v[v] >= ALL_LANES(MOST_FORCE_TRIALS));
    s->failed.v[v] |= out;
    s->searching.v[v] &= NOT(out);
    const vreal slope = natural_log(PICK(both, P / s->last_P.v[v], ALL_LANES(2))) /
                        natural_log(PICK(both, d / s->last_d.v[v], ALL_LANES(2)));
    s->power.v[v] = PICK(both, SMALLER(LARGER(slope, ALL_LANES((real)0.5)), ALL_LANES(4)), s->power.v[v]);
    s->last_d.v[v] = d;
    s->last_P.v[v] = P;
    s->low.v[v] = PICK(P < target, d, s->low.v[v]);
    s->high.v[v] = PICK(P < target, s->high.v[v], d);
    /* So narrow, it would hold no two forces that both miss: one of them was that of sweeps that had not settled. */
    const vint stale = s->high.v[v] - s->low.v[v] <= (real)0.1 * tolerance * d;
    s->low.v[v] = PICK(stale, ALL_LANES(0), s->low.v[v]);
    s->high.v[v] = PICK(stale, ALL_LANES(NO_BOUND), s->high.v[v]);
    const vreal trial =
        d * PICK(P > 0, depth_factor(target / LARGER(P, ALL_LANES((real)1e-30)), s->power.v[v]), ALL_LANES(2));
    const vreal halved = PICK(s->high.v[v] < NO_BOUND, (s->low.v[v] + s->high.v[v]) / 2, 2 * d);
    s->active.v[v] = s->searching.v[v];
    s->d.v[v] = PICK(s->active.v[v], PICK((trial > s->low.v[v]) & (trial < s->high.v[v]), trial, halved), d);
    s->trial_sweeps.v[v] = PICK(s->active.v[v], ALL_LANES(0), s->trial_sweeps.v[v]);
  }
  ROLLED for (int i = 0; i < COUNT; ++i) EACH_VECTOR(v) { set_open(influence, heights, s, i, v, c); }
}

/* Adds the slide of this increment; to `slid` where no cell sticks that touches. */
static void add_slide(const Influence *influence, const Cells *c, State *s) {
  EACH_VECTOR(v) {
    vreal sticking = 0;
    for (int k = 0; k < c->listed; ++k) {
      const int i = c->list[k];
      const vreal n = c->n[i].v[v], x = c->tx[i].v[v], y = c->ty[i].v[v], cone = INSIDE_CONE * MU(i, v) * n;
      sticking += PICK((n > 0) & (fma(x, x, y * y) < cone * cone), ALL_LANES(1), ALL_LANES(0));
    }
    const vreal slide = rms_slide(influence, c, v);
    s->slip_path.v[v] += slide;
    s->slid.v[v] += PICK(sticking > 0, ALL_LANES(0), slide);
  }
}

typedef struct {
  size_t first_lane; /* of the group, over all groups */
  int slots, write_forces, most_sweeps;
  real accept;
  global real *result, *forces;
} Answers;

/* The certificate of all vectors: rows RESULT_PENETRATION to PAD_RESULT_OUTSIDE. */
OUTLINE void certify(const Influence *influence, global const vreal *heights, real accept, const Cells *c,
                     const State *s, vreal *rows) {
  Residual r;
  Lanes per_d, outside[4];
  residual_of_cells(influence, c, s, &r);
  EACH_VECTOR(v) {
    per_d.v[v] = PICK(s->d.v[v] > 0, 1 / s->d.v[v], ALL_LANES(0));
    EACH(b, 4) { outside[b].v[v] = 0; }
  }
  ROLLED for (int k = 0; k < RING_PLACES; ++k) {
    int ix, iy;
    ring_place(k, &ix, &iy);
    const int sides = (ix < 0 ? 1 : ix == CELLS ? 2 : 0) + (iy < 0 ? 4 : iy == CELLS ? 8 : 0);
    Lanes uz;
    if (!displacement_of_ring(influence, heights, c, k, ix, iy, &uz)) continue;
    EACH_VECTOR(v) {
      const vreal inside =
          (uz.v[v] * influence->root_zz - (heights[(v * RING + ix + 1) * RING + iy + 1] - s->d.v[v])) * per_d.v[v];
      r.penetration.v[v] = LARGER(inside, r.penetration.v[v]);
      const vint beyond = inside > accept;
      EACH(b, 4) {
        outside[b].v[v] = PICK(beyond, LARGER(ALL_LANES((real)(sides >> b & 1)), outside[b].v[v]), outside[b].v[v]);
      }
    }
  }
  EACH_VECTOR(v) {
    rows[PAD_RESULT_ROWS * v + RESULT_PENETRATION] = r.penetration.v[v];
    rows[PAD_RESULT_ROWS * v + RESULT_COMPLEMENTARITY] = r.complementarity.v[v];
    rows[PAD_RESULT_ROWS * v + RESULT_CONE] = r.cone.v[v];
    rows[PAD_RESULT_ROWS * v + RESULT_DRIFT] = r.drift.v[v];
    rows[PAD_RESULT_ROWS * v + PAD_RESULT_ANGLE] = r.angle.v[v];
    rows[PAD_RESULT_ROWS * v + PAD_RESULT_OUTSIDE] =
        outside[0].v[v] + 2 * outside[1].v[v] + 4 * outside[2].v[v] + 8 * outside[3].v[v];
  }
}

/* Writes the answers of lanes with a slot. */
OUTLINE void report(const Influence *influence, global const vreal *lane_input, global const vreal *heights,
                    const Answers *a, const Lanes *slot, const Cells *c, State *s) {
  vreal rows[VECTORS * PAD_RESULT_ROWS];
  certify(influence, heights, a->accept, c, s, rows);
  const side n_unit = influence->hx * influence->hy / influence->root_zz,
             t_unit = influence->hx * influence->hy / influence->root_tt;
  ROLLED for (int v = 0; v < VECTORS; ++v) {
    global const vreal *in = lane_input + v * INPUT_ROWS;
    const vreal cosine = in[PAD_COSINE], sine = in[PAD_SINE], H = in[PAD_THICKNESS];
    const vreal force = CREEPING ? in[PAD_FORCE] / s->softer.v[v] : in[PAD_FORCE];
    vreal P = 0, Qx = 0, Qy = 0, M = 0, sticking = 0, touching = 0, slid = 0, grip = 0;
    vreal left = PAD_OPEN, right = -PAD_OPEN, below = PAD_OPEN, above = -PAD_OPEN;
    vreal first_x = CELLS, last_x = -1, first_y = CELLS, last_y = -1;
    for (int k = 0; k < c->listed; ++k) {
      const int i = c->list[k];
      const vreal n = c->n[i].v[v], x = c->tx[i].v[v], y = c->ty[i].v[v], edge = INSIDE_CONE * MU(i, v) * n;
      P += n;
      Qx += x;
      Qy += y;
      const vreal own_x = s->x_middle.v[v] + x_of(influence, i), own_y = s->y_middle.v[v] + y_of(influence, i);
      M = fma(own_x, y, fma(-own_y, x, M));
      const vint touches = n > 0;
      const vreal ux = CREEPING ? c->ux[i].v[v] + CREPT(c, 0, i, v) : c->ux[i].v[v],
                  uy = CREEPING ? c->uy[i].v[v] + CREPT(c, 1, i, v) : c->uy[i].v[v];
      if (FRICTION_MAP) grip = fma(MU(i, v), n, grip);
      const vreal slip_x = s->x.v[v] - s->twist.v[v] * own_y - ux * influence->root_tt,
                  slip_y = s->y.v[v] + s->twist.v[v] * own_x - uy * influence->root_tt;
      slid = PICK(touches, LARGER(fma(slip_x, slip_x, slip_y * slip_y), slid), slid);
      const vreal pad_x = cosine * own_x - sine * own_y, pad_y = sine * own_x + cosine * own_y;
      left = PICK(touches, SMALLER(pad_x, left), left);
      right = PICK(touches, LARGER(pad_x, right), right);
      below = PICK(touches, SMALLER(pad_y, below), below);
      above = PICK(touches, LARGER(pad_y, above), above);
      const vreal ix = ALL_LANES((real)(i / CELLS)), iy = ALL_LANES((real)(i % CELLS));
      first_x = PICK(touches, SMALLER(ix, first_x), first_x);
      last_x = PICK(touches, LARGER(ix, last_x), last_x);
      first_y = PICK(touches, SMALLER(iy, first_y), first_y);
      last_y = PICK(touches, LARGER(iy, last_y), last_y);
      touching += PICK(n > 0, ALL_LANES(1), ALL_LANES(0));
      sticking += PICK((n > 0) & (fma(x, x, y * y) < edge * edge), ALL_LANES(1), ALL_LANES(0));
    }
    vreal *to = rows + PAD_RESULT_ROWS * v;
    to[RESULT_P] = P * n_unit * force;
    to[PAD_RESULT_QX] = (cosine * Qx - sine * Qy) * t_unit * force;
    to[PAD_RESULT_QY] = (sine * Qx + cosine * Qy) * t_unit * force;
    to[PAD_RESULT_M] = M * t_unit * force * H;
    to[RESULT_S] = slip_margin(influence, c, s, v);
    to[RESULT_STICKING] = sticking;
    to[RESULT_SLIPPING] = touching - sticking;
    to[RESULT_SWEEPS] = s->sweeps.v[v];
    to[RESULT_DEPTH] = s->d.v[v] * H;
    to[RESULT_SLIP_DISTANCE] = sqrt(slid) * H;
    to[PAD_RESULT_AREA] = touching * influence->hx * influence->hy * H * H;
    const vreal half_x = (real)0.5 * (fabs(cosine) * influence->hx + fabs(sine) * influence->hy),
                half_y = (real)0.5 * (fabs(sine) * influence->hx + fabs(cosine) * influence->hy);
    to[PAD_RESULT_LEFT] = (left - half_x) * H;
    to[PAD_RESULT_RIGHT] = (right + half_x) * H;
    to[PAD_RESULT_BELOW] = (below - half_y) * H;
    to[PAD_RESULT_ABOVE] = (above + half_y) * H;
    to[PAD_RESULT_ACROSS] = PICK(touching > 0, 1 + SMALLER(last_x - first_x, last_y - first_y), ALL_LANES(0));
    to[PAD_RESULT_CELL] = LARGER(influence->hx * H, influence->hy * H);
    to[PAD_RESULT_SLID] = s->slid.v[v] * H;
    to[PAD_RESULT_SLIP_PATH] = s->slip_path.v[v] * H;
    to[PAD_RESULT_MU] = in[PAD_MU];
    if (FRICTION_MAP) to[PAD_RESULT_MU] = PICK(P > 0, grip * t_unit / (P * n_unit), in[PAD_MU]);
    const vint reports = slot->v[v] >= 0;
    vreal worst = to[RESULT_PENETRATION];
    EACH(r, 4) { worst = LARGER(to[RESULT_COMPLEMENTARITY + r], worst); }
    const vint finite =
        finite_sum(finite_sum(finite_sum(finite_sum(0, P), Qx), Qy), to[RESULT_DRIFT] + to[PAD_RESULT_ANGLE]) == 0;
    const vint solved = NOT(s->lost.v[v] | s->failed.v[v]) & finite & (worst <= a->accept);
    s->lost.v[v] |= reports & NOT(solved);
    const vint slides = (touching > 0) & (sticking == 0);
    to[RESULT_STATUS] =
        PICK(solved, PICK(slides, ALL_LANES(LANE_SLIDING), ALL_LANES(LANE_SOLVED)), ALL_LANES(LANE_UNSOLVED));
    real place[LANES], number[LANES];
    STORE(slot->v[v], place);
    for (int r = 0; r < PAD_RESULT_ROWS; ++r) {
      STORE(to[r], number);
      for (int l = 0; l < LANES; ++l)
        if (place[l] >= 0)
          a->result[((a->first_lane + v * LANES + l) * a->slots + (size_t)place[l]) * PAD_RESULT_ROWS + r] = number[l];
    }
    if (!a->write_forces) continue;
    for (int i = 0; i < COUNT; ++i)
      for (int part = 0; part < FORCE_PARTS; ++part) {
        if (CREEPING && part >= 3) {
          const vreal traction = part == 3 ? c->n[i].v[v] : part == 4 ? c->tx[i].v[v] : c->ty[i].v[v];
          STORE((traction + CREPT(c, part, i, v)) * (part == 3 ? n_unit : t_unit) * in[PAD_FORCE], number);
        } else {
          STORE((part == 0 ? c->n[i].v[v] * n_unit : (part == 1 ? c->tx[i].v[v] : c->ty[i].v[v]) * t_unit) * force,
                number);
        }
        for (int l = 0; l < LANES; ++l)
          if (place[l] >= 0)
            a->forces[(((a->first_lane + v * LANES + l) * a->slots + (size_t)place[l]) * FORCE_PARTS + part) * COUNT +
                      i] = number[l];
      }
  }
}

/* Lanes whose input is finite and sensible, as far as their own path goes. */
static void check_input(global const vreal *lane_input, global const vreal *path, global const vreal *heights,
                        int increments, State *s) {
  for (int v = 0; v < VECTORS; ++v) {
    global const vreal *in = lane_input + v * INPUT_ROWS;
    vreal sum = 0, lowest = PAD_OPEN;
    for (int r = 0; r < INPUT_ROWS; ++r) sum = finite_sum(sum, in[r]);
    for (int i = 0; i < RING * RING; ++i) {
      const vreal h = heights[v * RING * RING + i];
      sum = finite_sum(sum, h);
      lowest = SMALLER(h, lowest);
    }
    for (int k = 0; k < increments; ++k) {
      const vint own = in[PAD_STEPS] > (real)k;
      for (int r = 0; r < PATH_ROWS; ++r)
        sum = PICK(own, finite_sum(sum, path[(v * increments + k) * PATH_ROWS + r]), sum);
    }
    s->valid.v[v] = (sum == 0) & (in[PAD_MU] >= 0);
    s->lowest.v[v] = lowest;
  }
}

/* Walks the load paths of a group; the arrays are its own. `kept`: MEMORY_VECTORS of each vector, to work in. */
INLINE void walk(const Influence *influence, global const vreal *lane_input, global const vreal *path,
                 global const vreal *heights, int increments, real tolerance, const Answers *a, global vreal *kept) {
  Cells c;
  State s;
  check_input(lane_input, path, heights, increments, &s);
  c.listed = 0;
  s.half_size = (real)0.5 * CELLS * fmax(influence->hx, influence->hy);
  EACH_VECTOR(v) {
    global const vreal *in = lane_input + v * INPUT_ROWS;
    s.d.v[v] = s.x.v[v] = s.y.v[v] = s.twist.v[v] = s.change_d.v[v] = s.change_x.v[v] = s.change_y.v[v] =
        s.change_twist.v[v] = 0;
    s.lost.v[v] = s.failed.v[v] = s.searching.v[v] = 0;
    s.by_force.v[v] = s.valid.v[v] & (in[PAD_BY_FORCE] > 0);
    s.first_tolerance.v[v] = PICK(s.by_force.v[v], ALL_LANES((real)0.1 * tolerance), ALL_LANES(tolerance));
    s.power.v[v] = (real)1.5;
    s.trial_sweeps.v[v] = s.slid.v[v] = s.slip_path.v[v] = 0;
    for (int i = 0; i < MUS; ++i)
      s.mu[i].v[v] = PICK(s.valid.v[v], in[FRICTION_MAP ? PAD_INPUT_ROWS + i : PAD_MU], ALL_LANES(0)) *
                     (influence->root_tt / influence->root_zz);
    s.x_middle.v[v] = PICK(s.valid.v[v], in[PAD_X_MIDDLE], ALL_LANES(0));
    s.y_middle.v[v] = PICK(s.valid.v[v], in[PAD_Y_MIDDLE], ALL_LANES(0));
  }
  ROLLED for (int i = 0; i < COUNT; ++i) EACH_VECTOR(v) {
    c.n[i].v[v] = c.tx[i].v[v] = c.ty[i].v[v] = c.gx[i].v[v] = c.gy[i].v[v] = 0;
    c.ux[i].v[v] = c.uy[i].v[v] = c.uz[i].v[v] = c.n_last[i].v[v] = c.tx_last[i].v[v] = c.ty_last[i].v[v] = 0;
  }
  set_own(influence, &c);
  MEMORY_IN(memory, kept);
  (void)kept; /* on vectors and elastic rubber */
  if (CREEPING) forget(memory);
  ROLLED for (int k = 0; k < increments; ++k) {
    Lanes slot;
    Target target;
    Masks solving;
    EACH_VECTOR(v) {
      global const vreal *in = lane_input + v * INPUT_ROWS;
      global const vreal *to = path + (v * increments + k) * PATH_ROWS;
      s.running.v[v] = s.valid.v[v] & (in[PAD_STEPS] > (real)k);
      slot.v[v] = PICK(s.running.v[v], to[PAD_SLOT], ALL_LANES(-1));
      target.normal.v[v] = to[PAD_NORMAL];
      target.x.v[v] = to[PAD_X];
      target.y.v[v] = to[PAD_Y];
      target.twist.v[v] = to[PAD_TWIST];
    }
    if (!any_of(&s.running)) break;
    global const vreal *creep_rows = path + k * PATH_ROWS + PAD_PATH_ROWS;
    if (CREEPING) {
      begin_creep(influence, heights, creep_rows, increments * PATH_ROWS, memory, &c, &s);
      EACH_VECTOR(v) { target.normal.v[v] *= PICK(s.by_force.v[v], s.softer.v[v], ALL_LANES(1)); }
    }
    start_increment(influence, &target, heights, &c, &s, &solving);
    do {
      list_cells(&s.active, &c);
      while (any_of(&s.active)) sweep(influence, a->most_sweeps, &c, &s);
      list_all(&c);
      sum_afresh(influence, &c);
      widen(influence, &solving, &c, &s);
      if (any_of(&s.active)) continue;
      if (any_of(&s.searching)) next_depth(influence, heights, tolerance, &c, &s);
      refine(influence, &solving, a->accept, &c, &s);
    } while (any_of(&s.active));
    Masks asked;
    EACH_VECTOR(v) {
      asked.v[v] = slot.v[v] >= 0;
      s.lost.v[v] |= s.failed.v[v];
    }
    add_slide(influence, &c, &s);
    if (any_of(&asked)) report(influence, lane_input, heights, a, &slot, &c, &s);
    remember(&c, &s);
    if (CREEPING) end_creep(creep_rows, increments * PATH_ROWS, memory, &c, &s);
  }
  /* Lanes whose input is no scene. */
  ROLLED for (int v = 0; v < VECTORS; ++v) {
    real valid[LANES];
    STORE(PICK(s.valid.v[v], ALL_LANES(1), ALL_LANES(0)), valid);
    for (int l = 0; l < LANES; ++l)
      for (int k = 0; k < (valid[l] == 0 ? a->slots : 0) * PAD_RESULT_ROWS; ++k)
        a->result[(a->first_lane + v * LANES + l) * a->slots * PAD_RESULT_ROWS + k] =
            k % PAD_RESULT_ROWS == RESULT_STATUS ? (real)LANE_INVALID : 0;
  }
}

#endif
