// SPDX-License-Identifier: Apache-2.0
/* Batched contact of rigid indenters with a bonded layer, each on its own patch of equal elements: patch search,
   compliance, load path, certificate and base stress in one launch.

   One work-item carries LANES scenes of one sensor. An element bears a pressure force n >= 0 and a traction force t on
   the rubber, constant over its width; displacements are those of its middle. The kernel works at E = 1, where forces
   are in mm, and scales what it writes. Places along x count from the indenter's position: a contact of 2 um keeps its
   digits in fp32 wherever it is.

   Compliance. C = layer of infinite length in closed form + free sides. With k = i - j, element width w and thickness h
     C_yy[k] = c_y (-ln(w/h) - c_k + (R_yy((k + 1/2) w) - R_yy((k - 1/2) w)) / w),   C_xx alike,
     C_xy[k] = c_x ((1 - 2 nu) (pi/2) sgn k + (R_xy((k + 1/2) w) - R_xy((k - 1/2) w)) / w),   C_yx[k] = -C_xy[k],
   R: integrals of the smooth parts of the layer's kernels, tabulated over x / h. The sides add sum_m sign_m v_m(x_i)
   v_m(x_j)^T.

   Law at element i, with gap g = h - d - u_y and slip s = (u_x - u_x at the last increment) - (X - X there):
     n >= 0,  g >= 0,  n g = 0;   |t| <= mu n,  s = 0 inside the cone,  s t <= 0 on its edge.
   Sweeps are projected Gauss-Seidel with relaxation RELAXATION, scaled once so that a row is
     n_i = max(0, b_i + sum A_ij n_j + sum B_ij t_j),   t_i = clip(bt_i + sum D_ij n_j + sum E_ij t_j, -mu n_i, mu n_i).

   The twin (fem/layer) follows the same rules:
   - Search. The first window is the rigid intersection at the largest depth. SEARCH_ROUNDS rounds of frictionless
     contact on SEARCH_ELEMENTS elements, without sides, by plain sweeps from zero forces to SEARCH_TOLERANCE. The next
     window is the pressed extent + 1.5 elements a side, or + 25 % of the extent on a side where the outermost element
     presses, inside the limits (the indenter's edges, the sensor's ends). The patch is the last extent + MARGIN of it a
     side.
   - Edges. A side of the patch that reaches the indenter's own edge ends EDGE_PART of an element beyond it, on the
     sensor. A side that reaches the sensor's end ends there.
   - Driven by force, the search is repeated at depths that follow secants in the logarithms of depth and force. Sweeps
     then go to a tenth of the tolerance, and forces are met to the tolerance.
   - Sweeps go from left to right. The pressure of element i takes the traction of element i - 1 from the sweep before,
     so that it need not wait for it; everything else is the newest. A sweep is the last when no force changed by more
     than the tolerance (sweep_tolerance) times the largest pressure force. After DAMPED_AFTER sweeps a force moves half of its step,
     after 4 times as many a fifth.
   - The certificate looks for penetration at OUTSIDE places beyond each end, too. Where the patch is too small the host
     gives a larger one.
   - The first guess of an increment continues the last change of the forces in proportion to the load.
   - A sticking element's history is its exact position.
   - While the indenter presses only, an open element whose gap would close within the increment sticks from where it
     would be then.

   A lane's result depends on nothing but the lane: finished lanes keep their bits, and every sum runs in an order fixed
   by the element's index.

   Built with -D REAL (float | double), LANES (1, 2, 4, 8, 16), ELEMENTS, FORCE_CONTROL (0 | 1), FRICTION (0 | 1),
   SENSORS (0 | 1). With FORCE_CONTROL all lanes are driven by force. Without FRICTION all lanes have mu = 0: there is
   no traction and no history. With SENSORS every lane has its own sensor: its tables are read between two rows of
   Poisson's ratios, over x / h, and its sides are those of two ends (fem/layer/sensor_family.h, the twin of this
   way). */
// defines: ELEMENTS=12 FORCE_CONTROL=1 FRICTION=1 SENSORS=1
#include "shared/group.h"
#include "patch/answers.h"
#include "patch/force_control.h"

/* Lanes whose input is finite and sensible, as far as their own path and shape go. */
static inline vint check_input(global const vreal *lane_input, global const vreal *path, int increments,
                               global const real *shapes) {
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

/* smooth [cells][PATCH_BLOCK]; sides [side_rows][PATCH_BLOCK], signs [SIDE_MODES]; base [base_rows][2][outputs]:
   stresses by n, by t of a unit force, outputs a multiple of PATCH_BLOCK; shapes: Taylor terms (coefficient mm, power,
   1 / scale) and points that lanes refer to; lane_input [group][PATCH_INPUT_ROWS][lane]; path
   [group][increments][PATCH_PATH_ROWS][lane].
   Out: result [group][lane][slots][PATCH_BLOCK]; forces [group][lane][slots][FORCE_ROWS] over E, mm, where write_forces
   is not 0; stress [group][lane][slots][outputs] MPa; patches [group][lane][PATCH_BLOCK]. With one lane an item each
   array lies in blocks of INTERLEAVED items (shared/group.h, answer_at). */
#if SENSORS
/* The same with the tables of a family in place of a sensor's: sides, side_forces and side_stresses
   [side_rows][PATCH_BLOCK], cores [poissons][CORE_NUMBERS], layer_stresses [stress_cells][poissons][STRESS_NUMBERS],
   sensors [group][PATCH_SENSOR_ROWS][lane]. */
kernel void patch_contact_sensors(uint first_group, global const real *smooth, int cells, int poissons,
                                  real cells_per_h, global const real *sides, global const real *side_forces,
                                  global const real *side_stresses, int side_rows, real side_rows_per_h,
                                  global const real *cores, global const real *layer_stresses, int stress_cells,
                                  real stress_cells_per_h, int tactels, int outputs, global const vreal *sensors,
                                  global const real *shapes, global const vreal *lane_input, global const vreal *path,
                                  int increments, int slots, int write_forces, real tolerance, real accept,
                                  int most_sweeps, global real *result, global real *forces, global real *stress,
                                  global real *patches) {
  TAKE_GROUP(group);
  Layer layer = {.smooth = smooth, .cells = cells, .poissons = poissons, .sides = sides, .side_forces = side_forces};
  layer.side_rows = side_rows;
  layer.side_rows_per_h = side_rows_per_h;
  const StressTables tables = {layer_stresses, stress_cells, tactels, outputs, stress_cells_per_h, side_stresses};
  sensors += FIRST_NUMBER(group, PATCH_SENSOR_ROWS);
#else
kernel void patch_contact(uint first_group, global const real *smooth, int cells, real cells_per_mm, real thickness,
                          real length, real cy, real cx, real jump, global const real *sides, int side_rows,
                          real side_rows_per_mm, real sides_from, global const real *signs, global const real *base,
                          int base_rows, real base_rows_per_mm, real base_from, int outputs, global const real *shapes,
                          global const vreal *lane_input, global const vreal *path, int increments, int slots,
                          int write_forces, real tolerance, real accept, int most_sweeps, global real *result,
                          global real *forces, global real *stress, global real *patches) {
  TAKE_GROUP(group);
  const Layer layer = {smooth, cells, cells_per_mm, thickness,        length,     cy,   cx,
                       jump,   sides, side_rows,    side_rows_per_mm, sides_from, signs};
  const Answers answers = {group,     slots,  write_forces, accept, base, base_rows, outputs, base_rows_per_mm,
                           base_from, result, forces,       stress};
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
  ForceSearch search;
  start_force_search(&search, w.nearest);
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
