// SPDX-License-Identifier: Apache-2.0
/* Slippage index S of frames, and its quantiles or its bound where the network has their heads: scaling, network, shift
   by 0.5, bound. Frames are in the lanes. A frame has equal bits in a batch of any size and at any position, and those
   of nn/infer/layers.h and nn/infer/bound.cpp.

   Built with -D REAL, LANES, INPUTS, HIDDEN1, HIDDEN2 (0: one hidden layer), OUTPUTS (3: S, its upper and its lower
   quantile), LEAKY_RELU (1: hidden neurons are leaky rectifiers), BOUND (1: the bound instead of the quantiles), and
   NORMALS where they are not INPUTS / 2: the normal stresses of the first frame; with features (0: none) or RESTED (1:
   the last frame is the rest, to which the others become differences) or TOLD (2: mu and its spread follow the frames)
   STRESSES, the numbers of an input in MPa, and SHOWN, its frames without the rest; with features what
   shared/features.h names. */
// defines: INPUTS=42 HIDDEN1=42 HIDDEN2=21 OUTPUTS=3 LEAKY_RELU=0 BOUND=1
#include "shared/forward_layer.h"
#include "shared/frame_status.h"
#include "shared/group.h"
#include "shared/lane_sums.h"
#include "shared/transpose.h"

#ifndef NORMALS
#define NORMALS (INPUTS / 2)
#endif
#ifndef STRESSES
#define STRESSES INPUTS
#define SHOWN 1
#endif
#ifndef RESTED
#define RESTED 0
#endif
#ifndef TOLD
#define TOLD 0
#endif
#define NUMBERS (STRESSES + TOLD)
#define FRAME_NUMBERS (STRESSES / (SHOWN + RESTED))
#if FEATURES
#include "shared/features.h"
#endif
#define TILE (FRAME_VECTORS * LANES)  /* frames in a group */
#define ANSWERS (BOUND ? 4 : OUTPUTS) /* numbers of a frame: S; upper and lower quantile, or upper bound and interval */
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
  int by_frame; /* divide by the frame's own largest |normal stress|; else take times the factor */
  real factor;  /* 1 / the set's largest stress, 1/MPa; by the rest REST_SCALE */
  real usual;   /* usual peak, MPa, of features */
} Scaling;

/* NaN or infinite where any of the numbers was. */
INLINE vreal note_not_finite(vreal noted, vreal x) { return fma(x, ALL_LANES(0), noted); }

/* Loads LANES frames from `first` on, times `factor`: x[k] is input k of each. Lanes beyond the last row repeat it.
   Returns the lanes whose frames are not finite. */
INLINE vint load_frames(global const float *frames, uint first, uint rows, vreal factor, int v,
                        vreal (*x)[FRAME_VECTORS]) {
  vreal noted[4] = {0, 0, 0, 0};
#if NUMBERS >= LANES
  first = min(first, rows - 1);
  global const float *from = frames + (size_t)first * NUMBERS;
  const uint last = rows - 1 - first;
  uint place[LANES];
  EACH(lane, LANES) { place[lane] = min((uint)lane, last) * NUMBERS; }
  ROLLED for (int begin = 0; begin < NUMBERS; begin += LANES) {
    const int column = min(begin, NUMBERS - LANES); /* the last block overlaps the one before */
    vreal block[LANES];
    EACH(lane, LANES) { block[lane] = LOAD_FLOATS(from + place[lane] + column); }
    EACH(lane, LANES) { PREFETCH(from + place[lane] + column + TILE * NUMBERS); }
    transpose(block);
    EACH(k, LANES) {
      noted[k % 4] = note_not_finite(noted[k % 4], block[k]);
      x[column + k][v] = TOLD && column + k >= STRESSES ? block[k] : block[k] * factor;
    }
  }
#else
  for (int k = 0; k < NUMBERS; ++k) {
    vreal input;
    for (uint lane = 0; lane < LANES; ++lane)
      ((real *)&input)[lane] = frames[(size_t)min(first + lane, rows - 1) * NUMBERS + k];
    noted[k % 4] = note_not_finite(noted[k % 4], input);
    x[k][v] = TOLD && k >= STRESSES ? input : input * factor;
  }
#endif
  const vreal sum = (noted[0] + noted[1]) + (noted[2] + noted[3]);
  return sum != sum;
}

