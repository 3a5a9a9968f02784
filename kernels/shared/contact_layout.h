// SPDX-License-Identifier: Apache-2.0
/* Rows of the contact kernel's arrays. Everything is stored in the kernel's real type. `lane` is the fastest index. */
#ifndef TACTEL_CONTACT_LAYOUT_H
#define TACTEL_CONTACT_LAYOUT_H
#include "shared/result_rows.h"

/* Result of one lane (one scene) after one load increment: rows of `result`, [group][step][LANE_RESULT_ROWS][lane]. */
enum LaneResultRow {
  LANE_BALANCE = RESULT_OWN_RESIDUAL,
  LANE_TANGENTIAL = RESULT_OWN_ROWS, /* mm */
  LANE_Q,                            /* N/mm, > 0 drags the rubber to +x */
  LANE_RESULT_ROWS
};

/* Height of a node that carries no gap element, mm: a number that no profile reaches, small enough for its square in
   fp32. */
#define NO_GAP_ELEMENT 1e15

/* Output rows that the kernel computes together: `map` is [blocks of rows][NODES][ROW_BLOCK][2]. */
enum { ROW_BLOCK = 4 };

/* Numbers that the compliance holds of a pair of nodes, [NODES][NODES][COMPLIANCE_PARTS]; the first alone where there
   is no friction. */
enum CompliancePart {
  COMPLIANCE_UY_BY_N = 0,
  COMPLIANCE_UY_BY_T,
  COMPLIANCE_UX_BY_N,
  COMPLIANCE_UX_BY_T,
  COMPLIANCE_PARTS
};

/* Load targets, rows of `path`, [group][step][PATH_ROWS][lane]. */
enum PathRow {
  PATH_NORMAL = 0, /* indentation mm, or P / E mm */
  PATH_TANGENTIAL, /* indenter position mm, or Q / E mm */
  PATH_ROWS
};

/* Rows of `lane_input`, [group][LANE_INPUT_ROWS][lane]. */
enum LaneInputRow {
  LANE_MU = 0,
  LANE_YOUNG,    /* MPa */
  LANE_STEPS,    /* increments of this lane's path */
  LANE_MAY_STOP, /* index of the first increment after which a lane without a sticking node stops; a huge number:
                    never */
  LANE_FORCE,    /* ForceControl */
  LANE_INPUT_ROWS
};

/* Numbers of one surface node, rows of `node`, [NODES][NODE_ROWS]; E = 1. */
enum NodeRow {
  NODE_N_PER_UY = 0, /* pressure force that takes back a unit of u_y */
  NODE_T_PER_UX,     /* traction force that adds a unit of u_x */
  NODE_UX_PER_N,     /* u_x by its own pressure force */
  NODE_RISE_PER_N,   /* largest u_y that a unit of pressure force at another node can give, >= 0 */
  NODE_RISE_PER_T,   /* largest u_y that a unit of traction force at another node can give, >= 0 */
  NODE_ROWS
};

/* Which targets of a path are forces. The tangential one can be a force only when the normal one is. */
enum ForceControl { FORCE_NONE = 0, FORCE_NORMAL = 1, FORCE_BOTH = 2 };

enum NodeStatus { NODE_OPEN = 0, NODE_STICK, NODE_SLIP };

#endif
