#pragma once
#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "host/log.h"
#include "host/program.h"

namespace tactel::host {

/// What a kernel must look like to be run here:
/// - Its first argument is `uint first_group`, set by the executor. Its body begins with `TAKE_GROUP(group);` from
///   kernels/shared/group.h: that gives the index of the work, and lets the executor have it compiled before work
///   comes.
/// - One work-item does one group: a vector of LANES scenes (frames, networks); on a GPU, LANES = 1, one of them.
/// - Groups do not talk to each other: no barrier, no local memory, no reqd_work_group_size. `group` never reaches the
///   number of groups, so no guard is needed.
/// Then results do not depend on threads, chunks or device scheduling. A kernel without TAKE_GROUP runs, too: compiled
/// at its first use, and one group a launch.

struct ExecutorOptions {
  int threads = 0;              ///< of the host, the calling one included; 0: $TACTEL_THREADS, else all of this machine
  double spin_seconds = 50e-6;  ///< how long an idle thread listens for the next run before it sleeps
};

struct RunOptions {
  Progress progress{};  ///< groups done of all; called between chunks in the calling thread, and at the end
  /// Groups a thread draws at once, at most. Chunks start at 1 and grow while they are short, so that heavy groups side
  /// by side still spread over the threads. 1 for the most even spread.
  std::size_t largest_chunk = 4096;
};

struct RunReport {
  std::size_t groups_done = 0;
  double seconds = 0;                         ///< wall time of this run
  bool cancelled = false;                     ///< progress said so; groups not done left their outputs as they were
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

/// Sets arguments 1, 2, ... of a kernel; called once for each thread's kernel object, always in the calling thread.
using BindArguments = std::function<void(cl::Kernel&)>;

/// A kernel with its arguments: prepared once, run many times. One cl::Kernel object a thread.
class Launch {
 public:
  void bind(const BindArguments& bind);  ///< new arguments
  template <class Value>
  void set(unsigned index, const Value& value) {  ///< one argument, index >= 1: scalar, struct or cl::Buffer
    bind([&](cl::Kernel& kernel) { kernel.setArg(index, value); });
  }
  const std::string& kernel() const;

 private:
  friend class Executor;
  friend class Launcher;
  struct State;
  std::shared_ptr<State> state_;
};

/// A Launch and how many groups of it.
struct Job {
  Launch launch;
  std::size_t groups = 0;
};

/// Runs kernels on a device. On PoCL's `basic` device host threads, each with its own queue, draw chunks of groups from
/// a shared counter; other devices get one launch and schedule themselves. Runs of one executor take turns.
class Executor {
 public:
  explicit Executor(const Device& device, const ExecutorOptions& options = {});
  ~Executor();
  Executor(const Executor&) = delete;
  Executor& operator=(const Executor&) = delete;

  /// Runs groups 0 ... groups - 1 and waits. `bind` must set all arguments. Exceptions of any thread leave here, after
  /// every thread has stopped.
  RunReport run(const Program& program, const std::string& kernel, std::size_t groups, const BindArguments& bind,
                const RunOptions& options = {});

  /// The same in two parts, for kernels that run again and again. Preparing with arguments also compiles: no run waits
  /// for that.
  Launch prepare(const Program& program, const std::string& kernel, const BindArguments& bind = {});
  RunReport run(const Launch& launch, std::size_t groups, const RunOptions& options = {});

  /// Several launches as one pool of groups, drawn in the order given (put the longest first). They must not depend on
  /// each other.
  RunReport run(std::span<const Job> jobs, const RunOptions& options = {});

  /// One small launch in the calling thread, without waking others: the shortest way (under a microsecond on `basic`).
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
