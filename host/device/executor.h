// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "host/device/kernel_arguments.h"
#include "host/device/program.h"
#include "host/support/log.h"

namespace tactel::host {

/// Requirements of a kernel:
/// - Its first argument is `uint first_group`, set by the executor. Its body begins with `TAKE_GROUP(group);` from
///   kernels/shared/group.h. That gives the index of the group, and lets the executor compile the kernel early.
/// - One work-item computes one group: a vector of LANES scenes (frames, networks); on a GPU, LANES = 1, one of them.
/// - Groups do not communicate: no barrier, no local memory, no reqd_work_group_size. `group` is always below the
///   number of groups, so no guard is needed.
/// - But on a GPU the groups of one work-group communicate where the kernel requires its size (train_group.cl): runs
/// are
///   of a multiple of it.
/// Results then do not depend on threads, chunks or device scheduling. A kernel without TAKE_GROUP also runs: it is
/// compiled at its first use, and launched one group at a time.

struct ExecutorOptions {
  int threads = 0;              ///< of the host, the calling one included; 0: $TACTEL_THREADS, else all of the machine
  double spin_seconds = 50e-6;  ///< time for which an idle thread spins before it sleeps
};

struct RunOptions {
  Progress progress{};  ///< groups done of all; called between chunks in the calling thread, and at the end
  /// Most groups that a thread draws at once. Chunks start at 1 and grow while they are short, so that adjacent
  /// heavy groups still spread over the threads. 1 gives the most even spread.
  std::size_t largest_chunk = 4096;
  bool equal_groups = false;  ///< each group takes the same time: threads draw few, large chunks
};

struct RunReport {
  std::size_t groups_done = 0;
  double seconds = 0;                         ///< wall time of this run
  bool cancelled = false;                     ///< by progress; outputs of the remaining groups are unchanged
  std::vector<std::size_t> groups_by_thread;  ///< [threads]; one entry on devices that schedule themselves
};

/// Time spent in a kernel, summed over runs.
struct KernelTime {
  std::size_t launches = 0, groups = 0;
  double seconds = 0;  ///< of device work, summed over threads
  KernelTime& operator+=(const KernelTime& more) {
    launches += more.launches, groups += more.groups, seconds += more.seconds;
    return *this;
  }
};

/// Sets arguments 1, 2, ... of a kernel. It is called once for the kernel object of each thread, always in the
/// calling thread.
using BindArguments = std::function<void(KernelArguments&)>;

/// A kernel with its arguments: prepared once, run many times. One cl::Kernel object a thread.
class Launch {
 public:
  void bind(const BindArguments& bind);  ///< new arguments
  template <class Value>
  void set(unsigned index, const Value& value) {  ///< one argument, index >= 1: scalar, struct or Buffer
    bind([&](KernelArguments& kernel) { kernel.set(index, value); });
  }
  template <class Value>
  void set(std::string_view name, const Value& value) {  ///< the same by name
    bind([&](KernelArguments& kernel) { kernel.set(name, value); });
  }
  const std::string& kernel() const;

 private:
  friend class Executor;
  friend class Launcher;
  struct State;
  std::shared_ptr<State> state_;
};

/// A Launch and its number of groups.
struct Job {
  Launch launch;
  std::size_t groups = 0;
};

/// Runs kernels on a device. On PoCL's `basic` device host threads, each with its own queue, draw chunks of
/// groups from a shared counter. Concurrent runs take turns, but one of a single launch that finds the threads taken
/// goes in its calling thread. Other devices receive one launch and schedule themselves; runs go side by side there.
class Executor {
 public:
  explicit Executor(const Device& device, const ExecutorOptions& options = {});
  ~Executor();

  /// Runs groups 0 ... groups - 1 and waits. `bind` must set all arguments. Rethrows the exception of any
  /// thread after all threads have stopped.
  RunReport run(const Program& program, const std::string& kernel, std::size_t groups, const BindArguments& bind,
                const RunOptions& options = {});

  /// The same in two parts, for kernels that run repeatedly. prepare() with arguments also compiles, so that no
  /// run waits for compilation.
  Launch prepare(const Program& program, const std::string& kernel, const BindArguments& bind = {});
  RunReport run(const Launch& launch, std::size_t groups, const RunOptions& options = {});

  /// Runs several launches as one pool of groups, drawn in the given order (put the longest first). They must
  /// be independent of each other.
  RunReport run(std::span<const Job> jobs, const RunOptions& options = {});

  /// Runs a small launch in the calling thread, without waking others: the shortest latency (under a
  /// microsecond on `basic`).
  void run_here(const Launch& launch, std::size_t groups = 1);

  const Device& device() const;
  int threads() const;
  std::map<std::string, KernelTime> times() const;  ///< by kernel name
  void clear_times();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tactel::host
