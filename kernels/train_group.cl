// SPDX-License-Identifier: Apache-2.0
/* Pattern-by-pattern training on a GPU: the rule of train_online.cl, where a work-group of GROUP_ITEMS items trains one
   network, with all weights and steps in registers. Item l < HIDDEN1 has row l of the first layer, and column l of the
   second for the way back; item HIDDEN1 + n has row n of the second layer. Items of the last hidden layer have their
   weight into the output, all items its bias. Values pass through local memory, [now, next] where one pattern's may
   still be read when the next one's are written. The bits of a network depend on nothing but the network.

   Built with -D REAL, LANES=1, INPUTS, HIDDEN1, HIDDEN2 (0: one hidden layer), GROUP_ITEMS: above INPUTS, and at least
   HIDDEN1 + HIDDEN2. */
// defines: INPUTS=42 HIDDEN1=42 HIDDEN2=21 GROUP_ITEMS=64
#include "shared/activation.h"
#include "shared/group.h"
#include "shared/network_work.h"
#include "shared/online_cycle.h"

#define MOST_INPUTS (HIDDEN2 && HIDDEN1 > INPUTS ? HIDDEN1 : INPUTS) /* of an item's row */
#define FOURS(n) (((n) + 3) / 4)
#define WHOLE_GROUP __attribute__((reqd_work_group_size(GROUP_ITEMS, 1, 1)))
#define BARRIER barrier(CLK_LOCAL_MEM_FENCE)

#if LANES == 1
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
  real w, s; /* weight and last step */
} Weight;

INLINE Weight weight_at(global const real *network, int has, int place) {
  const Weight weight = {has ? network[place] : 0, has ? network[NETWORK_WEIGHTS + place] : 0};
  return weight;
}

INLINE void step_by(Weight *weight, real momentum, real delta) {
  weight->s = fma(momentum, weight->s, delta);
  weight->w += weight->s;
}

/* As train_online, without `vectors`; order: [networks of the launch][rows]. A launch has GROUP_ITEMS groups, one item
   each, for a slot. */
