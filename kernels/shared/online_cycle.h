// SPDX-License-Identifier: Apache-2.0
/* What a cycle of online training begins and ends with: the order of the rows, and the stop rules. Device only. */
#ifndef TACTEL_SHARED_ONLINE_CYCLE_H
#define TACTEL_SHARED_ONLINE_CYCLE_H
#include "shared/lanes.h"
#include "shared/online_report.h"
#include "shared/philox.h"
#include "shared/random_streams.h"
#include "shared/unroll.h"

/* Weights of a network in memory, [layer][out][in + 1]. */
#define LAST (HIDDEN2 ? HIDDEN2 : HIDDEN1) /* width of the last hidden layer */
#define COUNT1 (HIDDEN1 * (INPUTS + 1))
#define COUNT2 (HIDDEN2 * (HIDDEN1 + 1))
#define NETWORK_WEIGHTS (COUNT1 + COUNT2 + LAST + 1)

/* Fisher and Yates' shuffle of the rows for one cycle, as nn/presentation_order.h describes it. */
INLINE void shuffle(global uint *order, uint rows, ulong seed, uint cycle) {
  for (uint row = 0; row < rows; ++row) order[row] = row;
  vuint index;
  for (uint lane = 0; lane < LANES; ++lane) ((uint *)&index)[lane] = lane;
  for (uint first = 0; first + 1 < rows; first += 4 * LANES) {
    const RandomWords words = random_words(seed, ORDER_STREAM, index, cycle);
    index += (vuint)(LANES);
    const uint end = min(first + 4 * LANES, rows - 1);
    for (uint step = first; step < end; ++step) {
      const uint word = ((const uint *)&words.word[step % 4])[(step - first) / 4];
      const uint i = rows - 1 - step, j = mul_hi(word, i + 1);
      const uint row = order[i];
      order[i] = order[j];
      order[j] = row;
    }
  }
}

/* The stop rules of nn/train_online.cpp. */
INLINE int status_after(real sse, real largest, uint cycle, uint cycle_limit, real stop_error) {
  if (!isfinite(sse)) return ONLINE_NOT_FINITE;
  if (largest < stop_error) return ONLINE_LEARNT;
  return cycle >= cycle_limit ? ONLINE_CYCLE_LIMIT : ONLINE_RUNNING;
}

#endif
