// SPDX-License-Identifier: Apache-2.0
/* Batched contact of rigid indenters with one sensor: block Gauss-Seidel over gap elements on the surface compliance.
   One launch solves whole load paths.

   One work-item carries VECTORS vectors of LANES scenes (GROUP scenes). Surface forces are the pressure n >= 0 and the
   traction force t on the rubber. With u = C load / E the kernel computes at E = 1, where forces are in mm, and scales
   its outputs.

   Law at node i, with gap g = h - d - u_y and slip s = (u_x - u_x at the last increment) - (X - X there):
     n >= 0,  g >= 0,  n g = 0;   |t| <= mu n,  s = 0 inside the cone,  s t <= 0 on its edge.

   A lane's result depends on the lane alone: finished lanes keep their bits, nodes that only its neighbours use add
   exact zeros, and every sum runs in an order fixed by the node's index.

   Built with -D REAL (float | double), LANES (1, 4, 8, 16), VECTORS, NODES, FORCE_CONTROL (0 | 1), FRICTION (0 | 1).
   Without FRICTION all lanes have mu = 0: t stays 0, the tangential position has no effect, there is no history, and C
   is its n, u_y part alone. */
// defines: NODES=41 VECTORS=2 FORCE_CONTROL=1 FRICTION=1
#include "shared/group.h"
#include "shared/lanes.h"
#include "shared/contact_layout.h"
#include "shared/force_search.h"

/* Number of row r of a group's array, of vector v of EACH_VECTOR; from row to row. */
#define AT(r) (((r)*VECTORS + v) * INTERLEAVED)
#define STRIDE (VECTORS * INTERLEAVED)
#define EACH_VECTOR _Pragma("unroll") for (int v = 0; v < VECTORS; ++v)
#define C_PARTS (FRICTION ? COMPLIANCE_PARTS : 1)
#define FAR ((real)NO_GAP_ELEMENT) /* mm: height of a node that carries no gap element, in this lane or yet */
#define DAMPED_AFTER 500           /* sweeps; slow but steady ones need fewer down to rounding on the paper's meshes */
#define MOST_ACTIVATIONS 32        /* rounds of adding gap elements in one increment */
#define MOST_FORCE_TRIALS 60       /* trials of depth (and position) to reach given forces */

typedef struct {
  vreal n[NODES][VECTORS];      /* pressure force / E, mm */
  vreal t[NODES][VECTORS];      /* traction force / E, mm */
  vreal n_last[NODES][VECTORS]; /* both at the last increment */
  vreal t_last[NODES][VECTORS];
  vreal h[NODES][VECTORS];       /* profile height of active gap elements, FAR elsewhere, mm */
  vreal ux_last[NODES][VECTORS]; /* u_x at the last increment where a gap element is active, mm; of a sticking node its
                                    exact position */
  vreal ux[NODES][VECTORS], uy[NODES][VECTORS]; /* as certify computed them, mm */
  vreal reached[VECTORS];                       /* greatest depth at which activate_reached looked, mm */
  int first, end;                               /* nodes [first, end): all gap elements that are active in any lane */
  int first_pressed, end_pressed; /* nodes [first_pressed, end_pressed): all that bear a force in any lane */
} Contact;

/* Position of the indenter, and the lanes that iterate. */
typedef struct {
  vreal mu[VECTORS];
  vreal d[VECTORS]; /* indentation, mm */
  vreal x[VECTORS]; /* tangential position, mm */
  vreal x_last[VECTORS];
  vint active[VECTORS];
  vint held[VECTORS]; /* lanes whose position equals that of the last increment */
} Indenter;

typedef struct {
  vreal uy[VECTORS], ux[VECTORS];
} RowDisplacement;

/* Relative figures of fem/gap/contact_solution.h and the slip distance, mm, from the final forces alone. */
typedef struct {
  vreal penetration[VECTORS], cone[VECTORS], complementarity[VECTORS], drift[VECTORS];
  vreal slip_distance[VECTORS];
} Certificate;

/* The sensor, and the host's options (host/contact/lines/gap_sweep.h). */
typedef struct {
  global const real *compliance; /* [NODES][NODES][C_PARTS]: u_y by n, u_y by t, u_x by n, u_x by t */
  global const real *node;       /* [NODES][NODE_ROWS] */
  real tolerance;
  int most_sweeps;
  real reach; /* gap elements are activated up to this many indentations; certify adds those that are missing */
} Rules;

static inline int any_vector(const vint *mask) {
  vint all = 0;
  EACH_VECTOR { all |= mask[v]; }
  return ANY(all);
}

/* Adds the displacement u_y and u_x of one node under the forces of nodes [first, end); c: its row of the
   compliance. */
