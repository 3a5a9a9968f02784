// SPDX-License-Identifier: Apache-2.0
/* Batched contact of rigid indenters with a pad, a layer bonded to a rigid base, each on its own CELLS x CELLS cells:
   load path, certificate, slip index and share of sticking cells; and the stress that the base feels under an array
   of tactels.

   One work-item carries VECTORS vectors of LANES scenes whose cells have one size over the thickness H and one
   Poisson's ratio: they share a table of influence. Everything is in units of H at E = 1, in the indenter's own
   frame. With tractions n >= 0 (presses) and t (drags the rubber along), and offsets from source to place,
     u_z = -sum (zz n + xz t_x + yz t_y),   u_x = sum (xx t_x + xy t_y - xz n),   u_y = sum (xy t_x + yy t_y - yz n);
   gap h - d - u_z >= 0, n >= 0, n gap = 0;   |t| <= mu n, t along the slip of the indenter over the rubber.
   Unknowns are scaled by the roots of a cell's influence on itself, n sqrt(zz0), t sqrt(tt0), so that an update has
   neither division nor diagonal term: with g where the cell would be if it stuck,
     n <- max(0, n + w (u_z - (h - d))),   t <- t + w (g - u_t), shortened to mu n where it is longer,   w = 0.85.

   The twin (fem/pad) follows the same rules:
   - An increment starts from the last change of the tractions, times the part of the load's new change along its last
     one.
   - Sweeps run over the window, the cells that press or would be penetrated, in the order of their index. A sweep is
     the last when no traction changes by more than the tolerance times the largest pressure. After DAMPED_AFTER
     sweeps steps are halved. After an increment that most_sweeps did not settle the others get DAMPED_AFTER.
   - Fresh sums at all cells then find penetrated cells outside the window; they join it, and sweeps go on.
   - Where the residual of the cells is not accepted yet, sweeps go on with a quarter of the tolerance. Slow modes, of
     nearly incompressible rubber under wide contacts, change little in a sweep long before they have settled.
   - Driven by force, sweeps go to a tenth of the tolerance, and the depth follows secants in the logarithms of depth
     and force inside a bracket until the force is met to the tolerance.
   - A sticking cell's history is its exact position, that of another one where the fresh sums find it.
   - The certificate comes from the final tractions alone; a ring of cells around the grid counts for penetration.

   A lane's result depends on nothing but the lane: lanes that have settled, and cells outside a lane's own window,
   keep their bits; a cell without tractions adds an exact 0 to sums, whose order is that of the cells.

   Built with -D REAL (float | double), LANES (1, 2, 4, 8, 16), CELLS, VECTORS, OWN_TABLES (0 | 1). With OWN_TABLES
   every lane has a table of its own, one quadrant of it, and VECTORS is 1: for sizes of cells that few scenes share.
   The bits are those of a shared table.

   FREE_SIDES 1 with LANES and VECTORS 1, OWN_TABLES 0 and WIDE (1, 2, 4, 8, 16): the sides of the pad are free. A
   work-item makes the table of all pairs of its scene's cells (pad/free_sides.h), and takes WIDE cells at a time. Rows
   of a sweep are divided by what each cell does to itself.

   FRICTION_MAP 1: mu differs from cell to cell. S then has the share of each.

   CREEP_TERMS, 1 to 4: the rubber creeps (pad/creep.h). Numbers of terms that a scene lacks are 0. */
// defines: CELLS=8 VECTORS=1 OWN_TABLES=1 FRICTION_MAP=1 CREEP_TERMS=2
// defines of WIDE: CELLS=8 VECTORS=1 OWN_TABLES=0 FREE_SIDES=1
#include "pad/creep.h"
#include "pad/increment.h"
#include "pad/residual.h"
#include "pad/slip_margin.h"
#include "pad/sweep.h"

