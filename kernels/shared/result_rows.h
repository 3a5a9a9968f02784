// SPDX-License-Identifier: Apache-2.0
/* What the results of all kinds of contact have: the first rows of a step. Own rows of a kind follow (contact_layout.h,
   pad_layout.h). Forces are N/mm on a line, N on a pad. */
#ifndef TACTEL_RESULT_ROWS_H
#define TACTEL_RESULT_ROWS_H

enum ResultRow {
  RESULT_P = 0,         /* >= 0 */
  RESULT_DEPTH,         /* mm */
  RESULT_S,             /* slip index; 0 where mu P = 0 */
  RESULT_SLIP_DISTANCE, /* mm: how far the indenter has slid over the nodes or cells that touch, at most */
  RESULT_STICKING,      /* nodes or cells that stick */
  RESULT_SLIPPING,      /* nodes or cells that slip */
  RESULT_SWEEPS,        /* of this step */
  RESULT_STATUS,        /* LaneStatus */
  RESULT_PENETRATION,   /* the certificate, relative as in fem/gap/contact_solution.h and fem/pad/pad_contact.h */
  RESULT_COMPLEMENTARITY,
  RESULT_CONE,
  RESULT_DRIFT,
  RESULT_OWN_RESIDUAL, /* balance of a line; angle of a pad */
  RESULT_OWN_ROWS
};

enum LaneStatus {
  LANE_SOLVED = 0, /* met its tolerance */
  LANE_SLIDING,    /* met its tolerance, and every touching node slips */
  LANE_UNSOLVED,   /* did not meet its tolerance: its numbers are the last iterate */
  LANE_INVALID,    /* input not finite: its numbers are zero */
  LANE_NOT_RUN     /* the path had ended */
};

#endif
