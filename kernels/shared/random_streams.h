// SPDX-License-Identifier: Apache-2.0
/* Purpose of a draw, in kernels: nn::RandomStream, for host and device. */
#ifndef TACTEL_SHARED_RANDOM_STREAMS_H
#define TACTEL_SHARED_RANDOM_STREAMS_H

#define ORDER_STREAM 2    /* order of the patterns in a cycle */
#define READING_STREAM 6  /* noise of a reading */
#define GAIN_STREAM 7     /* gain and offset of a transducer */
#define INSTANCE_STREAM 8 /* which sensor a contact meets */
#define SPREAD_STREAM 10  /* how much a sensor's transducers spread */
#define FAULT_STREAM 11   /* place, crosstalk, mixing and failure of a transducer */
#define FRAME_STREAM 12   /* drift and repeated frames of a contact */

#endif
