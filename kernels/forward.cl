// SPDX-License-Identifier: Apache-2.0
/* Slippage index S of frames, and its quantiles where the network has their heads: scaling, network, shift by 0.5.
   Frames are in the lanes. A frame has equal bits in a batch of any size and at any position, and those of
   nn/infer/layers.h.

   Built with -D REAL, LANES, INPUTS, HIDDEN1, HIDDEN2 (0: one hidden layer), OUTPUTS (3: S, its upper and its lower
   quantile), LEAKY_RELU (1: hidden neurons are leaky rectifiers), and NORMALS where they are not INPUTS / 2: the normal
   stresses of the first frame. */
// defines: INPUTS=42 HIDDEN1=42 HIDDEN2=21 OUTPUTS=3 LEAKY_RELU=0
#include "shared/forward_layer.h"
#include "shared/frame_status.h"
#include "shared/group.h"
#include "shared/lane_sums.h"
#include "shared/transpose.h"

#ifndef NORMALS
#define NORMALS (INPUTS / 2)
#endif
#define TILE (FRAME_VECTORS * LANES) /* frames in a group */
#define LAST (HIDDEN2 ? HIDDEN2 : HIDDEN1)
#define LAYER1 (HIDDEN1 * (INPUTS + 1))
#define LAYER2 (HIDDEN2 * (HIDDEN1 + 1))
#define NETWORK_WEIGHTS (LAYER1 + LAYER2 + OUTPUTS * (LAST + 1))
#define V1 VECTORS_OF(HIDDEN1)
#define V2 VECTORS_OF(HIDDEN2)

#if LANES == 1
#define LOAD_FLOATS(p) ((real) * (p))
#else
#define LOAD_FLOATS(p) JOIN(convert_, JOIN(REAL, LANES))(JOIN(vload, LANES)(0, p))
#endif

/* Asks a processor for memory that the next group reads. */
#if LANES > 1 && (defined(__x86_64__) || defined(__aarch64__))
#define PREFETCH(p) __builtin_prefetch((const void *)(size_t)(p))
#else
#define PREFETCH(p)
#endif

/* Conversion of frames in MPa to inputs. */
typedef struct {
  int by_frame; /* divide by the frame's own largest |normal stress|; else by the set's largest stress */
  real factor;  /* 1 / the set's largest stress, 1/MPa */
} Scaling;

/* NaN or infinite where any of the numbers was. */
INLINE vreal note_not_finite(vreal noted, vreal x) { return fma(x, ALL_LANES(0), noted); }

/* Loads LANES frames from `first` on, times `factor`: x[k] is input k of each. Lanes beyond the last row repeat it.
   Returns the lanes whose frames are not finite. */
INLINE vint load_frames(global const float *frames, uint first, uint rows, vreal factor, int v,
                        vreal (*x)[FRAME_VECTORS]) {
  vreal noted[4] = {0, 0, 0, 0};
#if INPUTS >= LANES
  first = min(first, rows - 1);
  global const float *from = frames + (size_t)first * INPUTS;
  const uint last = rows - 1 - first;
  uint place[LANES];
  EACH(lane, LANES) { place[lane] = min((uint)lane, last) * INPUTS; }
  ROLLED for (int begin = 0; begin < INPUTS; begin += LANES) {
    const int column = min(begin, INPUTS - LANES); /* the last block overlaps the one before */
    vreal block[LANES];
    EACH(lane, LANES) { block[lane] = LOAD_FLOATS(from + place[lane] + column); }
    EACH(lane, LANES) { PREFETCH(from + place[lane] + column + TILE * INPUTS); }
    transpose(block);
    EACH(k, LANES) {
      noted[k % 4] = note_not_finite(noted[k % 4], block[k]);
      x[column + k][v] = block[k] * factor;
    }
  }
#else
  for (int k = 0; k < INPUTS; ++k) {
    vreal input;
    for (uint lane = 0; lane < LANES; ++lane)
      ((real *)&input)[lane] = frames[(size_t)min(first + lane, rows - 1) * INPUTS + k];
    noted[k % 4] = note_not_finite(noted[k % 4], input);
    x[k][v] = input * factor;
  }
#endif
  const vreal sum = (noted[0] + noted[1]) + (noted[2] + noted[3]);
  return sum != sum;
}

/* Scales LANES frames in MPa by the frame's own largest normal stress. Returns the lanes that carry no stress. */
INLINE vint scale_by_frame(int v, vreal (*x)[FRAME_VECTORS]) {
  vreal most[4] = {0, 0, 0, 0};
  UNROLL for (int k = 0; k < NORMALS; ++k) most[k % 4] = fmax(most[k % 4], fabs(x[k][v]));
  vreal largest = fmax(fmax(most[0], most[1]), fmax(most[2], most[3]));
  const vint large = largest > ALL_LANES(LARGE_STRESS);
  if (ANY(large)) {
    const vreal scale = PICK(large, ALL_LANES(LARGE_SCALE), ALL_LANES(1));
    ROLLED for (int k = 0; k < INPUTS; ++k) x[k][v] *= scale;
    largest *= scale;
  }
  const vreal factor = ALL_LANES(1) / largest;
  ROLLED for (int k = 0; k < INPUTS; ++k) x[k][v] *= factor;
  return largest < ALL_LANES(SMALLEST_STRESS);
}

