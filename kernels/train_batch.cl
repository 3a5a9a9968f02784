// SPDX-License-Identifier: Apache-2.0
/* Mini-batch training. Each batch gives the mean of delta_j o_i, the descent of each weight, and one change of the
   weights: by the delta rule with momentum, or by Adam (Kingma and Ba 2015, algorithm 1). Twin of nn/train_batch.cpp.

   Frames are in the lanes, a tile of FRAME_VECTORS LANES of them at a time. The outer products have a layer's inputs in
   the lanes and need no sum over lanes. Sums run over the frames of a slice one by one, then over slices in order. No
   result therefore depends on the number of threads.

   Two kernels:
     train_batch   batches of at most one slice, many of them in one launch, where a work-item trains a network; or the
                   slices of a larger batch, a work-item each
     batch_update  the sum over slices and the change of the weights; a work-item takes some of the weights

   A network's numbers: [layer][out][padded row], a padded row having fan_in weights, the bias and zeros up to whole
   vectors. Built with -D REAL, LANES, INPUTS, HIDDEN1, HIDDEN2 (0: one hidden layer), OUTPUTS (3: quantile heads, with
   the pinball loss), LEAKY_RELU (1: hidden neurons are leaky rectifiers). */
// defines: INPUTS=42 HIDDEN1=42 HIDDEN2=21 OUTPUTS=3 LEAKY_RELU=0
#include "shared/batch_rule.h"
#include "shared/forward_layer.h"
#include "shared/group.h"
#include "shared/lane_sums.h"
#include "shared/transpose.h"

#define TILE (FRAME_VECTORS * LANES)
#define LAST (HIDDEN2 ? HIDDEN2 : HIDDEN1)
#define ROW0 (VECTORS_OF(INPUTS + 1) * LANES)  /* padded rows: of inputs */
#define ROW1 (VECTORS_OF(HIDDEN1 + 1) * LANES) /* of first hidden layer outputs */
#define ROWL (VECTORS_OF(LAST + 1) * LANES)    /* of last hidden layer outputs */
#define LAYER2 (HIDDEN1 * ROW0)                /* where layers begin */
#define LAYER3 (LAYER2 + (HIDDEN2 ? HIDDEN2 * ROW1 : 0))
#define NUMBERS (LAYER3 + OUTPUTS * ROWL)                                 /* in a network */
#define UPDATES ((NUMBERS / LANES + UPDATE_VECTORS - 1) / UPDATE_VECTORS) /* work-items of a network's batch_update */
#define OUTER_ROWS (sizeof(vreal) == 64 ? 7 : 3) /* rows and vectors of an outer product that are summed together */
#define OUTER_VECTORS 3

/* Data of a tile. Lanes beyond the slice's end hold the row of zeros and have no error. */
typedef struct {
  int frames, vectors;                                /* that the tile holds; vectors of them, 1 or FRAME_VECTORS */
  real rows[TILE * ROW0];                             /* [frame][ROW0] inputs, then 1 for the bias, zeros */
  vreal target[FRAME_VECTORS], counts[FRAME_VECTORS]; /* S - 0.5; 1 where there is a frame, 0 where there is none */
  vreal x[ROW0][FRAME_VECTORS];                       /* the same, a frame in a lane */
  vreal o1[ROW1][FRAME_VECTORS], d1[HIDDEN1][FRAME_VECTORS];
#if HIDDEN2
  vreal o2[HIDDEN2][FRAME_VECTORS], d2[HIDDEN2][FRAME_VECTORS];
  real o1_rows[TILE * ROW1];
#endif
  vreal d_out[OUTPUTS][FRAME_VECTORS];
} Tile;

#if HIDDEN2
/* `numbers` columns, whole vectors, of a tile: a frame in a lane becomes a frame in a row. */
INLINE void frames_to_rows(const int vectors, const int numbers, const vreal (*columns)[FRAME_VECTORS], real *rows) {
  ROLLED for (int v = 0; v < vectors; ++v) {
    ROLLED for (int begin = 0; begin < numbers; begin += LANES) {
      vreal block[LANES];
      EACH(k, LANES) { block[k] = columns[begin + k][v]; }
      transpose(block);
      EACH(lane, LANES) { STORE(block[lane], rows + (v * LANES + lane) * numbers + begin); }
    }
  }
}
#endif