static inline void add_forces(global const real *c, const vreal (*n)[VECTORS], const vreal (*t)[VECTORS], int first,
                              int end, vreal *yn, vreal *yt, vreal *xn, vreal *xt) {
  c += C_PARTS * first;
  for (int j = first; j < end; ++j, c += C_PARTS) {
    EACH_VECTOR {
      yn[v] = fma(ALL_LANES(c[COMPLIANCE_UY_BY_N]), n[j][v], yn[v]);
      if (!FRICTION) continue;
      yt[v] = fma(ALL_LANES(c[COMPLIANCE_UY_BY_T]), t[j][v], yt[v]);
      xn[v] = fma(ALL_LANES(c[COMPLIANCE_UX_BY_N]), n[j][v], xn[v]);
      xt[v] = fma(ALL_LANES(c[COMPLIANCE_UX_BY_T]), t[j][v], xt[v]);
    }
  }
}

/* Displacement of node i under the forces of nodes [first, end). The node that a sweep has updated last, i - 1, comes
   last: its latency hides behind the others. */
static inline RowDisplacement row_displacement(const Rules *rules, int i, const vreal (*n)[VECTORS],
                                               const vreal (*t)[VECTORS], int first, int end) {
  global const real *row = rules->compliance + i * (NODES * C_PARTS);
  vreal yn[VECTORS], yt[VECTORS], xn[VECTORS], xt[VECTORS];
  EACH_VECTOR { yn[v] = yt[v] = xn[v] = xt[v] = 0; }
  const int split = clamp(i, first, end);
  add_forces(row, n, t, split, end, yn, yt, xn, xt);
  add_forces(row, n, t, first, split, yn, yt, xn, xt);
  RowDisplacement u;
  EACH_VECTOR {
    u.uy[v] = yn[v] + yt[v];
    u.ux[v] = xn[v] + xt[v];
  }
  return u;
}

/* Displacement of node i under all forces. Nodes without a force are left out: they would add exact zeros. A macro, as
   oclgrind cannot run what clang makes of one function that hands on the struct of another. */
#define DISPLACEMENT(rules, c, i) row_displacement(rules, i, (c)->n, (c)->t, (c)->first_pressed, (c)->end_pressed)

/* Extends the nodes that bear a force by node i, where it does. */
static inline void note_pressed(Contact *c, int i) {
  vint pressed[VECTORS];
  EACH_VECTOR { pressed[v] = c->n[i][v] != 0; }
  if (!any_vector(pressed)) return;
  c->first_pressed = c->first_pressed < c->end_pressed ? min(c->first_pressed, i) : i;
  c->end_pressed = max(c->end_pressed, i + 1);
}

/* One Gauss-Seidel sweep: at each node the normal force, then the tangential one in the new cone. moving: active lanes
   whose largest change was above tolerance times their largest pressure force. */
static inline void sweep(const Rules *rules, Contact *c, const Indenter *in, real relaxation, vint *moving) {
  vreal change[VECTORS], largest[VECTORS], dx[VECTORS];
  EACH_VECTOR {
    change[v] = largest[v] = 0;
    dx[v] = in->x[v] - in->x_last[v];
  }
  for (int i = c->first; i < c->end; ++i) {
    const RowDisplacement u = DISPLACEMENT(rules, c, i);
    global const real *node = rules->node + i * NODE_ROWS;
    const real n_per_uy = relaxation * node[NODE_N_PER_UY], t_per_ux = relaxation * node[NODE_T_PER_UX];
    EACH_VECTOR {
      const vreal n_old = c->n[i][v], t_old = c->t[i][v];
      const vreal inside = u.uy[v] - (c->h[i][v] - in->d[v]);
      const vreal n_free = fma(inside, ALL_LANES(n_per_uy), n_old);
      const vreal n = PICK(in->active[v], LARGER(n_free, ALL_LANES(0)), n_old);
      vreal moved = fabs(n - n_old);
      c->n[i][v] = n;
      if (FRICTION) {
        const vreal slip = fma(ALL_LANES(node[NODE_UX_PER_N]), n - n_old, u.ux[v]) - (c->ux_last[i][v] + dx[v]);
        const vreal cone = in->mu[v] * n;
        const vreal t_free = fma(-slip, ALL_LANES(t_per_ux), t_old);
        const vreal t = PICK(in->active[v], SMALLER(LARGER(t_free, -cone), cone), t_old);
        c->t[i][v] = t;
        moved = LARGER(moved, fabs(t - t_old));
      }
      change[v] = LARGER(change[v], moved);
      largest[v] = LARGER(largest[v], n);
    }
    if (i < c->first_pressed || i >= c->end_pressed) note_pressed(c, i);
  }
  EACH_VECTOR {
    const vreal tolerance = FRICTION ? sweep_tolerance(rules->tolerance, in->mu[v]) : ALL_LANES(rules->tolerance);
    moving[v] = in->active[v] & (change[v] > tolerance * largest[v]);
  }
}

/* Sweeps until every iterating lane has converged, or most_sweeps. Leaves in in->active the lanes that did not
   converge. Where friction is high and the rubber compressible, plain Gauss-Seidel can go round in circles: lanes that
   take long go on with damped steps. */
static inline void iterate(const Rules *rules, Contact *c, Indenter *in, vreal *sweeps) {
  c->first_pressed = c->end_pressed = 0;
  for (int i = c->first; i < c->end; ++i) note_pressed(c, i);
  for (int k = 0; k < rules->most_sweeps && any_vector(in->active); ++k) {
    vint moving[VECTORS];
    sweep(rules, c, in, k < DAMPED_AFTER ? (real)1 : k < 4 * DAMPED_AFTER ? (real)0.5 : (real)0.2, moving);
    EACH_VECTOR {
      sweeps[v] += PICK(in->active[v], ALL_LANES(1), ALL_LANES(0));
      in->active[v] = moving[v];
    }
  }
}

