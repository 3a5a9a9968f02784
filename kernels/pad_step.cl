// SPDX-License-Identifier: Apache-2.0
/* One increment of many contacts with one pad, whose state stays in buffers between launches: contacts inside a
   simulator, which knows the next pose or wrench only then. A contact a lane; the laws, the sweeps and their rules are
   those of kernels/pad_contact.cl, in the same code: the increments of a path, one a launch, have the bits of the path,
   where the object covers little of the grid. Where it covers most of it they agree within the tolerance of sweeps, for
   such contacts are split (kernels/pad/splitting.h).

   - Cells are fixed to the pad, CELLS x CELLS_Y of one size about its middle; all contacts share one table. Heights come
     anew with each step. What the object does to the friction is its motion alone: heights that travel do not drag.
   - A cell that the object covers in part, by the share f, has the compliance 1 / f - 1 of its own beside that of the
     table, over that of a cell on itself; a row of a sweep is divided by the sum of both.
   - By motion: `input` has the pose after the step. By wrench: it has the wrench, and the kernel finds the pose
     (kernels/pad/pose_search.h). A contact whose wrench is met, and whose heights are the same, keeps its bits.
   - Numbers that are no input, or lie beyond STEP_MOST_DEPTH and its like, leave a contact as it was (STEP_INVALID).
   - A step whose wrench is not met in most_solves poses, or whose residual is not accepted, has the flag STEP_UNMET;
     it counts all the same, as far as it came.

   A lane's result depends on nothing but the lane, as there.

   Built with -D REAL, LANES, CELLS, VECTORS as kernels/pad_contact.cl, CELLS_Y, and DENSE (0 | 1): with a table of all
   pairs of cells, where what a cell does depends on its place. */
// defines: CELLS=8 CELLS_Y=6 VECTORS=1 DENSE=1 CREEP_TERMS=2 MARKED=1 FRICTION_MAP=1
#define STEPPED 1
#define INPUT_ROWS (STEP_INPUT_ROWS + FRICTION_MAP * COUNT)
#include "pad/table_sums.h"
#include "pad/nearby.h"
#include "pad/pose_search.h"
#include "pad/residual.h"
#include "pad/splitting.h"
#include "pad/step_creep.h"

/* A number of 24 bits that heights, covers and mu give: it tells whether they are those of the last step. */
static vreal mark_of(global const vreal *in, global const vreal *heights, global const vreal *soft, int v) {
  vint mark = AS_VINT(in[STEP_MU]);
  for (int i = 0; i < COUNT; ++i) {
    mark = mark * 31 + AS_VINT(HEIGHT(heights, v, i));
    mark = mark * 31 + AS_VINT(soft[v * COUNT + i]);
    if (FRICTION_MAP)
      mark += 7 * (AS_VINT(in[STEP_INPUT_ROWS + i]) - AS_VINT(in[STEP_MU])); /* one mu: as without map */
    mark ^= mark >> 15;
  }
  return TO_VREAL(mark & 0xffffff);
}

/* Whether the pose or the wrench asked for is one. `deep` takes poses below the rubber. */
static vint is_target(global const vreal *in, vreal lowest, int by_wrench, vint *deep) {
  const real most = by_wrench ? (real)STEP_MOST_FORCE : (real)STEP_MOST_WAY;
  vint within = fabs(in[STEP_TO + 1]) <= most;
  within &= fabs(in[STEP_TO + 2]) <= most;
  within &= fabs(in[STEP_TO + 3]) <= most;
  *deep = by_wrench ? (vint)0 : in[STEP_TO] - lowest > (real)STEP_MOST_DEPTH;
  return within & (by_wrench ? fabs(in[STEP_TO]) <= most : NOT(*deep));
}