/* inputs: [rows + 1][ROW0]; shown: [count], which rows; zero_row: the row of zeros. */
INLINE void load_tile(Tile *tile, global const real *inputs, global const real *targets, global const uint *shown,
                      uint count, uint zero_row) {
  tile->frames = (int)min(count, (uint)TILE);
  tile->vectors = LANES > 1 && count <= LANES ? 1 : FRAME_VECTORS;
  global const real *from[TILE];
  ROLLED for (uint f = 0; f < (uint)tile->vectors * LANES; ++f) {
    const uint row = f < count ? shown[f] : zero_row;
    from[f] = inputs + (size_t)row * ROW0;
    ((real *)tile->target)[f] = targets[row];
  }
  EACH(v, FRAME_VECTORS) { tile->counts[v] = 1; }
  for (int f = tile->frames; f < tile->vectors * LANES; ++f) ((real *)tile->counts)[f] = 0;
  ROLLED for (int v = 0; v < tile->vectors; ++v) {
    ROLLED for (int begin = 0; begin < ROW0; begin += LANES) {
      vreal block[LANES];
      EACH(lane, LANES) {
        block[lane] = LOAD(from[v * LANES + lane] + begin);
        STORE(block[lane], tile->rows + (v * LANES + lane) * ROW0 + begin);
      }
      transpose(block);
      EACH(k, LANES) { tile->x[begin + k][v] = block[k]; }
    }
  }
}

#if HIDDEN2
/* back_k = sum_n w_nk d_n for `rows` neurons k, at most ROWS_TOGETHER; times the slope there. w: [fan_out][stride],
   from neuron k on. */
#define START_BACK(r, a, b) vreal a = 0, b = 0;
#define ADD_DELTA(r, a, b)                                                     \
  if (r < ROWS && r < rows) a = fma(ALL_LANES(w[n * stride + r]), d[n][0], a); \
  if (r < ROWS && B_ROW(r) < rows) b = fma(ALL_LANES(w[n * stride + B_ROW(r)]), d[n][vectors - 1], b);
#define END_BACK(r, a, b)                                              \
  if (r < ROWS && r < rows) d_below[r][0] = hidden_slope(o[r][0]) * a; \
  if (r < ROWS && B_ROW(r) < rows) d_below[B_ROW(r)][vectors - 1] = hidden_slope(o[B_ROW(r)][vectors - 1]) * b;
INLINE void backward_rows(const int vectors, const int rows, const int fan_out, const int stride, global const real *w,
                          const vreal (*d)[FRAME_VECTORS], const vreal (*o)[FRAME_VECTORS],
                          vreal (*d_below)[FRAME_VECTORS]) {
  EACH_ROW(START_BACK);
  ROLLED for (int n = 0; n < fan_out; ++n) { EACH_ROW(ADD_DELTA); }
  EACH_ROW(END_BACK);
}

INLINE void backward_layer(const int vectors, const int fan_in, const int fan_out, const int stride,
                           global const real *w, const vreal (*d)[FRAME_VECTORS], const vreal (*o)[FRAME_VECTORS],
                           vreal (*d_below)[FRAME_VECTORS]) {
  const int together = ROWS_TOGETHER(vectors), rest = fan_in % together, begin = fan_in - rest;
  ROLLED for (int k = 0; k < begin; k += together)
      backward_rows(vectors, together, fan_out, stride, w + k, d, o + k, d_below + k);
  if (rest) backward_rows(vectors, rest, fan_out, stride, w + begin, d, o + begin, d_below + begin);
}
#endif

/* sums[r][k] += d[r][f] x[f][k] over the tile's frames, for `rows` rows and `vectors` vectors of k; the sums begin at 0
   with the first tile. d: [rows][TILE]; x: [TILE][stride]; sums: [rows][stride]. */
INLINE void outer_block(int begins, int frames, const int rows, const int vectors, const int stride, const real *d,
                        const real *x, global real *sums) {
  vreal sum[OUTER_ROWS][OUTER_VECTORS];
  if (begins) {
    EACH(r, rows) {
      EACH(v, vectors) { sum[r][v] = 0; }
    }
  } else {
    EACH(r, rows) {
      EACH(v, vectors) { sum[r][v] = LOAD(sums + r * stride + v * LANES); }
    }
  }
  ROLLED for (int f = 0; f < frames; ++f) {
    vreal input[OUTER_VECTORS];
    EACH(v, vectors) { input[v] = LOAD(x + f * stride + v * LANES); }
    EACH(r, rows) {
      EACH(v, vectors) { sum[r][v] = fma(ALL_LANES(d[r * TILE + f]), input[v], sum[r][v]); }
    }
  }
  EACH(r, rows) {
    EACH(v, vectors) { STORE(sum[r][v], sums + r * stride + v * LANES); }
  }
}

/* The same for every k. */
INLINE void outer_rows(int begins, int frames, const int rows, const int stride, const real *d, const real *x,
                       global real *sums) {
  const int vectors = stride / LANES, rest = vectors % OUTER_VECTORS, begin = (vectors - rest) * LANES;
  ROLLED for (int k = 0; k + OUTER_VECTORS * LANES <= stride; k += OUTER_VECTORS * LANES) {
    outer_block(begins, frames, rows, OUTER_VECTORS, stride, d, x + k, sums + k);
  }
  if (rest) outer_block(begins, frames, rows, rest, stride, d, x + begin, sums + begin);
}