WHOLE_GROUP kernel void train_group(uint first_group, global real *weights, global OnlineReport *reports,
                                    global real *curve, global uint *order, global const uint *slots,
                                    global const ulong *seeds, global const real *inputs, global const uint *set_of,
                                    global const real *targets, uint rows, uint most_cycles, uint cycle_limit,
                                    int permuted, real rate, real momentum, real stop_error) {
  TAKE_GROUP(group);
  local real4 x_of[2][FOURS(MOST_INPUTS + 1)], p_of[FOURS(LAST)];
#if HIDDEN2
  local real4 o_of[2][FOURS(MOST_INPUTS + 1)], d_of[FOURS(HIDDEN2)];
#endif
  local int status;
  const uint network = slots[group / GROUP_ITEMS];
  if (network == NO_NETWORK || reports[network].status != ONLINE_RUNNING) return;
  const int l = (int)(group % GROUP_ITEMS), n = l - HIDDEN1, first = l < HIDDEN1, second = n >= 0 && n < HIDDEN2,
            in_last = HIDDEN2 ? second : first, into_last = HIDDEN2 ? n : l;
  global real *own = weights + (size_t)network * (2 * NETWORK_WEIGHTS);
  inputs += (size_t)set_of[network] * (rows + 1) * (INPUTS + 1);
  order += group / GROUP_ITEMS * rows;
  const uint done_before = reports[network].cycle;

#define ROW_PLACE(k) \
  (first && (k) <= INPUTS ? l * (INPUTS + 1) + (k) : second && (k) <= HIDDEN1 ? COUNT1 + n * (HIDDEN1 + 1) + (k) : -1)
  Weight row[MOST_INPUTS + 1], column[HIDDEN2 + 1];
  EACH(k, MOST_INPUTS + 1) { row[k] = weight_at(own, ROW_PLACE(k) >= 0, ROW_PLACE(k)); }
  EACH(k, HIDDEN2) { column[k] = weight_at(own, first, COUNT1 + k * (HIDDEN1 + 1) + l); }
  Weight out = weight_at(own, in_last, COUNT1 + COUNT2 + into_last), bias = weight_at(own, 1, NETWORK_WEIGHTS - 1);

  for (int k = l; k < 4 * FOURS(MOST_INPUTS + 1); k += GROUP_ITEMS) {
    ((local real *)x_of[0])[k] = ((local real *)x_of[1])[k] = 0;
#if HIDDEN2
    ((local real *)o_of[0])[k] = ((local real *)o_of[1])[k] = k == HIDDEN1;
#endif
  }
  for (uint at = l; at < rows; at += GROUP_ITEMS) order[at] = at;
  int now = 0;
  ROLLED for (uint done = 0; done < most_cycles; ++done) {
    barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
    if (permuted && l == 0) shuffle(order, rows, seeds[network], done_before + done);
    barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
    if (l <= INPUTS) ((local real *)x_of[now])[l] = inputs[(size_t)order[0] * (INPUTS + 1) + l];
    BARRIER;
    real sse = 0, largest = 0;
    ROLLED for (uint t = 0; t < rows; ++t, now = !now) {
      const real x_next = t + 1 < rows && l <= INPUTS ? inputs[(size_t)order[t + 1] * (INPUTS + 1) + l] : 0;
      const real target = targets[order[t]];
      local const real4 *x = x_of[now];
      real o = 0, output, g = 0;
      if (first) {
        SUM_OF(o, INPUTS + 1, row[k].w, x);
        o = activation(o);
      }
#if HIDDEN2
      local const real4 *o1 = o_of[now];
      if (first) ((local real *)o_of[now])[l] = o;
      BARRIER;
      if (second) {
        SUM_OF(o, HIDDEN1 + 1, row[k].w, o1);
        o = activation(o);
      }
#endif
      if (in_last) ((local real *)p_of)[into_last] = out.w * o;
      BARRIER;
      if (l <= INPUTS) ((local real *)x_of[!now])[l] = x_next;
      SUM_OF(output, LAST, 1, p_of);
      output = activation(output + bias.w);
      const real error = target - output, step = rate * (error * activation_slope(output));
      sse = fma(error, error, sse);
      largest = fmax(largest, fabs(error));
      step_by(&bias, momentum, step);
      if (in_last) {
        g = step * (activation_slope(o) * out.w);
        step_by(&out, momentum, step * o);
      }
#if HIDDEN2
      if (second) ((local real *)d_of)[n] = g;
      BARRIER;
      if (first) {
        SUM_OF(g, HIDDEN2, column[k].w, d_of);
        g *= activation_slope(o);
        EACH(k, HIDDEN2) { step_by(&column[k], momentum, PART(d_of, k) * o); }
      }
      local const real4 *into_row = first ? x : o1;
#else
      local const real4 *into_row = x;
#endif
      EACH(k, MOST_INPUTS + 1) { step_by(&row[k], momentum, g * PART(into_row, k)); }
#if !HIDDEN2
      BARRIER;
#endif
    }
    if (l == 0) {
      global OnlineReport *report = reports + network;
      global real *point = curve + ((size_t)network * most_cycles + done) * 2;
      report->sse = point[0] = sse;
      report->largest = point[1] = largest;
      report->cycle = done_before + done + 1;
      report->status = status = status_after(sse, largest, report->cycle, cycle_limit, stop_error);
    }
    BARRIER;
    if (status != ONLINE_RUNNING) break;
  }
#define KEEP(place, weight) own[place] = (weight).w, own[NETWORK_WEIGHTS + (place)] = (weight).s
  EACH(k, MOST_INPUTS + 1) {
    if (ROW_PLACE(k) >= 0) KEEP(ROW_PLACE(k), row[k]);
  }
  if (in_last) KEEP(COUNT1 + COUNT2 + into_last, out);
  if (l == 0) KEEP(NETWORK_WEIGHTS - 1, bias);
}
#endif