/* Lanes whose input is finite and sensible, their lowest heights, and where they were. */
static void load_numbers(const Influence *influence, global const vreal *input, global const vreal *heights,
                         global const vreal *soft, global const vreal *state, int by_wrench, State *s) {
  s->half_size = (real)0.5 * fmax(CELLS * influence->hx, CELLS_Y * influence->hy);
  EACH_VECTOR(v) {
    global const vreal *in = input + v * INPUT_ROWS, *own = state + v * STATE_ROWS + STEP_FIELDS * COUNT;
    vreal sum = 0, lowest = PAD_OPEN;
    vint sensible = in[STEP_MU] >= 0;
    for (int r = 0; r < INPUT_ROWS; ++r) sum = finite_sum(sum, in[r]);
    for (int i = 0; i < COUNT; ++i) {
      const vreal h = HEIGHT(heights, v, i), e = soft[v * COUNT + i];
      sum = finite_sum(finite_sum(sum, h), e);
      sensible &= e >= 0;
      lowest = SMALLER(h, lowest);
    }
    sensible &= (LARGER(fabs(in[STEP_AXIS_X]), fabs(in[STEP_AXIS_Y])) <= (real)STEP_MOST_WAY) | (lowest >= PAD_OPEN);
    sensible &= is_target(in, lowest, by_wrench, &s->below.v[v]);
    const vint valid = (sum == 0) & sensible;
    s->valid.v[v] = s->running.v[v] = valid;
    s->lowest.v[v] = PICK(valid, lowest, ALL_LANES(PAD_OPEN));
    for (int i = 0; i < MUS; ++i)
      MU(i, v) = PICK(valid, in[FRICTION_MAP ? STEP_INPUT_ROWS + i : STEP_MU], ALL_LANES(0)) *
                 (influence->root_tt / influence->root_zz);
    s->x_middle.v[v] = -PICK(valid, in[STEP_AXIS_X], ALL_LANES(0));
    s->y_middle.v[v] = -PICK(valid, in[STEP_AXIS_Y], ALL_LANES(0));
    s->d.v[v] = own[STEP_POSE];
    s->x.v[v] = own[STEP_POSE + 1];
    s->y.v[v] = own[STEP_POSE + 2];
    s->twist.v[v] = own[STEP_POSE + 3];
    s->change_d.v[v] = own[STEP_CHANGE];
    s->change_x.v[v] = own[STEP_CHANGE + 1];
    s->change_y.v[v] = own[STEP_CHANGE + 2];
    s->change_twist.v[v] = own[STEP_CHANGE + 3];
    s->anew.v[v] = valid & (mark_of(in, heights, soft, v) != own[STEP_MARK]);
    s->by_force.v[v] = s->searching.v[v] = s->failed.v[v] = s->lost.v[v] = 0;
    s->power.v[v] = (real)1.5;
    s->slid.v[v] = s->trial_sweeps.v[v] = s->sweeps.v[v] = 0;
  }
}

static void load_cells(const Influence *influence, global const vreal *soft, global const vreal *state, real softer,
                       const State *s, Cells *c) {
  ROLLED for (int i = 0; i < COUNT; ++i) EACH_VECTOR(v) {
    global const vreal *own = state + v * STATE_ROWS + i;
    c->n[i].v[v] = own[STEP_N * COUNT] * softer;
    c->tx[i].v[v] = own[STEP_TX * COUNT] * softer;
    c->ty[i].v[v] = own[STEP_TY * COUNT] * softer;
    c->n_last[i].v[v] = own[STEP_N_LAST * COUNT] * softer;
    c->tx_last[i].v[v] = own[STEP_TX_LAST * COUNT] * softer;
    c->ty_last[i].v[v] = own[STEP_TY_LAST * COUNT] * softer;
    c->soft[i].v[v] = PICK(s->valid.v[v], soft[v * COUNT + i], ALL_LANES(0));
    global const real *entry = influence->table + (size_t)PAD_PAIR * (COUNT + 1) * i;
    const real own_n = DENSE ? entry[PAD_ZZ] : (real)1, own_t = DENSE ? fmax(entry[PAD_XX], entry[PAD_YY]) : (real)1;
    c->per_own_n[i].v[v] = 1 / (own_n + c->soft[i].v[v]);
    c->per_own_t[i].v[v] = 1 / (own_t + c->soft[i].v[v]);
    c->ux[i].v[v] = c->uy[i].v[v] = 0;
    c->uz[i].v[v] = CREEP_TERMS > 0 ? softer * own[CREEP_AT + 2 * COUNT] : own[STEP_UZ * COUNT];
  }
}

