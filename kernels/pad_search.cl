// SPDX-License-Identifier: Apache-2.0
/* Search of the rectangle that a rigid indenter touches on a pad at its largest depth, or under its largest force,
   without friction: what pad_contact lays its cells on. The twin is fem/pad/pad_search.h.

   One work-item carries LANES scenes, each with its own sensor. Everything is in units of H at E = 1, in the indenter's
   own frame. SEARCH_ROUNDS rounds on SEARCH_CELLS x SEARCH_CELLS cells over a window, the first over the rigid section:
     p >= 0,   gap = h - d + sum zz p >= 0,   p gap = 0,
   by Gauss-Seidel from zero, until no pressure changes by more than SEARCH_TOLERANCE of the largest. The next window is
   the pressed extent and 1.5 cells more on a side, or a quarter of the extent on a side whose outermost cells press,
   inside the indenter's edges. The contact is the last extent and MARGIN of it more on a side. Measured heights of
   which the first round presses none get a second first window, around where they lie below the depth.
   Driven by force, the rounds are repeated at depths that follow secants in the logarithms of depth and force.

   Influence of cells, with rho the distance of their middles and corners [F] as in fem/pad/pad_layer.h:
     zz = (1 - nu^2) / pi ([y asinh(x / y) + x asinh(y / x)] + hx hy z0(rho)),
     z0 = u sum_k a_k T_k(2 u - 1),   u = 1 / sqrt(1 + (rho / PAD_SEARCH_LENGTH)^2),
 where the host gives a_k

   With MIRRORED all shapes are the same at -x and at -y. Unknowns are then the cells of one quadrant, and their influence
   is that of the four mirror images together: a 16th of the products.

   A lane's result depends on nothing but the lane: lanes that have settled keep their bits, and rows of cells that bear
   nothing in any lane add an exact 0.

   Built with -D REAL (float | double), LANES (1, 2, 4, 8, 16), MIRRORED (0 | 1). */
// defines: MIRRORED=0
#include "patch/numbers.h"
#include "shared/elementary.h"
#include "shared/pad_layout.h"

#define SEARCH_CELLS 12
#define SEARCH_ROUNDS 3
#define SEARCH_SWEEPS 200
#define SEARCH_TOLERANCE ((real)1e-3)
#define SEARCH_DEPTHS 20                /* trials of the depth that gives a force */
#define SEARCH_FORCE_ERROR ((real)0.02) /* of the force */
#define FIRST_DEPTH ((real)0.1)         /* tried first for a force */
#define LEAST_DEPTH ((real)1e-6)        /* an indenter that touches nothing: some cells below its lowest part */
#define WINDOW_MARGIN ((real)1.5)       /* cells */
#define WINDOW_GROWTH ((real)0.25)      /* of the pressed extent */
#define MARGIN ((real)0.06)
#define LEAST_PARTED ((real)0.35) /* longer sides of cells are parted for the smooth rest of their influence */
#define MOST_PARTS 16

/* Unknown cells of a row, and entries of the influence between two rows (BLOCKS: between rows of cells alike). */
#define SIDE (MIRRORED ? SEARCH_CELLS / 2 : SEARCH_CELLS)
#define ENTRIES (MIRRORED ? SIDE * (SIDE + 1) / 2 : SIDE)
#define MIRRORED_ENTRY(a, b) ((a) > (b) ? (a) * ((a) + 1) / 2 + (b) : (b) * ((b) + 1) / 2 + (a))
#define ENTRY(a, b) (MIRRORED ? MIRRORED_ENTRY(a, b) : (a) > (b) ? (a) - (b) : (b) - (a))
#define UNKNOWNS (SIDE * SIDE)

typedef struct {
  vreal left, right;
} Extent;

typedef struct {
  vreal zz[ENTRIES * ENTRIES]; /* influence, [entry along x][entry along y] */
  vreal target[UNKNOWNS];      /* d - h */
  vreal per_own[UNKNOWNS];     /* 1 / influence on itself */
  vreal p[UNKNOWNS];
  int bears[SIDE]; /* whether any lane presses in a row along y */
} Press;

/* y asinh(x / y) + x asinh(y / x) for x, y > 0. */
static inline vreal corner(vreal x, vreal y, vreal log_x, vreal log_y) {
  const vreal r = sqrt(fma(x, x, y * y));
  return fma(y, natural_log(x + r) - log_y, x * (natural_log(y + r) - log_x));
}

