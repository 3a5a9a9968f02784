// SPDX-License-Identifier: Apache-2.0
#include "host/device/executor.h"

#include <algorithm>
#include <atomic>
#include <limits>
#include <mutex>
#include <optional>
#include <stdexcept>

#include "host/device/group_supply.h"
#include "host/device/launcher.h"
#include "host/device/thread_team.h"
#include "host/support/host_limits.h"
#include "host/support/seconds.h"
#include "host/support/stop_scope.h"

namespace tactel::host {
namespace {

// Below this much work on one thread, waking another costs more than it brings.
constexpr double alone_seconds = 8e-6;
// With progress, a device that schedules itself gets its work in so many slices, none smaller than this many groups; of
// a GPU than this many for each compute unit, as many as it holds.
constexpr std::size_t progress_slices = 64, smallest_slice = 64, gpu_slice = 2048;

int chosen_threads(int wanted) { return wanted > 0 ? std::min(wanted, most_host_threads) : host_threads(); }

/// One run: what its threads share.
struct Run {
  std::span<const Job> jobs;
  const RunOptions& options;
  int threads;  ///< that share the groups
  GroupSupply supply;
  std::mutex merge;               ///< of the next two
  std::vector<KernelTime> times;  ///< [jobs]
  RunReport report;
  std::atomic<std::size_t> done{0};

  Run(std::span<const Job> jobs, const std::vector<std::size_t>& groups, const RunOptions& options, int threads)
      : jobs(jobs), options(options), threads(threads), supply(groups), times(jobs.size()) {}

  const StopScope::Asked* const asked = StopScope::current();

  // In the thread that started the run, between chunks: false when the run shall end.
  bool go_on() {
    if (asked && (*asked)()) {
      supply.stop();
      return false;
    }
    const std::size_t so_far = done;
    if (!options.progress || so_far == supply.total() || options.progress(so_far, supply.total())) return true;
    supply.stop();
    return false;
  }
};

}  // namespace

void Launch::bind(const BindArguments& bind) {
  translated(state_->device_name(), [&] {
    for (cl::Kernel& kernel : state_->kernels) {
      KernelArguments arguments(kernel, state_->parameters);
      bind(arguments);
    }
  });
}

const std::string& Launch::kernel() const { return state_->kernel; }

struct Executor::State {
  Launcher launcher;
  ThreadTeam team;
  std::mutex turn;            ///< whose run the threads do
  mutable std::mutex timing;  ///< of the next
  std::map<std::string, KernelTime> times;

  State(const Device& device, double spin_seconds, int threads)
      : launcher(device, threads), team(threads, spin_seconds) {
    if (team.threads() < threads)
      device.log(LogLevel::warning, "only " + std::to_string(team.threads()) + " of " + std::to_string(threads) +
                                        " threads could be created: the work continues with these");
  }