/* The same for every row: the descent of a layer's weights. d: [fan_out][FRAME_VECTORS]. */
INLINE void outer_layer(int begins, int frames, const int fan_out, const int stride, const vreal (*d)[FRAME_VECTORS],
                        const real *x, global real *sums) {
  ROLLED for (int n = 0; n + OUTER_ROWS <= fan_out; n += OUTER_ROWS) {
    outer_rows(begins, frames, OUTER_ROWS, stride, (const real *)(d + n), x, sums + n * stride);
  }
  const int rest = fan_out - fan_out % OUTER_ROWS;
  if (fan_out % OUTER_ROWS)
    outer_rows(begins, frames, fan_out % OUTER_ROWS, stride, (const real *)(d + rest), x, sums + rest * stride);
}

/* An output neuron's: sums[k] += sum over frames of d_out o_k; the bias at LAST. */
INLINE void outer_output(int begins, int vectors, const vreal (*o)[FRAME_VECTORS], const vreal *d_out,
                         global real *sums) {
  ROLLED for (int begin = 0; begin < ROWL; begin += LANES) {
    vreal product[LANES];
    ROLLED for (int i = 0; i < LANES; ++i) {
      product[i] = 0;
      if (begin + i < LAST) {
        for (int v = 0; v < vectors; ++v) product[i] = fma(o[begin + i][v], d_out[v], product[i]);
      } else if (begin + i == LAST) {
        for (int v = 0; v < vectors; ++v) product[i] += d_out[v];
      }
    }
    const vreal before = begins ? ALL_LANES(0) : LOAD(sums + begin);
    STORE(before + lane_sums(product), sums + begin);
  }
}

/* Outputs of the hidden layers for the tile's frames. */
INLINE void forward_tile(const int vectors, Tile *t, global const real *w) {
  forward_layer(vectors, INPUTS, HIDDEN1, ROW0, w, t->x, t->o1);
#if HIDDEN2
  forward_layer(vectors, HIDDEN1, HIDDEN2, ROW1, w + LAYER2, t->o1, t->o2);
#endif
}

/* Forward, errors, backward, outer products of one tile. errors: sum of squares and largest, by lane. begins: 1 for the
   slice's first tile. */
INLINE void learn_tile(int begins, Tile *t, global const real *w, global real *sums, vreal *errors, int absolute,
                       real level) {
  const int vectors = t->vectors;
  if (LANES > 1 && vectors == 1)
    forward_tile(1, t, w);
  else
    forward_tile(FRAME_VECTORS, t, w);
#if HIDDEN2
  const vreal(*last)[FRAME_VECTORS] = t->o2;
  vreal(*d_last)[FRAME_VECTORS] = t->d2;
#else
  const vreal(*last)[FRAME_VECTORS] = t->o1;
  vreal(*d_last)[FRAME_VECTORS] = t->d1;
#endif
  for (int v = 0; v < vectors; ++v) {
    vreal output[OUTPUTS], delta[OUTPUTS];
    EACH(h, OUTPUTS) { output[h] = forward_output(LAST, w + LAYER3 + h * ROWL, last, v); }
    const vreal error = (t->target[v] - output[0]) * t->counts[v];
    errors[0] = fma(error, error, errors[0]);
    errors[1] = fmax(errors[1], fabs(error));
    output_deltas(output, t->target[v], error, t->counts[v], absolute, level, delta);
    EACH(h, OUTPUTS) { t->d_out[h][v] = delta[h]; }
  }
  ROLLED for (int k = 0; k < LAST; ++k) {
    for (int v = 0; v < vectors; ++v) {
      vreal back = ALL_LANES(w[LAYER3 + k]) * t->d_out[0][v];
      EACH(h, OUTPUTS - 1) { back = fma(ALL_LANES(w[LAYER3 + (h + 1) * ROWL + k]), t->d_out[h + 1][v], back); }
      d_last[k][v] = hidden_slope(last[k][v]) * back;
    }
  }
#if HIDDEN2
  if (LANES > 1 && vectors == 1)
    backward_layer(1, HIDDEN1, HIDDEN2, ROW1, w + LAYER2, t->d2, t->o1, t->d1);
  else
    backward_layer(FRAME_VECTORS, HIDDEN1, HIDDEN2, ROW1, w + LAYER2, t->d2, t->o1, t->d1);
  ROLLED for (int k = HIDDEN1; k < ROW1; ++k) {
    for (int v = 0; v < vectors; ++v) t->o1[k][v] = ALL_LANES(k == HIDDEN1);
  }
  frames_to_rows(vectors, ROW1, t->o1, t->o1_rows);
  outer_layer(begins, t->frames, HIDDEN2, ROW1, t->d2, t->o1_rows, sums + LAYER2);
#endif
  outer_layer(begins, t->frames, HIDDEN1, ROW0, t->d1, t->rows, sums);
  EACH(h, OUTPUTS) { outer_output(begins, vectors, last, t->d_out[h], sums + LAYER3 + h * ROWL); }
}

