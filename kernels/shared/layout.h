// SPDX-License-Identifier: Apache-2.0
/* Every struct that host and device share, with every field: a test expands this list on both sides and compares sizes
   and offsets. Add a struct here when you add one to kernels/shared; a forgotten field is noticed by the sum of
   sizes. */
#ifndef TACTEL_SHARED_LAYOUT_H
#define TACTEL_SHARED_LAYOUT_H
#include "shared/chain_settings.h"
#include "shared/lane_result.h"
#include "shared/online_report.h"

#define SHARED_LAYOUT(STRUCT, FIELD)     \
  STRUCT(LaneResult)                     \
  FIELD(LaneResult, status)              \
  FIELD(LaneResult, sweeps)              \
  FIELD(LaneResult, residual)            \
  STRUCT(OnlineReport)                   \
  FIELD(OnlineReport, status)            \
  FIELD(OnlineReport, cycle)             \
  FIELD(OnlineReport, sse)               \
  FIELD(OnlineReport, largest)           \
  STRUCT(LateShare)                      \
  FIELD(LateShare, share)                \
  FIELD(LateShare, time)                 \
  FIELD(LateShare, decay)                \
  FIELD(LateShare, pass)                 \
  STRUCT(ChainSettings)                  \
  FIELD(ChainSettings, reading_seed)     \
  FIELD(ChainSettings, instance_seed)    \
  FIELD(ChainSettings, instances)        \
  FIELD(ChainSettings, decay)            \
  FIELD(ChainSettings, pass)             \
  FIELD(ChainSettings, step_time)        \
  FIELD(ChainSettings, time_constant)    \
  FIELD(ChainSettings, gain_spread)      \
  FIELD(ChainSettings, shear_gain)       \
  FIELD(ChainSettings, offset_spread)    \
  FIELD(ChainSettings, noise)            \
  FIELD(ChainSettings, noise_of_largest) \
  FIELD(ChainSettings, drift)            \
  FIELD(ChainSettings, repeats)          \
  FIELD(ChainSettings, mixing)           \
  FIELD(ChainSettings, shift_spread)     \
  FIELD(ChainSettings, crosstalk)        \
  FIELD(ChainSettings, dead)             \
  FIELD(ChainSettings, late)             \
  FIELD(ChainSettings, low)              \
  FIELD(ChainSettings, high)             \
  FIELD(ChainSettings, quantum)          \
  FIELD(ChainSettings, bits)             \
  FIELD(ChainSettings, range)

#endif
