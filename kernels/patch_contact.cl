// SPDX-License-Identifier: Apache-2.0
/* Batched contact of rigid indenters with a bonded layer, each on its own patch of equal elements: patch search, compliance, load path,
   certificate and base stress in one launch.

   One work-item carries LANES scenes of one sensor. An element bears a pressure force n >= 0 and a traction force t on the rubber, constant
   over its width; displacements are those of its middle. The kernel works at E = 1, where forces are in mm, and scales what it writes.
   Places along x count from the indenter's position: a contact of 2 um keeps its digits in fp32 wherever it is.

   Compliance. C = layer of infinite length in closed form + free sides. With k = i - j, element width w and thickness h
     C_yy[k] = c_y (-ln(w/h) - c_k + (R_yy((k + 1/2) w) - R_yy((k - 1/2) w)) / w),   C_xx alike,
     C_xy[k] = c_x ((1 - 2 nu) (pi/2) sgn k + (R_xy((k + 1/2) w) - R_xy((k - 1/2) w)) / w),   C_yx[k] = -C_xy[k],
   R: integrals of the smooth parts of the layer's kernels, tabulated over x / h. The sides add sum_m sign_m v_m(x_i) v_m(x_j)^T.

   Law at element i, with gap g = h - d - u_y and slip s = (u_x - u_x at the last increment) - (X - X at the last increment):
     n >= 0,  g >= 0,  n g = 0;   |t| <= mu n,  s = 0 inside the cone,  s t <= 0 on its edge.
   Sweeps are projected Gauss-Seidel with relaxation RELAXATION, scaled once so that a row is
     n_i = max(0, b_i + sum A_ij n_j + sum B_ij t_j),   t_i = clip(bt_i + sum D_ij n_j + sum E_ij t_j, -mu n_i, mu n_i).

   The twin (fem/layer) follows the same rules:
   - Search. The first window is the rigid intersection at the largest depth. SEARCH_ROUNDS rounds of frictionless contact on
     SEARCH_ELEMENTS elements, without sides, by plain sweeps from zero forces to SEARCH_TOLERANCE. The next window is the pressed extent +
     1.5 elements a side, or + 25 % of the extent on a side where the outermost element presses, inside the limits (the indenter's edges,
     the sensor's ends). The patch is the last extent + MARGIN of it a side.
   - Edges. A side of the patch that reaches the indenter's own edge ends EDGE_PART of an element beyond it, on the sensor. A side that
     reaches the sensor's end ends there.
   - Driven by force, the search is repeated at depths that follow secants in the logarithms of depth and force. Sweeps then go to a tenth of
     the tolerance, and forces are met to the tolerance.
   - Sweeps go from left to right. The pressure of element i takes the traction of element i - 1 from the sweep before, so that it need not
     wait for it; everything else is the newest. A sweep is the last when no force changed by more than the tolerance times the
     largest pressure force. After DAMPED_AFTER sweeps a force moves half of its step, after 4 times as many a fifth.
   - The certificate looks for penetration at OUTSIDE places beyond each end, too. Where the patch is too small the host gives a larger one.
   - The first guess of an increment continues the last change of the forces in proportion to the load.
   - A sticking element's history is its exact position.
   - While the indenter presses only, an open element whose gap would close within the increment sticks from where it would be then.

   A lane's result depends on nothing but the lane: finished lanes keep their bits, and every sum runs in an order fixed by the element's
   index.

   Built with -D REAL (float | double), LANES (1, 2, 4, 8, 16), ELEMENTS, FORCE_CONTROL (0 | 1), FRICTION (0 | 1), SENSORS (0 | 1). With
   FORCE_CONTROL all lanes are driven by force. Without FRICTION all lanes have mu = 0: there is no traction and no history. With SENSORS
   every lane has its own sensor: its tables are read between two rows of Poisson's ratios, over x / h, and its sides are those of two
   ends (fem/layer/sensor_family.h, the twin of this way). */
// defines: ELEMENTS=12 FORCE_CONTROL=1 FRICTION=1 SENSORS=1
#include "shared/group.h"
#include "shared/lanes.h"
#include "shared/transpose.h"
#include "shared/unroll.h"
#include "shared/elementary.h"
#include "shared/contact_layout.h"
#include "shared/patch_layout.h"

/* Stores what no kernel reads again, past the caches: a launch writes much more than they hold. */
#if LANES > 1 && defined(__has_builtin)
#if __has_builtin(__builtin_nontemporal_store)
#define STORE_AWAY(v, p) __builtin_nontemporal_store(v, (global vreal *)(p))
#endif
#endif
#ifndef STORE_AWAY
#define STORE_AWAY(v, p) STORE(v, p)
#endif

/* Row r of an array of vectors, and number r of an answer: of a group with vectors, next to each other. */
#define AT(r) ((r)*INTERLEAVED)

#define N ELEMENTS
#define C_PARTS (FRICTION ? 4 : 1)
#define FAR ((real)NO_GAP_ELEMENT) /* mm: height where there is no indenter or no rubber */
#define RELAXATION ((real)0.85)
#define DAMPED_AFTER 60
#define SEARCH_ELEMENTS 12
#define SEARCH_ROUNDS 3
#define SEARCH_SWEEPS 200
#define SEARCH_TOLERANCE ((real)1e-3)
#define SEARCH_DEPTHS 20                /* trials of the depth that gives a force */
#define SEARCH_FORCE_ERROR ((real)0.02) /* of the force */
#define BISECTIONS (REAL_IS_DOUBLE ? 60 : 30)
#define MARGIN ((real)0.06)
#define EDGE_PART ((real)0.15)
#define OUTSIDE 3                   /* rows beyond each end of the patch that the certificate looks at */
#define SLIDING_MARGIN ((real)1e-5) /* share of Q = mu P within which a contact slides as a whole */
#define MOST_FORCE_TRIALS 60        /* trials of depth (and position) to reach given forces */

/* A function of its own: what is unrolled in it exists once. */
#define OUTLINE static __attribute__((noinline))

/* Keeps the compiler from holding loaded numbers of one row for the next, which spills. Empty on GPUs, and in oclgrind (SPIR), whose builder
   crashes at inline assembly. */
#if LANES > 1 && !defined(__SPIR__)
#define ROW_BARRIER __asm__ volatile("" ::: "memory")
#else
#define ROW_BARRIER
#endif

/* c_k of the compliance: (k + 1/2) ln|k + 1/2| - (k - 1/2) ln|k - 1/2| - 1. */
constant real log_part[28] = {(real)-1.6931471805599453, (real)-0.045228747557780772, (real)0.68252916752314109, (real)1.0939435600484003,
                              (real)1.3836778957594453,  (real)1.6077662218181055,    (real)1.7905996425490055,  (real)1.9450585042066414,
                              (real)2.0787897356513159,  (real)2.1967096970434024,    (real)2.3021681134548118,  (real)2.3975507065293347,
                              (real)2.4846171471073426,  (real)2.5647026996459878,    (real)2.6388446631854856,  (real)2.7078649541559481,
                              (real)2.7724259141172118,  (real)2.8330691313078702,    (real)2.8902431272934675,  (real)2.9443235350500078,
                              (real)2.9956280873502593,  (real)3.0444279394133368,    (real)3.0909563518606571,  (real)3.1354154397942369,
                              (real)3.1779814829640299,  (real)3.2188091502000099,    (real)3.2580348941009761,  (real)3.2957797042017763};

#if SENSORS
/* A number of the sensor: of each lane, or of all. */
#define OF_LANES(x) (x)
#define ENDS 2
#else
#define OF_LANES(x) ALL_LANES(x)
#define ENDS 1
#endif
#define MODES (ENDS * SIDE_MODES) /* of the sides at a place: v_y of all, then v_x of all; those of the left end first */

/* The sensor, and what the host chose. */
#if SENSORS
typedef struct {
  global const real *smooth; /* [cells][poissons][PATCH_BLOCK] as below */
  int cells, poissons;
  int poisson[LANES]; /* row below, and how far above it */
  vreal part;
  vreal cells_per_mm, thickness, length, per_thickness;
  vreal cy, cx, jump;
  global const real *sides;       /* [side_rows][PATCH_BLOCK] displacement, by distance from an end over h */
  global const real *side_forces; /* [side_rows][PATCH_BLOCK] */
  int side_rows;                  /* 0: no free sides */
  real side_rows_per_h;
  vreal core[CORE_NUMBERS]; /* C and K between the rows */
} Layer;
#else
typedef struct {
  global const real *smooth; /* [cells][PATCH_BLOCK]: LAYER_COEFFICIENTS of R_yy, R_xx, R_xy over x / h */
  int cells;
  real cells_per_mm;
  real thickness, length;   /* mm */
  real cy, cx, jump;        /* factors of C_yy, of C_xy, and (1 - 2 nu) pi/2 */
  global const real *sides; /* [side_rows][PATCH_BLOCK], from the sensor's left end on */
  int side_rows;            /* 0: no free sides */
  real side_rows_per_mm;
  real sides_from;          /* mm */
  global const real *signs; /* [SIDE_MODES] */
} Layer;
#endif

/* The indenter's shape in every lane; kinds that no lane has cost nothing. */
typedef struct {
  global const real *shapes;
  vreal left, right, flat, c[5], radius, exp_height, exp_rate;
  int cylinders, exponentials, terms, points; /* whether any lane has them */
  int term_count[LANES], terms_at[LANES], point_count[LANES], points_at[LANES];
} Profile;

/* Whether elements may be touched within an increment: driven by depth, with a history. */
#define ENTRIES (FRICTION && !FORCE_CONTROL)

/* Compliance of 16 elements is kept once for each pair: dense, it would not fit the first-level cache. */
#define SYMMETRIC (N == 16)
#define PAIRS (N * (N + 1) / 2)
#define PAIR(i, j) ((i) > (j) ? (i) * ((i) + 1) / 2 + (j) : (j) * ((j) + 1) / 2 + (i))

typedef struct {
#if SYMMETRIC
  vreal yy[PAIRS]; /* - C_yy */
#if FRICTION
  vreal xx[PAIRS]; /* - C_xx */
  vreal xy[N][N];  /* C_xy: u_x of the first by f_y of the second, and u_y of the second by f_x of the first */
#endif
#else
  vreal c[N][N][C_PARTS]; /* A, B, D, E */
#endif
  vreal n[N], t[N]; /* pressure and traction force / E, mm */
  vreal n_last[N], t_last[N];
  vreal b[N], bt[N];  /* constant parts of the rows */
  vreal h[N];         /* profile heights, mm */
  vreal wy[N], wx[N]; /* RELAXATION / C_yy[i][i] and C_xx */
  vreal per_wy[N], per_wx[N];
  vreal ux_last[N]; /* wx times u_x at the last increment; of a sticking element what it should have been */
#if ENTRIES
  vreal ux[N], ux_before[N];   /* wx times u_x, as certify found it, and one increment before */
  vreal gap[N], gap_before[N]; /* mm: the same of the gap */
#endif
  vreal outside[2 * OUTSIDE][N][2]; /* u_y of the places beyond the ends, by n and by t */
  vreal h_outside[2 * OUTSIDE];     /* FAR where there is no indenter or no rubber */
} Contact;

