// SPDX-License-Identifier: Apache-2.0
/* Increments that are reported, and where their answers go. Device only. */
#ifndef TACTEL_PATCH_REPORTS_H
#define TACTEL_PATCH_REPORTS_H
#include "patch/load_path.h"

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

/* Reports wait here, so that writing them does not drive the compliance out of the first-level cache at every
   increment. */
#define MOST_WAITING 10
typedef struct {
  Solved solved[MOST_WAITING];
  int count;
  vint lost;   /* an increment was not solved: those that follow have no history to rest on */
  vreal slots; /* increments reported */
  vreal out_left, out_right;
} Reports;

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

#endif