#define INPUT_ROWS (PAD_INPUT_ROWS + FRICTION_MAP * COUNT)
#define PATH_ROWS (PAD_PATH_ROWS + (CREEPING ? 1 + CREEP_NUMBERS * CREEP_TERMS : 0))
/* n, t_x, t_y of each cell; of rubber that creeps then those that would strain elastic rubber as far. */
#define FORCE_PARTS (CREEPING ? 6 : 3)
#define MOST_FORCE_TRIALS 60
#define MOST_STEPS 16 /* load steps that the base stress is summed for at once */

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
  ROLLED for (int i = 0; i < COUNT; ++i) EACH_VECTOR(v) {
    c->open[i].v[v] = (HEIGHT(heights, v, i) - s->d.v[v]) / influence->root_zz LESS_CREPT(c, i, v);
  }
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
#if FREE_SIDES
    Lanes uz;
    if (heights[(ix + 1) * RING + iy + 1] >= PAD_OPEN) continue; /* the table lacks it */
    uz.v[0] = displacement_of_ring(influence, c, k);
#else
    Lanes ux, uy, uz;
    displacement(influence, c, ix, iy, &ux, &uy, &uz);
#endif
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
#if CREEPING
    const vreal force = in[PAD_FORCE] / s->softer.v[v];
#else
    const vreal force = in[PAD_FORCE];
#endif
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
#if CREEPING
      const vreal ux = c->ux[i].v[v] + CREPT(c, 0, i, v), uy = c->uy[i].v[v] + CREPT(c, 1, i, v);
#else
      const vreal ux = c->ux[i].v[v], uy = c->uy[i].v[v];
#endif
#if FRICTION_MAP
      grip = fma(MU(i, v), n, grip);
#endif
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
#if FRICTION_MAP
    to[PAD_RESULT_MU] = PICK(P > 0, grip * t_unit / (P * n_unit), in[PAD_MU]);
#endif
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
#if CREEPING
        if (part >= 3) {
          const vreal traction = part == 3 ? c->n[i].v[v] : part == 4 ? c->tx[i].v[v] : c->ty[i].v[v];
          STORE((traction + CREPT(c, part, i, v)) * (part == 3 ? n_unit : t_unit) * in[PAD_FORCE], number);
        } else
#endif
          STORE((part == 0 ? c->n[i].v[v] * n_unit : (part == 1 ? c->tx[i].v[v] : c->ty[i].v[v]) * t_unit) * force,
                number);
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

/* Walks the load paths of a group; the arrays are its own. */
INLINE void walk(const Influence *influence, global const vreal *lane_input, global const vreal *path,
                 global const vreal *heights, int increments, real tolerance, const Answers *a) {
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
#if FREE_SIDES
    global const real *own = influence->table + (size_t)PAIR_PLANES * COUNT * i + i;
    c.per_own_n[i].v[v] = 1 / own[PLANE_ZN * COUNT];
    c.per_own_t[i].v[v] = 1 / fmax(own[PLANE_XX * COUNT], own[PLANE_YY * COUNT]);
#endif
  }
#if CREEPING
  Memory memory;
  forget(&memory);
#endif
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
#if CREEPING
    global const vreal *creep_rows = path + k * PATH_ROWS + PAD_PATH_ROWS;
    begin_creep(influence, heights, creep_rows, increments * PATH_ROWS, &memory, &c, &s);
    EACH_VECTOR(v) { target.normal.v[v] *= PICK(s.by_force.v[v], s.softer.v[v], ALL_LANES(1)); }
#endif
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
#if CREEPING
    end_creep(creep_rows, increments * PATH_ROWS, &memory, &c, &s);
#endif
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

#if !FREE_SIDES
/* tables [tables][PAD_TABLE_HEAD + (2 CELLS + 1)^2 PAD_INFLUENCE], table_of [groups]; or, with OWN_TABLES,
   [groups][PAD_TABLE_HEAD + (CELLS + 1)^2 PAD_OWN_INFLUENCE][lane], and table_of is not read. The other arrays are as
   kernels/shared/pad_layout.h has them; those of the launch begin with vector `first_vector` of all.
   Out: result; forces [lane of all groups][slots][FORCE_PARTS][cells] N, in the own frame, where write_forces is not
   0. */