/* Activates the gap element of node i in some lanes: sets its height, and the node's position at the last increment. */
static inline void activate(const Rules *rules, global const vreal *profile, Contact *c, int i, const vint *activated) {
  EACH_VECTOR { c->h[i][v] = PICK(activated[v], profile[AT(i)], c->h[i][v]); }
  if (FRICTION) {
    const RowDisplacement last = row_displacement(rules, i, c->n_last, c->t_last, c->first, c->end);
    EACH_VECTOR { c->ux_last[i][v] = PICK(activated[v], last.ux[v], c->ux_last[i][v]); }
  }
  c->first = min(c->first, i);
  c->end = max(c->end, i + 1);
}

/* Gap elements where the rigid profile comes near the flat surface. Lanes that are no deeper than before have
   theirs. */
static inline void activate_reached(const Rules *rules, global const vreal *profile, Contact *c, const Indenter *in) {
  vint deeper[VECTORS];
  EACH_VECTOR {
    deeper[v] = in->active[v] & (in->d[v] > c->reached[v]);
    c->reached[v] = PICK(deeper[v], in->d[v], c->reached[v]);
  }
  if (!any_vector(deeper)) return;
  for (int i = 0; i < NODES; ++i) {
    vint activated[VECTORS];
    EACH_VECTOR { activated[v] = in->active[v] & (profile[AT(i)] <= in->d[v] * rules->reach) & (c->h[i][v] >= FAR); }
    if (any_vector(activated)) activate(rules, profile, c, i, activated);
  }
}

/* u_y of nodes [from, to) without gap elements, and in `inside` the largest penetration there, at least what it was.
   Rows are left out where in no lane the rubber can rise to the profile, whatever the forces: u_y <= (sum n) (largest
   rise by n) + (sum |t|) (largest rise by t). */
static inline void look_outside(const Rules *rules, global const vreal *profile, Contact *c, const Indenter *in,
                                const vreal *sum_n, const vreal *sum_t, int from, int to, vreal *inside) {
  for (int i = from; i < to; ++i) {
    global const real *node = rules->node + i * NODE_ROWS;
    vint near[VECTORS];
    EACH_VECTOR {
      const vreal most = fma(sum_n[v], ALL_LANES(node[NODE_RISE_PER_N]), sum_t[v] * node[NODE_RISE_PER_T]);
      c->uy[i][v] = most;
      near[v] = profile[AT(i)] - in->d[v] < most;
    }
    if (!any_vector(near)) continue;
    const RowDisplacement u = DISPLACEMENT(rules, c, i);
    EACH_VECTOR {
      c->uy[i][v] = u.uy[v];
      inside[v] = LARGER(u.uy[v] - (profile[AT(i)] - in->d[v]), inside[v]);
    }
  }
}

/* Activates nodes without a gap element that are penetrated by more than `allowed`, in the lanes of `checked`; these
   are then in->active. */
static inline void activate_penetrated(const Rules *rules, global const vreal *profile, Contact *c, Indenter *in,
                                       const vint *checked, const vreal *allowed) {
  for (int i = 0; i < NODES; ++i) {
    vint activated[VECTORS];
    EACH_VECTOR {
      const vreal inside = c->uy[i][v] - (profile[AT(i)] - in->d[v]);
      activated[v] = checked[v] & (c->h[i][v] >= FAR) & (inside > allowed[v]);
      in->active[v] |= activated[v];
    }
    if (any_vector(activated)) activate(rules, profile, c, i, activated);
  }
}

/* The contact laws at every surface node, from the forces alone. Lanes of `checked` in which a node without a gap
   element is penetrated get one there and come back in in->active. */
