// SPDX-License-Identifier: Apache-2.0
/* Settings of the transducer chain in the kernel's terms; nn::Transducer holds them in the user's. */
#ifndef TACTEL_SHARED_CHAIN_SETTINGS_H
#define TACTEL_SHARED_CHAIN_SETTINGS_H
#include "shared/scalars.h"

/* A share of the stress that arrives late, of a sensor evenly between the two; decay and pass as below, where all
   sensors have one time. */
typedef struct LateShare {
  float share[2];
  float time[2]; /* s */
  float decay, pass;
} LateShare;

typedef struct ChainSettings {
  shared_u64 reading_seed, instance_seed;
  shared_u32 instances;   /* sensors of which a contact meets one; 0: each its own */
  float decay, pass;      /* y = decay y_before + pass (x - x_before), where all sensors have one time constant */
  float step_time;        /* s */
  float time_constant[2]; /* s; of a sensor, evenly between the two; alike: decay and pass hold; 0: no high-pass */
  float gain_spread[2];   /* about 1; of a sensor, evenly between the two */
  float shear_gain[2];    /* natural logarithm of the gain of all axes but the first, alike; both 0: 1 */
  float offset_spread[2]; /* MPa, alike */
  float noise[2];         /* MPa, alike */
  float noise_of_largest; /* over the contact's largest stress */
  float drift[2];         /* over the contact's largest normal stress; of a sensor, evenly between the two */
  float repeats[2];       /* probability, alike */
  float mixing[2];        /* share of another axis of the tactel, alike */
  float shift_spread;     /* distances of two tactels */
  float crosstalk;        /* share of each neighbour's stress */
  float dead;             /* probability */
  LateShare late[2];      /* x less share h, h = decay h_before + pass (x - x_before) */
  float low, high;        /* readings are cut off there: in quanta where there are any, else in MPa; may be infinite */
  float quantum;          /* MPa; 0: none */
  shared_i32 bits[2];     /* of a sensor, a whole number from the first to the second; alike: low, high, quantum hold */
  float range;            /* MPa */
} ChainSettings;

#endif
