// SPDX-License-Identifier: Apache-2.0
/* Status of the evaluation of a frame: nn::FrameStatus, for host and device. */
#ifndef TACTEL_SHARED_FRAME_STATUS_H
#define TACTEL_SHARED_FRAME_STATUS_H

#define FRAME_OK 0
#define FRAME_NO_STRESS 1  /* scaling by the frame's own stress found none; the network received zeros */
#define FRAME_NOT_FINITE 2 /* the frame holds NaN or infinity; S is NaN */
#define FRAME_OVERFLOW 3   /* a sum inside the network was not finite; S is NaN */

#define FRAME_UNLIKE 4 /* added to one of these: the frame is unlike those of the learning set (nn::Bound) */

#define TOUCHING_SHARE 0.05f   /* nn::Bound::touching_share */
#define SMALLEST_STRESS 1e-12f /* MPa: less is no stress (scaling by frame) */
#define LEAST_DIVISOR 0.2f     /* nn::least_divisor of features */

/* Above LARGE_STRESS [MPa] the reciprocal of a stress is no normal number in fp32, and devices may flush it to zero.
   Such a frame is first multiplied by LARGE_SCALE, a power of two, which keeps its bits. */
#define LARGE_STRESS 0x1p126f
#define LARGE_SCALE 0x1p-8f
#define REST_SCALE 0x1p-10f /* times which inputs with a rest are taken */

#define USUAL_FRICTION 0.5f /* nn::usual_friction */
#define USUAL_SPREAD 0.1f   /* nn::usual_spread */

#endif