static inline void certify(const Rules *rules, global const vreal *profile, Contact *c, Indenter *in,
                           const vint *checked, Certificate *k) {
  vreal largest_uy[VECTORS], largest_n[VECTORS], sum_n[VECTORS], sum_t[VECTORS], finite[VECTORS];
  vreal idle_inside[VECTORS]; /* the largest penetration of a node without a gap element, mm */
  EACH_VECTOR {
    idle_inside[v] = 0;
    k->penetration[v] = k->cone[v] = k->complementarity[v] = k->drift[v] = k->slip_distance[v] = 0;
    largest_uy[v] = largest_n[v] = sum_n[v] = sum_t[v] = finite[v] = 0;
    in->active[v] = 0;
  }
  for (int i = c->first; i < c->end; ++i) {
    const RowDisplacement u = DISPLACEMENT(rules, c, i);
    EACH_VECTOR {
      const vreal n = c->n[i][v], t = c->t[i][v];
      const vreal cone = in->mu[v] * n;
      const vint works = c->h[i][v] < FAR;
      const vint pressed = n > 0;
      const vreal inside = u.uy[v] - (profile[AT(i)] - in->d[v]);
      const vreal moved = u.ux[v] - (c->ux_last[i][v] + (in->x[v] - in->x_last[v]));
      const vreal slip = PICK(in->held[v], ALL_LANES(0), moved);
      const vreal along =
          PICK(t > 0, slip, PICK(t < 0, -slip, ALL_LANES(0))); /* slip with friction instead of against it */
      const vreal drift = PICK(pressed, PICK(fabs(t) < cone, fabs(slip), along), ALL_LANES(0));
      const vreal apart = PICK(pressed, fabs(inside), ALL_LANES(0));
      const vreal size = PICK(works, fabs(u.uy[v]), ALL_LANES(0));
      const vreal outside_cone = fabs(t) - cone;
      const vreal slid = PICK(pressed, fabs(u.ux[v] - in->x[v]), ALL_LANES(0));
      c->uy[i][v] = u.uy[v];
      c->ux[i][v] = u.ux[v];
      k->penetration[v] = LARGER(inside, k->penetration[v]);
      const vreal idle = PICK(works, ALL_LANES(0), inside);
      idle_inside[v] = LARGER(idle, idle_inside[v]);
      k->complementarity[v] = LARGER(apart, k->complementarity[v]);
      k->cone[v] = LARGER(outside_cone, k->cone[v]);
      k->drift[v] = LARGER(drift, k->drift[v]);
      k->slip_distance[v] = LARGER(slid, k->slip_distance[v]);
      largest_uy[v] = LARGER(size, largest_uy[v]);
      largest_n[v] = LARGER(n, largest_n[v]);
      sum_n[v] += n;
      sum_t[v] += fabs(t);
      finite[v] = finite_sum(finite_sum(finite[v], u.uy[v]), u.ux[v]);
    }
  }
  look_outside(rules, profile, c, in, sum_n, sum_t, 0, c->first, idle_inside);
  look_outside(rules, profile, c, in, sum_n, sum_t, max(c->first, c->end), NODES, idle_inside);
  vreal allowed[VECTORS];
  vint penetrated[VECTORS];
  EACH_VECTOR {
    k->penetration[v] = LARGER(idle_inside[v], k->penetration[v]);
    allowed[v] = rules->tolerance * largest_uy[v];
    penetrated[v] = checked[v] & (idle_inside[v] > allowed[v]);
  }
  if (any_vector(penetrated)) activate_penetrated(rules, profile, c, in, checked, allowed);
  EACH_VECTOR {
    const vreal per_uy = PICK(largest_uy[v] > 0, 1 / largest_uy[v], ALL_LANES(0));
    k->penetration[v] = fma(k->penetration[v], per_uy, finite[v]);
    k->complementarity[v] *= per_uy;
    k->drift[v] *= per_uy;
    k->cone[v] *= PICK(largest_n[v] > 0, 1 / largest_n[v], ALL_LANES(0));
  }
}

/* Solves the contact at the indenter's position, in the active lanes. Returns in `failed` the lanes that ran out of
   sweeps. */
static inline void solve_contact(const Rules *rules, global const vreal *profile, Contact *c, Indenter *in,
                                 vreal *sweeps, vint *failed, Certificate *k) {
  vint checked[VECTORS];
  EACH_VECTOR {
    checked[v] = in->active[v];
    failed[v] = 0;
  }
  activate_reached(rules, profile, c, in);
  for (int round = 0; round < MOST_ACTIVATIONS; ++round) {
    iterate(rules, c, in, sweeps);
    EACH_VECTOR { failed[v] |= in->active[v]; }
    certify(rules, profile, c, in, checked, k);
    if (!any_vector(in->active)) return;
  }
  EACH_VECTOR { failed[v] |= in->active[v]; }
}

static inline void resultants(const Contact *c, vreal *p, vreal *q) {
  EACH_VECTOR { p[v] = q[v] = 0; }
  for (int i = c->first; i < c->end; ++i) EACH_VECTOR {
      p[v] += c->n[i][v];
      q[v] += c->t[i][v];
    }
}

/* Initial guess: extrapolates the last change of the forces in proportion to the load. */
static inline void extrapolate(Contact *c, const Indenter *in, const vreal *ratio) {
  for (int i = c->first; i < c->end; ++i) EACH_VECTOR {
      const vreal n = c->n[i][v], t = c->t[i][v];
      const vreal n_guess = fmax(fma(ratio[v], n - c->n_last[i][v], n), ALL_LANES(0));
      const vreal cone = in->mu[v] * n_guess;
      const vreal t_guess = fmin(fmax(fma(ratio[v], t - c->t_last[i][v], t), -cone), cone);
      c->n_last[i][v] = n;
      c->t_last[i][v] = t;
      c->n[i][v] = PICK(in->active[v], n_guess, n);
      c->t[i][v] = PICK(in->active[v], t_guess, t);
    }
}

#if FORCE_CONTROL
typedef struct {
  ForceSearch of[VECTORS];
  vreal nearest[VECTORS]; /* depth at which the undeformed surface is touched */
  vint by_force[VECTORS]; /* lanes whose normal target is a force */
  vint both[VECTORS];     /* lanes whose tangential target is also one */
} Search;