/* Where the indenter is, and which lanes iterate. */
typedef struct {
  vreal mu, d, x, x_last; /* mm */
  vint active;
  vint held; /* lanes that are where they were at the last increment */
} Indenter;

/* Relative figures of fem/contact_solution.h and the slip distance, mm, from the final forces alone. */
typedef struct {
  vreal penetration, cone, complementarity, drift, slip_distance;
  vreal largest_uy;
  vint sticks, slips; /* whether any element does */
} Certificate;

typedef struct {
  vreal origin, element; /* of the patch, mm */
  vreal sweeps;
} Patch;

typedef struct {
  real tolerance;
  int most_sweeps;
} Rules;

#define LARGER(a, b) PICK((a) > (b), a, b)
#define SMALLER(a, b) PICK((a) < (b), a, b)

/* Goes on being a number while every x is finite. */
static inline vreal finite_sum(vreal sum, vreal x) { return fma(ALL_LANES(0), x, sum); }

/* Cells of a table: the cell of each lane, and how far inside it. */
typedef struct {
  int cell[LANES];
  vreal q;
} Place;

/* Every place is in the table, numbers that are none too. */
static inline Place place_in(vreal at, int cells) {
  const vreal inside = SMALLER(LARGER(at, ALL_LANES(0)), ALL_LANES((real)cells));
  const vreal whole = SMALLER(TO_VREAL(TO_VINT(inside)), ALL_LANES((real)(cells - 1)));
  Place place;
  place.q = inside - whole;
  real cell[LANES];
  STORE(whole, cell);
  EACH(l, LANES) { place.cell[l] = (int)cell[l]; }
  return place;
}

/* Row rows[l] of a table of PATCH_BLOCK columns for each lane: column k of all lanes in to[k]. */
INLINE void gather_rows(global const real *table, const int *rows, vreal *to) {
  EACH(b, PATCH_BLOCK / LANES) {
    vreal r[LANES];
    EACH(l, LANES) { r[l] = LOAD(table + (size_t)rows[l] * PATCH_BLOCK + b * LANES); }
    transpose(r);
    EACH(l, LANES) { to[b * LANES + l] = r[l]; }
  }
}

INLINE vreal cubic(const vreal *c, vreal q) { return fma(fma(fma(c[3], q, c[2]), q, c[1]), q, c[0]); }

#if SENSORS
/* Row rows[l] of a table of any multiple of PATCH_BLOCK columns, and the one below, in each lane's own proportion. */
INLINE void gather_between(const Layer *layer, global const real *table, int columns, int block, vreal *to) {
  vreal next[PATCH_BLOCK];
  int rows[LANES];
  EACH(l, LANES) { rows[l] = layer->poisson[l] * (columns / PATCH_BLOCK) + block; }
  gather_rows(table, rows, to);
  EACH(l, LANES) { rows[l] += columns / PATCH_BLOCK; }
  gather_rows(table, rows, next);
  EACH(k, PATCH_BLOCK) { to[k] = fma(layer->part, next[k] - to[k], to[k]); }
}

/* R_yy, R_xx and R_xy at x >= 0, over h: between two rows of Poisson's ratios. */
OUTLINE void smooth_integrals(const Layer *layer, vreal x, vreal *r) {
  const Place place = place_in(x * layer->cells_per_mm, layer->cells);
  vreal c[PATCH_BLOCK];
  int rows[LANES];
  EACH(l, LANES) { rows[l] = place.cell[l] * layer->poissons + layer->poisson[l]; }
  gather_rows(layer->smooth, rows, c);
  EACH(a, 3) { r[a] = cubic(c + a * LAYER_COEFFICIENTS, place.q); }
  EACH(l, LANES) { rows[l] += 1; }
  gather_rows(layer->smooth, rows, c);
  EACH(a, 3) { r[a] = fma(layer->part, cubic(c + a * LAYER_COEFFICIENTS, place.q) - r[a], r[a]); }
}

/* A row of a table over the distance from an end, mm: linear between rows. The first half of its columns to `y`, the second, times
   `sign`, to `x`. */
INLINE void end_row(const Layer *layer, global const real *table, vreal distance, real sign, vreal *y, vreal *x) {
  const Place place = place_in(distance * layer->per_thickness * layer->side_rows_per_h, layer->side_rows - 1);
  vreal v[PATCH_BLOCK], next[PATCH_BLOCK];
  gather_rows(table, place.cell, v);
  gather_rows(table + PATCH_BLOCK, place.cell, next);
  EACH(m, SIDE_MODES) {
    y[m] = fma(place.q, next[m] - v[m], v[m]);
    x[m] = sign * fma(place.q, next[SIDE_MODES + m] - v[SIDE_MODES + m], v[SIDE_MODES + m]);
  }
}

/* v_y and v_x of the modes of both ends at x, mm from the sensor's middle. */
OUTLINE void side_modes(const Layer *layer, vreal x, vreal *v) {
  const vreal end = (real)0.5 * layer->length;
  end_row(layer, layer->sides, end + x, 1, v, v + MODES);
  end_row(layer, layer->sides, end - x, -1, v + SIDE_MODES, v + MODES + SIDE_MODES);
}

#define CORE_PAIR(r, q) ((r) < (q) ? (r) * (2 * SIDE_MODES - 1 - (r)) / 2 + (q) : (q) * (2 * SIDE_MODES - 1 - (q)) / 2 + (r))

/* C times the modes v of a place. */
OUTLINE void weighted_modes(const Layer *layer, const vreal *v, vreal *to) {
  for (int part = 0; part < 2 * ENDS; ++part) EACH(r, SIDE_MODES) {
      vreal sum = 0;
      EACH(q, SIDE_MODES) { sum = fma(layer->core[CORE_PAIR(r, q)], v[part * SIDE_MODES + q], sum); }
      to[part * SIDE_MODES + r] = sum;
    }
}
#else
/* R_yy, R_xx and R_xy at x >= 0, over h. */
static inline void smooth_integrals(const Layer *layer, vreal x, vreal *r) {
  const Place place = place_in(x * layer->cells_per_mm, layer->cells);
  vreal c[PATCH_BLOCK];
  gather_rows(layer->smooth, place.cell, c);
  r[0] = cubic(c, place.q);
  r[1] = cubic(c + LAYER_COEFFICIENTS, place.q);
  r[2] = cubic(c + 2 * LAYER_COEFFICIENTS, place.q);
}

/* v_y and v_x of the sides' modes at x, mm from the sensor's middle: linear between rows. */
static inline void side_modes(const Layer *layer, vreal x, vreal *v) {
  const Place place = place_in((x - layer->sides_from) * layer->side_rows_per_mm, layer->side_rows - 1);
  vreal next[PATCH_BLOCK];
  gather_rows(layer->sides, place.cell, v);
  gather_rows(layer->sides + PATCH_BLOCK, place.cell, next);
  EACH(m, 2 * SIDE_MODES) { v[m] = fma(place.q, next[m] - v[m], v[m]); }
}

static inline void weighted_modes(const Layer *layer, const vreal *v, vreal *to) {
  EACH(m, SIDE_MODES) {
    to[m] = layer->signs[m] * v[m];
    to[SIDE_MODES + m] = layer->signs[m] * v[SIDE_MODES + m];
  }
}
#endif

/* C_yy[k] / c_y or C_xx[k] / c_y: singular part and the difference of R. */
static inline vreal even_part(vreal log_width, int k, vreal to, vreal from, vreal per_width) {
  return fma(to - from, per_width, -(log_width + log_part[k]));
}

static inline vreal term_heights(const Profile *p, vreal q) {
  vreal sum = 0;
  int most = 0;
  EACH(l, LANES) { most = max(most, p->term_count[l]); }
  for (int k = 0; k < most; ++k) {
    real coefficient[LANES], power[LANES], per_scale[LANES];
    EACH(l, LANES) {
      const int has = k < p->term_count[l];
      global const real *term = p->shapes + p->terms_at[l] + 3 * k;
      coefficient[l] = has ? term[0] : 0;
      power[l] = has ? term[1] : 0;
      per_scale[l] = has ? term[2] : 0;
    }
    vreal square = q * LOAD(per_scale), product = LOAD(coefficient), left = LOAD(power);
    for (int bit = 0; bit < 7; ++bit) {
      const vreal halved = TO_VREAL(TO_VINT(left * (real)0.5));
      product = PICK(left - 2 * halved > (real)0.5, product * square, product);
      square = PICK(halved > 0, square * square, square);
      left = halved;
    }
    sum += product;
  }
  return sum;
}

/* Linear between the points of a measured profile: (x, height, slope to the next). */
static inline vreal point_heights(const Profile *p, vreal x, vreal y) {
  real at[LANES], height[LANES];
  STORE(x, at);
  STORE(y, height);
  for (int l = 0; l < LANES; ++l) {
    if (p->point_count[l] == 0) continue;
    global const real *points = p->shapes + p->points_at[l];
    int low = 0, high = p->point_count[l] - 1;
    while (high - low > 1) {
      const int middle = (low + high) / 2;
      if (points[3 * middle] <= at[l])
        low = middle;
      else
        high = middle;
    }
    height[l] = fma(points[3 * low + 2], at[l] - points[3 * low], points[3 * low + 1]);
  }
  return LOAD(height);
}

/* Height of the profile at x, mm; beyond the limits that of the limit. */
OUTLINE vreal profile_height(const Profile *p, vreal x) {
  x = SMALLER(LARGER(x, p->left), p->right);
  const vreal r = fabs(x), q = LARGER(r - p->flat, ALL_LANES(0));
  vreal y = q * fma(fma(fma(fma(p->c[4], q, p->c[3]), q, p->c[2]), q, p->c[1]), q, p->c[0]);
  if (p->cylinders) {
    const vreal inside = SMALLER(r, p->radius);
    const vreal below = p->radius + sqrt((p->radius - inside) * (p->radius + inside));
    y += PICK(p->radius > 0, inside * inside / below, ALL_LANES(0));
  }
  if (p->exponentials) y += p->exp_height * exp_minus_1(p->exp_rate * r);
  if (p->terms) y += term_heights(p, q);
  if (p->points) y = point_heights(p, x, y);
  return SMALLER(y, ALL_LANES(FAR));
}