static inline vreal smooth_rest(global const vreal *in, vreal rho2) {
  const vreal u = 1 / sqrt(fma(rho2, ALL_LANES((real)(1 / (PAD_SEARCH_LENGTH * PAD_SEARCH_LENGTH))), ALL_LANES(1)));
  const vreal t = fma(ALL_LANES(2), u, ALL_LANES(-1));
  vreal b = in[PAD_SEARCH_REST + PAD_SEARCH_TERMS - 1], b_next = 0;
  EACH(k, PAD_SEARCH_TERMS - 2) {
    const vreal now = fma(2 * t, b, in[PAD_SEARCH_REST + PAD_SEARCH_TERMS - 2 - k] - b_next);
    b_next = b;
    b = now;
  }
  return u * fma(t, b, in[PAD_SEARCH_REST] - b_next);
}

/* Places along a side of a cell at which its smooth rest is taken: the middle, or two Gauss points of each of so many
   parts. Lanes with fewer places than their neighbours take the others with weight 0. */
typedef struct {
  vreal side, parts, count;
} Places;

static inline Places places_along(vreal side) {
  const vreal parts = SMALLER(TO_VREAL(TO_VINT(2 * side)) + 1, ALL_LANES(MOST_PARTS));
  const Places places = {side, parts, PICK(side <= LEAST_PARTED, ALL_LANES(1), 2 * parts)};
  return places;
}

static inline vreal place_of(const Places *p, int k) {
  const real in_part = (real)(k / 2) + (real)0.5 + (k % 2 ? 1 : -1) * (real)0.28867513459481287;
  return PICK(p->count > 1, p->side * (in_part / p->parts - (real)0.5), ALL_LANES(0));
}

/* The mean of the smooth rest over a cell. */
static inline vreal mean_rest(global const vreal *in, const Places *along_x, const Places *along_y, vreal x, vreal y) {
  vreal sum = 0;
  ROLLED for (int k = 0; ANY(along_x->count > (real)k); ++k) {
    const vreal at_x = x + place_of(along_x, k);
    ROLLED for (int l = 0; ANY(along_y->count > (real)l); ++l) {
      const vreal at_y = y + place_of(along_y, l);
      const vint mine = (along_x->count > (real)k) & (along_y->count > (real)l);
      const vreal weight = PICK(mine, 1 / (along_x->count * along_y->count), ALL_LANES(0));
      sum = fma(weight, smooth_rest(in, fma(at_x, at_x, at_y * at_y)), sum);
    }
  }
  return sum;
}

/* zz of cells hx x hy at 0 to SEARCH_CELLS - 1 cells along x and y. */
OUTLINE void cell_influence(global const vreal *in, vreal hx, vreal hy, vreal *zz) {
  const Places places_x = places_along(hx), places_y = places_along(hy);
  vreal log_y[SEARCH_CELLS], last[SEARCH_CELLS]; /* corners of the row before */
  ROLLED for (int j = 0; j < SEARCH_CELLS; ++j) log_y[j] = natural_log(((real)j + (real)0.5) * hy);
  ROLLED for (int i = 0; i < SEARCH_CELLS; ++i) {
    const vreal x = ((real)i + (real)0.5) * hx, log_x = natural_log(x);
    vreal before = 0, before_last = 0;
    ROLLED for (int j = 0; j < SEARCH_CELLS; ++j) {
      const vreal now = corner(x, ((real)j + (real)0.5) * hy, log_x, log_y[j]);
      if (i == 0) last[j] = -now; /* corners are odd in x and in y */
      if (j == 0) before = -now, before_last = -last[j];
      const vreal rest = mean_rest(in, &places_x, &places_y, (real)i * hx, (real)j * hy);
      zz[i * SEARCH_CELLS + j] =
          in[PAD_SEARCH_NORMAL_FACTOR] * fma(hx * hy, rest, (now - before) - (last[j] - before_last));
      before_last = last[j];
      last[j] = now;
      before = now;
    }
  }
}

/* Measured heights, where any lane has some. */
typedef struct {
  global const real *heights;
  global const int *at; /* [lane] */
  int any;
} Maps;

