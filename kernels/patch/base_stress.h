// SPDX-License-Identifier: Apache-2.0
/* Stress at the base of the layer: at the tactels, or at other places of a table. Device only. */
#ifndef TACTEL_PATCH_BASE_STRESS_H
#define TACTEL_PATCH_BASE_STRESS_H
#include "patch/reports.h"

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
INLINE void layer_stress(const StressTables *tables, int poissons, int poisson, real part, real per_h, vreal x,
                         real element, TactelRows *to) {
  for (int j = 0; j < N; ++j) {
    const vreal distance = x - element * (real)j;
    const Place place = place_in(fabs(distance) * tables->cells_per_h, tables->cells);
    vreal c[PATCH_BLOCK], value[4];
    EACH(b, PATCH_BLOCK / LANES) {
      vreal r[LANES];
      EACH(l, LANES) {
        r[l] = LOAD(tables->layer + ((size_t)place.cell[l] * poissons + poisson) * STRESS_NUMBERS + b * LANES);
      }
      transpose(r);
      EACH(l, LANES) { c[b * LANES + l] = r[l]; }
    }
    EACH(a, 4) {
      const vreal low = fma(place.q, c[2 * a + 1] - c[2 * a], c[2 * a]);
      const vreal high =
          fma(place.q, c[STRESS_NUMBERS + 2 * a + 1] - c[STRESS_NUMBERS + 2 * a], c[STRESS_NUMBERS + 2 * a]);
      value[a] = per_h * fma(ALL_LANES(part), high - low, low);
    }
    to->sigma_n[j] = -value[0];
    to->tau_t[j] = value[1];
    to->tau_n[j] = PICK(distance < 0, value[2], -value[2]);
    to->sigma_t[j] = PICK(distance < 0, -value[3], value[3]);
  }
}

/* Adds what one end changes. distance: of the tactels from it, over h; forces: of this lane and end. */
INLINE void side_stress(const Layer *layer, const StressTables *tables, vreal distance, real sign, const real *forces,
                        TactelRows *to) {
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
static inline void write_stress(const Answers *to, const Reports *reports, int l, real origin, real element, real young,
                                size_t lane) {
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

#else
/* Base stresses of one lane in the increments that wait: its rows of the table at the elements' middles, times the
   forces. */
static inline void write_stress(const Answers *to, const Reports *reports, int l, real origin, real element, real young,
                                size_t lane) {
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
      STORE_AWAY(((n_even + n_odd) + (t_even + t_odd)) * young,
                 to->stress + answer_at(lane, to->slots, (long)slot, to->outputs) + AT(first));
    }
  }
}

#endif

#endif
