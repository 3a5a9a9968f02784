// SPDX-License-Identifier: Apache-2.0
/* kernels/pad_contact.cl on a pad whose sides are free, and what these change in the stress at its base. A work-item has
   one scene. It makes the table of all pairs of its cells (pad/free_sides.h), and takes WIDE cells at a time. Rows of a
   sweep are divided by what each cell does to itself.

   Built with -D REAL, CELLS, WIDE (1, 2, 4, 8, 16), FRICTION_MAP, CREEP_TERMS, LANES 1 and VECTORS 1. */
// defines of WIDE: CELLS=8 VECTORS=1 FRICTION_MAP=1 CREEP_TERMS=2
#define FREE_SIDES 1
#include "pad/free_sides.h"
#include "pad/path.h"

/* As pad_contact. layers [scenes][PAD_TABLE_HEAD + (CELLS + 1)^2 PAD_OWN_INFLUENCE]: the
   layer's means; softs [scenes][COUNT]: compliances that cells have of their own, over H; pairs [groups of the
   launch][PAIR_NUMBERS]: memory to work in. SidePart (pad/free_sides.h) tells the others. The launch begins with scene
   first_scene. */
kernel void pad_free_contact(uint first_group, global real *pairs, global const real *layers, global const real *softs,
                             global const real *between, int nodes_x, int nodes_y, real side_x, real side_y,
                             int first_scene, global const vreal *lane_input, global const vreal *path,
                             global const vreal *heights, int increments, int slots, int write_forces, real tolerance,
                             real accept, int most_sweeps, global real *result, global real *forces,
                             global vreal *memory) {
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
  walk(&influence, lane_input, path + scene * increments * PATH_ROWS, heights, increments, tolerance, &answers,
       memory + group * MEMORY_VECTORS);
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
