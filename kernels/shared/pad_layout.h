// SPDX-License-Identifier: Apache-2.0
/* Rows of the pad kernel's arrays. Everything is stored in the kernel's real type. Lengths are over the thickness H,
   except where a unit is named; directions are those of the indenter's own frame, except in answers. */
#ifndef TACTEL_PAD_LAYOUT_H
#define TACTEL_PAD_LAYOUT_H
#include "shared/result_rows.h"

/* Nodes along a side of the block of free sides, at most. */
enum { MOST_SIDE_NODES = 24 };

/* Numbers of a result; a gathered row of the base stress's table has as many. */
enum { PAD_BLOCK = 16 };

/* Influence of cells: `tables` holds PAD_TABLE_HEAD numbers of a table, then
   [2 CELLS + 1][2 CELLS + 1][PAD_INFLUENCE]: by source less place. */
enum PadTableHead {
  PAD_ROOT_ZZ = 0, /* root of zz of a cell on itself */
  PAD_ROOT_TT,     /* root of the larger of xx and yy of a cell on itself */
  PAD_HX,          /* sides of a cell */
  PAD_HY,
  PAD_TABLE_HEAD = 8
};
enum PadInfluenceNumber {
  PAD_ZZ = 0, /* over zz of a cell on itself; E = 1 */
  PAD_XX,     /* over the larger of xx and yy of a cell on itself */
  PAD_YY,
  PAD_XY,
  PAD_XZ, /* over the roots of both */
  PAD_YZ,
  PAD_OWN_INFLUENCE, /* numbers of an entry of a lane's own table: of offsets that are not negative */
  PAD_INFLUENCE = 8
};
/* Of pairs of cells, [place][source][PAD_PAIR], after a head as above: first the numbers above, x by y and x, y by z; then
   those that differ from them where the rubber has sides. */
enum PadPairNumber {
  PAD_PAIR_ZX = PAD_OWN_INFLUENCE, /* with the sign of PAD_XZ */
  PAD_PAIR_ZY,
  PAD_PAIR_YX,
  PAD_PAIR = 12
};

/* Memory of a scene with free sides, by the cells along a side of its grid (pad/free_sides.h): where its parts begin, and
   how many numbers it has. */
#define PAIRS_PLANES 9 /* numbers of a pair of cells */
#define PAIRS_RING_AT(cells) (PAIRS_PLANES * (cells) * (cells) * (cells) * (cells))
#define PAIRS_LAYER_AT(cells) (PAIRS_RING_AT(cells) + 4 * ((cells) + 1) * 3 * (cells) * (cells))
#define PAIRS_SHARES_AT(cells) (PAIRS_LAYER_AT(cells) + PAIRS_PLANES * (2 * (cells) + 1) * (2 * (cells) + 1))
#define PAIRS_ROW_AT(cells) (PAIRS_SHARES_AT(cells) + 16 * (cells) * (cells))
#define PAIRS_NUMBERS(cells) (PAIRS_ROW_AT(cells) + MOST_SIDE_NODES * MOST_SIDE_NODES * PAD_BLOCK)

/* Rows of `lane_input`, [group][vector][PAD_INPUT_ROWS][lane]; with FRICTION_MAP mu of each cell follows. */
enum PadInputRow {
  PAD_MU = 0,
  PAD_STEPS,    /* increments of this lane's path */
  PAD_X_MIDDLE, /* of the grid */
  PAD_Y_MIDDLE,
  PAD_FORCE,     /* E H^2, N: what a unit of force is */
  PAD_THICKNESS, /* mm */
  PAD_COSINE,    /* of the angle from the pad's frame to the own one */
  PAD_SINE,
  PAD_BY_FORCE, /* 1: the path's normal targets are forces */
  PAD_BLOCK_X,  /* with free sides: of the indenter's axis, from the middle of the block that has them */
  PAD_BLOCK_Y,
  PAD_INPUT_ROWS
};

/* Rows of `path`, [group][vector][increments][PAD_PATH_ROWS][lane]; of rubber that creeps 1 + CREEP_NUMBERS terms more. */
enum PadPathRow {
  PAD_NORMAL = 0, /* depth, or P / (E H^2) */
  PAD_X,          /* motion of the indenter since first touch */
  PAD_Y,
  PAD_TWIST, /* rad */
  PAD_SLOT,  /* place of this increment among those that are reported; -1: an increment between two of them */
  PAD_PATH_ROWS
};

/* What a term of rubber that creeps does in a step (fem/pad/creep.h), [terms][CREEP_NUMBERS]; in a path behind the rows
   above, after how much softer the rubber is in the increment. */
enum PadCreepNumber {
  CREEP_C = 0,
  CREEP_FADES, /* 1 - e: small in short steps, of which sums of fp32 keep the digits */
  CREEP_LAST,  /* b - e */
  CREEP_NEW,   /* 1 - b */
  CREEP_NUMBERS
};

/* Height of a cell that the indenter may not touch; `heights` is [group][vector][(CELLS + 2)^2][lane]. */
#define PAD_OPEN 1e9f

/* The result of a lane after an asked increment, `result`, [lane of all groups][slots][PAD_RESULT_ROWS], in the pad's
   frame. */