/* Moves the indenter of the active lanes towards the target forces. Leaves in in->active those that had not reached
   them. */
static inline void update_force_control(Search *s, const Contact *c, Indenter *in, real tolerance) {
  vreal p[VECTORS], q[VECTORS];
  resultants(c, p, q);
  EACH_VECTOR {
    const vreal z[2] = {in->d[v], in->x[v]};
    vreal next[2];
    in->active[v] &= next_trial(&s->of[v], z, p[v], q[v], in->active[v], s->both[v], tolerance, next);
    in->held[v] &= NOT(in->active[v]);
    in->d[v] = PICK(in->active[v], next[0], in->d[v]);
    in->x[v] = PICK(in->active[v] & s->both[v], next[1], in->x[v]);
  }
}
#endif

/* Output rows = map x surface forces, e.g. base forces; map: [blocks of rows][NODES][ROW_BLOCK][2], by n and by t.
   Leaves in base_x and base_y the sums of the first base_rows, x and y in turn. */
static inline void write_rows(global const real *map, int rows, int base_rows, const Contact *c, const vreal *scale,
                              global vreal *out, vreal *base_x, vreal *base_y) {
  EACH_VECTOR { base_x[v] = base_y[v] = 0; }
  for (int r = 0; r < rows; r += ROW_BLOCK, map += NODES * ROW_BLOCK * 2) {
    vreal sum[ROW_BLOCK][VECTORS];
    _Pragma("unroll") for (int b = 0; b < ROW_BLOCK; ++b) EACH_VECTOR { sum[b][v] = 0; }
    global const real *m = map + c->first_pressed * (ROW_BLOCK * 2);
    for (int j = c->first_pressed; j < c->end_pressed; ++j, m += ROW_BLOCK * 2) {
      _Pragma("unroll") for (int b = 0; b < ROW_BLOCK; ++b) EACH_VECTOR {
        sum[b][v] = fma(ALL_LANES(m[2 * b]), c->n[j][v], sum[b][v]);
        if (FRICTION) sum[b][v] = fma(ALL_LANES(m[2 * b + 1]), c->t[j][v], sum[b][v]);
      }
    }
    _Pragma("unroll") for (int b = 0; b < ROW_BLOCK; ++b) if (r + b < rows) EACH_VECTOR {
      const vreal row = sum[b][v] * scale[v];
      STORE_AWAY(row, &out[AT(r + b)]);
      if (r + b >= base_rows) continue;
      if ((r + b) % 2)
        base_y[v] += row;
      else
        base_x[v] += row;
    }
  }
}

/* Lanes with finite, valid input along their own path. */
static inline void check_input(global const vreal *lane_input, global const vreal *profile, global const vreal *path,
                               int steps, vint *valid) {
  EACH_VECTOR {
    vreal sum = 0;
    for (int r = 0; r < LANE_INPUT_ROWS; ++r) sum = finite_sum(sum, lane_input[AT(r)]);
    for (int i = 0; i < NODES; ++i) sum = finite_sum(sum, profile[AT(i)]);
    for (int k = 0; k < steps * PATH_ROWS; ++k) {
      const vint own = lane_input[AT(LANE_STEPS)] > (real)(k / PATH_ROWS);
      sum = PICK(own, finite_sum(sum, path[AT(k)]), sum);
    }
    valid[v] = (sum == 0) & (lane_input[AT(LANE_MU)] >= 0) & (lane_input[AT(LANE_YOUNG)] > 0);
  }
}

/* Forces and statuses of every node, rows [3 NODES]: n, t (N/mm), NodeStatus. */
static inline void write_nodes(const Contact *c, const Indenter *in, const vreal *young, global vreal *out) {
  for (int i = 0; i < NODES; ++i) EACH_VECTOR {
      const vreal n = c->n[i][v], t = c->t[i][v];
      out[AT(i)] = n * young[v];
      out[AT(NODES + i)] = t * young[v];
      const vreal touching = PICK(fabs(t) < in->mu[v] * n, ALL_LANES(NODE_STICK), ALL_LANES(NODE_SLIP));
      out[AT(2 * NODES + i)] = PICK(n > 0, touching, ALL_LANES(NODE_OPEN));
    }
}

static inline void count_nodes(const Contact *c, const Indenter *in, vreal *sticking, vreal *slipping) {
  EACH_VECTOR { sticking[v] = slipping[v] = 0; }
  for (int i = c->first; i < c->end; ++i) EACH_VECTOR {
      const vint pressed = c->n[i][v] > 0;
      const vint sticks = pressed & (fabs(c->t[i][v]) < in->mu[v] * c->n[i][v]);
      sticking[v] += PICK(sticks, ALL_LANES(1), ALL_LANES(0));
      slipping[v] += PICK(pressed, ALL_LANES(1), ALL_LANES(0)) - PICK(sticks, ALL_LANES(1), ALL_LANES(0));
    }
}

/* |base + surface force| over the largest of both, from the sums of the base forces. */
static inline vreal balance(vreal base_x, vreal base_y, vreal p, vreal q) {
  const vreal largest = fmax(fabs(p), fabs(q));
  const vreal off = finite_sum(fmax(fabs(base_x - q), fabs(base_y + p)), base_x + base_y);
  return PICK(largest > 0, off / largest, off);
}