/* One sweep of frictionless contact on the search's elements; a: its scaled row, [0] for the element itself. */
static inline vint search_sweep(const vreal *a, const vreal *b, vreal *n, vint active) {
  vreal change = 0, largest = 0;
  EACH(i, SEARCH_ELEMENTS) {
    vreal even = b[i], odd = 0;
    EACH(k, SEARCH_ELEMENTS / 2) {
      const int j = (i + 2 * k) % SEARCH_ELEMENTS, j1 = (i + 2 * k + 1) % SEARCH_ELEMENTS;
      even = fma(a[i > j ? i - j : j - i], n[j], even);
      odd = fma(a[i > j1 ? i - j1 : j1 - i], n[j1], odd);
    }
    const vreal old = n[i], now = PICK(active, LARGER(even + odd, ALL_LANES(0)), old);
    n[i] = now;
    change = LARGER(change, fabs(now - old));
    largest = LARGER(largest, now);
    ROW_BARRIER;
  }
  return active & (change > SEARCH_TOLERANCE * largest);
}

static inline void search_iterate(const vreal *a, const vreal *b, vreal *n, vint active, int most_sweeps, vreal *sweeps) {
  for (int k = 0; k < most_sweeps && ANY(active); ++k) {
    *sweeps += PICK(active, ALL_LANES(1), ALL_LANES(0));
    active = search_sweep(a, b, n, active);
  }
}

typedef struct {
  vreal a[SEARCH_ELEMENTS], h[SEARCH_ELEMENTS], b[SEARCH_ELEMENTS], n[SEARCH_ELEMENTS];
  vreal wy; /* 1 / C_yy[0] */
} SearchContact;

/* Frictionless contact on elements of this width from `left` on, with no forces yet. */
static inline void start_round(const Layer *layer, const Profile *profile, vreal left, vreal width, SearchContact *s) {
  const vreal over_h = width / layer->thickness, per = 1 / over_h, log_width = natural_log(over_h);
  vreal c[SEARCH_ELEMENTS], last = 0;
  for (int k = 0; k < SEARCH_ELEMENTS; ++k) {
    vreal r[3];
    smooth_integrals(layer, width * ((real)k + (real)0.5), r);
    c[k] = even_part(log_width, k, r[0], k == 0 ? -r[0] : last, per);
    last = r[0];
  }
  s->wy = 1 / (layer->cy * c[0]);
  const vreal scale = -1 / c[0];
  for (int k = 0; k < SEARCH_ELEMENTS; ++k) {
    s->a[k] = k == 0 ? ALL_LANES(0) : scale * c[k];
    s->h[k] = profile_height(profile, fma(width, ALL_LANES((real)k + (real)0.5), left));
    s->n[k] = 0;
  }
}

/* The pressed extent of a round becomes [*left, *right]; *from and *to become the next window. Where nothing presses
   the extent is the window. */
static inline void next_window(const Profile *profile, const SearchContact *s, vreal width, vreal *from, vreal *to, vreal *left, vreal *right) {
  vreal first = FAR, end = 0;
  for (int k = 0; k < SEARCH_ELEMENTS; ++k) {
    const vint pressed = s->n[k] > 0;
    first = PICK(pressed & (first >= FAR), ALL_LANES(k), first);
    end = PICK(pressed, ALL_LANES(k + 1), end);
  }
  const vint any = end > 0;
  const vreal l = PICK(any, fma(width, first, *from), *from), r = PICK(any, fma(width, end, *from), *to);
  const vreal part = (real)0.25 * (r - l), elements = (real)1.5 * width;
  const vreal next_from = l - PICK(first > 0, elements, part);
  const vreal next_to = r + PICK(end < SEARCH_ELEMENTS, elements, part);
  *left = l;
  *right = r;
  *from = LARGER(next_from, profile->left);
  *to = SMALLER(next_to, profile->right);
}

/* Elements over the contact [left, right]. */
static inline void lay_patch(const Layer *layer, const vreal *in, const Profile *profile, vreal left, vreal right, Patch *patch) {
  const vreal part = ALL_LANES(EDGE_PART), none = ALL_LANES(0);
  const vreal edge_left = PICK((left <= profile->left) & (in[PATCH_LEFT_EDGE] > 0), part, none);
  const vreal edge_right = PICK((right >= profile->right) & (in[PATCH_RIGHT_EDGE] > 0), part, none);
  const vreal l = LARGER(left, profile->left), r = SMALLER(right, profile->right);
  const vreal element = (r - l) / ((real)N - (edge_left + edge_right));
  const vreal end = (real)0.5 * layer->length, sensor_left = -end - in[PATCH_POSITION], sensor_right = end - in[PATCH_POSITION];
  const vreal from = LARGER(fma(-edge_left, element, l), SMALLER(sensor_left, l));
  const vreal to = SMALLER(fma(edge_right, element, r), LARGER(sensor_right, r));
  patch->origin = from;
  patch->element = (to - from) / N;
}

/* Rounds of frictionless contact at this depth from the window [from, to] on. Returns the force of the last; [*left, *right]: what
   presses. */
OUTLINE vreal search_at(const Layer *layer, const Profile *profile, vreal depth, vreal from, vreal to, vint searching, vreal *left, vreal *right,
                        vreal *sweeps) {
  vreal p = 0;
  *left = from;
  *right = to;
  for (int round = 0; round < SEARCH_ROUNDS; ++round) {
    SearchContact s;
    const vreal width = (to - from) / SEARCH_ELEMENTS;
    start_round(layer, profile, from, width, &s);
    for (int k = 0; k < SEARCH_ELEMENTS; ++k) s.b[k] = (depth - s.h[k]) * s.wy;
    search_iterate(s.a, s.b, s.n, searching, SEARCH_SWEEPS, sweeps);
    p = 0;
    for (int k = 0; k < SEARCH_ELEMENTS; ++k) p += s.n[k];
    next_window(profile, &s, width, &from, &to, left, right);
  }
  return p;
}

#if FORCE_CONTROL
/* The farthest place between `inside`, where the profile is below `depth`, and `outside`. */
static inline vreal last_below(const Profile *profile, vreal depth, vreal inside, vreal outside) {
  const vint all = profile_height(profile, outside) <= depth;
  vreal low = inside, high = outside;
  for (int k = 0; k < BISECTIONS; ++k) {
    const vreal middle = (real)0.5 * (low + high);
    const vint below = profile_height(profile, middle) <= depth;
    low = PICK(below, middle, low);
    high = PICK(below, high, middle);
  }
  return PICK(all, outside, low);
}

static inline vreal exponential(vreal x) {
  const vreal e = exp_minus_1(fabs(x)) + 1;
  return PICK(x < 0, 1 / e, e);
}

/* The extent that the largest force presses without friction: searches at depths from secants in the logarithms of depth and force. */
static inline void search_force(const Layer *layer, const Profile *profile, const vreal *in, vint searching, vreal *left, vreal *right,
                                vreal *sweeps) {
  const vreal wanted = in[PATCH_MOST];
  vreal depth = (real)0.3 * wanted, depth_last = depth, p = 0, p_last = 0, power = 1;
  searching &= wanted > 0;
  for (int trial = 0; trial < SEARCH_DEPTHS && ANY(searching); ++trial) {
    if (trial > 0) {
      const vint learns = (depth != depth_last) & (p > 0) & (p_last > 0);
      const vreal ratio = PICK(learns, p / p_last, ALL_LANES(2)), way = PICK(learns, depth / depth_last, ALL_LANES(2));
      const vreal slope = SMALLER(LARGER(natural_log(ratio) / natural_log(way), ALL_LANES((real)0.5)), ALL_LANES(4));
      if (trial > 1) power = PICK(learns, slope, power);
      const vreal step = exponential(natural_log(PICK(p > 0, wanted / p, ALL_LANES(1))) / power);
      const vreal factor = PICK(p > 0, SMALLER(LARGER(step, ALL_LANES((real)0.1)), ALL_LANES(10)), ALL_LANES(10));
      depth_last = depth;
      p_last = p;
      depth = PICK(searching, depth * factor, depth);
    }
    vreal trial_left, trial_right;
    const vreal from = last_below(profile, depth, in[PATCH_LOWEST_LEFT], profile->left);
    const vreal to = last_below(profile, depth, in[PATCH_LOWEST_RIGHT], profile->right);
    const vint touches = to > from;
    const vreal window_from = PICK(touches, from, profile->left), window_to = PICK(touches, to, profile->right);
    const vreal found = search_at(layer, profile, depth, window_from, window_to, searching & touches, &trial_left, &trial_right, sweeps);
    p = PICK(searching, found, p);
    *left = PICK(searching & touches, trial_left, *left);
    *right = PICK(searching & touches, trial_right, *right);
    searching &= NOT(fabs(p - wanted) <= SEARCH_FORCE_ERROR * wanted);
  }
}
#endif

/* The patch of each lane, from the search or as it is given. */
static inline void find_patch(const Layer *layer, const Profile *profile, const vreal *in, vint valid, Patch *patch) {
  const vint given = in[PATCH_GIVEN] > 0;
  vreal left = in[PATCH_FROM], right = in[PATCH_TO];
  patch->sweeps = 0;
#if FORCE_CONTROL
  search_force(layer, profile, in, valid & NOT(given), &left, &right, &patch->sweeps);
#else
  search_at(layer, profile, in[PATCH_MOST], in[PATCH_FROM], in[PATCH_TO], valid & NOT(given), &left, &right, &patch->sweeps);
#endif
  const vreal margin = MARGIN * (right - left);
  lay_patch(layer, in, profile, PICK(given, in[PATCH_FROM], left - margin), PICK(given, in[PATCH_TO], right + margin), patch);
}

/* Compliance of elements at distance k, C[k] of elements to the right of their source. */
typedef struct {
  vreal yy[N + OUTSIDE], xx[N + OUTSIDE], xy[N + OUTSIDE];
} LayerRows;

static inline void layer_rows(const Layer *layer, vreal width, LayerRows *rows) {
  const vreal over_h = width / layer->thickness, per = 1 / over_h, log_width = natural_log(over_h);
  vreal last[3] = {0, 0, 0};
  for (int k = 0; k < N + OUTSIDE; ++k) {
    vreal r[3];
    smooth_integrals(layer, width * ((real)k + (real)0.5), r);
    rows->yy[k] = layer->cy * even_part(log_width, k, r[0], k == 0 ? -r[0] : last[0], per);
    rows->xx[k] = layer->cy * even_part(log_width, k, r[1], k == 0 ? -r[1] : last[1], per);
    rows->xy[k] = k == 0 ? ALL_LANES(0) : layer->cx * fma(r[2] - last[2], per, OF_LANES(layer->jump));
    for (int a = 0; a < 3; ++a) last[a] = r[a];
  }
}

