// SPDX-License-Identifier: Apache-2.0
/* What estimate() asks of the system: steady NETWORK counts allocations and locks of 10000 frames; both must be 0.
   Calls of malloc and its kin, and of pthread_mutex_lock, go through the counting functions below. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <tactel.h>

void* __libc_malloc(size_t);
void* __libc_calloc(size_t, size_t);
void* __libc_realloc(void*, size_t);
void* __libc_memalign(size_t, size_t);

static volatile long allocations, locks;

void* malloc(size_t size) { return ++allocations, __libc_malloc(size); }
void* calloc(size_t count, size_t size) { return ++allocations, __libc_calloc(count, size); }
void* realloc(void* old, size_t size) { return ++allocations, __libc_realloc(old, size); }
void* aligned_alloc(size_t to, size_t size) { return ++allocations, __libc_memalign(to, size); }

int pthread_mutex_lock(pthread_mutex_t* mutex) {
  static int (*lock)(pthread_mutex_t*);
  if (lock == NULL) lock = (int (*)(pthread_mutex_t*))dlsym(RTLD_NEXT, "pthread_mutex_lock");
  return ++locks, lock(mutex);
}

int main(int count, char** words) {
  float frame[512] = {0};
  tactel_estimator* network = tactel_load(count > 1 ? words[1] : "");
  long before, locks_before, k;
  double sum = 0;
  if (network == NULL || allocations == 0) return fprintf(stderr, "%s\n", tactel_error()), 2;
  before = allocations, locks_before = locks;
  for (k = 0; k < 10000; ++k) {
    frame[0] = 1e-4f * (float)k;
    sum += (double)tactel_estimate(network, frame, tactel_inputs(network)).slip_index;
    frame[1] = k % 7 == 0 ? 0.0f / 0.0f : 0.5f; /* NaN takes the other way */
    tactel_estimate(network, frame, tactel_inputs(network) - (size_t)(k % 2));
    frame[1] = 0.5f;
  }
  before = allocations - before, locks_before = locks - locks_before;
  printf("%ld allocations, %ld locks\n", before, locks_before);
  tactel_free(network);
  return before != 0 || locks_before != 0 || !(sum > 0);
}