/* Every residual within bounds; no comparison holds for NaN. */
static inline vint within(const Certificate *said, int v, vreal off_balance, real accept) {
  return (said->penetration[v] <= accept) & (said->cone[v] <= accept) & (said->complementarity[v] <= accept) &
         (said->drift[v] <= accept) & (off_balance <= accept);
}

/* State of a lane along its load path. */
typedef struct {
  vint valid[VECTORS], running[VECTORS];
  vint lost[VECTORS]; /* an increment was not solved, so later ones have no valid history */
  vreal young[VECTORS];
  vreal nearest[VECTORS];                     /* depth at which the undeformed surface is touched, mm */
  vreal d_change[VECTORS], x_change[VECTORS]; /* of the last increment's target, mm */
  vreal sweeps[VECTORS];                      /* of this increment */
  vint failed[VECTORS];                       /* it did not converge, or missed the target forces */
  Certificate certificate;
} LoadStepping;

static inline void start(global const vreal *lane_input, global const vreal *profile, Contact *c, Indenter *in,
                         LoadStepping *w) {
  c->first = NODES;
  c->end = c->first_pressed = c->end_pressed = 0;
  EACH_VECTOR {
    w->nearest[v] = FAR;
    c->reached[v] = -FAR;
  }
  for (int i = 0; i < NODES; ++i) EACH_VECTOR {
      w->nearest[v] = SMALLER(profile[AT(i)], w->nearest[v]);
    }
  for (int i = 0; i < NODES; ++i) EACH_VECTOR {
      c->n[i][v] = c->t[i][v] = c->n_last[i][v] = c->t_last[i][v] = c->ux_last[i][v] = c->ux[i][v] = c->uy[i][v] = 0;
      c->h[i][v] = FAR;
    }
  EACH_VECTOR {
    in->mu[v] = PICK(w->valid[v], lane_input[AT(LANE_MU)], ALL_LANES(0));
    w->young[v] = PICK(w->valid[v], lane_input[AT(LANE_YOUNG)], ALL_LANES(0));
    in->d[v] = in->x[v] = in->x_last[v] = w->d_change[v] = w->x_change[v] = 0;
    w->running[v] = w->valid[v];
    w->lost[v] = 0;
  }
}

/* Target of increment k: (d, x), mm; lanes beyond their path stop and stay where they are. ratio: this change of the
   target over the last one, 0 where both d and x change, or the way turns, or the load is a force. */
static inline void next_target(global const vreal *lane_input, global const vreal *path, int k, const Indenter *in,
                               LoadStepping *w, vreal *d, vreal *x, vreal *ratio) {
  global const vreal *target = path + k * PATH_ROWS * STRIDE;
  EACH_VECTOR {
    w->running[v] &= lane_input[AT(LANE_STEPS)] > (real)k;
    w->sweeps[v] = 0;
    d[v] = PICK(w->running[v], target[AT(PATH_NORMAL)], in->d[v]);
    x[v] = PICK(w->running[v], target[AT(PATH_TANGENTIAL)], in->x[v]);
    const vreal d_now = d[v] - in->d[v], x_now = x[v] - in->x[v];
    const vint same_d = (d_now == 0) & (w->d_change[v] == 0), same_x = (x_now == 0) & (w->x_change[v] == 0);
    const vreal along_d = PICK(same_x & (w->d_change[v] != 0), d_now / w->d_change[v], ALL_LANES(0));
    const vreal along = PICK(same_d & (w->x_change[v] != 0), x_now / w->x_change[v], along_d);
    const vint by_depth = lane_input[AT(LANE_FORCE)] < FORCE_NORMAL;
    ratio[v] = PICK(by_depth & (along > 0) & (along <= 2), along, ALL_LANES(0));
    w->d_change[v] = d_now;
    w->x_change[v] = x_now;
  }
}

/* Lanes whose target equals their position are not iterated: their state is a solution, and a held contact does not
   creep by rounding. */
static inline void move_to(Indenter *in, const LoadStepping *w, const vreal *d, const vreal *x) {
  EACH_VECTOR {
    in->held[v] = d[v] == in->d[v];
    if (FRICTION) in->held[v] &= x[v] == in->x[v];
    in->active[v] = w->running[v] & NOT(in->held[v]);
    in->x_last[v] = in->x[v];
    in->d[v] = d[v];
    in->x[v] = x[v];
  }
}

/* Clears the forces of the lanes in `none`. */
static inline void release(Contact *c, const vint *none) {
  if (!any_vector(none)) return;
  for (int i = c->first; i < c->end; ++i) EACH_VECTOR {
      c->n[i][v] = PICK(none[v], ALL_LANES(0), c->n[i][v]);
      c->t[i][v] = PICK(none[v], ALL_LANES(0), c->t[i][v]);
    }
}

/* Clears lanes driven by depth whose indenter does not reach the undeformed surface: the rubber without forces is a
   solution. Sweeps alone would approach it through ever smaller forces. */
