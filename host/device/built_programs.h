// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>

#include "host/device/opencl.h"

// Calls of Program to OpenCL; not part of its interface.
namespace tactel::host {

struct BuiltProgram {
  cl::Program program;
  std::set<std::string> used;  ///< kernels
};

/// The programs of a context: a launcher that is made again takes its program from here, without PoCL's cache.
struct BuiltPrograms {
  std::mutex mutex;
  std::map<std::string, std::shared_ptr<BuiltProgram>> all;  ///< by options and source
};

}  // namespace tactel::host