/* After come_near: what friction remembers, and cells that are far. */
static void load_history(global const vreal *state, Cells *c) {
  ROLLED for (int i = 0; i < COUNT; ++i) EACH_VECTOR(v) {
    global const vreal *own = state + v * STATE_ROWS + i;
    c->gx[i].v[v] = own[STEP_GX * COUNT];
    c->gy[i].v[v] = own[STEP_GY * COUNT];
    c->uz[i].v[v] = PICK(c->near[i].v[v], c->uz[i].v[v], ALL_LANES(-PAD_OPEN));
  }
}

static void store(global const vreal *input, global const vreal *heights, global const vreal *soft, const Cells *c,
                  const State *s, const Search *w, int by_wrench, const Lanes *missing, real softer,
                  global vreal *state) {
  const real stiffer = 1 / softer;
#define KEEP(to, value) (to) = PICK(s->valid.v[v], value, to)
  EACH_VECTOR(v) {
    global vreal *own = state + v * STATE_ROWS + STEP_FIELDS * COUNT;
    KEEP(own[STEP_POSE], s->d.v[v]);
    KEEP(own[STEP_POSE + 1], s->x.v[v]);
    KEEP(own[STEP_POSE + 2], s->y.v[v]);
    KEEP(own[STEP_POSE + 3], s->twist.v[v]);
    KEEP(own[STEP_CHANGE], s->change_d.v[v]);
    KEEP(own[STEP_CHANGE + 1], s->change_x.v[v]);
    KEEP(own[STEP_CHANGE + 2], s->change_y.v[v]);
    KEEP(own[STEP_CHANGE + 3], s->change_twist.v[v]);
    KEEP(own[STEP_MARK], mark_of(input + v * INPUT_ROWS, heights, soft, v));
    if (!by_wrench) continue;
    KEEP(own[STEP_POWER], w->power.v[v]);
    EACH(k, 3) { KEEP(own[STEP_WAY + k], missing[k].v[v]); }
    EACH(k, 9) { KEEP(own[STEP_INVERSE + k], w->inverse[k].v[v]); }
  }
  ROLLED for (int i = 0; i < COUNT; ++i) EACH_VECTOR(v) {
    global vreal *own = state + v * STATE_ROWS + i;
    KEEP(own[STEP_N * COUNT], c->n[i].v[v] * stiffer);
    KEEP(own[STEP_TX * COUNT], c->tx[i].v[v] * stiffer);
    KEEP(own[STEP_TY * COUNT], c->ty[i].v[v] * stiffer);
    KEEP(own[STEP_N_LAST * COUNT], c->n_last[i].v[v] * stiffer);
    KEEP(own[STEP_TX_LAST * COUNT], c->tx_last[i].v[v] * stiffer);
    KEEP(own[STEP_TY_LAST * COUNT], c->ty_last[i].v[v] * stiffer);
    KEEP(own[STEP_GX * COUNT], c->gx[i].v[v]);
    KEEP(own[STEP_GY * COUNT], c->gy[i].v[v]);
    KEEP(own[STEP_UZ * COUNT], PICK(c->near[i].v[v], c->uz[i].v[v], ALL_LANES((real)STEP_UNKNOWN)));
    if (CREEP_TERMS > 0)
      own[STEP_UZ * COUNT] = PICK(s->valid.v[v], own[STEP_UZ * COUNT], ALL_LANES((real)STEP_UNKNOWN));
  }
#undef KEEP
}

