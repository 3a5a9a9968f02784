// SPDX-License-Identifier: Apache-2.0
/* One layer of a network with frames in the lanes. forward.cl and train_batch.cl share it, so that training and recall compute equal bits.
     z_j = b_j, then z_j = fma(w_ji, o_i, z_j) for i = 0, 1, ...;  o_j = f(z_j). Device only. */
#ifndef TACTEL_SHARED_FORWARD_LAYER_H
#define TACTEL_SHARED_FORWARD_LAYER_H
#include "shared/activation.h"
#include "shared/network_work.h"
#include "shared/unroll.h"

#define ROWS (sizeof(vreal) == 64 ? 7 : 6) /* neurons taken together: ROWS times FRAME_VECTORS sums and a few operands fill the registers */

/* `rows` neurons from n on of a layer with `fan_in` inputs; w: [out][stride], the bias at fan_in. */
INLINE void forward_rows(const int rows, const int fan_in, const int stride, int n, global const real *w, const vreal (*x)[FRAME_VECTORS],
                         vreal (*o)[FRAME_VECTORS]) {
  vreal z[ROWS][FRAME_VECTORS];
  w += n * stride;
  EACH(r, rows) {
    EACH(v, FRAME_VECTORS) { z[r][v] = ALL_LANES(w[r * stride + fan_in]); }
  }
  ROLLED for (int k = 0; k < fan_in; ++k) {
    EACH(r, rows) {
      EACH(v, FRAME_VECTORS) { z[r][v] = fma(ALL_LANES(w[r * stride + k]), x[k][v], z[r][v]); }
    }
  }
  EACH(r, rows) {
    EACH(v, FRAME_VECTORS) { o[n + r][v] = z[r][v]; }
  }
  ROLLED for (int r = 0; r < rows; ++r) {
    EACH(v, FRAME_VECTORS) { o[n + r][v] = hidden_activation(o[n + r][v]); }
  }
}

INLINE void forward_layer(const int fan_in, const int fan_out, const int stride, global const real *w, const vreal (*x)[FRAME_VECTORS],
                          vreal (*o)[FRAME_VECTORS]) {
  ROLLED for (int n = 0; n + ROWS <= fan_out; n += ROWS) forward_rows(ROWS, fan_in, stride, n, w, x, o);
  if (fan_out % ROWS) forward_rows(fan_out % ROWS, fan_in, stride, fan_out - fan_out % ROWS, w, x, o);
}

/* The output neuron for the frames in vector v, in four sums: (0 + 1) + (2 + 3). */
INLINE vreal forward_output(const int fan_in, global const real *w, const vreal (*o)[FRAME_VECTORS], int v) {
  vreal sum[4] = {ALL_LANES(w[fan_in]), 0, 0, 0};
  ROLLED for (int k = 0; k + 4 <= fan_in; k += 4) {
    EACH(i, 4) { sum[i] = fma(ALL_LANES(w[k + i]), o[k + i][v], sum[i]); }
  }
  EACH(i, fan_in % 4) { sum[i] = fma(ALL_LANES(w[fan_in - fan_in % 4 + i]), o[fan_in - fan_in % 4 + i][v], sum[i]); }
  return activation((sum[0] + sum[1]) + (sum[2] + sum[3]));
}

#endif
