// SPDX-License-Identifier: Apache-2.0
/* Progress of the online training of one network. */
#ifndef TACTEL_SHARED_ONLINE_REPORT_H
#define TACTEL_SHARED_ONLINE_REPORT_H
#include "shared/scalars.h"

typedef struct OnlineReport {
  shared_i32 status; /* nn::TrainStatus: 0 running, 1 below the stop error, 2 cycle limit, 3 not finite */
  shared_u32 cycle;  /* cycles done */
  float sse;         /* of the last cycle: sum of squared errors, each as its pattern was shown */
  float largest;     /* and the largest absolute error */
} OnlineReport;

#define ONLINE_RUNNING 0
#define ONLINE_LEARNT 1
#define ONLINE_CYCLE_LIMIT 2
#define ONLINE_NOT_FINITE 3

#endif