/* Whether an outermost cell presses at one of the sides -x, +x, -y, +y (1, 2, 4, 8). */
static vint at_edge(const Cells *c, int sides, int v) {
  vint edge = 0;
  for (int k = 0; k < c->listed; ++k) {
    const int i = c->list[k], x = i / CELLS_Y, y = i % CELLS_Y;
    const int at = (x == 0 ? 1 : 0) + (x == CELLS - 1 ? 2 : 0) + (y == 0 ? 4 : 0) + (y == CELLS_Y - 1 ? 8 : 0);
    if (at & sides) edge |= c->n[i].v[v] > 0;
  }
  return edge;
}

/* Whether a contact is deeper than the linear model holds. */
static vint is_deep(global const vreal *heights, const Cells *c, const State *s, vreal touch, int v) {
  vreal flat = 0;
  for (int k = 0; k < c->listed; ++k) {
    const int i = c->list[k];
    flat +=
        PICK((c->n[i].v[v] > 0) & (HEIGHT(heights, v, i) < (real)STEP_FLAT * s->d.v[v]), ALL_LANES(1), ALL_LANES(0));
  }
  const vreal limit =
      PICK((touch > 4) & (2 * flat >= touch), ALL_LANES((real)STEP_DEEP_FACE), ALL_LANES((real)STEP_DEEP_CURVED));
  return ((touch > 0) & (s->d.v[v] - s->lowest.v[v] >= limit * (real)(1 - 1e-6))) | s->below.v[v];
}

/* Sums of flags of where the object is. */
static vreal place_flags(global const vreal *in, global const vreal *heights, real reach, int sides, int by_wrench,
                         const Cells *c, const State *s, vreal touch, int v) {
  const vreal beyond = in[STEP_BEYOND], d = s->d.v[v], over = LARGER(d - s->lowest.v[v], ALL_LANES((real)1e-6));
  const vint known = beyond >= 0, unseen = by_wrench ? (in[STEP_TO] > 0) & (s->lowest.v[v] >= PAD_OPEN) : (vint)0;
  const vint edge = at_edge(c, sides, v) & (NOT(known) | (beyond - d < reach * over)),
             reaches = known & (beyond < PAD_OPEN) & ((d > beyond) | unseen);
  return PICK(edge, ALL_LANES(STEP_EDGE), ALL_LANES(0)) + PICK(reaches, ALL_LANES(STEP_REACH), ALL_LANES(0)) +
         PICK(is_deep(heights, c, s, touch, v), ALL_LANES(STEP_DEEP), ALL_LANES(0)) +
         PICK(s->valid.v[v], ALL_LANES(0), ALL_LANES(STEP_INVALID));
}

/* The mean slide in this increment of the cells that touch, x, y, and its turn times their rms distance from their
   middle, over H. Those that stick have none. */
static inline void mean_slide(const Influence *influence, const Cells *c, const State *s, int v, vreal mean[3]) {
  vreal touching = 0, X = 0, Y = 0, R2 = 0, sum_x = 0, sum_y = 0, turn = 0;
  for (int k = 0; k < c->listed; ++k) {
    const int i = c->list[k];
    const real x = x_of(influence, i), y = y_of(influence, i);
    const vreal n = c->n[i].v[v], tx = c->tx[i].v[v], ty = c->ty[i].v[v], cone = INSIDE_CONE * MU(i, v) * n,
                touches = PICK(n > 0, ALL_LANES(1), ALL_LANES(0));
    const vint slips = (n > 0) & NOT(fma(tx, tx, ty * ty) < cone * cone);
    const vreal slip_x = PICK(slips, c->gx[i].v[v] - c->ux[i].v[v], ALL_LANES(0)),
                slip_y = PICK(slips, c->gy[i].v[v] - c->uy[i].v[v], ALL_LANES(0));
    touching += touches;
    X += x * touches, Y += y * touches, R2 += (x * x + y * y) * touches;
    sum_x += slip_x, sum_y += slip_y, turn += x * slip_y - y * slip_x;
  }
  const vreal per = 1 / LARGER(touching, ALL_LANES(1)), unit = per * influence->root_tt;
  const vreal radius2 = R2 * per - (X * X + Y * Y) * per * per;
  mean[0] = sum_x * unit, mean[1] = sum_y * unit;
  mean[2] = (turn - (X * sum_y - Y * sum_x) * per) * unit /
            sqrt(LARGER(radius2, ALL_LANES((real)1e-6 * influence->hx * influence->hy)));
}

