// SPDX-License-Identifier: Apache-2.0
/* Logarithm, exponential, sine and cosine on vectors of lanes. Written out, so that every number of lanes and every
   OpenCL gives the same bits: kernels call no other (tests/kernels/check_builtins.py). Device only. */
#ifndef TACTEL_SHARED_ELEMENTARY_H
#define TACTEL_SHARED_ELEMENTARY_H
#include "shared/lanes.h"
#include "shared/unroll.h"

#if LANES == 1
#define AS_VINT JOIN(as_, REAL_INT)
#define AS_VREAL JOIN(as_, REAL)
#define TO_VINT JOIN(convert_, REAL_INT)
#define TO_VREAL JOIN(convert_, REAL)
#else
#define AS_VINT JOIN(JOIN(as_, REAL_INT), LANES)
#define AS_VREAL JOIN(JOIN(as_, REAL), LANES)
#define TO_VINT JOIN(JOIN(convert_, REAL_INT), LANES)
#define TO_VREAL JOIN(JOIN(convert_, REAL), LANES)
#endif

#if REAL_IS_DOUBLE
#define FRACTION_BITS 52
#define EXPONENT_BIAS 1023
#define LOGARITHM_TERMS 11 /* of 2 atanh(s), |s| <= 0.172: the next is below 1e-17 */
#define EXPONENTIAL_TERMS 14
#define TURN_TERMS 9 /* of cos t, |t| <= pi/4: the next is below 1e-20 */
#else
#define FRACTION_BITS 23
#define EXPONENT_BIAS 127
#define LOGARITHM_TERMS 5
#define EXPONENTIAL_TERMS 8
#define TURN_TERMS 5 /* the next is below 2e-10 */
#endif

/* Of x > 0, normal and finite: x = 2^e m with m from sqrt(1/2) to sqrt(2), ln m = 2 atanh((m - 1) / (m + 1)). */
static inline vreal natural_log(vreal x) {
  const vint bits = AS_VINT(x);
  const vint one = (vint)((REAL_INT)EXPONENT_BIAS << FRACTION_BITS);
  const vint fraction = bits & (vint)(((REAL_INT)1 << FRACTION_BITS) - 1);
  const vreal up = AS_VREAL(fraction | one);
  const vint large = up > ALL_LANES((real)1.41421356237309505);
  const vreal m = PICK(large, up * (real)0.5, up);
  const vreal e = TO_VREAL((bits >> FRACTION_BITS) - EXPONENT_BIAS) + PICK(large, ALL_LANES(1), ALL_LANES(0));
  const vreal s = (m - 1) / (m + 1), s2 = s * s;
  vreal sum = ALL_LANES((real)1 / (2 * LOGARITHM_TERMS - 1));
  EACH(k, LOGARITHM_TERMS - 1) { sum = fma(sum, s2, ALL_LANES((real)1 / (2 * LOGARITHM_TERMS - 3 - 2 * k))); }
  return fma(e, ALL_LANES((real)0.69314718055994531), 2 * s * sum);
}

/* e^x - 1 for 0 <= x; beyond 80 the value there. x = k ln 2 + r with |r| <= ln(2) / 2, and Taylor's sum of e^r - 1. */
static inline vreal exp_minus_1(vreal x) {
  x = PICK(x < ALL_LANES(80), x, ALL_LANES(80));
  const vint k = TO_VINT(fma(x, ALL_LANES((real)1.44269504088896341), ALL_LANES((real)0.5)));
  const vreal kr = TO_VREAL(k);
  /* ln 2 in two parts: the first has ten bits, so that k times it is exact. */
  const vreal r = fma(kr, ALL_LANES((real)2.12194440054690583e-4), fma(kr, ALL_LANES((real)-0.693359375), x));
  vreal sum = ALL_LANES(1);
  EACH(n, EXPONENTIAL_TERMS - 1) { sum = fma(sum * r, ALL_LANES((real)1 / (EXPONENTIAL_TERMS - n)), ALL_LANES(1)); }
  const vreal power = AS_VREAL((k + EXPONENT_BIAS) << FRACTION_BITS);
  return fma(power, sum * r, power - 1);
}

/* e^z for |z| <= 80; beyond, the value there. */
static inline vreal natural_exp(vreal z) {
  const vreal e = 1 + exp_minus_1(fabs(z));
  return PICK(z < 0, 1 / e, e);
}

/* cos(pi x) and sin(pi x), 0 <= x <= 2. x = k / 2 + r with |r| <= 1/4, and Taylor's sums of pi r. */
static inline vreal cos_pi(vreal x, vreal *sine) {
  const vint k = TO_VINT(rint(x + x));
  const vreal t = ALL_LANES((real)3.14159265358979324) * fma(TO_VREAL(k), ALL_LANES((real)-0.5), x), t2 = -t * t;
  vreal c = ALL_LANES(1), s = ALL_LANES(1);
  EACH(n, TURN_TERMS) {
    const int j = 2 * (TURN_TERMS - n);
    c = fma(t2 * c, ALL_LANES((real)1 / (j * (j - 1))), ALL_LANES(1));
    s = fma(t2 * s, ALL_LANES((real)1 / (j * (j + 1))), ALL_LANES(1));
  }
  s *= t;
  const vint odd = (k & 1) != 0, back = ((k + 1) & 2) != 0, down = (k & 2) != 0;
  const vreal along = PICK(odd, s, c), across = PICK(odd, c, s);
  *sine = PICK(down, -across, across);
  return PICK(back, -along, along);
}

/* ratio^(1 / power), between 0.1 and 10: of depths, by the ratio of forces. */
static inline vreal depth_factor(vreal ratio, vreal power) {
  const vreal z = natural_log(LARGER(ratio, ALL_LANES((real)1e-20))) / power, most = ALL_LANES((real)2.302585092994046);
  const vreal e = 1 + exp_minus_1(SMALLER(fabs(z), most));
  return PICK(z < 0, 1 / e, e);
}

#endif
