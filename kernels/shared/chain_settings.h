// SPDX-License-Identifier: Apache-2.0
/* Settings of the transducer chain in the kernel's terms; nn::Transducer holds them in the user's. */
#ifndef TACTEL_SHARED_CHAIN_SETTINGS_H
#define TACTEL_SHARED_CHAIN_SETTINGS_H
#include "shared/scalars.h"

typedef struct ChainSettings {
  shared_u64 reading_seed, instance_seed;
  shared_u32 instances; /* sensors of which a contact meets one; 0: each its own */
  shared_i32 high_pass; /* 1: there is one */
  float decay, pass;    /* y = decay y_before + pass (x - x_before) */
  float gain_spread;    /* about 1 */
  float offset_spread;  /* MPa */
  float noise;          /* MPa */
  float low, high;      /* readings are cut off there: in quanta where there are any, else in MPa; may be infinite */
  float quantum;        /* MPa; 0: none */
} ChainSettings;

#endif
