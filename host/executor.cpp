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
// PoCL compiles a kernel anew for grids of 65536 and more: larger ones go in slices.
constexpr std::size_t largest_cpu_slice = 32768;
constexpr std::size_t largest_gpu_slice = std::size_t{1} << 24;
constexpr std::size_t gpu_local_size = 64;
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
  bool noted = false;               ///< the program knows that it was launched

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

  void launch(const Launch::State& launch, int thread, std::size_t first, std::size_t count);
  void work(Run& run, int thread);
  void run_on_threads(Run& run);
  void run_on_device(Run& run);
  void run_slices(Run& run, std::size_t job);
  void finish(Run& run);
  void note(Launch::State& launch);
};

// Enqueues groups first ... first + count - 1 and waits. OpenCL's own offset stays zero: PoCL aborts when two threads
// launch a kernel with and without. On a GPU a ragged end goes in a launch of its own, as OpenCL 1.2 wants whole
// work-groups.
void Executor::State::launch(const Launch::State& launch, int thread, std::size_t first, std::size_t count) {
  cl::Kernel kernel = launch.kernels[thread];
  const std::size_t local = device.info().type == DeviceType::cpu ? 1 : gpu_local_size;
  const std::size_t whole = count - count % local;
  const auto enqueue = [&](std::size_t begin, std::size_t global, std::size_t size) {
    if (global == 0) return;
    kernel.setArg(0, static_cast<cl_uint>(begin));
    queues[thread].enqueueNDRangeKernel(kernel, cl::NullRange, cl::NDRange(global), cl::NDRange(size));
  };
  translated(device.info().name, [&] {
    enqueue(first, whole, local);
    enqueue(first + whole, count - whole, count - whole);
    queues[thread].finish();
  });
}

// What each thread does in a run on host threads: draw, launch, until nothing is left.
void Executor::State::work(Run& run, int thread) try {
  std::vector<KernelTime> times(run.jobs.size());
  ChunkPace pace(run.options.largest_chunk, team.threads());
  std::size_t last_job = run.jobs.size();
  std::size_t done = 0;
  pace.expect(run.jobs.front().launch.state_->seconds_per_group);
  while (const std::optional<Chunk> chunk = run.supply.draw(pace.next(run.supply.remaining()))) {
    const auto start = Clock::now();
    launch(*run.jobs[chunk->job].launch.state_, thread, chunk->first, chunk->count);
    const double seconds = seconds_since(start);
    if (chunk->job != last_job) pace = ChunkPace(run.options.largest_chunk, team.threads());
    last_job = chunk->job;
    pace.measured(chunk->count, seconds);
    times[chunk->job].launches += 1;
    times[chunk->job].groups += chunk->count;
    times[chunk->job].seconds += seconds;
    done += chunk->count;
    run.done += chunk->count;
    if (thread == 0 && !run.go_on()) break;
  }
  const std::lock_guard lock(run.merge);
  run.report.groups_by_thread[thread] = done;
  for (std::size_t job = 0; job < times.size(); ++job) run.times[job] += times[job];
} catch (...) {
  run.supply.stop();
  throw;
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
  std::size_t slice = device.info().type == DeviceType::cpu ? largest_cpu_slice : largest_gpu_slice;
  if (run.options.progress)
    slice = std::clamp<std::size_t>(run.jobs[job].groups / progress_slices, gpu_local_size, slice);
  const Launch::State& state = *run.jobs[job].launch.state_;
  for (std::size_t left = run.jobs[job].groups; left > 0;) {
    const Chunk chunk = run.supply.draw(std::min(slice, left)).value();
    const auto start = Clock::now();
    launch(state, 0, chunk.first, chunk.count);
    run.times[job] += KernelTime{1, chunk.count, seconds_since(start)};
    run.done += chunk.count;
    left -= chunk.count;
    if (!run.go_on()) return;
  }
}

// Books the times and tells programs which kernels are compiled by now.
void Executor::State::finish(Run& run) {
  for (std::size_t job = 0; job < run.jobs.size(); ++job) {
    Launch::State& launch = *run.jobs[job].launch.state_;
    const KernelTime& time = run.times[job];
    if (time.groups == 0) continue;
    *launch.time += time;
    launch.seconds_per_group = launch.noted ? time.seconds / static_cast<double>(time.groups) : 0;
    note(launch);
  }
  run.report.groups_done = run.done;
  run.report.cancelled = run.done < run.supply.total();
}

void Executor::State::note(Launch::State& launch) {
  if (launch.noted) return;
  launch.noted = true;
  launch.program.note_launched(launch.kernel);
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
  if (bind) launch.bind(bind);
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
  const auto start = Clock::now();
  state_->launch(state, 0, 0, groups);
  *state.time += KernelTime{1, groups, seconds_since(start)};
  state_->note(state);
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
