/* How the kernels of networks share out their work, for them and for the host that launches them. */
#ifndef TACTEL_SHARED_NETWORK_WORK_H
#define TACTEL_SHARED_NETWORK_WORK_H

#define FRAME_VECTORS 2        /* vectors of LANES frames that forward and train_batch take together */
#define UPDATE_VECTORS 16      /* vectors of weights that a work-item of batch_update takes */
#define NO_NETWORK 0xffffffffu /* in a slot of train_online that is free */

#endif
