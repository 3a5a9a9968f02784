// SPDX-License-Identifier: Apache-2.0
/* Mini-batch training on a GPU: the rule of train_batch.cl, where a work-group has a network (shared/network_group.h).
   Sums over a slice run row by row. The bits of a network depend on nothing but the network. */
// defines: INPUTS=42 HIDDEN1=42 HIDDEN2=21 OUTPUTS=3 LEAKY_RELU=0 GROUP_ITEMS=64
#include "shared/network_group.h"

#if LANES == 1
/* As train_batch; a launch has GROUP_ITEMS groups, one item each, for a slice. */
WHOLE_GROUP kernel void train_group_batch(uint first_group, global real *weights, global real *first,
                                          global real *second, global real *mean, global real *sums,
                                          global real *errors, global const real *factors, global const real *inputs,
                                          global const uint *set_of, global const real *targets,
                                          global const uint *order, uint rows, uint network, uint slices, uint slice,
                                          uint begin, uint batch, uint batches, int changes, int absolute, real level,
                                          int adam, real momentum, real beta1, real beta2, real epsilon) {
  TAKE_GROUP(group);
  local GroupValues values;
  const Rule rule = {adam, momentum, beta1, beta2, epsilon};
  const Learning how = {.summed = 1, .rate = 1, .absolute = absolute, .level = level};
  const uint place = (uint)(group / GROUP_ITEMS), from = place % slices * slice;
  const int l = (int)(group % GROUP_ITEMS);
  network += place / slices;
  const size_t at = (size_t)network * NUMBERS;
  inputs += (size_t)set_of[network] * (rows + 1) * (INPUTS + 1);
  order += (size_t)network * rows;
  sums += (size_t)place * NUMBERS;
  errors += (size_t)place * batches * 2;
  clear_values(&values, l);
  ROLLED for (uint b = 0; b < batches; ++b, begin += batch) {
    const uint count = min(batch, rows - begin);
    ItemWeights item;
    take_weights(&item, l, weights + at, 0);
    BARRIER(&values, ALL_MEMORY);
    real sse, largest;
    learn_rows(&how, &item, &values, l, inputs, targets, order + begin + from, min(slice, count - from), &sse,
               &largest);
    if (l == 0) errors[2 * b] = sse, errors[2 * b + 1] = largest;
    keep_weights(&item, l, 0, sums);
    if (!changes) return;
    BARRIER(&values, ALL_MEMORY);
    const real share = 1 / (real)count;
    ROLLED for (int i = l; i < NUMBERS; i += GROUP_ITEMS) {
      const size_t k = at + i;
      update_vector(&rule, sums[i] * share, weights + k, first + k, second + k, mean + k, factors + 4 * b);
    }
    BARRIER(&values, ALL_MEMORY);
  }
}
#endif