/* Scales LANES frames in MPa by the frame's own largest normal stress, the peak. Returns the lanes that carry no stress. */
INLINE vint scale_by_frame(int v, vreal (*x)[FRAME_VECTORS], vreal *peak) {
  vreal most[4] = {0, 0, 0, 0};
  UNROLL for (int k = 0; k < NORMALS; ++k) most[k % 4] = fmax(most[k % 4], fabs(x[k][v]));
  vreal largest = fmax(fmax(most[0], most[1]), fmax(most[2], most[3]));
  *peak = largest;
  const vint large = largest > ALL_LANES(LARGE_STRESS);
  if (ANY(large)) {
    const vreal scale = PICK(large, ALL_LANES(LARGE_SCALE), ALL_LANES(1));
    ROLLED for (int k = 0; k < STRESSES; ++k) x[k][v] *= scale;
    largest *= scale;
  }
  const vreal factor = ALL_LANES(1) / largest;
  ROLLED for (int k = 0; k < STRESSES; ++k) x[k][v] *= factor;
  return largest < ALL_LANES(SMALLEST_STRESS);
}

#if RESTED
/* Differences of LANES inputs' frames, times REST_SCALE, to their rest, over its P. Returns the lanes whose rest has none. */
INLINE vint scale_by_rest(int v, vreal (*x)[FRAME_VECTORS]) {
  const vreal(*rest)[FRAME_VECTORS] = x + SHOWN * FRAME_NUMBERS;
  vreal P = 0;
  ROLLED for (int k = 0; k < NORMALS; ++k) P = P - rest[k][v];
  const vreal factor = ALL_LANES(1) / P;
  ROLLED for (int k = 0; k < SHOWN * FRAME_NUMBERS; ++k) x[k][v] = (x[k][v] - rest[k % FRAME_NUMBERS][v]) * factor;
  return NOT(P >= ALL_LANES(SMALLEST_STRESS * REST_SCALE));
}
#endif