/* Bilinear between measured heights; no indenter beyond them. */
static vreal map_heights(const Maps *maps, global const vreal *in, vreal x, vreal y, vreal height) {
  real at_x[LANES], at_y[LANES], h[LANES], rows[LANES], columns[LANES], unit[LANES];
  STORE(in[PAD_MAP_ROWS], rows);
  STORE(in[PAD_MAP_COLUMNS], columns);
  STORE(in[PAD_MAP_UNIT], unit);
  STORE(fma(x, in[PAD_MAP_PER_PITCH], (in[PAD_MAP_ROWS] - 1) * (real)0.5), at_x);
  STORE(fma(y, in[PAD_MAP_PER_PITCH], (in[PAD_MAP_COLUMNS] - 1) * (real)0.5), at_y);
  STORE(height, h);
  for (int l = 0; l < LANES; ++l) {
    if (rows[l] == 0) continue;
    h[l] = PAD_OPEN;
    if (!(at_x[l] >= 0 && at_y[l] >= 0 && at_x[l] <= rows[l] - 1 && at_y[l] <= columns[l] - 1)) continue;
    const int across = (int)columns[l], i = min((int)at_x[l], (int)rows[l] - 2), j = min((int)at_y[l], across - 2);
    global const real *cell = maps->heights + maps->at[l] + i * across + j;
    const real p = at_x[l] - (real)i, q = at_y[l] - (real)j;
    h[l] = unit[l] * fma(1 - p, fma(1 - q, cell[0], q * cell[1]), p * fma(1 - q, cell[across], q * cell[across + 1]));
  }
  return LOAD(h);
}

/* A box around where measured heights lie below a depth replaces x and y in `lanes`: around their points and a pitch
   more, or, `between`, around where the bilinear profile does. */
static void map_box(const Maps *maps, global const vreal *in, vreal depth, int between, vint lanes, Extent *x,
                    Extent *y) {
  real rows[LANES], columns[LANES], below[LANES], from_x[LANES], to_x[LANES], from_y[LANES], to_y[LANES];
  STORE(in[PAD_MAP_ROWS], rows);
  STORE(in[PAD_MAP_COLUMNS], columns);
  STORE(depth / in[PAD_MAP_UNIT], below);
  const real more = between ? 0 : 1;
  for (int l = 0; l < LANES; ++l) {
    const int along = (int)rows[l], across = (int)columns[l];
    real first_i = along, last_i = 0, first_j = across, last_j = 0;
    for (int i = 0; i < along; ++i)
      for (int j = 0; j < across; ++j) {
        global const real *h = maps->heights + maps->at[l] + i * across + j;
        /* The point, and on the way to the next along x and y where the depth is met. */
        for (int k = 0; k < (between ? 3 : 1); ++k) {
          const int inside = k == 1 ? i + 1 < along : k == 2 ? j + 1 < across : 1;
          const real next = inside ? h[k == 1 ? across : k == 2 ? 1 : 0] : h[0];
          if (k == 0 ? h[0] > below[l] : !inside || (h[0] <= below[l]) == (next <= below[l])) continue;
          const real share = k == 0 ? 0 : (below[l] - h[0]) / (next - h[0]);
          const real at_i = (real)i + (k == 1 ? share : 0), at_j = (real)j + (k == 2 ? share : 0);
          first_i = fmin(first_i, at_i);
          last_i = fmax(last_i, at_i);
          first_j = fmin(first_j, at_j);
          last_j = fmax(last_j, at_j);
        }
      }
    from_x[l] = first_i - more - (real)0.5 * (real)(along - 1);
    to_x[l] = last_i + more - (real)0.5 * (real)(along - 1);
    from_y[l] = first_j - more - (real)0.5 * (real)(across - 1);
    to_y[l] = last_j + more - (real)0.5 * (real)(across - 1);
  }
  const vreal pitch = 1 / in[PAD_MAP_PER_PITCH];
  x->left = PICK(lanes, pitch * LOAD(from_x), x->left);
  x->right = PICK(lanes, pitch * LOAD(to_x), x->right);
  y->left = PICK(lanes, pitch * LOAD(from_y), y->left);
  y->right = PICK(lanes, pitch * LOAD(to_y), y->right);
}

INLINE void take(vint lanes, const Extent *from, Extent *to) {
  to->left = PICK(lanes, from->left, to->left);
  to->right = PICK(lanes, from->right, to->right);
}

/* The square of what lies beyond a flat, times a curvature. */
static inline vreal rounding(vreal distance, vreal flat, vreal curvature) {
  const vreal beyond = LARGER(distance - flat, ALL_LANES(0));
  return curvature * beyond * beyond;
}

