// SPDX-License-Identifier: Apache-2.0
#pragma once
// The C++ bindings, configured once. Kernels are OpenCL C 1.2; the bindings of Debian 12 compile with this target and
// minimum.
#define CL_HPP_TARGET_OPENCL_VERSION 300
#define CL_HPP_MINIMUM_OPENCL_VERSION 200
#define CL_HPP_ENABLE_EXCEPTIONS
#include <CL/opencl.hpp>
#include <string>

#include "host/support/errors.h"

namespace tactel::host {

/// Returns "CL_OUT_OF_RESOURCES" for -5, and "CL error -1234" for a code without a name.
std::string cl_code_name(cl_int code);

/// Calls `body`. Turns the exceptions of the bindings into a DeviceError that names call, code and `device`.
template <class Body>
auto translated(const std::string& device, Body&& body) {
  try {
    return body();
  } catch (const cl::Error& error) {
    throw DeviceError(error.what(), cl_code_name(error.err()), device);
  }
}

}  // namespace tactel::host
