// SPDX-License-Identifier: Apache-2.0
/* The activation of the networks, f(z) = 1/2 (1 - e^-z) / (1 + e^-z) = 1/2 tanh(z / 2), on vectors of lanes. Written
   out, so that every kernel and every place in a batch gets the same bits. Device only.

   fp32: z P(z^2) / Q(z^2) with polynomials of degree 4, minimax for the absolute error on |z| <= 16 (linear
   programming, then a search over the coefficients' last bits); beyond, the value at 16. Over all floats: absolute
   error at most 1.7e-7, relative 3.3e-7, and |f| < 0.5. fp64: tanh from e^|z| - 1. NaN stays NaN. */
#ifndef TACTEL_SHARED_ACTIVATION_H
#define TACTEL_SHARED_ACTIVATION_H
#include "shared/elementary.h"
#include "shared/lanes.h"

#if REAL_IS_DOUBLE
static inline vreal activation(vreal z) {
  const vreal e = exp_minus_1(fabs(z)), f = ALL_LANES(0.5) * e / (e + 2);
  return PICK(z > 0, f, PICK(z < 0, -f, z));
}
#else
static inline vreal activation(vreal z) {
  const vreal end = ALL_LANES(16.0f);
  z = z > end ? end : z;
  z = z < -end ? -end : z;
  const vreal u = z * z;
  vreal p = ALL_LANES(0x1.05a58ap-36f);
  p = fma(p, u, ALL_LANES(0x1.6f52cap-24f));
  p = fma(p, u, ALL_LANES(0x1.d421dap-15f));
  p = fma(p, u, ALL_LANES(0x1.1357bep-7f));
  p = fma(p, u, ALL_LANES(0x1.0p-2f));
  vreal q = ALL_LANES(0x1.c98802p-29f);
  q = fma(q, u, ALL_LANES(0x1.65b1dp-18f));
  q = fma(q, u, ALL_LANES(0x1.acad1ap-10f));
  q = fma(q, u, ALL_LANES(0x1.df012ep-4f));
  q = fma(q, u, ALL_LANES(1.0f));
  return z * p / q;
}
#endif

/* f'(z), from f = f(z). */
static inline vreal activation_slope(vreal f) { return fma(-f, f, ALL_LANES(0.25f)); }

/* Of the hidden neurons: the same, or with LEAKY_RELU z above 0 and a share of it below; NaN stays NaN. */
#if LEAKY_RELU
#define LEAK ((real)0.01f)
static inline vreal hidden_activation(vreal z) { return PICK(z > ALL_LANES(0), z, LEAK * z); }
static inline vreal hidden_slope(vreal o) { return PICK(o > ALL_LANES(0), ALL_LANES(1), ALL_LANES(LEAK)); }
#else
static inline vreal hidden_activation(vreal z) { return activation(z); }
static inline vreal hidden_slope(vreal o) { return activation_slope(o); }
#endif

#endif
