// SPDX-License-Identifier: Apache-2.0
/* Loops that must be unrolled, so that arrays live in registers, and loops that must not, so that compiling stays
   short. Device only. */
#ifndef TACTEL_SHARED_UNROLL_H
#define TACTEL_SHARED_UNROLL_H

#define ROLLED _Pragma("nounroll")
#if SHORT_CODE
#define UNROLL ROLLED
#else
#define UNROLL _Pragma("unroll")
#endif
#define EACH(i, n) UNROLL for (int i = 0; i < (n); ++i)
#define INLINE static inline __attribute__((always_inline))

#endif
