// SPDX-License-Identifier: Apache-2.0
/* Rows of the arrays of kernels/pad_step.cl. Lengths are over the thickness H, forces over E H^2, except in results. */
#ifndef TACTEL_PAD_STEP_LAYOUT_H
#define TACTEL_PAD_STEP_LAYOUT_H

/* Rows of `input`, [group][vector][STEP_INPUT_ROWS][lane]; with FRICTION_MAP mu of each cell follows. */
enum PadStepInputRow {
  STEP_MU = 0,
  STEP_AXIS_X, /* the object's axis on the pad, about which twist and torque are */
  STEP_AXIS_Y,
  STEP_BEYOND, /* least height of the object over rubber beyond the grid, PAD_OPEN: none; below 0: not known */
  STEP_TO,     /* four rows: depth, x, y, twist (rad) after the step; or the wrench P, Qx, Qy, M about the axis */
  STEP_INPUT_ROWS = STEP_TO + 4
};

/* Rows of `state`, [group][vector][STEP_FIELDS cells + STEP_NUMBERS][lane]: first fields, [field][cell], as
   kernels/pad/cells.h scales them. Zeros: a contact that nothing has touched. */
enum PadStepField {
  STEP_N = 0,
  STEP_TX,
  STEP_TY,
  STEP_N_LAST,
  STEP_TX_LAST,
  STEP_TY_LAST,
  STEP_GX,
  STEP_GY,
  STEP_UZ, /* STEP_UNKNOWN: the cell was far from the indenter, it and the history are to be summed */
  STEP_FIELDS
};
enum PadStepNumber {
  STEP_POSE = 0,               /* four: depth, x, y, twist */
  STEP_CHANGE = STEP_POSE + 4, /* four: of the last step; the twist times the half size of the grid */
  STEP_MARK = STEP_CHANGE + 4, /* of heights, covers and mu */
  STEP_POWER,                  /* of the force over the depth */
  STEP_WAY,                    /* three: the wrench's last change, x, y, torque over the half size */
  STEP_INVERSE = STEP_WAY + 3, /* nine: motion by force, the same three */
  STEP_NUMBERS = STEP_INVERSE + 9
};
#define STEP_UNKNOWN 1e30f

/* Rubber that creeps has 3 + 3 terms more fields behind the numbers: w of x, y, z, then v of each term, scaled as STEP_GX
   and STEP_UZ (PadCreepNumber). With markers these are six, also of n, t_x, t_y; behind them are those three that would
   strain elastic rubber as far. */

/* A result, `result`, [contact][STEP_RESULT_ROWS]. */
enum PadStepResultRow {
  STEP_RESULT_P = 0, /* N */
  STEP_RESULT_QX,
  STEP_RESULT_QY,
  STEP_RESULT_M,     /* N mm about the axis */
  STEP_RESULT_DEPTH, /* mm */
  STEP_RESULT_X,
  STEP_RESULT_Y,
  STEP_RESULT_TWIST, /* rad */
  STEP_RESULT_S,
  STEP_RESULT_STICK,  /* share of the touching cells that stick */
  STEP_RESULT_TOUCH,  /* cells that touch */
  STEP_RESULT_FLAGS,  /* sum of PadStepFlag */
  STEP_RESULT_SOLVES, /* poses that were solved */
  STEP_RESULT_SWEEPS,
  STEP_RESULT_RESIDUAL, /* largest, as fem/pad/pad_contact.h */
  STEP_RESULT_SLID,     /* mm: rms slide in this step of the cells that touch */
  STEP_RESULT_MEAN,     /* three, mm: their mean slide x, y, and its turn times their rms distance from their middle */
  STEP_RESULT_ROWS = STEP_RESULT_MEAN + 3
};
enum PadStepFlag {
  STEP_OPEN = 1,     /* no cell touches */
  STEP_SLIDES = 2,   /* every cell that touches slips, or the wrench is beyond what friction bears */
  STEP_UNMET = 4,    /* the wrench was not met, or the sweeps did not settle */
  STEP_EDGE = 8,     /* an outermost cell touches, beside rubber beyond the grid that the object may touch */
  STEP_INVALID = 16, /* numbers that are no input: the contact stays as it was */
  STEP_DEEP = 32,    /* deeper than the linear model holds: STEP_DEEP_FACE, STEP_DEEP_CURVED */
  STEP_REACH = 64    /* the object is deeper than the surface of rubber beyond the grid, which no cell sees */
};

/* Depths over H from which a contact is STEP_DEEP. Of faces P is 8 % above the linear one there, of balls below 2 %
   (docs/notebook/2026-11-29-steps.md). Faces: most of more than four touching cells lie less than STEP_FLAT of the
   depth above the lowest point. */
#define STEP_DEEP_FACE 0.05f
#define STEP_DEEP_CURVED 0.25f
#define STEP_FLAT 0.1f
/* Inputs beyond these are none: depths over H from the lowest cell, ways over H and turns since the reset, forces over
   E H^2. */
#define STEP_MOST_DEPTH 1.0f
#define STEP_MOST_WAY 1e4f
#define STEP_MOST_FORCE 1e6f

/* Rows of stresses that kernel pad_frames sums at once. */
enum { STEP_FRAME_BLOCK = 8 };

/* Rows of a block that kernels/pad/splitting.h multiplies at once. */
enum { STEP_ROUND = 12 };

#endif
