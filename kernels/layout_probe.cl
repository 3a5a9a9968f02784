// SPDX-License-Identifier: Apache-2.0

// Writes sizes and offsets of the shared structs as this device sees them, in the order of SHARED_LAYOUT.
#include "shared/group.h"
#include "shared/layout.h"

#define PUT_SIZE(S) numbers[k++] = (uint)sizeof(S);
#define PUT_OFFSET(S, field)                                                      \
  {                                                                               \
    S probe;                                                                      \
    numbers[k++] = (uint)((private char *)&probe.field - (private char *)&probe); \
  }

/* numbers: [structs + fields], bytes */
kernel void layout_probe(uint first_group, global uint *numbers) {
  TAKE_GROUP(group);
  uint k = 0;
  if (group == 0) {
    SHARED_LAYOUT(PUT_SIZE, PUT_OFFSET)
  }
}
