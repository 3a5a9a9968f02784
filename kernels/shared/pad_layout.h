// SPDX-License-Identifier: Apache-2.0
/* Rows of the pad kernel's arrays. Everything is stored in the kernel's real type. Lengths are over the thickness H,
   except where a unit is named; directions are those of the indenter's own frame, except in answers. */
#ifndef TACTEL_PAD_LAYOUT_H
#define TACTEL_PAD_LAYOUT_H

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

/* Rows of `lane_input`, [group][vector][PAD_INPUT_ROWS][lane]. */
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
  PAD_INPUT_ROWS
};

/* Rows of `path`, [group][vector][increments][PAD_PATH_ROWS][lane]. */
enum PadPathRow {
  PAD_NORMAL = 0, /* depth, or P / (E H^2) */
  PAD_X,          /* motion of the indenter since first touch */
  PAD_Y,
  PAD_TWIST, /* rad */
  PAD_SLOT,  /* place of this increment among those that are reported; -1: an increment between two of them */
  PAD_PATH_ROWS
};

/* Height of a cell that the indenter may not touch; `heights` is [group][vector][(CELLS + 2)^2][lane]. */
#define PAD_OPEN 1e9f

/* The result of a lane after an asked increment, `result`, [lane of all groups][slots][PAD_BLOCK], in the pad's
   frame. */
enum PadResultRow {
  PAD_RESULT_P = 0,       /* N, >= 0 */
  PAD_RESULT_QX,          /* N, > 0 drags the rubber to +x */
  PAD_RESULT_QY,          /* N */
  PAD_RESULT_M,           /* N mm about the indenter's axis */
  PAD_RESULT_S,           /* slip index 1 / lambda; 0 where mu P = 0 */
  PAD_RESULT_STICKING,    /* cells that stick */
  PAD_RESULT_SLIPPING,    /* cells that slip */
  PAD_RESULT_SWEEPS,      /* of this increment */
  PAD_RESULT_STATUS,      /* LaneStatus */
  PAD_RESULT_DEPTH,       /* mm */
  PAD_RESULT_PENETRATION, /* the certificate, relative as in fem/pad/pad_contact.h */
  PAD_RESULT_COMPLEMENTARITY,
  PAD_RESULT_CONE,
  PAD_RESULT_DRIFT,
  PAD_RESULT_ANGLE,
  PAD_RESULT_OUTSIDE /* sum of 1, 2, 4, 8: beyond the side -x, +x, -y, +y the surface is penetrated */
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
  PAD_PLACE_ROWS = 16
};

/* Coefficients of a row of the base stress's table: c0 + q (c1 + q c2) of each of b0, bA, bB, bxz, bzx. */
enum { PAD_STRESS_COEFFICIENTS = 3 };

#endif