static inline vreal height_at(const Maps *maps, global const vreal *in, vreal x, vreal y) {
  const vreal rho2 = fma(x, x, in[PAD_SHAPE_ROUND] * y * y), rho = sqrt(rho2);
  const vreal c = in[PAD_SHAPE_CIRCLE], square = rho2 * c;
  vreal h = square / (1 + sqrt(LARGER(fma(-square, c, ALL_LANES(1)), ALL_LANES(0))));
  h = fma(in[PAD_SHAPE_SLOPE], rho, h) + rounding(rho, in[PAD_SHAPE_FLAT], in[PAD_SHAPE_CURVE]);
  h += rounding(fabs(x), in[PAD_SHAPE_FLAT_X], in[PAD_SHAPE_CURVE_X]);
  h += rounding(fabs(y), in[PAD_SHAPE_FLAT_Y], in[PAD_SHAPE_CURVE_Y]);
  if (!MIRRORED) h += fma(in[PAD_SHAPE_TILT_X], x, fma(in[PAD_SHAPE_TILT_Y], y, in[PAD_SHAPE_BELOW]));
  if (!MIRRORED && maps->any) h = map_heights(maps, in, x, y, h);
  return PICK(rho > in[PAD_SHAPE_RIM], ALL_LANES(PAD_OPEN), h);
}

/* Half a side of the rigid section of closed shapes. */
static inline vreal half_section(vreal depth, vreal round_depth, vreal flat, vreal wide, vreal less, vreal slope) {
  return flat + sqrt(round_depth * fma(-less, round_depth, wide)) + slope * depth;
}

static void rigid_section(const Maps *maps, global const vreal *in, vreal depth, Extent *x, Extent *y) {
  const vreal d = PICK(depth > 0, depth, ALL_LANES(LEAST_DEPTH)), round_depth = SMALLER(d, in[PAD_SECTION_MOST]);
  x->right = half_section(d, round_depth, in[PAD_SECTION_X], in[PAD_SECTION_WIDE_X], in[PAD_SECTION_LESS_X],
                          in[PAD_SECTION_SLOPE]);
  y->right = half_section(d, round_depth, in[PAD_SECTION_Y], in[PAD_SECTION_WIDE_Y], in[PAD_SECTION_LESS_Y],
                          in[PAD_SECTION_SLOPE]);
  x->left = -x->right;
  y->left = -y->right;
  if (!MIRRORED && maps->any) map_box(maps, in, d, 0, in[PAD_MAP_ROWS] > 0, x, y);
}

static inline void clip(Extent *e, vreal edge) {
  e->left = LARGER(e->left, -edge);
  e->right = SMALLER(e->right, edge);
}

/* Heights and influence of a window's cells, which bear nothing yet. */
static void start_round(const Maps *maps, global const vreal *in, vreal depth, const Extent *x, const Extent *y,
                        vreal hx, vreal hy, Press *s) {
  vreal zz[SEARCH_CELLS * SEARCH_CELLS];
  cell_influence(in, hx, hy, zz);
  if (MIRRORED) {
    vreal along_y[SEARCH_CELLS * ENTRIES];
    ROLLED for (int i = 0; i < SEARCH_CELLS; ++i) for (int j = 0; j < SIDE; ++j) for (int l = 0; l <= j; ++l)
        along_y[i * ENTRIES + ENTRY(j, l)] = zz[i * SEARCH_CELLS + j - l] + zz[i * SEARCH_CELLS + j + l + 1];
    ROLLED for (int i = 0; i < SIDE; ++i) ROLLED for (int k = 0; k <= i; ++k) ROLLED for (int e = 0; e < ENTRIES; ++e)
        s->zz[ENTRY(i, k) * ENTRIES + e] = along_y[(i - k) * ENTRIES + e] + along_y[(i + k + 1) * ENTRIES + e];
  } else {
    ROLLED for (int e = 0; e < ENTRIES * ENTRIES; ++e) s->zz[e] = zz[e];
  }
  const vreal from_x = MIRRORED ? (vreal)(0) : x->left, from_y = MIRRORED ? (vreal)(0) : y->left;
  ROLLED for (int i = 0; i < SIDE; ++i) {
    s->bears[i] = 0;
    ROLLED for (int j = 0; j < SIDE; ++j) {
      const vreal at_x = fma(ALL_LANES((real)i + (real)0.5), hx, from_x),
                  at_y = fma(ALL_LANES((real)j + (real)0.5), hy, from_y);
      s->target[i * SIDE + j] = depth - height_at(maps, in, at_x, at_y);
      s->per_own[i * SIDE + j] = 1 / s->zz[ENTRY(i, i) * ENTRIES + ENTRY(j, j)];
      s->p[i * SIDE + j] = 0;
    }
  }
}

