// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "host/device/executor.h"
#include "host/device/opencl.h"

// Calls of the executor to OpenCL; not part of its interface.
namespace tactel::host {

struct Launch::State {
  Program program;
  std::string kernel;
  std::vector<cl::Kernel> kernels;                                   ///< [threads]
  const void* executor;                                              ///< its owner
  KernelTime* time;                                                  ///< its sum in the executor
  double seconds_per_group = 0;                                      ///< in the last run; 0: not run yet
  bool compiled = false;                                             ///< by a launch
  std::size_t widest = 1;                                            ///< groups in one launch; 1 without TAKE_GROUP
  std::size_t local = 1;                                             ///< groups in one work-group
  std::set<std::size_t> local_sizes{};                               ///< for which it is compiled
  std::uint64_t used = 0;                                            ///< Launcher::remind, by atomic_ref
  std::vector<KernelParameter> parameters{};                         ///< of the kernel
  std::unique_ptr<std::mutex> use = std::make_unique<std::mutex>();  ///< held by a run: kernel objects have its groups

  const std::string& device_name() const { return program.device().info().name; }
};

// PoCL (to 3.1 at least) aborts when two threads launch a kernel and one of them brings a wider grid than any before
// it. So every kernel is launched once, at its widest and for nothing, before any run. PoCL forgets the oldest of more
// than 128 kernels: such a one is launched so again. It also compiles grids of 65536 and more anew.
inline constexpr std::size_t widest_cpu_launch = 32768;

/// Launches groups of a kernel on a device and waits for them, with a queue for each thread.
class Launcher {
 public:
  Launcher(const Device& device, int threads);

  /// Launches the kernel once for nothing, on a queue of its own: beside any runs.
  void compile(Launch::State& launch);
  /// Runs groups first ... first + count - 1 with the kernel object and queue of this thread.
  void launch(Launch::State& launch, int thread, std::size_t first, std::size_t count);
  /// The same on a queue of its own, beside all threads; a launch has one such run at a time.
  void launch_beside(Launch::State& launch, std::size_t first, std::size_t count);
  std::size_t widest_launch() const;  ///< groups
  const Device& device() const { return device_; }

  /// Groups of a work-group whose size the kernel requires; 1: any.
  static std::size_t required_size(const Device& device, const cl::Kernel& kernel);
  static void enqueue(cl::CommandQueue& queue, cl::Kernel& kernel, std::size_t first, std::size_t global,
                      std::size_t local);

 private:
  std::size_t local_size(const cl::Kernel& kernel) const;
  bool compiles_sizes() const;  ///< anew for each local size
  void compile(Launch::State& launch, std::size_t global, std::size_t local);
  /// Launches at its widest, for nothing, what PoCL may have forgotten.
  void remind(cl::CommandQueue& queue, Launch::State& launch, int thread);
  void launch_on(cl::CommandQueue& queue, Launch::State& launch, int thread, std::size_t first, std::size_t count);
  template <class Use>
  void on_spare_queue(const Use& use);

  Device device_;
  std::vector<cl::CommandQueue> queues_;  ///< [threads]
  std::mutex spare_turn_;                 ///< of the next
  std::vector<cl::CommandQueue> spare_;   ///< of what runs beside the threads
};

}  // namespace tactel::host