kernel void pad_contact(uint first_group, global const side *tables, global const int *table_of, int first_vector,
                        global const vreal *lane_input, global const vreal *path, global const vreal *heights,
                        int increments, int slots, int write_forces, real tolerance, real accept, int most_sweeps,
                        global real *result, global real *forces) {
  TAKE_GROUP(group);
#if OWN_TABLES
  (void)table_of;
  global const side *head = tables + group * (PAD_TABLE_HEAD + (CELLS + 1) * (CELLS + 1) * PAD_OWN_INFLUENCE),
                    *table = head + PAD_TABLE_HEAD;
#else
  global const side *head = tables + (size_t)table_of[group] * (PAD_TABLE_HEAD + SPAN * SPAN * PAD_INFLUENCE);
  global const side *table = head + PAD_TABLE_HEAD + PAD_INFLUENCE * (CELLS * SPAN + CELLS);
#endif
  const Influence influence = {table, head[PAD_ROOT_ZZ], head[PAD_ROOT_TT], head[PAD_HX], head[PAD_HY]};
  const size_t vector = first_vector + group * VECTORS;
  const Answers answers = {vector * LANES, slots, write_forces, most_sweeps, accept, result, forces};
  walk(&influence, lane_input + vector * INPUT_ROWS, path + vector * increments * PATH_ROWS,
       heights + vector * RING * RING, increments, tolerance, &answers);
}
#endif

#if FREE_SIDES
/* The same with free sides, a scene a work-item. layers [scenes][PAD_TABLE_HEAD + (CELLS + 1)^2 PAD_OWN_INFLUENCE]: the
   layer's means; softs [scenes][COUNT]: compliances that cells have of their own, over H; pairs [groups of the
   launch][PAIR_NUMBERS]: memory to work in. SidePart (pad/free_sides.h) tells the others. The launch begins with scene
   first_scene. */
kernel void pad_free_contact(uint first_group, global real *pairs, global const real *layers, global const real *softs,
                             global const real *between, int nodes_x, int nodes_y, real side_x, real side_y,
                             int first_scene, global const vreal *lane_input, global const vreal *path,
                             global const vreal *heights, int increments, int slots, int write_forces, real tolerance,
                             real accept, int most_sweeps, global real *result, global real *forces) {
  TAKE_GROUP(group);
  const size_t scene = first_scene + group;
  const SidePart part = {between, nodes_x, nodes_y, side_x, side_y};
  global const real *head = layers + scene * (PAD_TABLE_HEAD + (CELLS + 1) * (CELLS + 1) * PAD_OWN_INFLUENCE);
  global real *table = pairs + group * PAIR_NUMBERS;
  lane_input += scene * INPUT_ROWS;
  heights += scene * RING * RING;
  make_pairs(&part, head, softs + scene * COUNT, lane_input, heights, table);
  const Influence influence = {table, head[PAD_ROOT_ZZ], head[PAD_ROOT_TT], head[PAD_HX], head[PAD_HY]};
  const Answers answers = {scene, slots, write_forces, most_sweeps, accept, result, forces};
  walk(&influence, lane_input, path + scene * increments * PATH_ROWS, heights, increments, tolerance, &answers);
}

/* Adds what free sides change in the stress at the base, one scene a work-item. `response_of` [scenes]: the scene's
   among `responses`, [3 nodes][3 tactels up to a multiple of SUMMANDS]: stress over 1 / H^2 by unit forces x, y, z on
   the nodes of the block. The other arrays are those of pad_contact and pad_base_stress. */
