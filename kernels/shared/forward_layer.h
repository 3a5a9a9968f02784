// SPDX-License-Identifier: Apache-2.0
/* One layer of a network with frames in the lanes. forward.cl and train_batch.cl share it, so that training and recall
   compute equal bits.
     z_j = b_j, then z_j = fma(w_ji, o_i, z_j) for i = 0, 1, ...;  o_j = f(z_j). Device only. */
#ifndef TACTEL_SHARED_FORWARD_LAYER_H
#define TACTEL_SHARED_FORWARD_LAYER_H
#include "shared/activation.h"
#include "shared/network_work.h"
#include "shared/unroll.h"

#define ROWS (sizeof(vreal) == 64 ? 7 : 6) /* ROWS times FRAME_VECTORS sums and a few operands fill the registers */

/* Sums of a block of neurons: a<r> of neuron r for the frames in vector 0; b<r> of neuron r for those in vector 1, or,
   where only vector 0 holds frames, of neuron ROWS + r for them. They are named variables, as PoCL keeps an array of
   them on the stack before and after the loop. */
#define EACH_ROW(DO) DO(0, a0, b0) DO(1, a1, b1) DO(2, a2, b2) DO(3, a3, b3) DO(4, a4, b4) DO(5, a5, b5) DO(6, a6, b6)
#define ROWS_TOGETHER(vectors) ((vectors) == 1 ? 2 * ROWS : ROWS)
#define B_ROW(r) (vectors == 1 ? ROWS + r : r)
#define WEIGHT(r, k) ALL_LANES(w[(r)*stride + (k)])
#define START_ROW(r, a, b)                                           \
  vreal a = r < ROWS && r < rows ? WEIGHT(r, fan_in) : ALL_LANES(0); \
  vreal b = r < ROWS && B_ROW(r) < rows ? WEIGHT(B_ROW(r), fan_in) : ALL_LANES(0);
#define ADD_INPUT(r, a, b)                                     \
  if (r < ROWS && r < rows) a = fma(WEIGHT(r, k), x[k][0], a); \
  if (r < ROWS && B_ROW(r) < rows) b = fma(WEIGHT(B_ROW(r), k), x[k][vectors - 1], b);
#if REAL_IS_DOUBLE /* the library's tanh is long: the block's share one */
#define END_ROW(r, a, b)                 \
  if (r < ROWS && r < rows) o[r][0] = a; \
  if (r < ROWS && B_ROW(r) < rows) o[B_ROW(r)][vectors - 1] = b;
#else
#define END_ROW(r, a, b)                                    \
  if (r < ROWS && r < rows) o[r][0] = hidden_activation(a); \
  if (r < ROWS && B_ROW(r) < rows) o[B_ROW(r)][vectors - 1] = hidden_activation(b);
#endif

/* `rows` neurons, at most ROWS_TOGETHER, of a layer with `fan_in` inputs. w: [rows][stride], the bias at fan_in. */
INLINE void forward_rows(const int vectors, const int rows, const int fan_in, const int stride, global const real *w,
                         const vreal (*x)[FRAME_VECTORS], vreal (*o)[FRAME_VECTORS]) {
  EACH_ROW(START_ROW);
  ROLLED for (int k = 0; k < fan_in; ++k) { EACH_ROW(ADD_INPUT); }
  EACH_ROW(END_ROW);
#if REAL_IS_DOUBLE
  ROLLED for (int r = 0; r < rows; ++r) {
    EACH(v, vectors) { o[r][v] = hidden_activation(o[r][v]); }
  }
#endif
}

/* The layer for the frames in the first `vectors` vectors, 1 or FRAME_VECTORS. */
INLINE void forward_layer(const int vectors, const int fan_in, const int fan_out, const int stride,
                          global const real *w, const vreal (*x)[FRAME_VECTORS], vreal (*o)[FRAME_VECTORS]) {
  const int together = ROWS_TOGETHER(vectors), rest = fan_out % together;
  ROLLED for (int n = 0; n + together <= fan_out; n += together)
      forward_rows(vectors, together, fan_in, stride, w + n * stride, x, o + n);
  if (rest) forward_rows(vectors, rest, fan_in, stride, w + (fan_out - rest) * stride, x, o + fan_out - rest);
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
