// SPDX-License-Identifier: Apache-2.0
/* How a batch changes a vector of weights, and the errors of a bound's heads. Device only. */
#ifndef TACTEL_SHARED_BATCH_RULE_H
#define TACTEL_SHARED_BATCH_RULE_H
#include "shared/activation.h"
#include "shared/unroll.h"

/* The rule's numbers; see nn::BatchOptions. */
typedef struct {
  int adam;
  real momentum, beta1, beta2, epsilon;
} Rule;

#if OUTPUTS > 1
/* -dL/dq of the pinball loss: level - [target < q]. */
INLINE vreal pinball_error(vreal target, vreal q, real level) {
  return PICK(target < q, ALL_LANES(level - 1), ALL_LANES(level));
}

#endif

/* The deltas of the output neurons, whose outputs are o: of one, or of a bound's three heads (nn/quantile_heads.h).
   target: S - 0.5; error: of o[0] to it; counts: 1, or 0 of lanes without a row; absolute: 1 for the absolute loss,
   whose error is a sign. */
INLINE void output_deltas(const vreal *o, vreal target, vreal error, vreal counts, int absolute, real level,
                          vreal *delta) {
#if OUTPUTS > 1
  (void)error, (void)absolute;
  const vreal upper = pinball_error(target, o[0] + (o[1] + (real)0.5), level);
  const vreal lower = pinball_error(target, o[0] - (o[2] + (real)0.5), 1 - level);
  const vreal errors[3] = {(pinball_error(target, o[0], (real)0.5) + upper) + lower, upper, -lower};
  EACH(h, 3) { delta[h] = errors[h] * counts * activation_slope(o[h]); }
#else
  (void)target, (void)counts, (void)level;
  delta[0] = (absolute ? sign(error) : error) * activation_slope(o[0]);
#endif
}

/* One vector of weights: descent is the mean over the batch.
   factors: [4] of the update: Adam's 1 / (1 - beta1^t) and 1 / (1 - beta2^t), the learning rate, and the share of the
   new weights in their mean; without a mean 0, and `mean` is not touched. */
INLINE void update_vector(const Rule *rule, vreal descent, global real *w, global real *first, global real *second,
                          global real *mean, global const real *factors) {
  const real rate = factors[2], share = factors[3];
  vreal m = LOAD(first), now;
  if (rule->adam) {
    m = fma(ALL_LANES(rule->beta1), m, (1 - rule->beta1) * descent);
    const vreal s = fma(ALL_LANES(rule->beta2), LOAD(second), (1 - rule->beta2) * descent * descent);
    STORE(s, second);
    now = LOAD(w) + rate * (m * factors[0]) / (sqrt(s * factors[1]) + rule->epsilon);
  } else {
    m = fma(ALL_LANES(rule->momentum), m, rate * descent);
    now = LOAD(w) + m;
  }
  STORE(now, w);
  STORE(m, first);
  if (share > 0) STORE(fma(ALL_LANES(share), now - LOAD(mean), LOAD(mean)), mean);
}

#endif
