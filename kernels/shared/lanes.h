/* Vectors of lanes for kernels: LANES and REAL come from the build. Device only.
   vreal: LANES numbers of type REAL; vint: as many integers of the same width, the type of comparisons.
   LANES = 1 gives scalars, for GPUs; there a comparison yields 1, not -1. Take masks apart with PICK, ANY, ALL, NOT, join them with
   & and |, and the same text serves every width. */
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
#else
typedef JOIN(REAL, LANES) vreal;
typedef JOIN(REAL_INT, LANES) vint;
#define LOAD(p) JOIN(vload, LANES)(0, p)
#define STORE(v, p) JOIN(vstore, LANES)(v, 0, p)
#define PICK(mask, yes, no) select(no, yes, mask)
#define ANY(mask) any(mask)
#define ALL(mask) all(mask)
#define NOT(mask) (~(mask))
#endif

/* The same number in every lane. */
#define ALL_LANES(x) ((vreal)(x))

#endif
