// SPDX-License-Identifier: Apache-2.0
/* Vectors of lanes for kernels: LANES and REAL come from the build. Device only.
   vreal: LANES numbers of type REAL; vint: as many integers of the same width, the type of comparisons.
   LANES = 1 gives scalars, for GPUs; there a comparison yields 1, not -1. Take masks apart with PICK, ANY, ALL, NOT,
   vectors with NUMBER, join masks with & and |, and the same text serves every width. */
#ifndef TACTEL_SHARED_LANES_H
#define TACTEL_SHARED_LANES_H

#define JOIN_(a, b) a##b
#define JOIN(a, b) JOIN_(a, b)
#define IS_double 1
#define IS_float 0
#define REAL_IS_DOUBLE JOIN(IS_, REAL)

#if REAL_IS_DOUBLE
#pragma OPENCL EXTENSION cl_khr_fp64 : enable
#define REAL_INT long
#else
#define REAL_INT int
#endif

/* What is fused is written so: the same bits on every device. */
#pragma OPENCL FP_CONTRACT OFF

typedef REAL real;
#if LANES == 1
typedef REAL vreal;
typedef REAL_INT vint;
#define LOAD(p) (*(p))
#define STORE(v, p) (*(p) = (v))
#define PICK(mask, yes, no) ((mask) ? (yes) : (no))
#define ANY(mask) ((mask) != 0)
#define ALL(mask) ((mask) != 0)
#define NOT(mask) (!(mask))
#define NUMBER(v, lane) (v)
#else
typedef JOIN(REAL, LANES) vreal;
typedef JOIN(REAL_INT, LANES) vint;
#define LOAD(p) JOIN(vload, LANES)(0, p)
#define STORE(v, p) JOIN(vstore, LANES)(v, 0, p)
#define PICK(mask, yes, no) select(no, yes, mask)
#define ANY(mask) (joined(mask) != 0)
#define ALL(mask) all(mask)
#define NOT(mask) (~(mask))
#define NUMBER(v, lane) (((const real *)&(v))[lane])
#endif

/* The mask of all lanes in one number. any() would branch for each lane, and be mispredicted where lanes finish one by
   one. */
#if LANES > 1
static inline REAL_INT joined(vint mask) {
#if LANES == 16
  const JOIN(REAL_INT, 8) eight = mask.lo | mask.hi;
#elif LANES == 8
  const vint eight = mask;
#endif
#if LANES >= 8
  const JOIN(REAL_INT, 4) four = eight.lo | eight.hi;
#elif LANES == 4
  const vint four = mask;
#endif
#if LANES >= 4
  const JOIN(REAL_INT, 2) two = four.lo | four.hi;
#else
  const vint two = mask;
#endif
  return two.x | two.y;
}
#endif

/* Stores what no kernel reads again, past the caches: a launch writes much more than they hold. */
#if LANES > 1 && defined(__has_builtin)
#if __has_builtin(__builtin_nontemporal_store)
#define STORE_AWAY(v, p) __builtin_nontemporal_store(v, (global vreal *)(p))
#endif
#endif
#ifndef STORE_AWAY
#define STORE_AWAY(v, p) STORE(v, p)
#endif

/* The same number in every lane. */
#define ALL_LANES(x) ((vreal)(x))

/* The largest and the smallest; unlike fmax and fmin one instruction, and the second argument where one is not a
   number. */
#define LARGER(a, b) PICK((a) > (b), a, b)
#define SMALLER(a, b) PICK((a) < (b), a, b)

/* The tolerance of sweeps, over the largest pressure force: below mu = 0.01 in proportion to mu, since S has mu P below
   it, to 1e-5 at least. */
static inline vreal sweep_tolerance(real tolerance, vreal mu) {
  const vreal least = SMALLER(ALL_LANES(tolerance), ALL_LANES((real)1e-5));
  return LARGER(tolerance * SMALLER((real)100 * mu, ALL_LANES(1)), least);
}

/* Stays a number while every x is finite, and else becomes NaN, which LARGER, SMALLER and fmax would lose. */
static inline vreal finite_sum(vreal sum, vreal x) { return fma(ALL_LANES(0), x, sum); }

#endif