static Influence influence_of(global const real *table) {
  global const real *entries = table + PAD_TABLE_HEAD;
  if (!DENSE) entries += PAD_INFLUENCE * (CELLS * SPAN + CELLS_Y);
  const Influence influence = {entries, table[PAD_ROOT_ZZ], table[PAD_ROOT_TT], table[PAD_HX], table[PAD_HY]};
  return influence;
}

/* Rows of `result` of all lanes. */
OUTLINE void answer(const Influence *influence, global const vreal *input, global const vreal *heights, real accept,
                    real force, real thickness, real reach, int sides, const Cells *c, const State *s, const Search *w,
                    int by_wrench, size_t first_lane, global real *result) {
  Totals f;
  Residual r;
  totals(influence, c, s, &f);
  residual_of_cells(influence, c, s, &r);
  ROLLED for (int v = 0; v < VECTORS; ++v) {
    vreal rows[STEP_RESULT_ROWS];
    const vreal X = f.X.v[v], Y = f.Y.v[v], touch = f.touch.v[v];
    const vreal worst = LARGER(
        LARGER(LARGER(r.penetration.v[v], r.complementarity.v[v]), LARGER(r.drift.v[v], r.angle.v[v])), r.cone.v[v]);
    const vint finite =
        finite_sum(finite_sum(finite_sum(finite_sum(0, f.P.v[v]), X), Y), r.drift.v[v] + r.angle.v[v]) == 0;
    const vint slides = ((touch > 0) & (f.stick.v[v] == 0)) |
                        (by_wrench ? NOT(w->met.v[v]) & w->beyond.v[v] & NOT(s->failed.v[v]) & (touch > 0) : (vint)0);
    const vint missed = by_wrench ? (w->P.v[v] > 0) & (touch == 0) : (vint)0;
    const vint unmet = s->failed.v[v] | missed | NOT(finite & (worst <= accept));
    rows[STEP_RESULT_P] = f.P.v[v] * force;
    rows[STEP_RESULT_QX] = X * force;
    rows[STEP_RESULT_QY] = Y * force;
    rows[STEP_RESULT_M] = (f.M.v[v] + (s->x_middle.v[v] * Y - s->y_middle.v[v] * X)) * force * thickness;
    rows[STEP_RESULT_DEPTH] = s->d.v[v] * thickness;
    rows[STEP_RESULT_X] = s->x.v[v] * thickness;
    rows[STEP_RESULT_Y] = s->y.v[v] * thickness;
    rows[STEP_RESULT_TWIST] = s->twist.v[v];
    rows[STEP_RESULT_S] = slip_margin(influence, c, s, v);
    rows[STEP_RESULT_STICK] = f.stick.v[v] / LARGER(touch, ALL_LANES(1));
    rows[STEP_RESULT_TOUCH] = touch;
    rows[STEP_RESULT_FLAGS] = PICK(touch == 0, ALL_LANES(STEP_OPEN), ALL_LANES(0)) +
                              PICK(slides, ALL_LANES(STEP_SLIDES), ALL_LANES(0)) +
                              PICK(unmet, ALL_LANES(STEP_UNMET), ALL_LANES(0)) +
                              place_flags(input + v * INPUT_ROWS, heights, reach, sides, by_wrench, c, s, touch, v);
    rows[STEP_RESULT_SOLVES] = by_wrench ? w->solves.v[v] : PICK(s->sweeps.v[v] > 0, ALL_LANES(1), ALL_LANES(0));
    rows[STEP_RESULT_SWEEPS] = s->sweeps.v[v];
    rows[STEP_RESULT_RESIDUAL] = worst;
    vreal mean[3];
    mean_slide(influence, c, s, v, mean);
    EACH(k, 3) { rows[STEP_RESULT_MEAN + k] = PICK(s->sweeps.v[v] > 0, mean[k] * thickness, ALL_LANES(0)); }
    rows[STEP_RESULT_SLID] = PICK(s->sweeps.v[v] > 0, rms_slide(influence, c, v) * thickness, ALL_LANES(0));
    real number[LANES];
    for (int k = 0; k < STEP_RESULT_ROWS; ++k) {
      STORE(rows[k], number);
      for (int l = 0; l < LANES; ++l) result[(first_lane + v * LANES + l) * STEP_RESULT_ROWS + k] = number[l];
    }
  }
}

