// SPDX-License-Identifier: Apache-2.0
#pragma once

// Fused multiply-adds are instructions of every x86 processor since 2013; elsewhere libm computes the same bits.
// Vectors of 16 numbers halve the time. The variant is chosen when the library is loaded. Sanitizers do not go with
// that.
#if defined(__x86_64__) && !defined(__FMA__) && !defined(TACTEL_SANITIZED)
#define FOR_EACH_PROCESSOR __attribute__((target_clones("default", "fma", "avx512f")))
#else
#define FOR_EACH_PROCESSOR
#endif