/* The scaled inputs of LANES frames; a frame that is not finite or carries no stress becomes zeros and has a status. */
INLINE vint scaled_frames(global const float *frames, uint first, uint rows, Scaling scaling, int v,
                          vreal (*x)[FRAME_VECTORS]) {
  const vint not_finite =
      load_frames(frames, first, rows, ALL_LANES(scaling.by_frame ? (real)1 : scaling.factor), v, x);
  vint no_stress = 0;
  if (scaling.by_frame) no_stress = scale_by_frame(v, x);
  const vint zero = not_finite | no_stress;
  if (ANY(zero)) {
    ROLLED for (int k = 0; k < INPUTS; ++k) x[k][v] = PICK(zero, ALL_LANES(0), x[k][v]);
  }
  return PICK(not_finite, (vint)(FRAME_NOT_FINITE), PICK(no_stress, (vint)(FRAME_NO_STRESS), (vint)(FRAME_OK)));
}

/* Writes the answer to a frame: NaN and a status where it has none. */
INLINE real answer(real s, int status_before, int *status) {
  *status = status_before == FRAME_OK && isnan(s) ? FRAME_OVERFLOW : status_before;
  return status_before == FRAME_NOT_FINITE ? (real)NAN : s;
}

/* S, its upper and its lower quantile from the outputs of the last layer (nn/quantile_heads.h); in place. All are NaN
   where one is. One output: S alone. */
INLINE void quantiles(vreal *o) {
  EACH(h, OUTPUTS) { o[h] = o[h] + ALL_LANES(0.5f); }
#if OUTPUTS > 1
  o[1] = o[0] + o[1];
  o[2] = o[0] - o[2];
  const vreal none = ((o[0] + o[1]) + o[2]) * ALL_LANES(0);
  EACH(h, OUTPUTS) { o[h] += none; }
#endif
}

/* Outputs of the hidden layers for the frames in the first `vectors` vectors; `last` is o1 of a network with one of
   them. */
INLINE void hidden_layers(const int vectors, global const real *w, const vreal (*x)[FRAME_VECTORS],
                          vreal (*o1)[FRAME_VECTORS], vreal (*last)[FRAME_VECTORS]) {
  forward_layer(vectors, INPUTS, HIDDEN1, INPUTS + 1, w, x, o1);
#if HIDDEN2
  forward_layer(vectors, HIDDEN1, HIDDEN2, HIDDEN1 + 1, w + LAYER1, o1, last);
#else
  (void)last;
#endif
}

/* Group g: tile g % tiles of the frames, for network g / tiles.
   weights: [networks][NETWORK_WEIGHTS], each [layer][out][in + 1] with the bias last
   frames:  [rows][INPUTS] MPa, normal stresses first
   slip_index: [networks][OUTPUTS][rows];  status: [networks][rows] */
kernel void forward(uint first_group, global const real *weights, global const float *frames, global real *slip_index,
                    global uchar *status, uint rows, uint tiles, int by_frame, real factor) {
  TAKE_GROUP(group);
  const size_t network = group / tiles;
  const uint first = (uint)(group % tiles) * TILE, end = min(first + TILE, rows);
  global const real *w = weights + network * NETWORK_WEIGHTS;
  const Scaling scaling = {by_frame, factor};
  slip_index += network * OUTPUTS * rows;
  status += network * rows;
  vreal x[INPUTS][FRAME_VECTORS], o1[HIDDEN1][FRAME_VECTORS];
  vint found[FRAME_VECTORS];
  const int vectors = LANES > 1 && end - first <= LANES ? 1 : FRAME_VECTORS;
  ROLLED for (int v = 0; v < vectors; ++v) found[v] = scaled_frames(frames, first + v * LANES, rows, scaling, v, x);
#if HIDDEN2
  vreal last[HIDDEN2][FRAME_VECTORS];
#else
  vreal(*last)[FRAME_VECTORS] = o1;
#endif
  if (vectors == 1)
    hidden_layers(1, w, x, o1, last);
  else
    hidden_layers(FRAME_VECTORS, w, x, o1, last);
  ROLLED for (int v = 0; v < vectors; ++v) {
    vreal s[OUTPUTS];
    EACH(h, OUTPUTS) { s[h] = forward_output(LAST, w + LAYER1 + LAYER2 + h * (LAST + 1), last, v); }
    quantiles(s);
    const uint begin = first + v * LANES;
    for (uint lane = 0, row = begin; lane < LANES && row < end; ++lane, ++row) {
      const int before = ((const REAL_INT *)&found[v])[lane];
      int final_status;
      EACH(h, OUTPUTS) { slip_index[h * rows + row] = answer(((const real *)&s[h])[lane], before, &final_status); }
      status[row] = (uchar)final_status;
    }
  }
}