/* table [PAD_TABLE_HEAD + (2 CELLS + 1) (2 CELLS_Y + 1) PAD_INFLUENCE], DENSE [PAD_TABLE_HEAD + cells cells PAD_PAIR];
   heights, soft [group][vector][cells][lane]: over H, above the object's lowest point, where its depth counts from,
   PAD_OPEN where there is no object; 1 / f - 1. The other arrays are as kernels/shared/pad_step_layout.h has them.
   kt, kr: Stiffness; force: E H^2, N; thickness: H, mm; reach: cells are near up to that part of the depth above it;
   travel: the longest motion of a solve along the pad; sides: sum of 1, 2, 4, 8 where rubber lies beyond -x, +x, -y,
   +y; blocks, rho_n, rho_t: of kernels/pad/splitting.h, [2][4][BLOCK_ROUNDS][BLOCK_ROWS][STEP_ROUND], B and
   (B + rho)^-1; wide_from: cells in the window of a contact that is split. creep: how much softer rubber that creeps is
   in the step, then its terms [CREEP_TERMS][CREEP_NUMBERS]. */
kernel void pad_step(uint first_group, global const real *table, global const real *blocks, real rho_n, real rho_t,
                     int wide_from, global const vreal *input, global const vreal *heights, global const vreal *soft,
                     int by_wrench, real kt, real kr, real force, real thickness, real tolerance, real accept,
                     real force_tolerance, int most_sweeps, int most_solves, real reach, real travel, int sides,
                     global vreal *state, global real *result, global const real *creep) {
  TAKE_GROUP(group);
  const Influence influence = influence_of(table);
  const Stiffness stiff = {kt, kr};
  const size_t vector = group * VECTORS;
  input += vector * INPUT_ROWS;
  heights += vector * COUNT;
  soft += vector * COUNT;
  state += vector * STATE_ROWS;
  const real softer = CREEP_TERMS > 0 ? creep[0] : (real)1;
  if (CREEP_TERMS > 0) heights = begin_creep(&influence, creep, heights, state);

  Cells c;
  State s;
  Search search;
  Target target;
  Split splitting;
  Lanes missing[3];
  load_numbers(&influence, input, heights, soft, state, by_wrench, &s);
  load_cells(&influence, soft, state, softer, &s, &c);
  list_pressing(&c);
  if (by_wrench) {
    first_pose(&influence, &stiff, input, state + STEP_FIELDS * COUNT, STATE_ROWS, force_tolerance, travel, &c, &s,
               &search, &target, missing);
  } else {
    EACH_VECTOR(v) {
      global const vreal *to = input + v * INPUT_ROWS + STEP_TO;
      target.normal.v[v] = LARGER(to[0], ALL_LANES((real)-STEP_MOST_WAY));
      target.x.v[v] = to[1];
      target.y.v[v] = to[2];
      target.twist.v[v] = to[3];
    }
  }
  Masks solving, wants;
  EACH_VECTOR(v) {
    wants.v[v] = s.searching.v[v];
    s.anew.v[v] |= wants.v[v];
    s.searching.v[v] = 0;
    s.first_tolerance.v[v] = tolerance;
    s.deep.v[v] = PICK(s.valid.v[v], LARGER(target.normal.v[v], s.d.v[v]), s.d.v[v]);
  }
  come_near(&influence, heights, state, STATE_ROWS, reach, 0, &c, &s);
  load_history(state, &c);
  list_pressing(&c);
  start_increment(&influence, &target, heights, &c, &s, &solving);
  splitting.rho_n = rho_n;
  splitting.rho_t = rho_t;
  start_splitting(&influence, wide_from, &c, &s, &splitting);
  EACH_VECTOR(v) { s.searching.v[v] = s.by_force.v[v] = wants.v[v]; }
  do {
    split(&influence, blocks + BLOCKS_NUMBERS, most_sweeps, &c, &s, &splitting);
    list_cells(&s.active, &c);
    while (any_of(&s.active)) sweep(&influence, most_sweeps, &c, &s);
    sum_split(&influence, blocks, &c, &splitting);
    widen(&influence, &solving, &c, &s);
    if (any_of(&s.active)) continue;
    if (any_of(&s.searching))
      next_pose(&influence, heights, state, STATE_ROWS, reach, force_tolerance, most_solves, travel, &c, &s, &search);
    refine(&influence, &solving, accept, &c, &s);
  } while (any_of(&s.active));
  answer(&influence, input, heights, accept, force, thickness, reach, sides, &c, &s, &search, by_wrench, vector * LANES,
         result);
  remember(&c, &s);
  store(input, heights, soft, &c, &s, &search, by_wrench, missing, softer, state);
  if (CREEP_TERMS > 0) end_creep(&influence, creep, &splitting, &c, &s, state);
}