static inline void lift_off(global const vreal *lane_input, Contact *c, const Indenter *in, const LoadStepping *w) {
  vint none[VECTORS];
  EACH_VECTOR { none[v] = w->running[v] & (in->d[v] <= w->nearest[v]) & (lane_input[AT(LANE_FORCE)] < FORCE_NORMAL); }
  release(c, none);
}

#if FORCE_CONTROL
static inline void start_search(global const vreal *lane_input, const LoadStepping *w, Search *s) {
  EACH_VECTOR {
    s->nearest[v] = w->nearest[v];
    s->by_force[v] = lane_input[AT(LANE_FORCE)] >= FORCE_NORMAL;
    s->both[v] = lane_input[AT(LANE_FORCE)] >= FORCE_BOTH;
    start_force_search(&s->of[v], s->nearest[v]);
  }
}

/* Target without force: no node touches, the rubber is undeformed, and depth 0 is a solution. */
static inline void release_unloaded(const Search *s, Contact *c, const LoadStepping *w) {
  vint none[VECTORS];
  EACH_VECTOR { none[v] = w->running[v] & s->by_force[v] & (s->of[v].p_target <= 0); }
  release(c, none);
}

/* Where targets are forces: stores them in the search, and replaces them by the indenter's position or a first
   guess. */
static inline void first_trial(Search *s, const Indenter *in, vreal *d, vreal *x) {
  EACH_VECTOR {
    const vreal guess = first_depth(&s->of[v], in->d[v], s->nearest[v], d[v], x[v]);
    d[v] = PICK(s->by_force[v], guess, d[v]);
    x[v] = PICK(s->both[v], in->x[v], x[v]);
  }
}

static inline void reach_forces(const Rules *rules, global const vreal *profile, Search *s, Contact *c, Indenter *in,
                                LoadStepping *w) {
  EACH_VECTOR { in->active[v] = w->running[v] & s->by_force[v] & (s->of[v].p_target > 0); }
  for (int trial = 0; trial < MOST_FORCE_TRIALS; ++trial) {
    update_force_control(s, c, in, 10 * rules->tolerance);
    if (!any_vector(in->active)) return;
    vint searching[VECTORS], failed[VECTORS];
    EACH_VECTOR { searching[v] = in->active[v]; }
    solve_contact(rules, profile, c, in, w->sweeps, failed, &w->certificate);
    EACH_VECTOR {
      w->failed[v] = (w->failed[v] & NOT(searching[v])) | failed[v];
      in->active[v] = searching[v];
    }
  }
  EACH_VECTOR { w->failed[v] |= in->active[v]; }
}
#endif

/* Writes the result of this increment, LaneResultRow by row; ends lanes that slide where they may stop. base_x, base_y:
   sums of the base forces, where base_rows is not 0. */
static inline void report(global const vreal *lane_input, int k, const Contact *c, const Indenter *in, real accept,
                          int base_rows, const vreal *base_x, const vreal *base_y, LoadStepping *w,
                          global vreal *result) {
  vreal p[VECTORS], q[VECTORS], sticking[VECTORS], slipping[VECTORS];
  resultants(c, p, q);
  count_nodes(c, in, sticking, slipping);
  EACH_VECTOR {
    const Certificate *said = &w->certificate;
    const vreal held = in->mu[v] * p[v];
    const vreal off_balance =
        base_rows == 0 ? ALL_LANES(0) : balance(base_x[v], base_y[v], p[v] * w->young[v], q[v] * w->young[v]);
    const vint slides = w->running[v] & (sticking[v] == 0) & (slipping[v] > 0);
    const vint finite = finite_sum(0, (p[v] + fabs(q[v])) * w->young[v]) == 0;
    const vint solved = NOT(w->lost[v] | w->failed[v]) & finite & within(said, v, off_balance, accept);
    const vreal good = PICK(slides, ALL_LANES(LANE_SLIDING), ALL_LANES(LANE_SOLVED));
    const vreal idle = PICK(w->valid[v], ALL_LANES(LANE_NOT_RUN), ALL_LANES(LANE_INVALID));
    STORE_AWAY(in->d[v], &result[AT(RESULT_DEPTH)]);
    STORE_AWAY(in->x[v], &result[AT(LANE_TANGENTIAL)]);
    STORE_AWAY(p[v] * w->young[v], &result[AT(RESULT_P)]);
    STORE_AWAY(q[v] * w->young[v], &result[AT(LANE_Q)]);
    STORE_AWAY(PICK(held > 0, q[v] / held, ALL_LANES(0)), &result[AT(RESULT_S)]);
    STORE_AWAY(sticking[v], &result[AT(RESULT_STICKING)]);
    STORE_AWAY(slipping[v], &result[AT(RESULT_SLIPPING)]);
    STORE_AWAY(w->sweeps[v], &result[AT(RESULT_SWEEPS)]);
    STORE_AWAY(PICK(w->running[v], PICK(solved, good, ALL_LANES(LANE_UNSOLVED)), idle), &result[AT(RESULT_STATUS)]);
    STORE_AWAY(said->penetration[v], &result[AT(RESULT_PENETRATION)]);
    STORE_AWAY(said->cone[v], &result[AT(RESULT_CONE)]);
    STORE_AWAY(said->complementarity[v], &result[AT(RESULT_COMPLEMENTARITY)]);
    STORE_AWAY(said->drift[v], &result[AT(RESULT_DRIFT)]);
    STORE_AWAY(off_balance, &result[AT(LANE_BALANCE)]);
    STORE_AWAY(said->slip_distance[v], &result[AT(RESULT_SLIP_DISTANCE)]);
    w->lost[v] |= NOT(solved);
    // Without a sticking node the contact slides, or there is none: a drag changes neither.
    w->running[v] &= NOT((sticking[v] == 0) & (lane_input[AT(LANE_MAY_STOP)] <= (real)k));
  }
}

