// SPDX-License-Identifier: Apache-2.0
/* A work-group of GROUP_ITEMS items with a network in its registers, and what a row teaches it. Item l < HIDDEN1 has
   row l of the first layer, and column l of the second for the way back; item HIDDEN1 + n has row n of the second layer.
   Items of the last hidden layer have their weights into the outputs, all items the biases there. Values pass through
   local memory, [now, next] where one row's may still be read when the next one's are written. Device only.

   Built with -D REAL, LANES=1, INPUTS, HIDDEN1, HIDDEN2 (0: one hidden layer), OUTPUTS, LEAKY_RELU, and GROUP_ITEMS: above
   INPUTS, and at least HIDDEN1 + HIDDEN2. */
#ifndef TACTEL_SHARED_NETWORK_GROUP_H
#define TACTEL_SHARED_NETWORK_GROUP_H
#include "shared/batch_rule.h"
#include "shared/group.h"
#include "shared/network_work.h"
#include "shared/online_cycle.h"

#if LANES == 1
#define MOST_INPUTS (HIDDEN2 && HIDDEN1 > INPUTS ? HIDDEN1 : INPUTS) /* of an item's row */
#define OUT_PLACE(h, k) (COUNT1 + COUNT2 + (h) * (LAST + 1) + (k))   /* of a weight into output h; the bias at LAST */
#define NUMBERS OUT_PLACE(OUTPUTS, 0)                                /* weights of a network */
#define FOURS(n) (((n) + 3) / 4)
#define WHOLE_GROUP __attribute__((reqd_work_group_size(GROUP_ITEMS, 1, 1)))
/* Where all items meet. PoCL 3.1 takes a branch that directly follows a barrier for all items as one of them does: so
   something is read there, of which no compiler knows that it can wait. */
#define BARRIER(values, fences)                     \
  {                                                 \
    barrier(fences);                                \
    (void)*(volatile local int *)&(values)->unused; \
  }
#define ALL_MEMORY (CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE)

typedef JOIN(REAL, 4) real4;

/* Number k of local memory that is read four at a time. */
#define PART(v, k) \
  ((k) % 4 == 0 ? (v)[(k) / 4].x : (k) % 4 == 1 ? (v)[(k) / 4].y : (k) % 4 == 2 ? (v)[(k) / 4].z : (v)[(k) / 4].w)
/* Sum of factor(k) v[k], k < n, in four chains. */
#define SUM_OF(result, n, factor, v)                                     \
  {                                                                      \
    real chain[4] = {0, 0, 0, 0};                                        \
    EACH(k, n) { chain[k % 4] = fma(factor, PART(v, k), chain[k % 4]); } \
    (result) = (chain[0] + chain[1]) + (chain[2] + chain[3]);            \
  }

typedef struct {
  real w, s; /* weight; its last step, or its sum over a batch */
} Weight;

typedef struct {
  Weight row[MOST_INPUTS + 1], column[HIDDEN2 + 1], out[OUTPUTS], bias[OUTPUTS];
} ItemWeights;

/* inputs, outputs of the first layer, deltas of the second, terms of the outputs' sums */
typedef struct {
  real4 x[2][FOURS(MOST_INPUTS + 1)], o[2][FOURS(MOST_INPUTS + 1)], d[FOURS(HIDDEN2 + 1)], p[OUTPUTS][FOURS(LAST)];
  int unused;
} GroupValues;

INLINE int in_last(int l) { return HIDDEN2 ? l >= HIDDEN1 && l < HIDDEN1 + HIDDEN2 : l < HIDDEN1; }

/* Where number k of an item's row is in memory; -1: it has none. */
INLINE int row_place(int l, int k) {
  if (l < HIDDEN1) return k <= INPUTS ? l * (INPUTS + 1) + k : -1;
  return l < HIDDEN1 + HIDDEN2 && k <= HIDDEN1 ? COUNT1 + (l - HIDDEN1) * (HIDDEN1 + 1) + k : -1;
}

/* w, s: [NUMBERS]; without s, which begins at 0 */
INLINE Weight weight_at(global const real *w, global const real *s, int has, int place) {
  const Weight weight = {has ? w[place] : 0, has && s ? s[place] : 0};
  return weight;
}

INLINE void take_weights(ItemWeights *own, int l, global const real *w, global const real *s) {
  EACH(k, MOST_INPUTS + 1) { own->row[k] = weight_at(w, s, row_place(l, k) >= 0, row_place(l, k)); }
  EACH(k, HIDDEN2) { own->column[k] = weight_at(w, s, l < HIDDEN1, COUNT1 + k * (HIDDEN1 + 1) + l); }
  EACH(h, OUTPUTS) {
    own->out[h] = weight_at(w, s, in_last(l), OUT_PLACE(h, HIDDEN2 ? l - HIDDEN1 : l));
    own->bias[h] = weight_at(w, s, 1, OUT_PLACE(h, LAST));
  }
}