/* Stress at the base under the tactels from the tractions of the state, by one matrix of the pad: base [blocks][cells][n,
   t_x, t_y][STEP_FRAME_BLOCK] MPa over a traction of the state, rows sigma_z, tau_x, tau_y of the tactels, with zeros
   behind. Out: frames [contact][rows] MPa. from: where the tractions are in a state. */
kernel void pad_frames(uint first_group, global const real *base, int rows, int from, global const vreal *state,
                       global real *frames) {
  TAKE_GROUP(group);
  int list[COUNT], listed;
  ROLLED for (int v = 0; v < VECTORS; ++v) {
    global const vreal *own = state + (group * VECTORS + v) * STATE_ROWS + from;
    listed = 0;
    for (int i = 0; i < COUNT; ++i) {
      const vint presses = own[i] > 0;
      list[listed] = i;
      listed += ANY(presses);
    }
    ROLLED for (int first = 0; first < rows; first += STEP_FRAME_BLOCK) {
      vreal sum[STEP_FRAME_BLOCK];
      EACH(r, STEP_FRAME_BLOCK) { sum[r] = 0; }
      global const real *block = base + (size_t)first * 3 * COUNT;
      ROLLED for (int k = 0; k < listed; ++k) {
        const int i = list[k];
        const vreal n = own[i], x = own[STEP_TX * COUNT + i], y = own[STEP_TY * COUNT + i];
        global const real *b = block + 3 * STEP_FRAME_BLOCK * i;
        EACH(r, STEP_FRAME_BLOCK) {
          sum[r] =
              fma(ALL_LANES(b[r]), n,
                  fma(ALL_LANES(b[STEP_FRAME_BLOCK + r]), x, fma(ALL_LANES(b[2 * STEP_FRAME_BLOCK + r]), y, sum[r])));
        }
      }
      const size_t lane = (group * VECTORS + v) * LANES;
      const int own_rows = rows - first < STEP_FRAME_BLOCK ? rows - first : STEP_FRAME_BLOCK;
      for (int r = 0; r < own_rows; ++r) {
        real number[LANES];
        STORE(sum[r], number);
        for (int l = 0; l < LANES; ++l) frames[(lane + l) * rows + first + r] = number[l];
      }
    }
  }
}