  void check(const Launch& launch) const {
    if (!launch.state_ || launch.state_->executor != this)
      throw std::logic_error("a launch runs only on the executor that prepared it");
  }
  void work(Run& run, int thread);
  ChunkPace pace_of(const Run& run, std::size_t job) const;
  void run_on_threads(Run& run);
  void run_on_device(Run& run);
  bool run_slices(Run& run, std::size_t job);
  void finish(Run& run);
  static std::vector<std::unique_lock<std::mutex>> used(std::span<const Job> jobs);
  std::optional<RunReport> run_beside(std::span<const Job> jobs, const RunOptions& options);
};

// What each thread does in a run on host threads: draw, launch, until nothing is left.
void Executor::State::work(Run& run, int thread) try {
  std::vector<KernelTime> times(run.jobs.size());
  std::size_t done = 0;
  std::size_t job = run.jobs.size();
  ChunkPace pace(1, 1, 0);
  const auto chunk_size = [&](std::size_t next_job) {
    if (next_job != job) pace = pace_of(run, job = next_job);
    return pace.next(run.supply.remaining());
  };
  while (const std::optional<Chunk> chunk = run.supply.draw(chunk_size)) {
    const auto start = Clock::now();
    launcher.launch(*run.jobs[chunk->job].launch.state_, thread, chunk->first, chunk->count);
    const KernelTime time{1, chunk->count, seconds_since(start)};
    pace.measured(time.groups, time.seconds);
    times[chunk->job] += time;
    done += chunk->count;
    run.done += chunk->count;
    if (thread == 0 && !run.go_on()) break;
  }
  const std::lock_guard lock(run.merge);
  run.report.groups_by_thread[thread] = done;
  for (std::size_t i = 0; i < times.size(); ++i) run.times[i] += times[i];
} catch (...) {
  run.supply.stop();
  throw;
}

ChunkPace Executor::State::pace_of(const Run& run, std::size_t job) const {
  const Launch::State& launch = *run.jobs[job].launch.state_;
  const std::size_t largest = std::clamp<std::size_t>(run.options.largest_chunk, 1, launch.widest);
  return ChunkPace(largest, run.threads, launch.seconds_per_group, run.options.equal_groups);
}

void Executor::State::run_on_threads(Run& run) {
  run.report.groups_by_thread.assign(team.threads(), 0);
  double expected = 0;
  for (const Job& job : run.jobs) {
    const double each = job.launch.state_->seconds_per_group;
    expected += each > 0 ? each * static_cast<double>(job.groups) : alone_seconds;
  }
  if (expected < alone_seconds) {
    run.threads = 1;
    return work(run, 0);
  }
  team.run([call = std::pair(this, &run)](int thread) { call.first->work(*call.second, thread); });
}

void Executor::State::run_on_device(Run& run) {
  for (std::size_t job = 0; job < run.jobs.size(); ++job)
    if (!run_slices(run, job)) break;
  run.report.groups_by_thread = {run.done};
}

// A job on a device that schedules itself; false when progress ended the run.
bool Executor::State::run_slices(Run& run, std::size_t job) {
  std::size_t slice = launcher.widest_launch();
  if (run.options.progress || run.asked) {
    const DeviceInfo& info = launcher.device().info();
    const std::size_t smallest =
        std::min(slice, info.type == DeviceType::gpu ? gpu_slice * static_cast<std::size_t>(info.compute_units)
                                                     : smallest_slice);
    slice = std::clamp(run.jobs[job].groups / progress_slices, smallest, slice);
    const std::size_t local = run.jobs[job].launch.state_->local;
    slice = (slice + local - 1) / local * local;  // items of a work-group stay together
  }
  for (std::size_t left = run.jobs[job].groups; left > 0;) {
    const Chunk chunk = run.supply.draw([&](std::size_t) { return std::min(slice, left); }).value();
    const auto start = Clock::now();
    launcher.launch_beside(*run.jobs[job].launch.state_, chunk.first, chunk.count);
    run.times[job] += KernelTime{1, chunk.count, seconds_since(start)};
    run.done += chunk.count;
    left -= chunk.count;
    if (!run.go_on()) return false;
  }
  return true;
}

void Executor::State::finish(Run& run) {
  std::unique_lock lock(timing);
  for (std::size_t job = 0; job < run.jobs.size(); ++job) {
    Launch::State& launch = *run.jobs[job].launch.state_;
    const KernelTime& time = run.times[job];
    *launch.time += time;
    if (time.groups > 0) launch.seconds_per_group = time.seconds / static_cast<double>(time.groups);
  }
  lock.unlock();
  const std::size_t total = run.supply.total();
  run.report.groups_done = run.done;
  run.report.cancelled = run.done < total;
  if (run.options.progress && !run.report.cancelled) run.options.progress(total, total);
}

/// A run in the calling thread alone, while another has the threads: on `basic`, of one compiled launch that nothing
/// else runs. None otherwise. Its seconds are those of one thread, as if all had shared them.
std::optional<RunReport> Executor::State::run_beside(std::span<const Job> jobs, const RunOptions& options) {
  if (jobs.size() != 1 || options.progress) return {};
  const auto& [launch, groups] = jobs.front();
  Launch::State& state = *launch.state_;
  const std::unique_lock use(*state.use, std::try_to_lock);
  if (!use.owns_lock() || !state.compiled || !state.program.takes_group(state.kernel)) return {};
  const auto start = Clock::now();
  ChunkPace pace(options.largest_chunk, 1, state.seconds_per_group);
  for (std::size_t first = 0, count = groups; first < groups; first += count) {
    StopScope::check();
    if (StopScope::current()) count = pace.next(groups - first);
    const auto begun = Clock::now();
    launcher.launch_beside(state, first, count);
    pace.measured(count, seconds_since(begun));
  }
  const double seconds = seconds_since(start);
  const std::lock_guard lock(timing);
  *state.time += KernelTime{1, groups, seconds};
  RunReport report{.groups_done = groups, .seconds = seconds / team.threads(), .groups_by_thread = {}};
  report.groups_by_thread.assign(static_cast<std::size_t>(team.threads()), 0);
  report.groups_by_thread[0] = groups;
  return report;
}

Executor::Executor(const Device& device, const ExecutorOptions& options)
    : state_(std::make_unique<State>(device, options.spin_seconds,
                                     device.info().low_latency ? chosen_threads(options.threads) : 1)) {}

Executor::~Executor() = default;

Launch Executor::prepare(const Program& program, const std::string& kernel, const BindArguments& bind) {
  const auto time = [&] {
    const std::lock_guard lock(state_->timing);
    return &state_->times[kernel];
  };
  Launch launch;
  launch.state_ = std::make_shared<Launch::State>(Launch::State{program, kernel, {}, state_.get(), time()});
  launch.state_->parameters = program.parameters(kernel);
  for (int i = 0; i < threads(); ++i) launch.state_->kernels.push_back(program.kernel(kernel));
  if (bind) {
    launch.bind(bind);
    state_->launcher.compile(*launch.state_);
  }
  return launch;
}

RunReport Executor::run(const Program& program, const std::string& kernel, std::size_t groups,
                        const BindArguments& bind, const RunOptions& options) {
  return run(prepare(program, kernel, bind), groups, options);
}

RunReport Executor::run(const Launch& launch, std::size_t groups, const RunOptions& options) {
  const Job job{launch, groups};
  return run(std::span(&job, 1), options);
}

/// Waits for runs of these launches beside the threads, and keeps others from beginning.
std::vector<std::unique_lock<std::mutex>> Executor::State::used(std::span<const Job> jobs) {
  std::vector<std::mutex*> mutexes;
  mutexes.reserve(jobs.size());
  for (const Job& job : jobs) mutexes.push_back(job.launch.state_->use.get());
  std::sort(mutexes.begin(), mutexes.end());
  mutexes.erase(std::unique(mutexes.begin(), mutexes.end()), mutexes.end());
  std::vector<std::unique_lock<std::mutex>> locks;
  locks.reserve(mutexes.size());
  for (std::mutex* mutex : mutexes) locks.emplace_back(*mutex);
  return locks;
}

RunReport Executor::run(std::span<const Job> jobs, const RunOptions& options) {
  std::vector<std::size_t> groups;
  for (const Job& job : jobs) {
    state_->check(job.launch);
    if (job.groups >= std::numeric_limits<cl_uint>::max())
      throw std::length_error("more groups than a kernel can count");
    groups.push_back(job.groups);
  }
  const bool on_threads = device().info().low_latency;
  std::unique_lock lock(state_->turn, std::defer_lock);
  if (on_threads && !lock.try_lock()) {
    if (const auto report = state_->run_beside(jobs, options)) return *report;
    lock.lock();
  }
  StopScope::check();
  const auto uses = State::used(jobs);
  const auto start = Clock::now();
  Run run(jobs, groups, options, threads());
  for (const Job& job : jobs) state_->launcher.compile(*job.launch.state_);
  if (run.supply.total() > 0) on_threads ? state_->run_on_threads(run) : state_->run_on_device(run);
  state_->finish(run);
  run.report.seconds = seconds_since(start);
  if (run.report.cancelled) StopScope::check();
  return run.report;
}

void Executor::run_here(const Launch& launch, std::size_t groups) {
  state_->check(launch);
  if (groups == 0) return;
  const std::lock_guard lock(state_->turn);
  Launch::State& state = *launch.state_;
  const std::lock_guard use(*state.use);
  state_->launcher.compile(state);
  const auto start = Clock::now();
  state_->launcher.launch(state, 0, 0, groups);
  const std::lock_guard timing(state_->timing);
  *state.time += KernelTime{1, groups, seconds_since(start)};
}

const Device& Executor::device() const { return state_->launcher.device(); }
int Executor::threads() const { return state_->team.threads(); }

std::map<std::string, KernelTime> Executor::times() const {
  const std::lock_guard lock(state_->timing);
  return state_->times;
}

void Executor::clear_times() {
  const std::lock_guard lock(state_->timing);
  for (auto& [kernel, time] : state_->times) time = {};
}

}  // namespace tactel::host