/* Adds the sides' part of u_y by f_y, u_x by f_x, u_x(i) by f_y(j) and u_x(j) by f_y(i). vi: weighted modes of place i. */
INLINE void add_sides(const vreal *vi, const vreal *vj, vreal *yy, vreal *xx, vreal *xy, vreal *yx) {
  EACH(m, MODES) {
    *yy = fma(vi[m], vj[m], *yy);
    *xx = fma(vi[MODES + m], vj[MODES + m], *xx);
    *xy = fma(vi[MODES + m], vj[m], *xy);
    *yx = fma(vi[m], vj[MODES + m], *yx);
  }
}

static inline vreal middle_of(const Patch *patch, int i) { return fma(patch->element, ALL_LANES((real)i + (real)0.5), patch->origin); }

/* Index of the places beyond the ends: to the left from the patch on, then to the right. */
static inline int outside_place(int o) { return o < OUTSIDE ? -1 - o : N + o - OUTSIDE; }

/* Rows of the compliance, scaled, and those beyond the ends. */
OUTLINE void build_compliance(const Layer *layer, const Patch *patch, vreal position, Contact *c) {
  LayerRows rows;
  layer_rows(layer, patch->element, &rows);
  vreal v[N][2 * MODES];
  const int sides = layer->side_rows > 0;
  for (int i = 0; i < N; ++i) {
    vreal yy = rows.yy[0], xx = rows.xx[0];
    if (sides) {
      side_modes(layer, position + middle_of(patch, i), v[i]);
      vreal vi[2 * MODES];
      weighted_modes(layer, v[i], vi);
      EACH(m, MODES) {
        yy = fma(vi[m], v[i][m], yy);
        xx = fma(vi[MODES + m], v[i][MODES + m], xx);
      }
    }
    c->wy[i] = RELAXATION / yy;
    c->wx[i] = RELAXATION / xx;
    c->per_wy[i] = yy * (1 / RELAXATION);
    c->per_wx[i] = xx * (1 / RELAXATION);
  }
  for (int i = 0; i < N; ++i) {
    vreal vi[2 * MODES];
    if (sides) weighted_modes(layer, v[i], vi);
    for (int j = 0; j <= i; ++j) {
      vreal yy = rows.yy[i - j], xx = rows.xx[i - j], xy = rows.xy[i - j], yx = -rows.xy[i - j];
      if (sides) add_sides(vi, v[j], &yy, &xx, &xy, &yx);
#if SYMMETRIC
      c->yy[PAIR(i, j)] = -yy;
#if FRICTION
      c->xx[PAIR(i, j)] = -xx;
      c->xy[i][j] = xy;
      c->xy[j][i] = yx;
#endif
#else
      c->c[i][j][0] = -c->wy[i] * yy;
      c->c[j][i][0] = -c->wy[j] * yy;
#if FRICTION
      c->c[i][j][1] = c->wy[i] * yx;
      c->c[j][i][1] = c->wy[j] * xy;
      c->c[i][j][2] = c->wx[i] * xy;
      c->c[j][i][2] = c->wx[j] * yx;
      c->c[i][j][3] = -c->wx[i] * xx;
      c->c[j][i][3] = -c->wx[j] * xx;
#endif
#endif
    }
#if !SYMMETRIC
    c->c[i][i][0] = 1 - RELAXATION;
#if FRICTION
    c->c[i][i][3] = 1 - RELAXATION;
#endif
#endif
  }
  for (int o = 0; o < 2 * OUTSIDE; ++o) {
    const int place = outside_place(o);
    vreal vo[2 * MODES], weighted_vo[2 * MODES];
    if (sides) {
      side_modes(layer, position + middle_of(patch, place), vo);
      weighted_modes(layer, vo, weighted_vo);
    }
    for (int j = 0; j < N; ++j) {
      const int k = place < j ? j - place : place - j;
      vreal yy = rows.yy[k], yx = place < j ? rows.xy[k] : -rows.xy[k];
      if (sides) EACH(m, MODES) {
          yy = fma(weighted_vo[m], v[j][m], yy);
          yx = fma(weighted_vo[m], v[j][MODES + m], yx);
        }
      c->outside[o][j][0] = -yy;
      c->outside[o][j][1] = yx;
    }
  }
}

/* Returns the lowest height of an element. */
static inline vreal put_heights(const Profile *profile, const Patch *patch, Contact *c) {
  vreal lowest = FAR;
  for (int i = 0; i < N; ++i) {
    c->h[i] = profile_height(profile, middle_of(patch, i));
    lowest = SMALLER(c->h[i], lowest);
  }
  for (int o = 0; o < 2 * OUTSIDE; ++o) {
    const vreal x = middle_of(patch, outside_place(o));
    c->h_outside[o] = PICK((x >= profile->left) & (x <= profile->right), profile_height(profile, x), ALL_LANES(FAR));
  }
  return lowest;
}

/* Rows are unrolled up to 16 elements; more would not fit the compiler's limits, and C is in the second-level cache there. A row's sums
   start at its own element when unrolled: the one that was updated last comes last, and its latency hides behind the others. */
#if N <= 16
#define EACH_ROW(i) EACH(i, N)
#define COLUMN(i, k) (((i) + (k)) % N)
#define OWN(k, factor) (!SYMMETRIC && (k) == 0 ? ALL_LANES(1 - RELAXATION) : (factor)) /* of the element itself it needs no load */
#else
#define EACH_ROW(i) ROLLED for (int i = 0; i < N; ++i)
#define COLUMN(i, k) (k)
#define OWN(k, factor) (factor)
#endif

/* Factors of n_j and t_j in the rows of element i, and what finishes a row: its sum becomes the free force without the constant part. */
#if SYMMETRIC
#define N_BY_N(c, i, j) (c)->yy[PAIR(i, j)]
#define N_BY_T(c, i, j) (c)->xy[j][i]
#define T_BY_N(c, i, j) (c)->xy[i][j]
#define T_BY_T(c, i, j) (c)->xx[PAIR(i, j)]
#define FINISH_N(c, i, sum, n_old) fma((c)->wy[i], sum, n_old)
#define FINISH_T(c, i, sum, t_old) fma((c)->wx[i], sum, t_old)
#define START(constant) ALL_LANES(0)
#define CONSTANT(constant) (constant)
#else
#define N_BY_N(c, i, j) (c)->c[i][j][0]
#define N_BY_T(c, i, j) (c)->c[i][j][1]
#define T_BY_N(c, i, j) (c)->c[i][j][2]
#define T_BY_T(c, i, j) (c)->c[i][j][3]
#define FINISH_N(c, i, sum, n_old) (sum)
#define FINISH_T(c, i, sum, t_old) (sum)
#define START(constant) (constant)
#define CONSTANT(constant) ALL_LANES(0)
#endif

/* One Gauss-Seidel sweep. Returns the active lanes whose largest change was above tolerance times their largest pressure force. Forces are
   in registers up to 12 elements; those of the last sweep stay in memory until all rows are done, and the change is found then. */
INLINE vint sweep(Contact *c, const Indenter *in, real tolerance) {
  vreal n[N], t[N];
  EACH(i, N) {
    n[i] = c->n[i];
    t[i] = FRICTION ? c->t[i] : ALL_LANES(0);
  }
  vreal late = t[0];
  EACH_ROW(i) {
    vreal yn = START(c->b[i]);
    const vreal n_old = n[i];
#if FRICTION
    vreal yt = 0, xn = START(c->bt[i]), xt = 0;
    const vreal t_old = t[i];
    EACH(k, N) {
      const int j = COLUMN(i, k);
      yn = fma(OWN(k, N_BY_N(c, i, j)), n[j], yn);
      yt = fma(N_BY_T(c, i, j), t[j], yt);
    }
    if (i > 0) t[i - 1] = late;
    EACH(k, N) {
      const int j = COLUMN(i, k);
      xn = fma(T_BY_N(c, i, j), n[j], xn);
      xt = fma(OWN(k, T_BY_T(c, i, j)), t[j], xt);
    }
    const vreal n_free = FINISH_N(c, i, yn + yt, n_old + CONSTANT(c->b[i]));
    n[i] = PICK(in->active, LARGER(n_free, ALL_LANES(0)), n_old);
    const vreal t_free = FINISH_T(c, i, fma(T_BY_N(c, i, i), n[i] - n_old, xn + xt), t_old + CONSTANT(c->bt[i]));
    const vreal cone = in->mu * n[i];
    late = PICK(in->active, SMALLER(LARGER(t_free, -cone), cone), t_old);
#else
    vreal odd = 0;
    EACH(k, N / 2) {
      const int j = COLUMN(i, 2 * k), next = COLUMN(i, 2 * k + 1);
      yn = fma(N_BY_N(c, i, j), n[j], yn);
      odd = fma(N_BY_N(c, i, next), n[next], odd);
    }
    const vreal n_free = FINISH_N(c, i, yn + odd, n_old + CONSTANT(c->b[i]));
    n[i] = PICK(in->active, LARGER(n_free, ALL_LANES(0)), n_old);
#endif
#if N > 12
    ROW_BARRIER;
#endif
  }
  t[N - 1] = late;
  ROW_BARRIER;
  vreal change = 0, largest = 0;
  EACH(i, N) {
    change = LARGER(change, fabs(n[i] - c->n[i]));
    largest = LARGER(largest, n[i]);
    c->n[i] = n[i];
    if (FRICTION) {
      change = LARGER(change, fabs(t[i] - c->t[i]));
      c->t[i] = t[i];
    }
  }
  return in->active & (change > tolerance * largest);
}

/* Free forces of element i from the forces n and t, without the constant parts. */
INLINE void row_sums(const Contact *c, const vreal *n, const vreal *t, int i, vreal *n_sum, vreal *t_sum) {
  vreal yn = 0, yt = 0, xn = 0, xt = 0;
  EACH(j, N) {
    yn = fma(N_BY_N(c, i, j), n[j], yn);
#if FRICTION
    yt = fma(N_BY_T(c, i, j), t[j], yt);
    xn = fma(T_BY_N(c, i, j), n[j], xn);
    xt = fma(T_BY_T(c, i, j), t[j], xt);
#endif
  }
  (void)t;
  *n_sum = FINISH_N(c, i, yn + yt, c->n[i]);
  *t_sum = FINISH_T(c, i, xn + xt, c->t[i]);
}

