// SPDX-License-Identifier: Apache-2.0
/* Layout of contacts on devices with one lane a work-item (GPUs): that many work-items keep their numbers side by side,
   so that neighbours read neighbouring numbers. */
#ifndef TACTEL_SHARED_INTERLEAVED_H
#define TACTEL_SHARED_INTERLEAVED_H

#define INTERLEAVED_SCALARS 64

#endif
