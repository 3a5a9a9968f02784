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

   FRICTION_MAP 1: mu differs from cell to cell. S then has the share of each.

   CREEP_TERMS, 1 to 4: the rubber creeps (pad/creep.h). Numbers of terms that a scene lacks are 0. */
// defines: CELLS=8 VECTORS=1 OWN_TABLES=1 FRICTION_MAP=1 CREEP_TERMS=2
#include "pad/table_sums.h"
#include "pad/path.h"

#define MOST_STEPS 16 /* load steps that the base stress is summed for at once */

/* tables [tables][PAD_TABLE_HEAD + (2 CELLS + 1)^2 PAD_INFLUENCE], table_of [groups]; or, with OWN_TABLES,
   [groups][PAD_TABLE_HEAD + (CELLS + 1)^2 PAD_OWN_INFLUENCE][lane], and table_of is not read. The other arrays are as
   kernels/shared/pad_layout.h has them; those of the launch begin with vector `first_vector` of all.
   Out: result; forces [lane of all groups][slots][FORCE_PARTS][cells] N, in the own frame, where write_forces is not
   0. memory [vectors of all groups][MEMORY_VECTORS]: to work in, of rubber that creeps where LANES is 1. */
kernel void pad_contact(uint first_group, global const side *tables, global const int *table_of, int first_vector,
                        global const vreal *lane_input, global const vreal *path, global const vreal *heights,
                        int increments, int slots, int write_forces, real tolerance, real accept, int most_sweeps,
                        global real *result, global real *forces, global vreal *memory) {
  TAKE_GROUP(group);
  const size_t entries = OWN_TABLES ? (CELLS + 1) * (CELLS + 1) * PAD_OWN_INFLUENCE : SPAN * SPAN * PAD_INFLUENCE;
  global const side *head = tables + (OWN_TABLES ? group : (size_t)table_of[group]) * (PAD_TABLE_HEAD + entries),
                    *table = head + PAD_TABLE_HEAD + (OWN_TABLES ? 0 : PAD_INFLUENCE * (CELLS * SPAN + CELLS));
  const Influence influence = {table, head[PAD_ROOT_ZZ], head[PAD_ROOT_TT], head[PAD_HX], head[PAD_HY]};
  const size_t vector = first_vector + group * VECTORS;
  const Answers answers = {vector * LANES, slots, write_forces, most_sweeps, accept, result, forces};
  walk(&influence, lane_input + vector * INPUT_ROWS, path + vector * increments * PATH_ROWS,
       heights + vector * RING * RING, increments, tolerance, &answers, memory + vector * MEMORY_VECTORS);
}

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
