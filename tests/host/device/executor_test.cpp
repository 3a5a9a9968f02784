// SPDX-License-Identifier: Apache-2.0

// Runs on host threads (basic) and on a device that schedules itself (pthread): every group once, same bits, errors and
// cancellation that leave the executor usable.
#include "host/device/executor.h"

#include <gmock/gmock.h>

#include <atomic>
#include <cstring>
#include <latch>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <thread>

#include "host/device/buffer.h"
#include "host/support/errors.h"
#include "host/support/seconds.h"
#include "host/support/stop_scope.h"
#include "tests/host/device/test_device.h"

namespace tactel::host::executor_test {

constexpr int poison = -1000, twice = -2000;

// mark: out[group] = group, once. chain: a recurrence of `terms` terms, some us each 1000; lanes of any width and
// precision.
const char* const text =
    "#include \"shared/group.h\"\n#include \"shared/lanes.h\"\n"
    "kernel void mark(uint first_group, global int *out) {\n"
    "  TAKE_GROUP(group);\n"
    "  out[group] = out[group] == -1000 ? (int)group : -2000;\n"
    "}\n"
    "kernel void mark_unguarded(uint first_group, global int *out) {\n"
    "  const size_t group = first_group + get_global_id(0);\n"
    "  out[group] = out[group] == -1000 ? (int)group : -2000;\n"
    "}\n"
    "kernel void mark_slowly(uint first_group, global int *out) {\n"
    "  TAKE_GROUP(group);\n"
    "  real x = (real)group + 1;\n"
    "  for (int i = 0; i < 20000; ++i) x = sqrt(x) + exp(-x) / (x + i);\n"
    "  out[group] = out[group] == -1000 && x > 0 ? (int)group : -2000;\n"
    "}\n"
    "kernel void chain(uint first_group, global vreal *out, int terms) {\n"
    "  TAKE_GROUP(group);\n"
    "  vreal x = ALL_LANES(group) + 1;\n"
    "  for (int i = 0; i < terms; ++i) x = sqrt(x) + exp(-x) / (x + i);\n"
    "  out[group] = x;\n"
    "}\n";

Program program(const Device& device, Precision precision = Precision::fp32) {
  return Program::from_text(device, "executor_test.cl", text, lanes_of(device, precision));
}

/// What `mark` writes into, with guard rows behind.
class Marks {
 public:
  Marks(const Device& device, std::size_t groups) : groups_(groups), buffer_(device, groups + 64) {
    buffer_.write(std::vector<int>(groups + 64, poison));
  }
  BindArguments bind() const {
    return [this](KernelArguments& kernel) { kernel.set(1, buffer_); };
  }
  /// How many groups were done; fails for one done twice or outside.
  std::size_t done() const {
    std::vector<int> marks(groups_ + 64);
    buffer_.read(marks);
    std::size_t count = 0;
    for (std::size_t i = 0; i < marks.size(); ++i) {
      if (marks[i] == poison) continue;
      EXPECT_LT(i, groups_);
      EXPECT_EQ(marks[i], static_cast<int>(i)) << (marks[i] == twice ? "done twice" : "wrong index");
      ++count;
    }
    return count;
  }