/* What the target of a row of cells leaves over when other rows press: those before it and behind it. */
INLINE void take_row(const vreal *zz, const vreal *p, vreal *left) {
  EACH(l, SIDE) EACH(j, SIDE) { left[j] = fma(-zz[ENTRY(j, l)], p[l], left[j]); }
}

/* One sweep, row by row along x; returns the lanes that have not settled. */
OUTLINE vint search_sweep(Press *s, vint active) {
  vreal change = 0, largest = 0;
  ROLLED for (int i = 0; i < SIDE; ++i) {
    vreal left[SIDE], *p = s->p + i * SIDE;
    EACH(j, SIDE) { left[j] = s->target[i * SIDE + j]; }
    ROLLED for (int k = 0; k < SIDE; ++k) if (k != i && s->bears[k])
        take_row(s->zz + ENTRY(i, k) * ENTRIES, s->p + k * SIDE, left);
    const vreal *zz = s->zz + ENTRY(i, i) * ENTRIES;
    EACH(l, SIDE) EACH(j, l) { left[j] = fma(-zz[ENTRY(j, l)], p[l], left[j]); }
    vint bears = 0;
    EACH(l, SIDE) {
      const vreal old = p[l], now = PICK(active, LARGER(left[l] * s->per_own[i * SIDE + l], ALL_LANES(0)), old);
      EACH(j, SIDE - 1 - l) { left[l + 1 + j] = fma(-zz[ENTRY(l + 1 + j, l)], now, left[l + 1 + j]); }
      p[l] = now;
      bears |= now > 0;
      change = LARGER(fabs(now - old), change);
      largest = LARGER(now, largest);
    }
    s->bears[i] = ANY(bears);
  }
  return active & (change > SEARCH_TOLERANCE * largest);
}

/* The pressed extent in a direction becomes `pressed`, and `window` the next window. `bears[i]`: whether a lane presses
   in the cells i. */
static void next_extent(const vint *bears, vreal h, vint any, vreal edge, Extent *window, Extent *pressed) {
  vreal first = SIDE, end = 0;
  ROLLED for (int i = 0; i < SIDE; ++i) {
    first = PICK(bears[i] & (first >= SIDE), ALL_LANES(i), first);
    end = PICK(bears[i], ALL_LANES(i + 1), end);
  }
  const Extent now = {MIRRORED ? -(end * h) : fma(first, h, window->left),
                      MIRRORED ? end * h : fma(end, h, window->left)};
  const vint grows_left = MIRRORED ? end >= SIDE : first <= 0;
  const vreal part = WINDOW_GROWTH * (now.right - now.left), cells = WINDOW_MARGIN * h;
  const Extent next = {now.left - PICK(grows_left, part, cells), now.right + PICK(end >= SIDE, part, cells)};
  pressed->left = PICK(any, now.left, pressed->left);
  pressed->right = PICK(any, now.right, pressed->right);
  window->left = PICK(any, LARGER(next.left, -edge), window->left);
  window->right = PICK(any, SMALLER(next.right, edge), window->right);
}