/* Sums over the frames of one slice, [NUMBERS], and its errors, [2]. */
static __attribute__((noinline)) void learn_slice(global const real *w, global const real *inputs,
                                                  global const real *targets, global const uint *shown, uint count,
                                                  uint zero_row, global real *sums, global real *errors, int absolute,
                                                  real level) {
  Tile tile;
  vreal lane_errors[2] = {0, 0};
  for (uint first = 0; first < count; first += TILE) {
    load_tile(&tile, inputs, targets, shown + first, count - first, zero_row);
    learn_tile(first == 0, &tile, w, sums, lane_errors, absolute, level);
  }
  errors[0] = lane_sum(lane_errors[0]);
  errors[1] = 0;
  for (int lane = 0; lane < LANES; ++lane) errors[1] = fmax(errors[1], ((const real *)(lane_errors + 1))[lane]);
}

/* Learns from slice `group % slices` of each of `batches` batches, for the network `group / slices` behind `network`.
   weights, first, second, mean: [networks][NUMBERS], changed in place; first: last change or first moment; second:
            second moment; mean: of the weights
   sums:    [groups][NUMBERS], of the last batch
   errors:  [groups][batches][2], sum of squared errors and largest error of each slice, as it was shown
   factors: [batches][4], see update_vector
   inputs:  [sets][rows + 1][ROW0], scaled, 1 at place INPUTS, then zeros; row `rows` all zeros
   set_of:  [networks]
   targets: [rows + 1], S - 0.5; the last unused
   order:   [networks][rows], rows as this epoch shows them; the first batch begins at place `begin`
   changes: 1 where a batch is one slice, and changes the weights; else batch_update does, after one batch
   level:   of the upper quantile, where OUTPUTS is 3 */
kernel void train_batch(uint first_group, global real *weights, global real *first, global real *second,
                        global real *mean, global real *sums, global real *errors, global const real *factors,
                        global const real *inputs, global const uint *set_of, global const real *targets,
                        global const uint *order, uint rows, uint network, uint slices, uint slice, uint begin,
                        uint batch, uint batches, int changes, int absolute, real level, int adam, real momentum,
                        real beta1, real beta2, real epsilon) {
  TAKE_GROUP(group);
  const Rule rule = {adam, momentum, beta1, beta2, epsilon};
  network += group / slices;
  const size_t at = (size_t)network * NUMBERS;
  inputs += (size_t)set_of[network] * (rows + 1) * ROW0;
  order += (size_t)network * rows;
  sums += group * NUMBERS;
  errors += group * batches * 2;
  for (uint b = 0; b < batches; ++b, begin += batch) {
    const uint count = min(batch, rows - begin), from = (uint)(group % slices) * slice;
    learn_slice(weights + at, inputs, targets, order + begin + from, min(slice, count - from), rows, sums,
                errors + 2 * b, absolute, level);
    const real share = 1 / (real)count;
    ROLLED for (size_t i = 0; changes && i < NUMBERS; i += LANES) {
      const size_t k = at + i;
      update_vector(&rule, LOAD(sums + i) * share, weights + k, first + k, second + k, mean + k, factors + 4 * b);
    }
  }
}

/* Some UPDATE_VECTORS vectors of the weights of a network, after the batch's `slices` slices; a launch takes the
   networks from `network` on, whose slices are side by side in `sums`. factors: [4]. */
kernel void batch_update(uint first_group, global real *weights, global real *first, global real *second,
                         global real *mean, global const real *sums, uint network, uint slices, uint rows, uint begin,
                         uint batch, global const real *factors, int adam, real momentum, real beta1, real beta2,
                         real epsilon) {
  TAKE_GROUP(group);
  const Rule rule = {adam, momentum, beta1, beta2, epsilon};
  const size_t place = group / UPDATES, at = (network + place) * NUMBERS;
  const size_t start = group % UPDATES * UPDATE_VECTORS * LANES;
  const size_t end = min(start + UPDATE_VECTORS * LANES, (size_t)NUMBERS);
  const real share = 1 / (real)min(batch, rows - begin);
  sums += place * slices * NUMBERS;
  ROLLED for (size_t i = start; i < end; i += LANES) {
    vreal sum = LOAD(sums + i);
    for (uint s = 1; s < slices; ++s) sum += LOAD(sums + s * NUMBERS + i);
    update_vector(&rule, sum * share, weights + at + i, first + at + i, second + at + i, mean + at + i, factors);
  }
}