kernel void pad_side_stress(uint first_group, global const real *responses, global const int *response_of, int nodes_x,
                            int nodes_y, real side_x, real side_y, global const real *lane_input,
                            global const real *places, int tactels, int slots, global const real *forces,
                            global real *stress) {
  TAKE_GROUP(group);
  const SidePart part = {0, nodes_x, nodes_y, side_x, side_y};
  global const real *place = places + group * PAD_PLACE_ROWS, *in = lane_input + group * INPUT_ROWS;
  const int numbers = 3 * tactels, row = (numbers + SUMMANDS - 1) / SUMMANDS * SUMMANDS, nodes = nodes_x * nodes_y;
  global const real *response = responses + (size_t)response_of[group] * 3 * nodes * row;
  const real unit = place[PAD_PLACE_THICKNESS] * place[PAD_PLACE_THICKNESS];
  real on_node[3 * MOST_SIDE_NODES * MOST_SIDE_NODES];
  for (int k = 0; k < (int)place[PAD_PLACE_STEPS]; ++k) {
    global const real *f = forces + (group * slots + k) * FORCE_PARTS * COUNT;
    for (int m = 0; m < 3 * nodes; ++m) on_node[m] = 0;
    for (int i = 0; i < COUNT; ++i) {
      const real n = f[i], tx = f[COUNT + i], ty = f[2 * COUNT + i];
      if (!(n > 0)) continue;
      NodeShares at;
      shares_at(&part, in,
                place[PAD_PLACE_X_MIDDLE] + ((real)(i / CELLS) - (real)0.5 * (CELLS - 1)) * place[PAD_PLACE_HX],
                place[PAD_PLACE_Y_MIDDLE] + ((real)(i % CELLS) - (real)0.5 * (CELLS - 1)) * place[PAD_PLACE_HY], &at);
      const real x = place[PAD_PLACE_COSINE] * tx - place[PAD_PLACE_SINE] * ty,
                 y = place[PAD_PLACE_SINE] * tx + place[PAD_PLACE_COSINE] * ty;
      for (int m = 0; m < 16; ++m) {
        real *to = on_node + 3 * ((at.x + m / 4) * nodes_y + at.y + m % 4);
        to[0] = fma(at.share[m], x, to[0]);
        to[1] = fma(at.share[m], y, to[1]);
        to[2] = fma(at.share[m], -n, to[2]);
      }
    }
    global real *to = stress + (group * slots + k) * numbers;
    for (int at = 0; at < numbers; at += SUMMANDS) {
      wide sum[PARTS];
      real found[SUMMANDS];
      EACH(p, PARTS) { sum[p] = 0; }
      for (int m = 0; m < 3 * nodes; ++m) EACH(p, PARTS) {
          sum[p] = fma((wide)(on_node[m]), LOAD_WIDE(response + (size_t)m * row + at + p * WIDE), sum[p]);
        }
      EACH(p, PARTS) { STORE_WIDE(sum[p], found + p * WIDE); }
      for (int l = 0; l < SUMMANDS && at + l < numbers; ++l) to[at + l] = fma(unit, found[l], to[at + l]);
    }
  }
}
#else
/* Stress at the base under tactels in the lanes, one scene and LANES tactels a work-item, from the forces of
   pad_contact: the layer's kernels (fem/pad/pad_integrals.h) by a table in rho, the sum over points of each cell, four
   Gauss points or the parts of a wide one (PadLayer::shares). A tactel is the weighted mean of `parts` points. layer [rows][PAD_BLOCK], rows_a_thickness rows for each H and
   layer_rows for each Poisson's ratio; places [scenes][PAD_PLACE_ROWS]; points [blocks][parts][x, y][LANES] mm: times
   1 / H of the scene; weights [parts]; shares [points of a cell along a side][place over the side, share of its force].
   Out: stress [scenes][slots][numbers], from `from` on [3][tactels] MPa: sigma_z, tau_x, tau_y in the pad's frame. With
   another table, of displacements at a depth, and markers in place of tactels: u_z, u_x, u_y in mm. first_part: the
   first of the FORCE_PARTS that are summed. */
