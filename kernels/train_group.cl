// SPDX-License-Identifier: Apache-2.0
/* Pattern-by-pattern training on a GPU: the rule of train_online.cl, where a work-group trains one network
   (shared/network_group.h). The bits of a network depend on nothing but the network. */
// defines: INPUTS=42 HIDDEN1=42 HIDDEN2=21 OUTPUTS=1 LEAKY_RELU=0 GROUP_ITEMS=64
#include "shared/network_group.h"

#if LANES == 1
/* As train_online, without `vectors`; order: [networks of the launch][rows]. A launch has GROUP_ITEMS groups, one item
   each, for a slot. */
WHOLE_GROUP kernel void train_group(uint first_group, global real *weights, global OnlineReport *reports,
                                    global real *curve, global uint *order, global const uint *slots,
                                    global const ulong *seeds, global const real *inputs, global const uint *set_of,
                                    global const real *targets, uint rows, uint most_cycles, uint cycle_limit,
                                    int permuted, real rate, real momentum, real stop_error) {
  TAKE_GROUP(group);
  local GroupValues values;
  local int status;
  const uint network = slots[group / GROUP_ITEMS];
  if (network == NO_NETWORK || reports[network].status != ONLINE_RUNNING) return;
  const int l = (int)(group % GROUP_ITEMS);
  const Learning how = {.rate = rate, .momentum = momentum};
  global real *own = weights + (size_t)network * (2 * NUMBERS);
  inputs += (size_t)set_of[network] * (rows + 1) * (INPUTS + 1);
  order += group / GROUP_ITEMS * rows;
  const uint done_before = reports[network].cycle;
  ItemWeights item;
  take_weights(&item, l, own, own + NUMBERS);
  clear_values(&values, l);
  for (uint at = l; at < rows; at += GROUP_ITEMS) order[at] = at;
  ROLLED for (uint done = 0; done < most_cycles; ++done) {
    BARRIER(&values, ALL_MEMORY);
    if (permuted && l == 0) shuffle(order, rows, seeds[network], done_before + done);
    BARRIER(&values, ALL_MEMORY);
    real sse, largest;
    learn_rows(&how, &item, &values, l, inputs, targets, order, rows, &sse, &largest);
    if (l == 0) {
      global OnlineReport *report = reports + network;
      global real *point = curve + ((size_t)network * most_cycles + done) * 2;
      report->sse = point[0] = sse;
      report->largest = point[1] = largest;
      report->cycle = done_before + done + 1;
      report->status = status = status_after(sse, largest, report->cycle, cycle_limit, stop_error);
    }
    BARRIER(&values, CLK_LOCAL_MEM_FENCE);
    if (status != ONLINE_RUNNING) break;
  }
  keep_weights(&item, l, own, own + NUMBERS);
}
#endif
