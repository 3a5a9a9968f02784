// SPDX-License-Identifier: Apache-2.0
/* Division of the work in the kernels of networks, for kernels and host. */
#ifndef TACTEL_SHARED_NETWORK_WORK_H
#define TACTEL_SHARED_NETWORK_WORK_H

#define FRAME_VECTORS 2        /* vectors of LANES frames that forward and train_batch take together */
#define BOUND_COLUMNS 8        /* columns of a bound's whitening that forward takes together */
#define UPDATE_VECTORS 16      /* vectors of weights that a work-item of batch_update takes */
#define MOST_GROUP_ITEMS 128   /* of a work-group of train_group */
#define NO_NETWORK 0xffffffffu /* in a slot of train_online that is free */

#endif