kernel void pad_base_stress(uint first_group, global const real *layer, int layer_rows, real rows_a_thickness,
                            global const real *places, global const real *shares, global const real *points,
                            global const real *weights, int parts, int tactels, int slots, int numbers, int from,
                            int first_part, global const real *forces, global real *stress) {
  TAKE_GROUP(group);
  const size_t blocks = (tactels + LANES - 1) / LANES, scene = group / blocks, block = group % blocks;
  global const real *place = places + scene * PAD_PLACE_ROWS;
  const int steps = (int)place[PAD_PLACE_STEPS];
  const real cosine = place[PAD_PLACE_COSINE], sine = place[PAD_PLACE_SINE], hx = place[PAD_PLACE_HX],
             hy = place[PAD_PLACE_HY];
  global const real *shares_x = shares + 2 * (int)place[PAD_PLACE_SHARES_X],
                    *shares_y = shares + 2 * (int)place[PAD_PLACE_SHARES_Y];
  const int along_y = (int)place[PAD_PLACE_COUNT_Y], in_cell = (int)place[PAD_PLACE_COUNT_X] * along_y;
  const real per_H = place[PAD_PLACE_THICKNESS];
  points += block * parts * 2 * LANES;
  forces += (scene * slots * FORCE_PARTS + first_part) * COUNT;
  stress += scene * slots * numbers + from + block * LANES;
  const int own_tactels = tactels - (int)block * LANES < LANES ? tactels - (int)block * LANES : LANES;
  vreal sum[3 * MOST_STEPS];
  for (int first = 0; first < steps; first += MOST_STEPS) {
    const int count = steps - first < MOST_STEPS ? steps - first : MOST_STEPS;
    for (int k = 0; k < 3 * count; ++k) sum[k] = 0;
    for (int i = 0; i < COUNT; ++i) {
      int loaded = 0;
      for (int k = 0; k < count; ++k) loaded |= forces[(first + k) * FORCE_PARTS * COUNT + i] > 0;
      if (!loaded) continue;
      vreal T[9];
      EACH(r, 9) { T[r] = 0; }
      ROLLED for (int p = 0; p < in_cell * parts; ++p) {
        const int part = p / in_cell;
        global const real *at_x = shares_x + 2 * (p % in_cell / along_y), *at_y = shares_y + 2 * (p % along_y);
        /* The point in the own frame, from the middle of the grid. */
        const vreal px = LOAD(points + 2 * part * LANES) * per_H - place[PAD_PLACE_X],
                    py = LOAD(points + (2 * part + 1) * LANES) * per_H - place[PAD_PLACE_Y];
        const vreal own_x = cosine * px + sine * py - place[PAD_PLACE_X_MIDDLE],
                    own_y = cosine * py - sine * px - place[PAD_PLACE_Y_MIDDLE];
        const vreal x = own_x - ((real)(i / CELLS) - (real)0.5 * (CELLS - 1) + at_x[0]) * hx;
        const vreal y = own_y - ((real)(i % CELLS) - (real)0.5 * (CELLS - 1) + at_y[0]) * hy;
        const vreal rho = sqrt(fma(x, x, y * y)), per_rho = 1 / LARGER(rho, ALL_LANES((real)1e-20));
        const real weight = at_x[1] * at_y[1] * weights[part];
        Place at = place_in(rho * rows_a_thickness, layer_rows - 1);
        EACH(l, LANES) { at.cell[l] += (int)place[PAD_PLACE_LAYER]; }
        vreal c[PAD_BLOCK], b[5];
        gather_rows(layer, at.cell, c);
        EACH(f, 5) { b[f] = weight * fma(fma(c[3 * f + 2], at.q, c[3 * f + 1]), at.q, c[3 * f]); }
        const vreal ct = PICK(rho > 0, x * per_rho, ALL_LANES(1)), st = y * per_rho, even = b[2] * (ct * ct - st * st),
                    odd = b[2] * 2 * ct * st;
        T[0] -= b[0]; /* sigma_z by n, t_x, t_y */
        T[1] -= ct * b[4];
        T[2] -= st * b[4];
        T[3] += ct * b[3]; /* tau_x */
        T[4] += b[1] - even;
        T[5] -= odd;
        T[6] += st * b[3]; /* tau_y */
        T[7] -= odd;
        T[8] += b[1] + even;
      }
      for (int k = 0; k < count; ++k) {
        global const real *f = forces + (first + k) * FORCE_PARTS * COUNT + i;
        const real n = f[0], tx = f[COUNT], ty = f[2 * COUNT];
        EACH(r, 3) {
          sum[3 * k + r] = fma(T[3 * r], ALL_LANES(n),
                               fma(T[3 * r + 1], ALL_LANES(tx), fma(T[3 * r + 2], ALL_LANES(ty), sum[3 * k + r])));
        }
      }
    }
    const real unit = place[PAD_PLACE_STRESS];
    for (int k = 0; k < count; ++k) {
      const vreal turned[3] = {unit * sum[3 * k], unit * (cosine * sum[3 * k + 1] - sine * sum[3 * k + 2]),
                               unit * (sine * sum[3 * k + 1] + cosine * sum[3 * k + 2])};
      for (int r = 0; r < 3; ++r) {
        real lane[LANES];
        STORE(turned[r], lane);
        for (int l = 0; l < own_tactels; ++l) stress[(size_t)(first + k) * numbers + r * tactels + l] = lane[l];
      }
    }
  }
}
#endif