/* The same sweep with steps shortened to `part`, in a loop: it is rare. */
static inline vint damped_sweep(Contact *c, const Indenter *in, real part, real tolerance) {
  vreal change = 0, largest = 0, late = 0;
  for (int i = 0; i < N; ++i) {
    const vreal n_old = c->n[i];
    vreal n_sum, t_sum;
    row_sums(c, c->n, c->t, i, &n_sum, &t_sum);
    const vreal n_part = fma(part, (c->b[i] + n_sum) - n_old, n_old);
    const vreal n = PICK(in->active, LARGER(n_part, ALL_LANES(0)), n_old);
    c->n[i] = n;
    change = LARGER(change, fabs(n - n_old));
    largest = LARGER(largest, n);
#if FRICTION
    if (i > 0) c->t[i - 1] = late;
    row_sums(c, c->n, c->t, i, &n_sum, &t_sum);
    const vreal t_old = c->t[i], cone = in->mu * n;
    const vreal t_part = fma(part, (c->bt[i] + t_sum) - t_old, t_old);
    late = PICK(in->active, SMALLER(LARGER(t_part, -cone), cone), t_old);
    change = LARGER(change, fabs(late - t_old));
#endif
  }
  if (FRICTION) c->t[N - 1] = late;
  return in->active & (change > tolerance * largest);
}

/* Sweeps until every active lane has converged. Leaves in in->active the lanes that ran out of sweeps. */
OUTLINE void iterate(const Rules *rules, Contact *c, Indenter *in, vreal *sweeps) {
  int k = 0;
  for (; k < min(rules->most_sweeps, DAMPED_AFTER) && ANY(in->active); ++k) {
    *sweeps += PICK(in->active, ALL_LANES(1), ALL_LANES(0));
    in->active = sweep(c, in, rules->tolerance);
  }
  for (; k < rules->most_sweeps && ANY(in->active); ++k) {
    *sweeps += PICK(in->active, ALL_LANES(1), ALL_LANES(0));
    in->active = damped_sweep(c, in, k < 4 * DAMPED_AFTER ? (real)0.5 : (real)0.2, rules->tolerance);
  }
}

/* The contact laws at every element, from the forces alone, and the history for the next increment. A sticking element counts as having
   followed the indenter: what convergence left of it is then made good by the next increment instead of adding up over thousands of them. */
OUTLINE void certify(Contact *c, const Indenter *in, Certificate *k) {
  vreal largest_uy = 0, largest_n = 0, finite = 0;
  k->sticks = k->slips = 0;
  k->penetration = k->cone = k->complementarity = k->drift = k->slip_distance = 0;
  vreal all_n[N], all_t[N];
  EACH(i, N) {
    all_n[i] = c->n[i];
    all_t[i] = c->t[i];
  }
  ROLLED for (int i = 0; i < N; ++i) {
    vreal n_sum, t_sum;
    row_sums(c, all_n, all_t, i, &n_sum, &t_sum);
    const vreal n = c->n[i], t = c->t[i], cone = in->mu * n;
    const vint pressed = n > 0, sticks = pressed & (fabs(t) < cone);
    k->sticks |= sticks;
    k->slips |= pressed & NOT(sticks);
    const vreal uy = (n_sum - n) * c->per_wy[i];
    const vreal inside = uy - (c->h[i] - in->d);
#if ENTRIES
    c->gap_before[i] = c->gap[i];
    c->gap[i] = -inside;
#endif
    k->penetration = LARGER(inside, k->penetration);
    k->complementarity = LARGER(PICK(pressed, fabs(inside), ALL_LANES(0)), k->complementarity);
    largest_uy = LARGER(fabs(uy), largest_uy);
    largest_n = LARGER(n, largest_n);
    finite = finite_sum(finite, uy);
#if FRICTION
    const vreal per_wx = c->per_wx[i];
    const vreal ux = t - t_sum; /* wx times u_x */
    const vreal slip = PICK(in->held, ALL_LANES(0), (ux - c->bt[i]) * per_wx);
    const vreal along = PICK(t > 0, slip, PICK(t < 0, -slip, ALL_LANES(0))); /* slip with friction instead of against it */
    const vreal drift = PICK(pressed, PICK(fabs(t) < cone, fabs(slip), along), ALL_LANES(0));
    const vreal slid = PICK(pressed, fabs(fma(ux, per_wx, -in->x)), ALL_LANES(0));
    c->ux_last[i] = PICK(sticks, c->bt[i], ux);
#if ENTRIES
    c->ux_before[i] = c->ux[i];
    c->ux[i] = ux;
#endif
    k->drift = LARGER(drift, k->drift);
    k->cone = LARGER(fabs(t) - cone, k->cone);
    k->slip_distance = LARGER(slid, k->slip_distance);
    finite = finite_sum(finite, ux);
#else
    (void)t_sum;
    k->slip_distance = PICK(largest_n > 0, fabs(in->x), ALL_LANES(0));
#endif
  }
  k->largest_uy = largest_uy;
  const vreal per_uy = PICK(largest_uy > 0, 1 / largest_uy, ALL_LANES(0));
  k->penetration = fma(k->penetration, per_uy, finite);
  k->complementarity *= per_uy;
  k->drift *= per_uy;
  k->cone *= PICK(largest_n > 0, 1 / largest_n, ALL_LANES(0));
}

static inline void resultants(const vreal *n, const vreal *t, vreal *p, vreal *q) {
  *p = *q = 0;
  for (int i = 0; i < N; ++i) {
    *p += n[i];
    if (FRICTION) *q += t[i];
  }
}

/* Constant parts of the rows for the indenter where it is. */
static inline void set_indenter(Contact *c, const Indenter *in) {
  for (int i = 0; i < N; ++i) {
    c->b[i] = (in->d - c->h[i]) * c->wy[i];
#if FRICTION
    c->bt[i] = fma(in->x - in->x_last, c->wx[i], c->ux_last[i]);
#endif
  }
}

#if ENTRIES
/* While the indenter presses only, an open element whose gap would close within this increment, `part` of the last change from now, sticks
   from where it would be then. Without that it would stick from where the last increment left it. */
static inline void touch_within(Contact *c, const Indenter *in, vreal ratio) {
  const vint presses = in->active & (in->x == in->x_last) & (ratio > 0);
  if (!ANY(presses)) return;
  for (int i = 0; i < N; ++i) {
    const vreal gap = c->gap[i], closed = c->gap_before[i] - gap;
    const vint closes = presses & NOT(c->n[i] > 0) & (gap > 0) & (gap < ratio * closed);
    const vreal part = PICK(closes, gap / closed, ALL_LANES(0));
    c->ux_last[i] = PICK(closes, fma(part, c->ux[i] - c->ux_before[i], c->ux_last[i]), c->ux_last[i]);
  }
}
#endif

/* A first guess: the last change of the forces goes on in proportion to the load. */
static inline void extrapolate(Contact *c, const Indenter *in, vreal ratio) {
  for (int i = 0; i < N; ++i) {
    const vreal n = c->n[i], n_guess = LARGER(fma(ratio, n - c->n_last[i], n), ALL_LANES(0));
    c->n_last[i] = n;
    c->n[i] = PICK(in->active, n_guess, n);
#if FRICTION
    const vreal t = c->t[i], cone = in->mu * n_guess;
    const vreal t_guess = SMALLER(LARGER(fma(ratio, t - c->t_last[i], t), -cone), cone);
    c->t_last[i] = t;
    c->t[i] = PICK(in->active, t_guess, t);
#endif
  }
}

/* A lane on its way along its load path. */
typedef struct {
  vint valid, running;
  vint both;                /* P and Q are both given */
  vint failed;              /* this increment did not converge, or not at the forces asked for */
  vint failed_before;       /* one of those before it */
  vreal nearest;            /* depth at which an element's middle is touched, mm */
  vreal d_change, x_change; /* of the last increment's target, mm */
  vreal sweeps;             /* since the last report */
} LoadStepping;

#if FORCE_CONTROL
/* Search for the indenter's place z = (d, x) that gives the forces asked for: f = (P - P_target, Q - (Q_target / P_target) P) = 0, by
   Broyden's inverse update (Broyden 1965). */
typedef struct {
  vreal b[2][2];    /* inverse Jacobian */
  vreal z[2], g[2]; /* last trial that did not slide: place; P and Q - (Q_target / P_target) P */
  vreal low, high;  /* bracket of d */
  vreal p_target, q_target;
} Search;

/* Inverse update with the trial (z, g) in the given lanes; b stays where the step was too small to tell anything. */
static inline void broyden_update(Search *s, const vreal *z, const vreal *g, vint lanes) {
  const vreal dz0 = z[0] - s->z[0], dz1 = z[1] - s->z[1];
  const vreal dg0 = g[0] - s->g[0], dg1 = g[1] - s->g[1];
  const vreal e0 = dz0 - (s->b[0][0] * dg0 + s->b[0][1] * dg1);
  const vreal e1 = dz1 - (s->b[1][0] * dg0 + s->b[1][1] * dg1);
  const vreal r0 = dz0 * s->b[0][0] + dz1 * s->b[1][0];
  const vreal r1 = dz0 * s->b[0][1] + dz1 * s->b[1][1];
  const vreal below = r0 * dg0 + r1 * dg1;
  const vint use = lanes & (fabs(below) > (real)1e-2 * (dz0 * dz0 + dz1 * dz1));
  const vreal per = PICK(use, 1 / below, ALL_LANES(0));
  s->b[0][0] = fma(e0 * r0, per, s->b[0][0]);
  s->b[0][1] = fma(e0 * r1, per, s->b[0][1]);
  s->b[1][0] = fma(e1 * r0, per, s->b[1][0]);
  s->b[1][1] = fma(e1 * r1, per, s->b[1][1]);
  for (int a = 0; a < 2; ++a) {
    s->z[a] = PICK(lanes, z[a], s->z[a]);
    s->g[a] = PICK(lanes, g[a], s->g[a]);
  }
}

/* A trial inside the bracket: where Broyden's step leaves it, halfway to the bound, or twice as deep where there is no bound yet. */
static inline vreal bracketed(vreal trial, vreal now, vreal low, vreal high) {
  const vreal deeper = PICK(high < FAR, (real)0.5 * (now + high), 2 * now);
  return PICK(trial >= high, deeper, PICK(trial <= low, (real)0.5 * (now + low), trial));
}

/* Moves the indenter of the active lanes towards the forces asked for. Leaves in in->active those that were not there yet. Forces do not
   change with x where the contact slides as a whole: such a trial teaches nothing, and the next one lies halfway to the last that did not
   slide. */
