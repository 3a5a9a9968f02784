// SPDX-License-Identifier: Apache-2.0
/* Places in the one argument of the kernel `forward_one`, an array of its precision. */
#ifndef TACTEL_SHARED_ONE_FRAME_H
#define TACTEL_SHARED_ONE_FRAME_H

#define ONE_SLIP_INDEX 0 /* S: the answer */
#define ONE_STATUS 1     /* status of the frame: FRAME_OK, ... */
#define ONE_BY_FRAME 2   /* 1: scaled by the frame's own largest |normal stress|; 0: by a factor */
#define ONE_FACTOR 3     /* that factor, 1/MPa */
#define ONE_UPPER 4      /* upper and lower quantile of S, of networks with their heads */
#define ONE_LOWER 5
#define ONE_FRAME 16 /* the frame, MPa, in whole vectors of lanes, zeros behind its end; the weights follow */

#endif
