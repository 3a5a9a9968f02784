#include "host/executor.h"

#include <algorithm>
#include <atomic>
#include <charconv>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <mutex>
#include <numeric>
#include <stdexcept>
#include <thread>

#include "host/group_supply.h"
#include "host/thread_team.h"

namespace tactel::host {
namespace {

using Clock = std::chrono::steady_clock;

// Below this much work on one thread, waking another costs more than it brings.
constexpr double alone_seconds = 4e-6;
// PoCL (to 3.1 at least) aborts when two threads launch a kernel and one of them is the first to use so wide a grid. So
// every kernel is launched once, at its widest, before any run; and nothing wider follows. It also compiles grids of
// 65536 and more anew.
constexpr std::size_t widest_cpu_launch = 32768;
constexpr std::size_t widest_gpu_launch = std::size_t{1} << 24;
constexpr std::size_t gpu_local_size = 64;
constexpr cl_uint no_groups = 0xffffffffu;  // NO_GROUPS of kernels/shared/group.h
// With progress, a device that schedules itself gets its work in so many slices.
constexpr std::size_t progress_slices = 64;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

int chosen_threads(int wanted) {
  constexpr int most = 1024;
  if (wanted > 0) return std::min(wanted, most);
  const char* text = std::getenv("TACTEL_THREADS");
  if (!text || !*text) return std::max(1u, std::thread::hardware_concurrency());
  int threads = 0;
  const char* end = text + std::strlen(text);
  const auto [stop, error] = std::from_chars(text, end, threads);
  if (error != std::errc{} || stop != end || threads < 1 || threads > most)
    throw ConfigError("", "TACTEL_THREADS", text, "a whole number from 1 to " + std::to_string(most));
  return threads;
}

}  // namespace

struct Launch::State {
  Program program;
  std::string kernel;
  std::vector<cl::Kernel> kernels;  ///< [threads]
  const void* executor;             ///< the one that made it
  KernelTime* time;                 ///< its sum there
  double seconds_per_group = 0;     ///< in the last run; 0: not run yet
  bool compiled = false;            ///< by a launch; the program knows
  std::size_t widest = 1;           ///< groups in one launch

  const std::string& device_name() const { return program.device().info().name; }
};

void Launch::bind(const BindArguments& bind) {
  translated(state_->device_name(), [&] {
    for (cl::Kernel& kernel : state_->kernels) bind(kernel);
  });
}

const std::string& Launch::kernel() const { return state_->kernel; }

/// One run: what its threads share.
struct Run {
  std::span<const Job> jobs;
  const RunOptions& options;
  GroupSupply supply;
  std::vector<KernelTime> times;  ///< [jobs]
  RunReport report;
  std::atomic<std::size_t> done{0};
  std::mutex merge;

  Run(std::span<const Job> jobs, const std::vector<std::size_t>& groups, const RunOptions& options)
      : jobs(jobs), options(options), supply(groups), times(jobs.size()) {}

  // To be called in the thread that started the run; false when the run shall end.
  bool go_on() {
    if (!options.progress || options.progress(done, supply.total())) return true;
    supply.stop();
    return false;
  }
};

struct Executor::State {
  Device device;
  ExecutorOptions options;
  ThreadTeam team;
  std::vector<cl::CommandQueue> queues;  ///< [threads]
  std::mutex turn;
  std::map<std::string, KernelTime> times;

  State(const Device& device, const ExecutorOptions& options, int threads)
      : device(device), options(options), team(threads, options.spin_seconds) {
    for (int i = 0; i < threads; ++i) queues.push_back(device.make_queue());
  }

  void check(const Launch::State& launch) const {
    if (launch.executor != this)
      throw std::logic_error("launch " + launch.kernel + " was prepared by another executor");
  }