static inline void update_force_control(Search *s, const Contact *c, Indenter *in, vint both, real tolerance) {
  vreal p, q;
  resultants(c->n, c->t, &p, &q);
  const vreal ratio = PICK(both & (s->p_target > 0), s->q_target / s->p_target, ALL_LANES(0));
  const vreal z[2] = {in->d, in->x};
  const vreal g[2] = {p, PICK(both, q - ratio * p, ALL_LANES(0))};
  const vreal miss[2] = {p - s->p_target, g[1]};
  const vreal enough = tolerance * s->p_target;
  const vint slides = both & (p > 0) & (fabs(q) >= (1 - SLIDING_MARGIN) * in->mu * p);
  broyden_update(s, z, g, in->active & NOT(slides));
  in->active &= (fabs(miss[0]) > enough) | (fabs(miss[1]) > enough);
  in->held &= NOT(in->active);
  const vreal step[2] = {s->b[0][0] * miss[0] + s->b[0][1] * miss[1], s->b[1][0] * miss[0] + s->b[1][1] * miss[1]};
  s->low = PICK(miss[0] < 0, LARGER(z[0], s->low), s->low);
  s->high = PICK(miss[0] > 0, SMALLER(z[0], s->high), s->high);
  /* P grows with d alone where x is given: keep inside the bracket. With both unknown the bracket moves: bound the step instead. */
  const vreal far_d = (real)0.5 * z[0], far_x = LARGER(fabs(z[1]), far_d);
  const vreal bounded = SMALLER(LARGER(z[0] - step[0], z[0] - far_d), z[0] + 2 * far_d);
  const vreal near_x = SMALLER(LARGER(z[1] - step[1], z[1] - far_x), z[1] + far_x);
  const vreal next[2] = {PICK(both, bounded, bracketed(z[0] - step[0], z[0], s->low, s->high)),
                         PICK(slides, (real)0.5 * (z[1] + s->z[1]), near_x)};
  in->d = PICK(in->active, next[0], in->d);
  in->x = PICK(in->active & both, next[1], in->x);
}

static inline void start_search(const LoadStepping *w, Search *s) {
  s->b[0][0] = (real)0.3; /* thickness / width, about: a start that the first trial corrects */
  s->b[1][1] = 1;
  s->z[0] = w->nearest;
  s->b[0][1] = s->b[1][0] = s->z[1] = s->g[0] = s->g[1] = 0;
}

/* Keeps the targets in the search, and puts the indenter where it is, or to a first guess, instead. */
static inline void first_trial(Search *s, const Indenter *in, const LoadStepping *w, vreal *d, vreal *x) {
  const vreal guess = PICK(in->d > w->nearest, in->d, fma(s->b[0][0], *d, w->nearest));
  s->p_target = *d;
  s->q_target = *x;
  s->low = 0;
  s->high = FAR;
  *d = PICK(*d > 0, guess, ALL_LANES(0));
  *x = PICK(w->both, in->x, *x);
}

static inline void reach_forces(const Rules *rules, Search *s, Contact *c, Indenter *in, LoadStepping *w) {
  in->active = w->running & (s->p_target > 0);
  for (int trial = 0; trial < MOST_FORCE_TRIALS; ++trial) {
    update_force_control(s, c, in, w->both, 10 * rules->tolerance); /* 10 times what the sweeps leave */
    if (!ANY(in->active)) return;
    const vint searching = in->active;
    set_indenter(c, in);
    iterate(rules, c, in, &w->sweeps);
    w->failed = (w->failed & NOT(searching)) | in->active;
    in->active = searching;
  }
  w->failed |= in->active;
}
#endif

/* Lanes in `none` bear no forces. */
static inline void release(Contact *c, vint none) {
  if (!ANY(none)) return;
  for (int i = 0; i < N; ++i) {
    c->n[i] = PICK(none, ALL_LANES(0), c->n[i]);
    if (FRICTION) c->t[i] = PICK(none, ALL_LANES(0), c->t[i]);
  }
}

/* Lanes whose input is finite and sensible, as far as their own path and shape go. */
static inline vint check_input(global const vreal *lane_input, global const vreal *path, int increments, global const real *shapes) {
  vreal sum = 0;
  for (int r = 0; r < PATCH_INPUT_ROWS; ++r) sum = finite_sum(sum, lane_input[AT(r)]);
  for (int k = 0; k < increments * PATCH_PATH_ROWS; ++k) {
    const vint own = lane_input[AT(PATCH_STEPS)] > (real)(k / PATCH_PATH_ROWS);
    sum = PICK(own, finite_sum(sum, path[AT(k)]), sum);
  }
  const vint counts = (sum == 0) & (lane_input[AT(PATCH_POINTS)] > 0);
  if (ANY(counts)) {
    real at[LANES], count[LANES], points[LANES];
    STORE(PICK(counts, lane_input[AT(PATCH_POINTS_AT)], ALL_LANES(0)), at);
    STORE(PICK(counts, lane_input[AT(PATCH_POINTS)], ALL_LANES(0)), count);
    for (int l = 0; l < LANES; ++l) {
      points[l] = 0;
      for (int k = 0; k < 3 * (int)count[l]; ++k) points[l] = fma((real)0, shapes[(int)at[l] + k], points[l]);
    }
    sum += LOAD(points);
  }
  return (sum == 0) & (lane_input[AT(PATCH_MU)] >= 0) & (lane_input[AT(PATCH_YOUNG)] > 0) &
         (lane_input[AT(PATCH_FROM)] < lane_input[AT(PATCH_TO)]);
}

/* Lane input with harmless numbers in lanes that are not valid. */
static inline void take_input(global const vreal *lane_input, vint valid, vreal *in) {
  for (int r = 0; r < PATCH_INPUT_ROWS; ++r) {
    const real harmless = r == PATCH_LEFT || r == PATCH_FROM ? -1 : r == PATCH_RIGHT || r == PATCH_TO ? 1 : 0;
    in[r] = PICK(valid, lane_input[AT(r)], ALL_LANES(harmless));
  }
}

static inline int store_counts(vreal count, vreal at, int *counts, int *places) {
  real number[LANES], place[LANES];
  STORE(count, number);
  STORE(at, place);
  int any = 0;
  EACH(l, LANES) {
    counts[l] = (int)number[l];
    places[l] = (int)place[l];
    any |= counts[l] > 0;
  }
  return any;
}

static inline void take_profile(const vreal *in, global const real *shapes, Profile *p) {
  p->shapes = shapes;
  p->left = in[PATCH_LEFT];
  p->right = in[PATCH_RIGHT];
  p->flat = in[PATCH_FLAT];
  EACH(k, 5) { p->c[k] = in[PATCH_C1 + k]; }
  p->radius = in[PATCH_RADIUS];
  p->exp_height = in[PATCH_EXP_HEIGHT];
  p->exp_rate = in[PATCH_EXP_RATE];
  p->cylinders = ANY(p->radius > 0);
  p->exponentials = ANY(p->exp_height > 0);
  p->terms = store_counts(in[PATCH_TERMS], in[PATCH_TERMS_AT], p->term_count, p->terms_at);
  p->points = store_counts(in[PATCH_POINTS], in[PATCH_POINTS_AT], p->point_count, p->points_at);
}

/* Target of increment k: (d, x), mm, or forces; lanes beyond their path stop and stay where they are. ratio: this change of the target
   over the last one, 0 where both d and x change, or the way turns, or the load is a force. */
static inline void next_target(const vreal *lane, global const vreal *path, int k, const Indenter *in, LoadStepping *w, vreal *d, vreal *x,
                               vreal *ratio) {
  global const vreal *target = path + AT(k * PATCH_PATH_ROWS);
  w->running &= lane[PATCH_STEPS] > (real)k;
  *d = PICK(w->running, target[AT(PATCH_NORMAL)], in->d);
  *x = PICK(w->running, target[AT(PATCH_TANGENTIAL)], in->x);
  const vreal d_now = *d - in->d, x_now = *x - in->x;
  const vint same_d = (d_now == 0) & (w->d_change == 0), same_x = (x_now == 0) & (w->x_change == 0);
  const vreal along_d = PICK(same_x & (w->d_change != 0), d_now / w->d_change, ALL_LANES(0));
  const vreal along = PICK(same_d & (w->x_change != 0), x_now / w->x_change, along_d);
  *ratio = FORCE_CONTROL ? ALL_LANES(0) : PICK((along > 0) & (along <= 2), along, ALL_LANES(0));
  w->d_change = d_now;
  w->x_change = x_now;
}

/* Lanes whose target is where they are rest as they are: that is a solution, and so a held contact does not creep by rounding. */
static inline void move_to(Indenter *in, const LoadStepping *w, vreal d, vreal x) {
  in->held = d == in->d;
  if (FRICTION) in->held &= x == in->x;
  in->active = w->running & NOT(in->held);
  in->x_last = in->x;
  in->d = d;
  in->x = x;
}

static inline void start(const vreal *lane, Contact *c, Indenter *in, LoadStepping *w) {
  for (int i = 0; i < N; ++i) c->n[i] = c->t[i] = c->n_last[i] = c->t_last[i] = c->ux_last[i] = 0;
#if ENTRIES
  for (int i = 0; i < N; ++i) {
    c->ux[i] = c->ux_before[i] = 0;
    c->gap[i] = c->gap_before[i] = c->h[i];
  }
#endif
  in->mu = lane[PATCH_MU];
  in->d = in->x = in->x_last = 0;
  w->both = lane[PATCH_CONTROL] >= FORCE_BOTH;
  w->d_change = w->x_change = w->sweeps = 0;
  w->running = w->valid;
  w->failed = w->failed_before = 0;
}

/* Where a lane's answer of `numbers` numbers begins in [lanes / INTERLEAVED][slots][numbers][INTERLEAVED], the lane counted over all groups. */
static inline size_t answer_at(size_t lane, int slots, long slot, int numbers) {
  return AT((lane / INTERLEAVED * (size_t)slots + (size_t)slot) * (size_t)numbers) + lane % INTERLEAVED;
}

/* Block b of PATCH_BLOCK vectors as a row of numbers for each lane, at[l] numbers into `out`; lanes with at[l] < 0 are left out. */
INLINE void store_rows(const vreal *rows, const long *at, global real *out) {
  EACH(b, PATCH_BLOCK / LANES) {
    vreal r[LANES];
    EACH(l, LANES) { r[l] = rows[b * LANES + l]; }
    transpose(r);
    for (int l = 0; l < LANES; ++l)
      if (at[l] >= 0) STORE_AWAY(r[l], out + at[l] + AT(b * LANES));
  }
}

#define FORCE_ROWS ((2 * N + PATCH_BLOCK - 1) / PATCH_BLOCK * PATCH_BLOCK) /* n of all elements, then t */

/* An increment that is reported in some lanes, as it was solved. */
typedef struct {
  vreal n[N], t[N];
  vreal d, x, sweeps;
  vreal slot;  /* place among the reported ones; -1 in lanes that do not report it */
  vint failed; /* this increment or one before it */
  vint slides;
  Certificate certificate;
} Solved;

/* Reports wait here, so that writing them does not drive the compliance out of the first-level cache at every increment. */
#define MOST_WAITING 10
typedef struct {
  Solved solved[MOST_WAITING];
  int count;
  vint lost;   /* an increment was not solved: those that follow have no history to rest on */
  vreal slots; /* increments reported */
  vreal out_left, out_right;
} Reports;

/* Adds penetration of places beyond the ends to the certificate. out: how many elements beyond the left and the right end are penetrated by
   more than `accept`. */
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