 private:
  std::size_t groups_;
  Buffer<int> buffer_;
};

struct Setting {
  std::string device;
  int threads;
  std::size_t groups;
};

class EveryGroup : public testing::TestWithParam<Setting> {};

TEST_P(EveryGroup, ExactlyOnce) {
  const auto& [choice, threads, groups] = GetParam();
  Executor executor(device(choice), {.threads = threads});
  for (const char* kernel : {"mark", "mark_unguarded"}) {
    Marks marks(executor.device(), groups);
    const RunReport report = executor.run(program(executor.device()), kernel, groups, marks.bind());
    EXPECT_EQ(marks.done(), groups) << kernel;
    EXPECT_EQ(report.groups_done, groups);
    EXPECT_FALSE(report.cancelled);
    EXPECT_EQ(std::accumulate(report.groups_by_thread.begin(), report.groups_by_thread.end(), std::size_t{0}), groups);
  }
}

TEST_P(EveryGroup, ExactlyOnceInTheCallingThread) {
  const auto& [choice, threads, groups] = GetParam();
  Executor executor(device(choice), {.threads = threads});
  Marks marks(executor.device(), groups);
  executor.run_here(executor.prepare(program(executor.device()), "mark", marks.bind()), groups);
  EXPECT_EQ(marks.done(), groups);
}

std::vector<Setting> settings() {
  std::vector<Setting> all;
  for (const std::size_t groups : {0, 1, 7, 1000, 40000}) {  // 40000: more than one launch takes
    for (const int threads : {1, 2, 3}) all.push_back({"basic", threads, groups});
    all.push_back({"pthread", 0, groups});
  }
  return all;
}

INSTANTIATE_TEST_SUITE_P(Ragged, EveryGroup, testing::ValuesIn(settings()), [](const auto& setting) {
  return setting.param.device + "_" + std::to_string(setting.param.threads) + "_" +
         std::to_string(setting.param.groups);
});

/// Bytes that `chain` writes for `groups` groups.
template <class Real>
std::vector<char> chained_numbers(Executor& executor, Precision precision, std::size_t groups,
                                  std::size_t largest_chunk) {
  const Device& device = executor.device();
  Buffer<Real> out(device, groups * static_cast<std::size_t>(device.lanes(precision)));
  const auto bind = [&](KernelArguments& kernel) {
    kernel.set(1, out);
    kernel.set(2, 20);
  };
  executor.run(program(device, precision), "chain", groups, bind, {.largest_chunk = largest_chunk});
  std::vector<Real> written(out.size());
  out.read(written);
  const char* first = reinterpret_cast<const char*>(written.data());
  return {first, first + written.size() * sizeof(Real)};
}

std::vector<char> chained(Executor& executor, Precision precision, std::size_t groups, std::size_t largest_chunk) {
  return precision == Precision::fp32 ? chained_numbers<float>(executor, precision, groups, largest_chunk)
                                      : chained_numbers<double>(executor, precision, groups, largest_chunk);
}

TEST(Executor, SameBitsForAnyThreadsChunksAndDevice) {
  for (const Precision precision : {Precision::fp32, Precision::fp64}) {
    Executor one(device("basic"), {.threads = 1}), three(device("basic"), {.threads = 3}), other(device("pthread"));
    const auto expected = chained(one, precision, 777, 1);
    EXPECT_EQ(chained(three, precision, 777, 1), expected);
    EXPECT_EQ(chained(three, precision, 777, 4096), expected);
    EXPECT_EQ(chained(other, precision, 777, 1), expected);
    const auto alone = chained(one, precision, 1, 1);
    EXPECT_EQ(std::memcmp(alone.data(), expected.data(), alone.size()), 0);
  }
}

// Slow groups, some 0.2 s in all: every thread comes in time to get one, on a busy machine, too.
constexpr std::size_t slow_groups = 400;

TEST(Executor, ThreadsShareTheWork) {
  Executor executor(device("basic"), {.threads = 2});
  Marks marks(executor.device(), slow_groups);
  const RunReport report = executor.run(program(executor.device()), "mark_slowly", slow_groups, marks.bind());
  EXPECT_THAT(report.groups_by_thread, testing::ElementsAre(testing::Gt(0u), testing::Gt(0u)));
  EXPECT_EQ(marks.done(), slow_groups);
}

TEST(Executor, AnErrorInAWorkerReachesTheCaller) {
  Executor executor(device("basic"), {.threads = 2});
  Marks slow(executor.device(), slow_groups);
  int bound = 0;
  const Launch launch = executor.prepare(program(executor.device()), "mark_slowly", [&](KernelArguments& kernel) {
    if (bound++ == 0) slow.bind()(kernel);  // the second thread's kernel lacks its argument
  });
  EXPECT_EQ(bound, 2);
  EXPECT_THAT([&] { executor.run(launch, slow_groups); },
              throws_device_error("clEnqueueNDRangeKernel", "CL_INVALID_KERNEL_ARGS", "basic"));
  Marks marks(executor.device(), 100);  // and the executor goes on working
  executor.run(program(executor.device()), "mark", 100, marks.bind());
  EXPECT_EQ(marks.done(), 100u);
}

TEST(Executor, AWrongArgumentIsADeviceError) {
  Executor executor(device());
  const auto bind = [](KernelArguments& kernel) { kernel.set(7, 1); };
  EXPECT_THAT([&] { executor.run(program(device()), "mark", 1, bind); },
              throws_device_error("clSetKernelArg", "CL_INVALID_ARG_INDEX"));
}

class ProgressOn : public testing::TestWithParam<std::string> {};

TEST_P(ProgressOn, GrowsUpToTheTotal) {
  Executor executor(device(GetParam()), {.threads = 2});
  Marks marks(executor.device(), slow_groups);
  std::vector<std::size_t> heard;
  const auto progress = [&](std::size_t done, std::size_t total) {
    EXPECT_EQ(total, slow_groups);
    heard.push_back(done);
    return true;
  };
  executor.run(program(executor.device()), "mark_slowly", slow_groups, marks.bind(), {.progress = progress});
  EXPECT_GE(heard.size(), 2u);
  EXPECT_TRUE(std::ranges::is_sorted(heard));
  EXPECT_EQ(heard.back(), slow_groups);
  EXPECT_EQ(std::ranges::count(heard, slow_groups), 1);
}

TEST_P(ProgressOn, FalseCancels) {
  Executor executor(device(GetParam()), {.threads = 2});
  Marks marks(executor.device(), slow_groups);
  const auto progress = [&](std::size_t done, std::size_t) { return done < 20; };
  const RunReport report =
      executor.run(program(executor.device()), "mark_slowly", slow_groups, marks.bind(), {.progress = progress});
  EXPECT_TRUE(report.cancelled);
  EXPECT_GE(report.groups_done, 20u);
  EXPECT_LT(report.groups_done, slow_groups);
  EXPECT_EQ(marks.done(), report.groups_done);  // what was not done was left alone
}

TEST_P(ProgressOn, AStopOfTheCallerEndsTheRun) {
  Executor executor(device(GetParam()), {.threads = 2});
  Marks marks(executor.device(), slow_groups);
  std::atomic<int> looks = 0;
  const StopScope::Asked asked = [&] { return ++looks > 2; };
  const StopScope scope(&asked);
  EXPECT_THROW(executor.run(program(executor.device()), "mark_slowly", slow_groups, marks.bind()), Stopped);
  EXPECT_LT(marks.done(), slow_groups);
}

TEST_P(ProgressOn, AnExceptionEndsTheRun) {
  Executor executor(device(GetParam()), {.threads = 2});
  Marks marks(executor.device(), slow_groups);
  const auto progress = [](std::size_t, std::size_t) -> bool { throw std::runtime_error("enough"); };
  EXPECT_THROW(
      executor.run(program(executor.device()), "mark_slowly", slow_groups, marks.bind(), {.progress = progress}),
      std::runtime_error);
  EXPECT_LT(marks.done(), slow_groups);
}

INSTANTIATE_TEST_SUITE_P(Devices, ProgressOn, testing::ValuesIn(tested_devices()));

// With progress a GPU still gets slices that fill it: 2048 groups for each of its 132 compute units, and all of less
// work.
TEST(Executor, SlicesFillAGpu) {
  Executor executor(Device("basic").as_gpu());
  constexpr std::size_t slice = 2048 * 132;
  using Shown = std::vector<std::size_t>;
  for (const auto& [groups, expected] : {std::pair(slice + 5, Shown{slice, slice + 5}), {41'000, Shown{41'000}}}) {
    const Marks marks(executor.device(), groups);
    Shown shown;
    executor.clear_times();
    executor.run(program(executor.device()), "mark", groups, marks.bind(),
                 {.progress = [&](std::size_t done, std::size_t) {
                   shown.push_back(done);
                   return true;
                 }});
    EXPECT_EQ(shown, expected);
    EXPECT_EQ(executor.times().at("mark").launches, expected.size());
    EXPECT_EQ(marks.done(), groups);
  }
}

