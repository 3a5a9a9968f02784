/* Every struct that host and device share, with every field: a test expands this list on both sides and compares sizes
   and offsets. Add a struct here when you add one to kernels/shared; a forgotten field is noticed by the sum of sizes. */
#ifndef TACTEL_SHARED_LAYOUT_H
#define TACTEL_SHARED_LAYOUT_H
#include "shared/lane_result.h"
#include "shared/online_report.h"

#define SHARED_LAYOUT(STRUCT, FIELD) \
  STRUCT(LaneResult)                 \
  FIELD(LaneResult, status)          \
  FIELD(LaneResult, sweeps)          \
  FIELD(LaneResult, residual)        \
  STRUCT(OnlineReport)               \
  FIELD(OnlineReport, status)        \
  FIELD(OnlineReport, cycle)         \
  FIELD(OnlineReport, sse)           \
  FIELD(OnlineReport, largest)

#endif