/* The scaled inputs of LANES frames; a frame that is not finite or carries no stress becomes zeros and has a status. */
INLINE vint scaled_frames(global const float *frames, uint first, uint rows, Scaling scaling, int v,
                          vreal (*x)[FRAME_VECTORS]) {
  const vint not_finite =
      load_frames(frames, first, rows, ALL_LANES(scaling.by_frame ? (real)1 : scaling.factor), v, x);
  vint no_stress = 0;
  vreal peak = 0;
#if TOLD
  const vreal mu = x[STRESSES][v], spread = x[STRESSES + 1][v];
#endif
#if RESTED
  no_stress = scale_by_rest(v, x);
#else
  if (scaling.by_frame) no_stress = scale_by_frame(v, x, &peak);
#endif
#if FEATURES
  add_features(v, peak, scaling.usual, x);
#endif
#if TOLD /* nn::tell_friction */
  const vint told = mu > ALL_LANES(0);
  x[INPUTS - 2][v] = PICK(told, mu / (mu + ALL_LANES(USUAL_FRICTION)), ALL_LANES(0.5f));
  x[INPUTS - 1][v] = PICK(told, spread / (spread + ALL_LANES(USUAL_SPREAD)), ALL_LANES(1));
#endif
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

#if BOUND
/* The bound of a network, numbers of host/networks/forward.cpp: tactels; the largest squared distance of a frame that is
   like the learning set's; edges of touching tactels, of S, of the quantiles' width, of the distance; then
   centre [INPUTS], whitening [columns / BOUND_COLUMNS][INPUTS][BOUND_COLUMNS] with zeros beyond its columns, the edges
   one after the other, corrections [classes] of the upper quantile and of the interval. */
#define BOUND_CENTRE (bound + 6)
#define BOUND_WHITENING (BOUND_CENTRE + INPUTS)
#define BOUND_EDGES (BOUND_WHITENING + (INPUTS + BOUND_COLUMNS - 1) / BOUND_COLUMNS * BOUND_COLUMNS * INPUTS)

/* nn::touching_tactels of scaled frames. */
INLINE vreal touching_tactels(global const real *bound, const vreal (*x)[FRAME_VECTORS], int v) {
  const int tactels = (int)bound[0];
  vreal largest = 0, touching = 0;
  ROLLED for (int k = 0; k < tactels; ++k) largest = LARGER(fabs(x[k][v]), largest);
  const vreal least = ALL_LANES(TOUCHING_SHARE) * largest;
  ROLLED for (int k = 0; k < tactels; ++k) touching += PICK(fabs(x[k][v]) > least, ALL_LANES(1), ALL_LANES(0));
  return touching;
}

/* nn::squared_distance of scaled frames, in its order: each product from 0 on by the inputs, and nothing is fused. */
INLINE vreal squared_distance(global const real *bound, const vreal (*x)[FRAME_VECTORS], int v) {
  global const real *w = BOUND_WHITENING;
  vreal sum = 0;
  ROLLED for (int first = 0; first < INPUTS; first += BOUND_COLUMNS) {
    vreal product[BOUND_COLUMNS] = {0};
    ROLLED for (int j = 0; j < INPUTS; ++j, w += BOUND_COLUMNS) {
      const vreal from_centre = x[j][v] - ALL_LANES(BOUND_CENTRE[j]);
      EACH(i, BOUND_COLUMNS) { product[i] += from_centre * ALL_LANES(w[i]); }
    }
    EACH(i, BOUND_COLUMNS) { sum += product[i] * product[i]; }
  }
  return PICK(sum != sum, ALL_LANES(INFINITY), sum); /* infinity less infinity */
}

/* Adds a feature to the classes of LANES frames: how many of its next edges are below the value. */
INLINE vreal classes_by(vreal classes, int count, global const real **edges, vreal value) {
  classes *= ALL_LANES(count + 1);
  ROLLED for (int i = 0; i < count; ++i) classes += PICK(value > ALL_LANES((*edges)[i]), ALL_LANES(1), ALL_LANES(0));
  *edges += count;
  return classes;
}

/* Each lane's number of a table. */
INLINE vreal looked_up(global const real *table, vreal places) {
  vreal found;
  for (int lane = 0; lane < LANES; ++lane) ((real *)&found)[lane] = table[(int)((const real *)&places)[lane]];
  return found;
}

/* nn::Bound::answer: S, its upper bound and its interval from S and its quantiles, in place. NaN stays. Returns the
   lanes whose frames are unlike those of the learning set. */
INLINE vint bounded(global const real *bound, const vreal (*x)[FRAME_VECTORS], int v, vreal *s) {
  const vreal median = s[0], above = s[1], below = s[2], distance = squared_distance(bound, x, v);
  global const real *tables = BOUND_EDGES;
  vreal classes = classes_by(ALL_LANES(0), (int)bound[2], &tables, touching_tactels(bound, x, v));
  classes = classes_by(classes, (int)bound[3], &tables, median);
  classes = classes_by(classes, (int)bound[4], &tables, above - below);
  classes = classes_by(classes, (int)bound[5], &tables, distance);
  const int all = ((int)bound[2] + 1) * ((int)bound[3] + 1) * ((int)bound[4] + 1) * ((int)bound[5] + 1);
  const vreal widening = looked_up(tables + all, classes);
  s[1] = above + looked_up(tables, classes);
  s[2] = below - widening;
  s[3] = above + widening;
  /* At most 1, where everything slides, and never on the wrong side of S. */
  for (int end = 1; end < ANSWERS; end += 2) {
    s[end] = PICK(s[end] < median, median, s[end]);
    s[end] = PICK(s[end] > ALL_LANES(1), ALL_LANES(1), s[end]);
  }
  s[2] = PICK(median < s[2], median, s[2]);
  s[2] = PICK(s[2] < ALL_LANES(-1), ALL_LANES(-1), s[2]);
  return NOT(distance <= ALL_LANES(bound[1]));
}
#endif

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
   frames:  [rows][NUMBERS] MPa, normal stresses first, and what is told
   bounds:  [networks][bound_numbers], see BOUND_CENTRE; unused without BOUND
   slip_index: [networks][ANSWERS][rows];  status: [networks][rows] FRAME_OK ..., plus FRAME_UNLIKE */
kernel void forward(uint first_group, global const real *weights, global const float *frames, global real *slip_index,
                    global uchar *status, uint rows, uint tiles, int by_frame, real factor, real usual,
                    global const real *bounds, uint bound_numbers) {
  TAKE_GROUP(group);
  const size_t network = group / tiles;
  const uint first = (uint)(group % tiles) * TILE, end = min(first + TILE, rows);
  global const real *w = weights + network * NETWORK_WEIGHTS;
  const Scaling scaling = {by_frame, factor, usual};
  slip_index += network * ANSWERS * rows;
  status += network * rows;
  vreal x[INPUTS > NUMBERS ? INPUTS : NUMBERS][FRAME_VECTORS], o1[HIDDEN1][FRAME_VECTORS];
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
    vreal s[ANSWERS];
    vint unlike = 0;
    EACH(h, OUTPUTS) { s[h] = forward_output(LAST, w + LAYER1 + LAYER2 + h * (LAST + 1), last, v); }
    quantiles(s);
#if BOUND
    unlike = bounded(bounds + network * bound_numbers, x, v, s);
#endif
    const uint begin = first + v * LANES;
    for (uint lane = 0, row = begin; lane < LANES && row < end; ++lane, ++row) {
      const int before = ((const REAL_INT *)&found[v])[lane];
      int final_status;
      EACH(h, ANSWERS) { slip_index[h * rows + row] = answer(((const real *)&s[h])[lane], before, &final_status); }
      status[row] = (uchar)(final_status | (((const REAL_INT *)&unlike)[lane] ? FRAME_UNLIKE : 0));
    }
  }
}