/* Stores the history for the next increment. A sticking node is taken to have followed the indenter exactly. The next
   increment then corrects the error of convergence, which does not accumulate over thousands of increments. */
static inline void remember(Contact *c, const Indenter *in) {
  for (int i = c->first; i < c->end; ++i) EACH_VECTOR {
      const vint sticks = (c->n[i][v] > 0) & (fabs(c->t[i][v]) < in->mu[v] * c->n[i][v]);
      c->ux_last[i][v] = PICK(sticks, c->ux_last[i][v] + (in->x[v] - in->x_last[v]), c->ux[i][v]);
    }
}

static inline void report_idle(const LoadStepping *w, global vreal *result) {
  for (int r = 0; r < LANE_RESULT_ROWS; ++r) EACH_VECTOR {
      const vreal idle = PICK(w->valid[v], ALL_LANES(LANE_NOT_RUN), ALL_LANES(LANE_INVALID));
      result[AT(r)] = r == RESULT_STATUS ? idle : ALL_LANES(0);
    }
}

/* compliance [NODES][NODES][C_PARTS]; node [NODES][NODE_ROWS]; map [blocks of ROW_BLOCK rows][NODES][ROW_BLOCK][2],
   base forces first (base_rows of them); lane_input [group][LANE_INPUT_ROWS][lane]; profile [group][NODES][lane] mm, >=
   FAR where there is no indenter; path [group][steps][PATH_ROWS][lane]. Out: result
   [group][steps][LANE_RESULT_ROWS][lane]; rows_out [group][steps][rows][lane]; nodes_out [group][steps][3 NODES][lane]
   unless write_node_rows is 0. With one lane an item each array lies in blocks of INTERLEAVED items
   (shared/group.h). */
kernel void gap_sweep(uint first_group, global const real *compliance, global const real *node, global const real *map,
                      int rows, int base_rows, global const vreal *lane_input, global const vreal *profile,
                      global const vreal *path, int steps, real tolerance, real accept, int most_sweeps, real reach,
                      global vreal *result, global vreal *rows_out, global vreal *nodes_out, int write_node_rows) {
  TAKE_GROUP(group);
  const Rules rules = {compliance, node, tolerance, most_sweeps, reach};
  lane_input += FIRST_NUMBER(group, LANE_INPUT_ROWS * VECTORS);
  profile += FIRST_NUMBER(group, NODES * VECTORS);
  path += FIRST_NUMBER(group, steps * PATH_ROWS * VECTORS);
  result += FIRST_NUMBER(group, steps * LANE_RESULT_ROWS * VECTORS);
  rows_out += FIRST_NUMBER(group, steps * rows * VECTORS);
  nodes_out += FIRST_NUMBER(group, steps * 3 * NODES * VECTORS);

  Contact c;
  Indenter in;
  LoadStepping w;
  check_input(lane_input, profile, path, steps, w.valid);
  start(lane_input, profile, &c, &in, &w);
#if FORCE_CONTROL
  Search search;
  start_search(lane_input, &w, &search);
#endif
  for (int k = 0; k < steps; ++k) {
    vreal d[VECTORS], x[VECTORS], ratio[VECTORS];
    next_target(lane_input, path, k, &in, &w, d, x, ratio);
    if (any_vector(w.running)) {
#if FORCE_CONTROL
      first_trial(&search, &in, d, x);
#endif
      move_to(&in, &w, d, x);
      extrapolate(&c, &in, ratio);
      lift_off(lane_input, &c, &in, &w);
#if FORCE_CONTROL
      release_unloaded(&search, &c, &w);
#endif
      solve_contact(&rules, profile, &c, &in, w.sweeps, w.failed, &w.certificate);
#if FORCE_CONTROL
      reach_forces(&rules, profile, &search, &c, &in, &w);
#endif
      vreal base_x[VECTORS], base_y[VECTORS];
      write_rows(map, rows, base_rows, &c, w.young, rows_out, base_x, base_y);
      if (write_node_rows) write_nodes(&c, &in, w.young, nodes_out);
      report(lane_input, k, &c, &in, accept, base_rows, base_x, base_y, &w, result);
      if (FRICTION) remember(&c, &in);
    } else {
      report_idle(&w, result);
    }
    result += LANE_RESULT_ROWS * STRIDE;
    rows_out += rows * STRIDE;
    nodes_out += 3 * NODES * STRIDE;
  }
}
