// SPDX-License-Identifier: Apache-2.0
// Preloaded: no thread can be made, as under `ulimit -u` of a user with as many processes.
#include <errno.h>
#include <pthread.h>

int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*run)(void*), void* argument) {
  (void)thread, (void)attributes, (void)run, (void)argument;
  return EAGAIN;
}
