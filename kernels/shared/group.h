// SPDX-License-Identifier: Apache-2.0
/* Index of a work-item's group: `TAKE_GROUP(group);` first in the body of a kernel whose first argument is `uint
   first_group`. A launch with NO_GROUPS does nothing: so the host makes OpenCL compile a kernel, for the widest launch
   it will need, before any work waits for it. The host uses NO_GROUPS alone; TAKE_GROUP is for the device. */
#ifndef TACTEL_SHARED_GROUP_H
#define TACTEL_SHARED_GROUP_H

#include "shared/interleaved.h"

#define NO_GROUPS 0xffffffffu
#define TAKE_GROUP(group)               \
  if (first_group == NO_GROUPS) return; \
  const size_t group = first_group + get_global_id(0)

/* Where a group's rows begin in an array of `rows` vectors a group, [groups / INTERLEAVED][row][INTERLEAVED]: the next
   row lies INTERLEAVED farther. A vector holds neighbours already; where an item is a scalar, its neighbours' numbers
   lie beside its own. */
#if LANES == 1
#define INTERLEAVED INTERLEAVED_SCALARS
#else
#define INTERLEAVED 1
#endif
#define FIRST_NUMBER(group, rows) ((group) / INTERLEAVED * (rows)*INTERLEAVED + (group) % INTERLEAVED)

#endif