/* The same back; without w the s alone. */
INLINE void keep_weight(global real *w, global real *s, int place, Weight weight) {
  if (w) w[place] = weight.w;
  s[place] = weight.s;
}

INLINE void keep_weights(const ItemWeights *own, int l, global real *w, global real *s) {
  EACH(k, MOST_INPUTS + 1) {
    if (row_place(l, k) >= 0) keep_weight(w, s, row_place(l, k), own->row[k]);
  }
  EACH(h, OUTPUTS) {
    if (in_last(l)) keep_weight(w, s, OUT_PLACE(h, HIDDEN2 ? l - HIDDEN1 : l), own->out[h]);
    if (l == 0) keep_weight(w, s, OUT_PLACE(h, LAST), own->bias[h]);
  }
}

/* Before the first rows: 1 is what the second layer's bias reads. */
INLINE void clear_values(local GroupValues *v, int l) {
  for (int k = l; k < 4 * FOURS(MOST_INPUTS + 1); k += GROUP_ITEMS) {
    ((local real *)v->x[0])[k] = ((local real *)v->x[1])[k] = 0;
    ((local real *)v->o[0])[k] = ((local real *)v->o[1])[k] = k == HIDDEN1;
  }
}

/* How the rows are learnt. */
typedef struct {
  int summed; /* weights stay, and their descents are summed; else each row changes them */
  real rate, momentum;
  int absolute;
  real level;
} Learning;

INLINE void learn_weight(const Learning *how, Weight *weight, real delta, real o) {
  if (how->summed) {
    weight->s = fma(delta, o, weight->s);
  } else {
    weight->s = fma(how->momentum, weight->s, delta * o);
    weight->w += weight->s;
  }
}

/* Shows a network `count` rows, at least one, after a barrier. inputs: of its set; sse, largest: of all these rows. */
INLINE void learn_rows(const Learning *how, ItemWeights *own, local GroupValues *v, int l, global const real *inputs,
                       global const real *targets, global const uint *order, uint count, real *sse, real *largest) {
  const int first = l < HIDDEN1, last = in_last(l), second = last && !first, into_last = HIDDEN2 ? l - HIDDEN1 : l;
  *sse = *largest = 0;
  if (l <= INPUTS) ((local real *)v->x[0])[l] = inputs[(size_t)order[0] * (INPUTS + 1) + l];
  BARRIER(v, CLK_LOCAL_MEM_FENCE);
  int now = 0;
  ROLLED for (uint t = 0; t < count; ++t, now = !now) {
    const real x_next = t + 1 < count && l <= INPUTS ? inputs[(size_t)order[t + 1] * (INPUTS + 1) + l] : 0;
    const real target = targets[order[t]];
    local const real4 *x = v->x[now], *o1 = v->o[now];
    real o = 0, output[OUTPUTS], delta[OUTPUTS], g = 0;
    if (first) {
      SUM_OF(o, INPUTS + 1, own->row[k].w, x);
      o = hidden_activation(o);
    }
    if (HIDDEN2) {
      if (first) ((local real *)v->o[now])[l] = o;
      BARRIER(v, CLK_LOCAL_MEM_FENCE);
      if (second) {
        SUM_OF(o, HIDDEN1 + 1, own->row[k].w, o1);
        o = hidden_activation(o);
      }
    }
    EACH(h, OUTPUTS) {
      if (last) ((local real *)v->p[h])[into_last] = own->out[h].w * o;
    }
    BARRIER(v, CLK_LOCAL_MEM_FENCE);
    if (l <= INPUTS) ((local real *)v->x[!now])[l] = x_next;
    EACH(h, OUTPUTS) {
      SUM_OF(output[h], LAST, 1, v->p[h]);
      output[h] = activation(output[h] + own->bias[h].w);
    }
    const real error = target - output[0];
    *sse = fma(error, error, *sse);
    *largest = fmax(*largest, fabs(error));
    output_deltas(output, target, error, 1, how->absolute, how->level, delta);
    EACH(h, OUTPUTS) {
      const real step = how->rate * delta[h];
      learn_weight(how, &own->bias[h], step, 1);
      if (last) {
        g += step * (hidden_slope(o) * own->out[h].w);
        learn_weight(how, &own->out[h], step, o);
      }
    }
    if (second) ((local real *)v->d)[into_last] = g;
    BARRIER(v, CLK_LOCAL_MEM_FENCE);
    if (first && !last) {
      SUM_OF(g, HIDDEN2, own->column[k].w, v->d);
      g *= hidden_slope(o);
      EACH(k, HIDDEN2) { learn_weight(how, &own->column[k], PART(v->d, k), o); }
    }
    local const real4 *into_row = first ? x : o1;
    EACH(k, MOST_INPUTS + 1) { learn_weight(how, &own->row[k], g, PART(into_row, k)); }
  }
}
#endif

#endif