/* Rounds at this depth. Returns the force of the last; *x, *y: what presses, and the window where nothing does. */
static vreal search_at(const Maps *maps, global const vreal *in, vreal depth, vint running, Extent *x, Extent *y) {
  vreal P = 0;
  Extent window_x, window_y;
  Press s;
  rigid_section(maps, in, depth, &window_x, &window_y);
  clip(&window_x, in[PAD_SHAPE_EDGE_X]);
  clip(&window_y, in[PAD_SHAPE_EDGE_Y]);
  *x = window_x;
  *y = window_y;
  running &= depth > 0;
  ROLLED for (int round = 0; round < SEARCH_ROUNDS && ANY(running); ++round) {
    const vreal hx = (window_x.right - window_x.left) / SEARCH_CELLS,
                hy = (window_y.right - window_y.left) / SEARCH_CELLS;
    start_round(maps, in, depth, &window_x, &window_y, hx, hy, &s);
    vint active = running, bears_x[SIDE], bears_y[SIDE], any = 0;
    ROLLED for (int k = 0; k < SEARCH_SWEEPS && ANY(active); ++k) active = search_sweep(&s, active);
    vreal sum = 0;
    for (int i = 0; i < SIDE; ++i) bears_x[i] = bears_y[i] = 0;
    ROLLED for (int i = 0; i < UNKNOWNS; ++i) {
      const vint bears = s.p[i] > 0;
      bears_x[i / SIDE] |= bears;
      bears_y[i % SIDE] |= bears;
      any |= bears;
      sum += s.p[i];
    }
    if (MIRRORED) sum *= 4;
    P = PICK(running, sum * hx * hy, P);
    next_extent(bears_x, hx, running & any, in[PAD_SHAPE_EDGE_X], &window_x, x);
    next_extent(bears_y, hy, running & any, in[PAD_SHAPE_EDGE_Y], &window_y, y);
    const vint missed = !MIRRORED && round == 0 && maps->any ? running & NOT(any) & (in[PAD_MAP_ROWS] > 0) : (vint)(0);
    if (ANY(missed)) {
      map_box(maps, in, depth, 1, missed, &window_x, &window_y);
      take(missed, &window_x, x);
      take(missed, &window_y, y);
      any |= missed;
    }
    running &= any;
  }
  return P;
}

/* lane_input [groups][PAD_SEARCH_ROWS][lane]; maps: measured heights, mm, [rows][columns] each; map_at
   [groups][lane]: the first height of a lane's. Out: found [groups][PAD_FOUND_ROWS][lane]. */
kernel void pad_search(uint first_group, global const vreal *lane_input, global const real *maps,
                       global const int *map_at, global vreal *found) {
  TAKE_GROUP(group);
  global const vreal *in = lane_input + group * PAD_SEARCH_ROWS;
  const vint valid = in[PAD_SEARCH_NORMAL_FACTOR] > 0, by_force = in[PAD_SEARCH_BY_FORCE] > 0;
  const vreal target = in[PAD_SEARCH_TARGET];
  const Maps lane_maps = {maps, map_at + group * LANES, ANY(in[PAD_MAP_ROWS] > 0)};
  Extent x, y;
  vreal depth = PICK(by_force, PICK(target > 0, ALL_LANES(FIRST_DEPTH), ALL_LANES(0)), target);
  vreal P = search_at(&lane_maps, in, depth, valid, &x, &y);

  /* The twin's secants in the logarithms of depth and force. */
  vreal last_depth = depth, last_P = P, power = (real)1.5;
  vint searching = valid & by_force & (target > 0);
  ROLLED for (int trial = 1; trial < SEARCH_DEPTHS; ++trial) {
    searching &= fabs(P - target) > SEARCH_FORCE_ERROR * target;
    if (!ANY(searching)) break;
    const vint learns = searching & (depth != last_depth) & (P > 0) & (last_P > 0);
    const vreal slope = natural_log(PICK(learns, P / last_P, ALL_LANES(2))) /
                        natural_log(PICK(learns, depth / last_depth, ALL_LANES(2)));
    power = PICK(learns, SMALLER(LARGER(slope, ALL_LANES((real)0.5)), ALL_LANES(4)), power);
    const vreal factor = PICK(P > 0, depth_factor(PICK(P > 0, target / P, ALL_LANES(1)), power), ALL_LANES(10));
    last_depth = PICK(searching, depth, last_depth);
    last_P = PICK(searching, P, last_P);
    depth = PICK(searching, depth * factor, depth);
    Extent trial_x, trial_y;
    const vreal now = search_at(&lane_maps, in, depth, searching, &trial_x, &trial_y);
    P = PICK(searching, now, P);
    x.left = PICK(searching, trial_x.left, x.left);
    x.right = PICK(searching, trial_x.right, x.right);
    y.left = PICK(searching, trial_y.left, y.left);
    y.right = PICK(searching, trial_y.right, y.right);
  }
  const vreal more_x = MARGIN * (x.right - x.left), more_y = MARGIN * (y.right - y.left);
  found += group * PAD_FOUND_ROWS;
  found[PAD_FOUND_LEFT] = x.left - more_x;
  found[PAD_FOUND_RIGHT] = x.right + more_x;
  found[PAD_FOUND_BELOW] = y.left - more_y;
  found[PAD_FOUND_ABOVE] = y.right + more_y;
  found[PAD_FOUND_DEPTH] = depth;
  found[PAD_FOUND_P] = P;
}