#if SENSORS
/* Tables of the base stress of sensors, and what of them belongs to one lane. */
typedef struct {
  global const real *layer; /* [stress_cells][poissons][STRESS_NUMBERS] over distance / h */
  int cells, tactels, outputs;
  real cells_per_h;
  global const real *sides; /* [side_rows][PATCH_BLOCK] sigma_y, then tau, of every mode */
} StressTables;
#endif

/* Where answers go, and what base stresses take. */
typedef struct {
  size_t group;
  int slots, write_forces;
  real accept;
#if SENSORS
  const Layer *layer;
  const StressTables *tables;
  const real *sensor, *side; /* numbers of the lanes' sensors; their side forces */
#else
  global const real *base; /* [base_rows][2][outputs] */
  int base_rows, outputs;
  real base_rows_per_mm, base_from;
#endif
  global real *result, *forces, *stress;
} Answers;

/* Results and forces of one increment go to its place among the reported ones. */
static inline void write_report(const vreal *lane, const Contact *c, const Solved *s, const Answers *answers, Reports *to) {
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
  const vint within = (said.penetration <= accept) & (said.cone <= accept) & (said.complementarity <= accept) & (said.drift <= accept);
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
  rows[LANE_INDENTATION] = s->d;
  rows[LANE_TANGENTIAL] = s->x;
  rows[LANE_P] = p * young;
  rows[LANE_Q] = q * young;
  rows[LANE_SLIP_INDEX] = PICK(cone > 0, q / cone, ALL_LANES(0));
  rows[LANE_STICKING] = sticking;
  rows[LANE_SLIPPING] = slipping;
  rows[LANE_SWEEPS] = s->sweeps;
  rows[LANE_STATUS] = PICK(solved, good, ALL_LANES(LANE_UNSOLVED));
  rows[LANE_PENETRATION] = said.penetration;
  rows[LANE_CONE] = said.cone;
  rows[LANE_COMPLEMENTARITY] = said.complementarity;
  rows[LANE_DRIFT] = said.drift;
  rows[LANE_SLIP_DISTANCE] = said.slip_distance;
  EACH(l, LANES) { row_at[l] = place[l] < 0 ? -1 : (long)answer_at(first_lane + l, answers->slots, (long)place[l], PATCH_BLOCK); }
  store_rows(rows, row_at, answers->result);
  if (!answers->write_forces) return;
  EACH(i, FORCE_ROWS) { rows[i] = i < N ? s->n[i % N] : i < 2 * N ? s->t[i % N] : ALL_LANES(0); }
  EACH(l, LANES) { row_at[l] = place[l] < 0 ? -1 : (long)answer_at(first_lane + l, answers->slots, (long)place[l], FORCE_ROWS); }
  EACH(b, FORCE_ROWS / PATCH_BLOCK) { store_rows(rows + b * PATCH_BLOCK, row_at, answers->forces + AT(b * PATCH_BLOCK)); }
}

#if SENSORS
/* K times the force modes of every element, for each lane by itself: [lane][element][end][by n, by t][SIDE_MODES]. */
#define SIDE_FORCES (N * ENDS * 2 * SIDE_MODES)
OUTLINE void weigh_side_forces(const Layer *layer, const Patch *patch, vreal position, real *to) {
  const vreal end = (real)0.5 * layer->length;
  for (int j = 0; j < N; ++j)
    for (int e = 0; e < ENDS; ++e) {
      const vreal x = position + middle_of(patch, j);
      vreal by[2][SIDE_MODES], rows[PATCH_BLOCK];
      end_row(layer, layer->side_forces, e == 0 ? end + x : end - x, e == 0 ? 1 : -1, by[0], by[1]);
      for (int part = 0; part < 2; ++part) EACH(r, SIDE_MODES) {
          vreal sum = 0;
          EACH(q, SIDE_MODES) { sum = fma(layer->core[CORE_COMPLIANCE + r * SIDE_MODES + q], by[part][q], sum); }
          rows[part * SIDE_MODES + r] = (part == 0 ? -layer->per_thickness : layer->per_thickness) * sum;
        }
      EACH(b, PATCH_BLOCK / LANES) {
        vreal r[LANES];
        EACH(l, LANES) { r[l] = rows[b * LANES + l]; }
        transpose(r);
        EACH(l, LANES) { STORE(r[l], to + l * SIDE_FORCES + (j * ENDS + e) * PATCH_BLOCK + b * LANES); }
      }
    }
}

/* Stress at LANES tactels of one lane's sensor, by n = 1 and t = 1 on its elements. */
typedef struct {
  vreal sigma_n[N], sigma_t[N], tau_n[N], tau_t[N];
} TactelRows;

/* x: tactels less the first element's middle, element: its width, both over h. */
INLINE void layer_stress(const StressTables *tables, int poissons, int poisson, real part, real per_h, vreal x, real element, TactelRows *to) {
  for (int j = 0; j < N; ++j) {
    const vreal distance = x - element * (real)j;
    const Place place = place_in(fabs(distance) * tables->cells_per_h, tables->cells);
    vreal c[PATCH_BLOCK], value[4];
    EACH(b, PATCH_BLOCK / LANES) {
      vreal r[LANES];
      EACH(l, LANES) { r[l] = LOAD(tables->layer + ((size_t)place.cell[l] * poissons + poisson) * STRESS_NUMBERS + b * LANES); }
      transpose(r);
      EACH(l, LANES) { c[b * LANES + l] = r[l]; }
    }
    EACH(a, 4) {
      const vreal low = fma(place.q, c[2 * a + 1] - c[2 * a], c[2 * a]);
      const vreal high = fma(place.q, c[STRESS_NUMBERS + 2 * a + 1] - c[STRESS_NUMBERS + 2 * a], c[STRESS_NUMBERS + 2 * a]);
      value[a] = per_h * fma(ALL_LANES(part), high - low, low);
    }
    to->sigma_n[j] = -value[0];
    to->tau_t[j] = value[1];
    to->tau_n[j] = PICK(distance < 0, value[2], -value[2]);
    to->sigma_t[j] = PICK(distance < 0, -value[3], value[3]);
  }
}

/* Adds what one end changes. distance: of the tactels from it, over h; forces: of this lane and end. */
INLINE void side_stress(const Layer *layer, const StressTables *tables, vreal distance, real sign, const real *forces, TactelRows *to) {
  const Place place = place_in(distance * layer->side_rows_per_h, layer->side_rows - 1);
  vreal v[PATCH_BLOCK], next[PATCH_BLOCK];
  gather_rows(tables->sides, place.cell, v);
  gather_rows(tables->sides + PATCH_BLOCK, place.cell, next);
  EACH(m, PATCH_BLOCK) { v[m] = (m < SIDE_MODES ? 1 : sign) * fma(place.q, next[m] - v[m], v[m]); }
  for (int j = 0; j < N; ++j) {
    const real *f = forces + j * ENDS * PATCH_BLOCK;
    EACH(m, SIDE_MODES) {
      to->sigma_n[j] = fma(v[m], ALL_LANES(f[m]), to->sigma_n[j]);
      to->tau_n[j] = fma(v[SIDE_MODES + m], ALL_LANES(f[m]), to->tau_n[j]);
      if (FRICTION) {
        to->sigma_t[j] = fma(v[m], ALL_LANES(f[SIDE_MODES + m]), to->sigma_t[j]);
        to->tau_t[j] = fma(v[SIDE_MODES + m], ALL_LANES(f[SIDE_MODES + m]), to->tau_t[j]);
      }
    }
  }
}

/* Stores the first `count` lanes. */
INLINE void store_first(vreal v, int count, global real *to) {
  if (count >= LANES) {
    STORE(v, to);
    return;
  }
  real numbers[LANES];
  STORE(v, numbers);
  for (int l = 0; l < count; ++l) to[l] = numbers[l];
}

/* Base stresses of lane l at all its tactels, in the increments that wait. */
static inline void write_stress(const Answers *to, const Reports *reports, int l, real origin, real element, real young, size_t lane) {
  const Layer *layer = to->layer;
  const StressTables *tables = to->tables;
  const real *sensor = to->sensor, *side = to->side + l * SIDE_FORCES;
  const real middle = fma(element, (real)0.5, origin);
  const real per_h = 1 / sensor[SENSOR_THICKNESS * LANES + l], end = (real)0.5 * sensor[SENSOR_LENGTH * LANES + l];
  const real part = sensor[SENSOR_POISSON * LANES + l] - (real)layer->poisson[l];
  real number[LANES];
  EACH(k, LANES) { number[k] = (real)k; }
  for (int first = 0; first < tables->tactels; first += LANES) {
    const vreal k = LOAD(number) + (real)first;
    const vreal x = fma(k, ALL_LANES(sensor[SENSOR_SPACING * LANES + l]), ALL_LANES(sensor[SENSOR_TACTEL * LANES + l]));
    TactelRows rows;
    layer_stress(tables, layer->poissons, layer->poisson[l], part, per_h, (x - middle) * per_h, element * per_h, &rows);
    if (layer->side_rows > 0) {
      side_stress(layer, tables, (end + x) * per_h, 1, side, &rows);
      side_stress(layer, tables, (end - x) * per_h, -1, side + PATCH_BLOCK, &rows);
    }
    for (int r = 0; r < reports->count; ++r) {
      const Solved *s = &reports->solved[r];
      const real slot = NUMBER(s->slot, l);
      if (slot < 0) continue;
      vreal sigma = 0, tau = 0, sigma_t = 0, tau_t = 0;
      EACH(j, N) {
        sigma = fma(ALL_LANES(NUMBER(s->n[j], l)), rows.sigma_n[j], sigma);
        tau = fma(ALL_LANES(NUMBER(s->n[j], l)), rows.tau_n[j], tau);
        if (FRICTION) {
          sigma_t = fma(ALL_LANES(NUMBER(s->t[j], l)), rows.sigma_t[j], sigma_t);
          tau_t = fma(ALL_LANES(NUMBER(s->t[j], l)), rows.tau_t[j], tau_t);
        }
      }
      global real *stress = to->stress + answer_at(lane, to->slots, (long)slot, tables->outputs) + AT(first);
      store_first((sigma + sigma_t) * young, tables->tactels - first, stress);
      store_first((tau + tau_t) * young, tables->tactels - first, stress + AT(tables->tactels));
    }
  }
}

static inline vint check_sensors(global const vreal *sensors) {
  vreal finite = 0;
  EACH(r, PATCH_SENSOR_ROWS) { finite = finite_sum(finite, sensors[AT(r)]); }
  return (finite == 0) & (sensors[AT(SENSOR_THICKNESS)] > 0);
}

