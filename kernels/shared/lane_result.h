// SPDX-License-Identifier: Apache-2.0
/* Report of a lane (one scene) about its own answer. */
#ifndef TACTEL_SHARED_LANE_RESULT_H
#define TACTEL_SHARED_LANE_RESULT_H
#include "shared/scalars.h"

typedef struct LaneResult {
  shared_i32 status; /* 0 solved; the kernel that writes it defines the others */
  shared_i32 sweeps; /* iterations spent */
  float residual;    /* largest relative residual */
} LaneResult;

#endif
