// SPDX-License-Identifier: Apache-2.0
/* Logarithm of the density of readings under every frame of a bank (nn/frame_likelihood.h has the model). A reading x of a contact with the
   frames f has the residual r = x - f. With gains of variance g and i = 1 / sigma a transducer adds
     -1/2 i^2 (r.r - g i^2 (r.f)^2 / D) = -1/2 i^2 (|r - a f|^2 + a (r.f) / D),  D = 1 + g i^2 f.f,  a = g i^2 (r.f) / D,
   where the dots go over the frames of the history (Sherman, Morrison 1950), and a is the likeliest gain error. The second form has no difference of
   large terms. What does not depend on the reading is the row's constant.
   A work-item takes LIKELIHOOD_VECTORS vectors of rows and LIKELIHOOD_READINGS readings. A number of the bank is thus loaded once for all of them.

   Built with -D REAL, LANES, INPUTS, HISTORY. */
// defines: INPUTS=42 HISTORY=1
#include "shared/group.h"
#include "shared/lanes.h"
#include "shared/likelihood_layout.h"
#include "shared/unroll.h"

/* bank:     [vectors][INPUTS][HISTORY][LANES] f, MPa
   rows:     [vectors][2][LANES] 1 / sigma^2 in 1/MPa^2, constant
   readings: [reading_groups][INPUTS][HISTORY][LIKELIHOOD_READINGS] MPa
   out:      [reading_groups * LIKELIHOOD_READINGS][vectors * LANES] */
kernel void frame_likelihood(uint first_group, global const vreal *bank, global const vreal *rows, global const real *readings, global real *out,
                             uint vectors, uint reading_groups, real gain2) {
  TAKE_GROUP(group);
  const uint tile = (uint)(group / reading_groups), reading_group = (uint)(group % reading_groups);
  const uint first = tile * LIKELIHOOD_VECTORS, end = min(first + LIKELIHOOD_VECTORS, vectors);
  readings += (size_t)reading_group * (INPUTS * HISTORY * LIKELIHOOD_READINGS);
  for (uint v = first; v < end; ++v) {
    global const vreal *f = bank + (size_t)v * (INPUTS * HISTORY);
    const vreal over_variance = rows[2 * v], of_row = rows[2 * v + 1];
    vreal sum[LIKELIHOOD_READINGS];
    EACH(q, LIKELIHOOD_READINGS) { sum[q] = 0; }
    ROLLED for (int t = 0; t < INPUTS; ++t) {
      vreal rf[LIKELIHOOD_READINGS], gain[LIKELIHOOD_READINGS];
      vreal ff = 0;
      EACH(q, LIKELIHOOD_READINGS) { rf[q] = 0; }
      ROLLED for (int at = t * HISTORY; at < (t + 1) * HISTORY; ++at) {
        const vreal frame = f[at];
        ff = fma(frame, frame, ff);
        EACH(q, LIKELIHOOD_READINGS) { rf[q] = fma(ALL_LANES(readings[at * LIKELIHOOD_READINGS + q]) - frame, frame, rf[q]); }
      }
      const vreal over_d = 1 / fma(gain2 * over_variance, ff, ALL_LANES(1));
      EACH(q, LIKELIHOOD_READINGS) {
        gain[q] = gain2 * over_variance * rf[q] * over_d;
        sum[q] = fma(gain[q] * rf[q], over_d, sum[q]);
      }
      ROLLED for (int at = t * HISTORY; at < (t + 1) * HISTORY; ++at) {
        const vreal frame = f[at];
        EACH(q, LIKELIHOOD_READINGS) {
          const vreal r = fma(-gain[q], frame, ALL_LANES(readings[at * LIKELIHOOD_READINGS + q]) - frame);
          sum[q] = fma(r, r, sum[q]);
        }
      }
    }
    global real *answer = out + ((size_t)reading_group * LIKELIHOOD_READINGS * vectors + v) * LANES;
    EACH(q, LIKELIHOOD_READINGS) { STORE(fma((real)-0.5 * over_variance, sum[q], of_row), answer + (size_t)q * vectors * LANES); }
  }
}
