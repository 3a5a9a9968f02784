// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <map>
#include <mutex>
#include <string>

#include "host/device/opencl.h"

// Calls of Program and Buffer to OpenCL; not part of their interface.
namespace tactel::host {

class CompileCache;
class Device;

/// What a context keeps. A launcher that is made again takes its program from here, without PoCL's cache.
struct BuiltPrograms {
  std::mutex mutex;
  std::map<std::string, cl::Program> all;  ///< by options and source

  /// Of buffers that no launch holds any more, for the next, and the queue of all transfers. With memory of its own.
  struct {
    std::mutex transfer;  ///< of the queue
    cl::CommandQueue queue;
    std::mutex mutex;                              ///< of the next two
    std::multimap<std::size_t, cl::Buffer> spare;  ///< by bytes
    std::size_t bytes = 0;                         ///< of the spare ones
  } memory;
};

/// What a program is built from; `text` includes nothing.
struct ProgramText {
  std::string name, options, text;
};

/// Returns the program from the cache, or compiles it and its kernels. Throws KernelBuildError with the compiler's log;
/// Stopped where a signal asks for a stop meanwhile.
cl::Program built_program(const Device& device, const ProgramText& program);

/// Returns the cache of this process; none where the user says where kernels are kept, or where no folder can be used.
const CompileCache* compile_cache();
/// Makes this the cache of this process, which compiles for another, before its first device.
void compile_in(const std::filesystem::path& folder, const std::filesystem::path& own);

}  // namespace tactel::host
