// SPDX-License-Identifier: Apache-2.0
/* Shape of the work of frame_likelihood. */
#ifndef TACTEL_SHARED_LIKELIHOOD_LAYOUT_H
#define TACTEL_SHARED_LIKELIHOOD_LAYOUT_H
#define LIKELIHOOD_READINGS 8 /* readings that share each loaded number of the bank */
#define LIKELIHOOD_VECTORS 16 /* vectors of rows of the bank in a group */
#endif
