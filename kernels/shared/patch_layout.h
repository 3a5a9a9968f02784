// SPDX-License-Identifier: Apache-2.0
/* Rows of the patch kernel's arrays. Everything is stored in the kernel's real type. contact_layout.h has the rows of
   results. */
#ifndef TACTEL_PATCH_LAYOUT_H
#define TACTEL_PATCH_LAYOUT_H

/* Numbers that a gathered row of a table holds; results, forces and stresses are stored in multiples of it. */
enum { PATCH_BLOCK = 16 };

/* Coefficients of one cell of the layer's table: c0 + q (c1 + q (c2 + q c3)) of R_yy, then of R_xx, then of R_xy. */
enum { LAYER_COEFFICIENTS = 4 };

/* Columns of one row of the sides' table: v_y of every mode, then v_x. */
enum { SIDE_MODES = 8 };

/* Where every lane has its own sensor: numbers of a core row, C (upper triangle by rows) and then K of
   fem/layer/end_modes.h, and those of one place in the table of the layer's base stress: sigma_y by f_y, tau by f_x,
   tau by f_y, sigma_y by f_x, each here and one cell farther. */
enum { CORE_COMPLIANCE = SIDE_MODES * (SIDE_MODES + 1) / 2, CORE_NUMBERS = 112, STRESS_NUMBERS = 8 };

/* Rows of `sensors`, [group][PATCH_SENSOR_ROWS][lane]. */
enum PatchSensorRow {
  SENSOR_THICKNESS = 0, /* mm */
  SENSOR_LENGTH,        /* mm */
  SENSOR_POISSON,       /* place among the rows of Poisson's ratios */
  SENSOR_CY,            /* factors of C_yy, of C_xy, and (1 - 2 nu) pi/2 */
  SENSOR_CX,
  SENSOR_JUMP,
  SENSOR_TACTEL,  /* middle of the first tactel, mm from the sensor's middle */
  SENSOR_SPACING, /* from tactel to tactel, mm */
  PATCH_SENSOR_ROWS
};

/* Rows of `lane_input`, [group][PATCH_INPUT_ROWS][lane]. Places along x count from the indenter's position, mm. */
enum PatchInputRow {
  PATCH_MU = 0,
  PATCH_YOUNG,    /* MPa */
  PATCH_STEPS,    /* increments of this lane's path */
  PATCH_MAY_STOP, /* index of the first increment after which a fully sliding lane stops; a huge number: never */
  PATCH_CONTROL,  /* ForceControl */
  PATCH_POSITION, /* of the indenter on the sensor, mm from the sensor's middle */
  PATCH_LEFT,     /* left limit of contact: the indenter's own edge or the sensor's end */
  PATCH_RIGHT,
  PATCH_LEFT_EDGE, /* 1 where the left limit is the indenter's own edge, 0 where it is the sensor's end */
  PATCH_RIGHT_EDGE,
  PATCH_FROM, /* where the search starts: the rigid profile at the largest depth, inside the limits */
  PATCH_TO,
  PATCH_MOST,        /* largest depth, mm, or largest P / E, mm */
  PATCH_LOWEST_LEFT, /* ends of the profile's lowest part, inside the limits */
  PATCH_LOWEST_RIGHT,
  PATCH_GIVEN, /* 1: PATCH_FROM and PATCH_TO are the contact that the patch must cover, and nothing is searched */
  PATCH_FLAT,  /* half the width of a flat bottom, mm; beyond it, with q = |x| - flat, the height is the sum of */
  PATCH_C1,    /* c1 q + c2 q^2 + ... + c5 q^5 */
  PATCH_C2,
  PATCH_C3,
  PATCH_C4,
  PATCH_C5,
  PATCH_RADIUS,     /* of a cylinder, mm; 0: none */
  PATCH_EXP_HEIGHT, /* of an exponential, mm; 0: none */
  PATCH_EXP_RATE,   /* 1/mm */
  PATCH_TERMS,      /* number of terms (coefficient, power, 1 / scale) of a Taylor profile beyond c5 */
  PATCH_TERMS_AT,   /* where they begin in `shapes` */
  PATCH_POINTS,     /* number of points (x, height, slope to the next) of a measured profile; 0: none */
  PATCH_POINTS_AT,  /* where they begin in `shapes` */
  PATCH_INPUT_ROWS
};

/* Rows of `path`, [group][increments][PATCH_PATH_ROWS][lane]. */
enum PatchPathRow {
  PATCH_NORMAL = 0, /* indentation mm, or P / E mm */
  PATCH_TANGENTIAL, /* indenter position mm, or Q / E mm */
  PATCH_SLOT,       /* place of this increment among those that are reported; -1: an increment between two of them */
  PATCH_PATH_ROWS
};

/* The patch of a lane and how it was found, `patch`, [lane of all groups][PATCH_BLOCK]. */
enum PatchRow {
  PATCH_ORIGIN = 0, /* left end, mm from the indenter's position */
  PATCH_ELEMENT,    /* width of an element, mm */
  PATCH_OUT_LEFT,   /* elements beyond the left end that are penetrated, as far as the certificate looks */
  PATCH_OUT_RIGHT,
  PATCH_SEARCH_SWEEPS,
  PATCH_SLOTS, /* increments reported */
  PATCH_ROWS
};

#endif