  std::size_t widest_launch() const;
  void enqueue(Launch::State& launch, int thread, cl_uint first, std::size_t global, std::size_t local);
  void compile(Launch::State& launch);
  void launch(Launch::State& launch, int thread, std::size_t first, std::size_t count);
  void work(Run& run, int thread);
  ChunkPace pace_of(const Run& run, std::size_t job) const;
  void run_on_threads(Run& run);
  void run_on_device(Run& run);
  void run_slices(Run& run, std::size_t job);
  void finish(Run& run);
};

std::size_t Executor::State::widest_launch() const {
  return device.info().type == DeviceType::cpu ? widest_cpu_launch : widest_gpu_launch;
}

void Executor::State::enqueue(Launch::State& launch, int thread, cl_uint first, std::size_t global, std::size_t local) {
  if (global == 0) return;
  launch.kernels[thread].setArg(0, first);
  queues[thread].enqueueNDRangeKernel(launch.kernels[thread], cl::NullRange, cl::NDRange(global), cl::NDRange(local));
}

// Launches the kernel at its widest, for nothing. Every thread's run of it comes later.
void Executor::State::compile(Launch::State& launch) {
  static std::mutex one_at_a_time;
  if (launch.compiled) return;
  const bool cpu = device.info().type == DeviceType::cpu;
  const std::lock_guard lock(one_at_a_time);
  if (launch.program.takes_group(launch.kernel)) {
    launch.widest = widest_launch();
    translated(device.info().name, [&] {
      enqueue(launch, 0, no_groups, cpu ? launch.widest : gpu_local_size, cpu ? 1 : gpu_local_size);
      queues[0].finish();
    });
    launch.program.note_launched(launch.kernel);
  } else {
    device.log(LogLevel::warning, launch.kernel + " lacks TAKE_GROUP: compiled at its first use, run group by group");
  }
  launch.compiled = true;
}

// Runs groups first ... first + count - 1 and waits. OpenCL's own offset stays zero: PoCL aborts when two threads
// launch a kernel with and without. On a GPU a ragged end goes in a launch of its own, as OpenCL 1.2 wants whole
// work-groups.
void Executor::State::launch(Launch::State& launch, int thread, std::size_t first, std::size_t count) {
  const std::size_t local = device.info().type == DeviceType::cpu ? 1 : gpu_local_size;
  translated(device.info().name, [&] {
    for (const std::size_t end = first + count; first < end; first += count) {
      count = std::min(end - first, launch.widest);
      const std::size_t whole = count - count % local;
      enqueue(launch, thread, static_cast<cl_uint>(first), whole, local);
      enqueue(launch, thread, static_cast<cl_uint>(first + whole), count - whole, count - whole);
    }
    queues[thread].finish();
  });
}

// What each thread does in a run on host threads: draw, launch, until nothing is left.
void Executor::State::work(Run& run, int thread) try {
  std::vector<KernelTime> times(run.jobs.size());
  std::size_t done = 0;
  std::size_t job = run.jobs.size();
  ChunkPace pace(1, 1);
  const auto chunk_size = [&](std::size_t next_job) {
    if (next_job != job) pace = pace_of(run, job = next_job);
    return pace.next(run.supply.remaining());
  };
  while (const std::optional<Chunk> chunk = run.supply.draw(chunk_size)) {
    const auto start = Clock::now();
    launch(*run.jobs[chunk->job].launch.state_, thread, chunk->first, chunk->count);
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
  ChunkPace pace(std::min(std::max<std::size_t>(run.options.largest_chunk, 1), launch.widest), team.threads());
  pace.expect(launch.seconds_per_group);
  return pace;
}

void Executor::State::run_on_threads(Run& run) {
  run.report.groups_by_thread.assign(team.threads(), 0);
  double expected = 0;
  for (const Job& job : run.jobs) {
    const double each = job.launch.state_->seconds_per_group;
    expected += each > 0 ? each * static_cast<double>(job.groups) : 1;
  }
  if (expected < alone_seconds) return work(run, 0);
  struct Body {
    State* state;
    Run* run;
    void operator()(int thread) const { state->work(*run, thread); }
  };
  team.run(Body{this, &run});
}

void Executor::State::run_on_device(Run& run) {
  for (std::size_t job = 0; job < run.jobs.size() && run.supply.remaining() > 0; ++job) run_slices(run, job);
  run.report.groups_by_thread = {run.done};
}

void Executor::State::run_slices(Run& run, std::size_t job) {
  std::size_t slice = widest_launch();
  if (run.options.progress)
    slice = std::clamp<std::size_t>(run.jobs[job].groups / progress_slices, gpu_local_size, slice);
  Launch::State& state = *run.jobs[job].launch.state_;
  for (std::size_t left = run.jobs[job].groups; left > 0;) {
    const Chunk chunk = run.supply.draw([&](std::size_t) { return std::min(slice, left); }).value();
    const auto start = Clock::now();
    launch(state, 0, chunk.first, chunk.count);
    run.times[job] += KernelTime{1, chunk.count, seconds_since(start)};
    run.done += chunk.count;
    left -= chunk.count;
    if (!run.go_on()) return;
  }
}

// Books the times.
void Executor::State::finish(Run& run) {
  for (std::size_t job = 0; job < run.jobs.size(); ++job) {
    Launch::State& launch = *run.jobs[job].launch.state_;
    const KernelTime& time = run.times[job];
    if (time.groups == 0) continue;
    *launch.time += time;
    launch.seconds_per_group = time.seconds / static_cast<double>(time.groups);
  }
  run.report.groups_done = run.done;
  run.report.cancelled = run.done < run.supply.total();
}

Executor::Executor(const Device& device, const ExecutorOptions& options)
    : state_(
          std::make_unique<State>(device, options, device.info().low_latency ? chosen_threads(options.threads) : 1)) {}

Executor::~Executor() = default;

Launch Executor::prepare(const Program& program, const std::string& kernel, const BindArguments& bind) {
  const std::lock_guard lock(state_->turn);
  Launch launch;
  launch.state_ =
      std::make_shared<Launch::State>(Launch::State{program, kernel, {}, state_.get(), &state_->times[kernel]});
  for (int i = 0; i < threads(); ++i) launch.state_->kernels.push_back(program.kernel(kernel));
  if (bind) {
    launch.bind(bind);
    state_->compile(*launch.state_);
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

RunReport Executor::run(std::span<const Job> jobs, const RunOptions& options) {
  std::vector<std::size_t> groups;
  for (const Job& job : jobs) {
    state_->check(*job.launch.state_);
    if (job.groups > std::numeric_limits<cl_uint>::max())
      throw std::length_error("more groups than a kernel can count");
    groups.push_back(job.groups);
  }
  const std::lock_guard lock(state_->turn);
  const auto start = Clock::now();
  for (const Job& job : jobs) state_->compile(*job.launch.state_);
  Run run(jobs, groups, options);
  if (run.supply.total() > 0)
    state_->device.info().low_latency ? state_->run_on_threads(run) : state_->run_on_device(run);
  state_->finish(run);
  run.report.seconds = seconds_since(start);
  return run.report;
}

void Executor::run_here(const Launch& launch, std::size_t groups) {
  Launch::State& state = *launch.state_;
  state_->check(state);
  if (groups == 0) return;
  const std::lock_guard lock(state_->turn);
  state_->compile(state);
  const auto start = Clock::now();
  state_->launch(state, 0, 0, groups);
  *state.time += KernelTime{1, groups, seconds_since(start)};
}

const Device& Executor::device() const { return state_->device; }
int Executor::threads() const { return state_->team.threads(); }

std::map<std::string, KernelTime> Executor::times() const {
  const std::lock_guard lock(state_->turn);
  return state_->times;
}

void Executor::clear_times() {
  const std::lock_guard lock(state_->turn);
  for (auto& [kernel, time] : state_->times) time = {};
}

}  // namespace tactel::host
