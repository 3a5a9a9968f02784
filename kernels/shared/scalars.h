// SPDX-License-Identifier: Apache-2.0
/* Scalar types that host and device agree on, for structs in kernels/shared: no size_t, bool, pointers or vectors
   there. */
#ifndef TACTEL_SHARED_SCALARS_H
#define TACTEL_SHARED_SCALARS_H
#ifdef __OPENCL_C_VERSION__ /* offline clang does not set __OPENCL_VERSION__ */
typedef int shared_i32;
typedef uint shared_u32;
typedef long shared_i64;
typedef ulong shared_u64;
#else
#include <cstdint>
typedef std::int32_t shared_i32;
typedef std::uint32_t shared_u32;
typedef std::int64_t shared_i64;
typedef std::uint64_t shared_u64;
#endif
#endif
