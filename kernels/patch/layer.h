// SPDX-License-Identifier: Apache-2.0
/* The rubber layer: its tables at a place, of one sensor for all lanes or of each lane's own. Device only. */
#ifndef TACTEL_PATCH_LAYER_H
#define TACTEL_PATCH_LAYER_H
#include "patch/numbers.h"

/* c_k of the compliance: (k + 1/2) ln|k + 1/2| - (k - 1/2) ln|k - 1/2| - 1. */
constant real log_part[28] = {
    (real)-1.6931471805599453, (real)-0.045228747557780772, (real)0.68252916752314109, (real)1.0939435600484003,
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
#define MODES \
  (ENDS * SIDE_MODES) /* of the sides at a place: v_y of all, then v_x of all; those of the left end first */

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

/* A row of a table over the distance from an end, mm: linear between rows. The first half of its columns to `y`, the
   second, times `sign`, to `x`. */
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

#define CORE_PAIR(r, q) \
  ((r) < (q) ? (r) * (2 * SIDE_MODES - 1 - (r)) / 2 + (q) : (q) * (2 * SIDE_MODES - 1 - (q)) / 2 + (r))

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

#if SENSORS
static inline vint check_sensors(global const vreal *sensors) {
  vreal finite = 0;
  EACH(r, PATCH_SENSOR_ROWS) { finite = finite_sum(finite, sensors[AT(r)]); }
  return (finite == 0) & (sensors[AT(SENSOR_THICKNESS)] > 0);
}

/* The sensor of every lane; in lanes that are not valid some sensor. */
static inline void take_sensors(global const vreal *sensors, vint valid, global const real *cores, real cells_per_h,
                                Layer *layer, real *numbers) {
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
    for (int b = 0; b < CORE_NUMBERS / PATCH_BLOCK; ++b)
      gather_between(layer, cores, CORE_NUMBERS, b, layer->core + b * PATCH_BLOCK);
}
#endif

#endif