enum PadResultRow {
  PAD_RESULT_ANGLE = RESULT_OWN_RESIDUAL,
  PAD_RESULT_QX = RESULT_OWN_ROWS, /* N, > 0 drags the rubber to +x */
  PAD_RESULT_QY,                   /* N */
  PAD_RESULT_M,                    /* N mm about the indenter's axis */
  PAD_RESULT_OUTSIDE,              /* sum of 1, 2, 4, 8: beyond the side -x, +x, -y, +y the surface is penetrated */
  PAD_RESULT_AREA,                 /* mm^2 of the cells that touch */
  PAD_RESULT_LEFT, /* mm along the pad from the indenter's axis to the edges of the outermost such cells: x */
  PAD_RESULT_RIGHT,
  PAD_RESULT_BELOW, /* y */
  PAD_RESULT_ABOVE,
  PAD_RESULT_ACROSS,    /* cells over which they extend, along the shorter side of the own frame */
  PAD_RESULT_CELL,      /* mm: the longer side of a cell */
  PAD_RESULT_SLID,      /* mm: sum over the increments without a sticking cell of the rms slide of those that touch */
  PAD_RESULT_SLIP_PATH, /* mm: the same over all increments */
  PAD_RESULT_MU,        /* mean of mu, weighed by the pressures */
  PAD_RESULT_ROWS
};

/* Rows of `places` of a scene, [scene][PAD_PLACE_ROWS], for the base stress. */
enum PadPlaceRow {
  PAD_PLACE_X = 0, /* of the indenter's axis on the pad */
  PAD_PLACE_Y,
  PAD_PLACE_COSINE,
  PAD_PLACE_SINE,
  PAD_PLACE_X_MIDDLE, /* of the grid, in the own frame */
  PAD_PLACE_Y_MIDDLE,
  PAD_PLACE_HX,
  PAD_PLACE_HY,
  PAD_PLACE_THICKNESS, /* 1 / H, 1/mm */
  PAD_PLACE_STRESS,    /* 1 / (2 pi H^2), 1/mm^2 */
  PAD_PLACE_STEPS,     /* slots that are filled */
  PAD_PLACE_LAYER,     /* first row of its Poisson's ratio in the table */
  PAD_PLACE_SHARES_X,  /* first point along x of a cell in `shares` */
  PAD_PLACE_COUNT_X,   /* points along x */
  PAD_PLACE_SHARES_Y,
  PAD_PLACE_COUNT_Y,
  PAD_PLACE_ROWS = 16
};

/* Coefficients of a row of the base stress's table: c0 + q (c1 + q c2) of each of b0, bA, bB, bxz, bzx. */
enum { PAD_STRESS_COEFFICIENTS = 3 };

/* The smooth rest z0 of the normal influence, a Chebyshev sum (kernels/pad_search.cl). With these it is right to 1e-5
   at any distance and Poisson's ratio. */
#define PAD_SEARCH_LENGTH 2.5
enum { PAD_SEARCH_TERMS = 14 };

/* Rows of a scene for kernels/pad_search.cl, [group][PAD_SEARCH_ROWS][lane]. The profile is the sum of
     slope rho,   the circle's rho^2 c / (1 + sqrt(1 - (c rho)^2)),   rho^2 = x^2 + round y^2,
     curve max(0, rho - flat)^2,   alike along x with |x|, along y with |y|,   the plane tilt_x x + tilt_y y + below,
   and open beyond rho = rim; or measured heights. Half a side of the rigid section at depth d is
     flat + sqrt(m (wide - less m)) + slope d,   m = min(d, most). */
enum PadSearchRow {
  PAD_SEARCH_TARGET = 0, /* largest depth, or force over E H^2 */
  PAD_SEARCH_BY_FORCE,
  PAD_SEARCH_NORMAL_FACTOR, /* (1 - nu^2) / pi; 0: no scene */
  PAD_SHAPE_ROUND,
  PAD_SHAPE_SLOPE,
  PAD_SHAPE_CIRCLE, /* its curvature */
  PAD_SHAPE_FLAT,
  PAD_SHAPE_CURVE,
  PAD_SHAPE_FLAT_X,
  PAD_SHAPE_CURVE_X,
  PAD_SHAPE_FLAT_Y,
  PAD_SHAPE_CURVE_Y,
  PAD_SHAPE_RIM,
  PAD_SHAPE_TILT_X,
  PAD_SHAPE_TILT_Y,
  PAD_SHAPE_BELOW,
  PAD_SHAPE_EDGE_X, /* half the indenter's extent; PAD_OPEN: it has no edge */
  PAD_SHAPE_EDGE_Y,
  PAD_SECTION_X,
  PAD_SECTION_Y,
  PAD_SECTION_WIDE_X,
  PAD_SECTION_WIDE_Y,
  PAD_SECTION_LESS_X,
  PAD_SECTION_LESS_Y,
  PAD_SECTION_SLOPE,
  PAD_SECTION_MOST,
  PAD_MAP_ROWS, /* of measured heights, along x; 0: none */
  PAD_MAP_COLUMNS,
  PAD_MAP_PER_PITCH, /* H over their pitch */
  PAD_MAP_UNIT,      /* a unit of heights over H */
  PAD_SEARCH_REST,   /* PAD_SEARCH_TERMS coefficients of z0 */
  PAD_SEARCH_ROWS = PAD_SEARCH_REST + PAD_SEARCH_TERMS
};

/* What it finds, [group][PAD_FOUND_ROWS][lane], in the own frame: the contact, not yet clipped to the edges. */
enum PadFoundRow {
  PAD_FOUND_LEFT = 0, /* x */
  PAD_FOUND_RIGHT,
  PAD_FOUND_BELOW, /* y */
  PAD_FOUND_ABOVE,
  PAD_FOUND_DEPTH,
  PAD_FOUND_P, /* over E H^2 */
  PAD_FOUND_ROWS
};

#endif