TEST(Executor, SeveralJobsAreOnePool) {
  for (const std::string& choice : tested_devices()) {
    Executor executor(device(choice), {.threads = 2});
    const Program built = program(executor.device());
    const Marks first(executor.device(), 3), none(executor.device(), 1), last(executor.device(), 5000);
    const std::vector<Job> jobs{{executor.prepare(built, "mark", first.bind()), 3},
                                {executor.prepare(built, "mark", none.bind()), 0},
                                {executor.prepare(built, "mark_unguarded", last.bind()), 5000}};
    EXPECT_EQ(executor.run(jobs).groups_done, 5003u);
    EXPECT_EQ(first.done(), 3u);
    EXPECT_EQ(none.done(), 0u);
    EXPECT_EQ(last.done(), 5000u);
    const auto times = executor.times();
    EXPECT_EQ(times.at("mark").groups, 3u);
    EXPECT_EQ(times.at("mark_unguarded").groups, 5000u);
    EXPECT_GT(times.at("mark_unguarded").seconds, 0.0);
    executor.clear_times();
    EXPECT_EQ(executor.times().at("mark").launches, 0u);
  }
}

// Three threads run launches of their own and one in common: a run that finds the threads taken goes beside them.
TEST(Executor, RunsOfSeveralThreadsGoBesideEachOther) {
  constexpr std::size_t groups = 10, runs = 40;
  Executor executor(device("basic"), {.threads = 2});
  const Program built = program(executor.device());
  const Marks alone(executor.device(), 1);
  const Launch shared = executor.prepare(built, "mark", alone.bind());
  const auto many_runs = [&] {
    for (std::size_t run = 0; run < runs; ++run) {
      const Marks marks(executor.device(), groups);
      const Launch launch = executor.prepare(built, "mark_slowly", marks.bind());
      EXPECT_EQ(executor.run(launch, groups).groups_done, groups);
      EXPECT_EQ(marks.done(), groups);
      executor.run(shared, 1);
    }
  };
  {
    const std::jthread one(many_runs), two(many_runs);
    many_runs();
  }
  const auto times = executor.times();
  EXPECT_EQ(times.at("mark_slowly").groups, 3 * runs * groups);
  EXPECT_EQ(times.at("mark").groups, 3 * runs);
}

