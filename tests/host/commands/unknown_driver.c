// SPDX-License-Identifier: Apache-2.0
// Preloaded: the OpenCL platform bears a name that nobody knows; where CRASH is set, its compiler ends the process, and
// where IDLE is set, kernels do nothing.
#define _GNU_SOURCE
#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>
#include <dlfcn.h>
#include <stdlib.h>
#include <string.h>

__attribute__((visibility("default"))) cl_int clGetPlatformInfo(cl_platform_id platform, cl_platform_info what,
                                                                size_t room, void* value, size_t* needed) {
  static const char name[] = "Nobody's OpenCL";
  static cl_int (*next)(cl_platform_id, cl_platform_info, size_t, void*, size_t*) = NULL;
  if (!next) *(void**)&next = dlsym(RTLD_NEXT, "clGetPlatformInfo");
  if (what != CL_PLATFORM_NAME) return next(platform, what, room, value, needed);
  if (needed) *needed = sizeof name;
  if (value && room < sizeof name) return CL_INVALID_VALUE;
  if (value) memcpy(value, name, sizeof name);
  return CL_SUCCESS;
}

__attribute__((visibility("default"))) cl_int clBuildProgram(cl_program program, cl_uint count,
                                                             const cl_device_id* devices, const char* options,
                                                             void(CL_CALLBACK* notify)(cl_program, void*), void* user) {
  static cl_int (*next)(cl_program, cl_uint, const cl_device_id*, const char*, void(CL_CALLBACK*)(cl_program, void*),
                        void*) = NULL;
  if (!next) *(void**)&next = dlsym(RTLD_NEXT, "clBuildProgram");
  if (getenv("CRASH")) *(volatile int*)NULL = 0;  // no raise(): signals are held meanwhile
  return next(program, count, devices, options, notify, user);
}

__attribute__((visibility("default"))) cl_int clEnqueueNDRangeKernel(cl_command_queue queue, cl_kernel kernel,
                                                                     cl_uint axes, const size_t* from,
                                                                     const size_t* global, const size_t* local,
                                                                     cl_uint waits, const cl_event* wait_for,
                                                                     cl_event* event) {
  static cl_int (*next)(cl_command_queue, cl_kernel, cl_uint, const size_t*, const size_t*, const size_t*, cl_uint,
                        const cl_event*, cl_event*) = NULL;
  static cl_int (*mark)(cl_command_queue, cl_uint, const cl_event*, cl_event*) = NULL;
  if (!next) *(void**)&next = dlsym(RTLD_NEXT, "clEnqueueNDRangeKernel");
  if (!mark) *(void**)&mark = dlsym(RTLD_NEXT, "clEnqueueMarkerWithWaitList");  // by name: linkers lack it
  if (getenv("IDLE")) return mark(queue, waits, wait_for, event);
  return next(queue, kernel, axes, from, global, local, waits, wait_for, event);
}