/* The sensor of every lane; in lanes that are not valid some sensor. */
static inline void take_sensors(global const vreal *sensors, vint valid, global const real *cores, real cells_per_h, Layer *layer,
                                real *numbers) {
  EACH(r, PATCH_SENSOR_ROWS) {
    const real harmless = r == SENSOR_POISSON || r == SENSOR_TACTEL ? 0 : 1;
    STORE(PICK(valid, sensors[AT(r)], ALL_LANES(harmless)), numbers + r * LANES);
  }
  layer->thickness = LOAD(numbers + SENSOR_THICKNESS * LANES);
  layer->length = LOAD(numbers + SENSOR_LENGTH * LANES);
  layer->cy = LOAD(numbers + SENSOR_CY * LANES);
  layer->cx = LOAD(numbers + SENSOR_CX * LANES);
  layer->jump = LOAD(numbers + SENSOR_JUMP * LANES);
  layer->per_thickness = 1 / layer->thickness;
  layer->cells_per_mm = cells_per_h * layer->per_thickness;
  const Place place = place_in(LOAD(numbers + SENSOR_POISSON * LANES), layer->poissons - 1);
  EACH(l, LANES) { layer->poisson[l] = place.cell[l]; }
  layer->part = place.q;
  if (layer->side_rows > 0)
    for (int b = 0; b < CORE_NUMBERS / PATCH_BLOCK; ++b) gather_between(layer, cores, CORE_NUMBERS, b, layer->core + b * PATCH_BLOCK);
}
#else
/* Base stresses of one lane in the increments that wait: its rows of the table at the elements' middles, times the forces. */
static inline void write_stress(const Answers *to, const Reports *reports, int l, real origin, real element, real young, size_t lane) {
  (void)l;
  int row[N];
  real part[N];
  for (int j = 0; j < N; ++j) {
    const real at = (fma(element, (real)j + (real)0.5, origin) - to->base_from) * to->base_rows_per_mm;
    const real inside = at > 0 ? (at < (real)(to->base_rows - 1) ? at : (real)(to->base_rows - 1)) : 0;
    row[j] = min((int)inside, to->base_rows - 2);
    part[j] = inside - (real)row[j];
  }
  for (int first = 0; first < to->outputs; first += LANES) {
    vreal by_n[N], by_t[N];
    EACH(j, N) {
      global const real *here = to->base + ((size_t)row[j] * 2) * to->outputs + first, *next = here + 2 * to->outputs;
      const vreal n0 = LOAD(here), t0 = LOAD(here + to->outputs);
      by_n[j] = fma(ALL_LANES(part[j]), LOAD(next) - n0, n0);
      by_t[j] = fma(ALL_LANES(part[j]), LOAD(next + to->outputs) - t0, t0);
    }
    for (int r = 0; r < reports->count; ++r) {
      const Solved *s = &reports->solved[r];
      const real slot = NUMBER(s->slot, l);
      if (slot < 0) continue;
      vreal n_even = 0, n_odd = 0, t_even = 0, t_odd = 0;
      EACH(j, N / 2) {
        n_even = fma(ALL_LANES(NUMBER(s->n[2 * j], l)), by_n[2 * j], n_even);
        n_odd = fma(ALL_LANES(NUMBER(s->n[2 * j + 1], l)), by_n[2 * j + 1], n_odd);
        if (FRICTION) {
          t_even = fma(ALL_LANES(NUMBER(s->t[2 * j], l)), by_t[2 * j], t_even);
          t_odd = fma(ALL_LANES(NUMBER(s->t[2 * j + 1], l)), by_t[2 * j + 1], t_odd);
        }
      }
      STORE_AWAY(((n_even + n_odd) + (t_even + t_odd)) * young, to->stress + answer_at(lane, to->slots, (long)slot, to->outputs) + AT(first));
    }
  }
}

#endif

/* Writes the reports that wait. */
OUTLINE void write_reports(const vreal *lane, const Contact *c, const Patch *patch, const Answers *to, Reports *reports) {
  if (reports->count == 0) return;
  for (int r = 0; r < reports->count; ++r) write_report(lane, c, &reports->solved[r], to, reports);
  for (int l = 0; l < LANES; ++l)
    write_stress(to, reports, l, NUMBER(lane[PATCH_POSITION], l) + NUMBER(patch->origin, l), NUMBER(patch->element, l),
                 NUMBER(lane[PATCH_YOUNG], l), to->group * LANES + l);
  reports->count = 0;
}

/* Takes this increment among the reports in lanes where it has a place. Lanes that slide as a whole may end their path with it. */
static inline void report(const vreal *lane, vreal slot, int k, const Contact *c, const Indenter *in, const Certificate *said, LoadStepping *w,
                          Reports *to) {
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
static inline void finish(const Answers *answers, const Patch *patch, vint valid, const Reports *to, global real *patches) {
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
      for (int r = 0; r < PATCH_BLOCK; ++r) result[AT(r)] = r == LANE_STATUS ? idle[l] : 0;
    }
}

/* smooth [cells][PATCH_BLOCK]; sides [side_rows][PATCH_BLOCK], signs [SIDE_MODES]; base [base_rows][2][outputs]: stresses by n, by t of a unit
   force, outputs a multiple of PATCH_BLOCK; shapes: Taylor terms (coefficient mm, power, 1 / scale) and points that lanes refer to; lane_input [group][PATCH_INPUT_ROWS][lane]; path
   [group][increments][PATCH_PATH_ROWS][lane].
   Out: result [group][lane][slots][PATCH_BLOCK]; forces [group][lane][slots][FORCE_ROWS] over E, mm, where write_forces is not 0;
   stress [group][lane][slots][outputs] MPa; patches [group][lane][PATCH_BLOCK]. With one lane an item each array lies in blocks of INTERLEAVED items (shared/group.h, answer_at). */
#if SENSORS
/* The same with the tables of a family in place of a sensor's: sides, side_forces and side_stresses [side_rows][PATCH_BLOCK], cores
   [poissons][CORE_NUMBERS], layer_stresses [stress_cells][poissons][STRESS_NUMBERS], sensors [group][PATCH_SENSOR_ROWS][lane]. */
kernel void patch_contact_sensors(uint first_group, global const real *smooth, int cells, int poissons, real cells_per_h,
                                  global const real *sides, global const real *side_forces, global const real *side_stresses, int side_rows,
                                  real side_rows_per_h, global const real *cores, global const real *layer_stresses, int stress_cells,
                                  real stress_cells_per_h, int tactels, int outputs, global const vreal *sensors, global const real *shapes,
                                  global const vreal *lane_input, global const vreal *path, int increments, int slots, int write_forces,
                                  real tolerance, real accept, int most_sweeps, global real *result, global real *forces, global real *stress,
                                  global real *patches) {
  TAKE_GROUP(group);
  Layer layer = {.smooth = smooth, .cells = cells, .poissons = poissons, .sides = sides, .side_forces = side_forces};
  layer.side_rows = side_rows;
  layer.side_rows_per_h = side_rows_per_h;
  const StressTables tables = {layer_stresses, stress_cells, tactels, outputs, stress_cells_per_h, side_stresses};
  sensors += FIRST_NUMBER(group, PATCH_SENSOR_ROWS);
#else
kernel void patch_contact(uint first_group, global const real *smooth, int cells, real cells_per_mm, real thickness, real length, real cy,
                          real cx, real jump, global const real *sides, int side_rows, real side_rows_per_mm, real sides_from,
                          global const real *signs, global const real *base, int base_rows, real base_rows_per_mm, real base_from, int outputs,
                          global const real *shapes, global const vreal *lane_input, global const vreal *path, int increments, int slots,
                          int write_forces, real tolerance, real accept, int most_sweeps, global real *result, global real *forces,
                          global real *stress, global real *patches) {
  TAKE_GROUP(group);
  const Layer layer = {smooth, cells, cells_per_mm, thickness, length, cy, cx, jump, sides, side_rows, side_rows_per_mm, sides_from, signs};
  const Answers answers = {group, slots, write_forces, accept, base, base_rows, outputs, base_rows_per_mm, base_from, result, forces, stress};
#endif
  const Rules rules = {FORCE_CONTROL ? (real)0.1 * tolerance : tolerance, most_sweeps};
  lane_input += FIRST_NUMBER(group, PATCH_INPUT_ROWS);
  path += FIRST_NUMBER(group, increments * PATCH_PATH_ROWS);

  Contact c;
  Indenter in;
  LoadStepping w;
  Profile profile;
  Patch patch;
  Certificate said;
  Reports reports;
  vreal lane[PATCH_INPUT_ROWS];
  w.valid = check_input(lane_input, path, increments, shapes);
#if SENSORS
  real sensor[PATCH_SENSOR_ROWS * LANES];
  w.valid &= check_sensors(sensors);
  take_sensors(sensors, w.valid, cores, cells_per_h, &layer, sensor);
#endif
  take_input(lane_input, w.valid, lane);
  take_profile(lane, shapes, &profile);
  reports.count = 0;
  reports.lost = 0;
  reports.slots = reports.out_left = reports.out_right = 0;
  find_patch(&layer, &profile, lane, w.valid, &patch);
  build_compliance(&layer, &patch, lane[PATCH_POSITION], &c);
#if SENSORS
  real side[LANES * SIDE_FORCES];
  if (layer.side_rows > 0) weigh_side_forces(&layer, &patch, lane[PATCH_POSITION], side);
  const Answers answers = {group, slots, write_forces, accept, &layer, &tables, sensor, side, result, forces, stress};
#endif
  w.nearest = put_heights(&profile, &patch, &c);
  start(lane, &c, &in, &w);
#if FORCE_CONTROL
  Search search;
  start_search(&w, &search);
#endif
  for (int k = 0; k < increments; ++k) {
    vreal d, x, ratio;
    next_target(lane, path, k, &in, &w, &d, &x, &ratio);
    if (!ANY(w.running)) break;
#if FORCE_CONTROL
    first_trial(&search, &in, &w, &d, &x);
#endif
    move_to(&in, &w, d, x);
#if ENTRIES
    touch_within(&c, &in, ratio);
#endif
    extrapolate(&c, &in, ratio);
#if FORCE_CONTROL
    const vint none = w.running & (search.p_target <= 0);
#else
    const vint none = w.running & (in.d <= w.nearest);
#endif
    release(&c, none);
    set_indenter(&c, &in);
    iterate(&rules, &c, &in, &w.sweeps);
    w.failed = in.active;
#if FORCE_CONTROL
    reach_forces(&rules, &search, &c, &in, &w);
    set_indenter(&c, &in);
#endif
    certify(&c, &in, &said);
    report(lane, path[AT(k * PATCH_PATH_ROWS + PATCH_SLOT)], k, &c, &in, &said, &w, &reports);
    if (reports.count == MOST_WAITING) write_reports(lane, &c, &patch, &answers, &reports);
  }
  write_reports(lane, &c, &patch, &answers, &reports);
  finish(&answers, &patch, w.valid, &reports, patches);
}