// On devices that schedule themselves: each of two runs waits in its progress for the other one's.
TEST(Executor, RunsGoSideBySideOnDevicesThatScheduleThemselves) {
  constexpr std::size_t groups = 300'000;  // two slices of a GPU
  for (const Device& on : {device("basic").as_gpu(), device("pthread")}) {
    Executor executor(on);
    const Program built = program(on);
    std::latch both(2);
    const auto meet = [&] {
      both.count_down();
      for (const auto start = Clock::now(); !both.try_wait() && seconds_since(start) < 10;) std::this_thread::yield();
      return both.try_wait();
    };
    const auto run = [&] {
      const Marks marks(on, groups);
      std::optional<bool> met;
      executor.run(built, "mark", groups, marks.bind(), {.progress = [&](std::size_t, std::size_t) {
                     if (!met) met = meet();
                     return true;
                   }});
      EXPECT_EQ(met, true) << on.info().name;
      EXPECT_EQ(marks.done(), groups);
    };
    {
      const std::jthread other(run);
      run();
    }
    EXPECT_EQ(executor.times().at("mark").groups, 2 * groups);
  }
}

TEST(Executor, AnswersAreReadWhileAGpuComputes) {
  Executor executor(device("basic").as_gpu());
  const Marks marks(executor.device(), 2000);
  const Launch launch = executor.prepare(program(executor.device()), "mark_slowly", marks.bind());
  const Buffer<int> answers(executor.device(), std::vector<int>(100'000, 7));
  std::atomic<bool> computes = true;
  std::size_t read = 0;
  std::jthread reader([&] {
    while (computes) {
      EXPECT_EQ(answers.map(MapFor::reading)[99'999], 7);
      read += computes;
    }
  });
  const auto start = Clock::now();
  executor.run(launch, 2000);
  EXPECT_GT(seconds_since(start), 0.05);  // much longer than a copy
  computes = false;
  reader.join();
  EXPECT_GT(read, 1u);
}

TEST(Executor, ALaunchBelongsToItsExecutor) {
  Executor one(device()), other(device());
  const Launch launch = one.prepare(program(device()), "mark");
  EXPECT_THROW(other.run(launch, 1), std::logic_error);
  EXPECT_THROW(other.run(Launch(), 1), std::logic_error);
}

// PoCL 3.1 aborts when threads bring wider and wider grids of one kernel; two executors and ragged runs provoke that.
TEST(Executor, WidthsMayGrowOnAllThreads) {
  const Program built = program(device());
  const auto ragged_runs = [&](int seed) {
    Executor executor(device(), {.threads = 2});
    Marks marks(device(), 4096);
    const Launch launch = executor.prepare(built, "mark", marks.bind());
    for (std::size_t run = 0; run < 300; ++run) executor.run(launch, 1 + (run * (37 + seed)) % 4096);
  };
  std::thread other(ragged_runs, 1);
  ragged_runs(2);
  other.join();
}

// In the place of a GPU PoCL compiles a kernel for each ragged end, and aborts where another thread launches it then.
TEST(Executor, RaggedEndsMayBeNewOnAllThreads) {
  const Device gpu = device("basic").as_gpu();
  const Program built = program(gpu);
  const auto ragged_runs = [&](std::size_t first) {
    Executor executor(gpu);
    for (std::size_t groups = first; groups < 192; groups += 23) {
      const Marks marks(gpu, groups);
      executor.run(built, "mark", groups, marks.bind());
      EXPECT_EQ(marks.done(), groups);
    }
  };
  const std::jthread one(ragged_runs, 65), two(ragged_runs, 70);
  ragged_runs(75);
}

TEST(Executor, ThreadsFromTheEnvironment) {
  setenv("TACTEL_THREADS", "3", 1);
  EXPECT_EQ(Executor(device()).threads(), 3);
  EXPECT_EQ(Executor(device(), {.threads = 1}).threads(), 1);
  for (const char* bad : {"0", "-1", "two", "3x", "99999"}) {
    setenv("TACTEL_THREADS", bad, 1);
    EXPECT_THROW(Executor{device()}, ConfigError) << bad;
  }
  unsetenv("TACTEL_THREADS");
}

// PoCL keeps 128 kernels. One that it has forgotten, launched by several threads in grids that grow, ended the process.
TEST(ExecutorKernels, AreMoreThanPoclKeeps) {
  constexpr int kernels = 140, rounds = 5;
  constexpr std::size_t groups = 20000;
  std::string all = "#include \"shared/group.h\"\n";
  for (int k = 0; k < kernels; ++k)
    all += "kernel void add" + std::to_string(k) + "(uint first_group, global int *out) {\n  TAKE_GROUP(group);\n" +
           "  out[group] += " + std::to_string(k) + ";\n}\n";
  const Device device("basic");
  Executor executor(device, {.threads = 4});
  const Program program = Program::from_text(device, "many.cl", all, lanes_of(device, Precision::fp32));
  Buffer<int> out(device, groups);
  out.write(std::vector<int>(groups));
  std::vector<Launch> launches;
  for (int k = 0; k < kernels; ++k)
    launches.push_back(executor.prepare(program, "add" + std::to_string(k),
                                        [&](KernelArguments& arguments) { arguments.set(1, out); }));
  for (int round = 0; round < rounds; ++round)
    for (const Launch& launch : launches) executor.run(launch, groups);
  std::vector<int> sums(groups);
  out.read(sums);
  EXPECT_THAT(sums, testing::Each(rounds * kernels * (kernels - 1) / 2));
}

}  // namespace tactel::host::executor_test
