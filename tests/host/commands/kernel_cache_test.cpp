// SPDX-License-Identifier: Apache-2.0

// The program on a cache of compiled kernels that is damaged, and interrupted while it compiles.
#include <gmock/gmock.h>

#include "tests/host/commands/small_sweep.h"
#include "tests/host/support/run_tactel.h"

namespace tactel::host::kernel_cache_test {

namespace fs = std::filesystem;
using testing::HasSubstr;

/// `tactel solve` on a cache of its own; `pocl` is where PoCL keeps what it compiled.
class SolveWithCache : public testing::Test {
 protected:
  ChildResult solve() {
    return run_child({"env", "-u", "POCL_CACHE_DIR", "TACTEL_CACHE_DIR=" + (folder_ / "cache").string(), TACTEL_PROGRAM,
                      "solve", source_file("examples/parabola.toml")});
  }
  ScratchFolder folder_;
};

TEST_F(SolveWithCache, DamagedFilesCostACompilation) {
  const ChildResult first = solve();
  ASSERT_EQ(first.exit_code, 0) << first.err;
  EXPECT_EQ(without_progress(first.err), "");
  int damaged = 0;
  for (const auto& file : fs::directory_iterator(folder_ / "cache/pocl/programs")) {
    fs::resize_file(file.path(), 100);
    ++damaged;
  }
  ASSERT_EQ(damaged, 1);
  const ChildResult second = solve();
  EXPECT_EQ(second.exit_code, 0) << second.err;
  EXPECT_EQ(second.out, first.out);
}

/// Programs that are kept, and folders of processes.
std::pair<int, int> kept_and_left(const fs::path& pocl) {
  int kept = 0, left = 0;
  for (const auto& entry : fs::directory_iterator(pocl / "programs")) kept += entry.path().extension() == ".binary";
  for (const auto& entry : fs::directory_iterator(pocl)) left += entry.is_directory();
  return {kept, left - 1};
}

/// PoCL's binary has a kernel for groups of one item and for groups of any size. They begin with equal headers where
/// both are the same.
TEST_F(SolveWithCache, ARunLeavesTheProgramAloneWhoseKernelIsCompiledOnce) {
  ASSERT_EQ(solve().exit_code, 0);
  EXPECT_EQ(kept_and_left(folder_ / "cache/pocl"), std::pair(1, 0));
  const std::string binary = text_of(fs::directory_iterator(folder_ / "cache/pocl/programs")->path());
  const std::size_t first = binary.find("\177ELF"), second = binary.find("\177ELF", first + 1);
  ASSERT_NE(second, std::string::npos);
  EXPECT_EQ(binary.substr(first, 64), binary.substr(second, 64));
}

/// A shell in which $solve and $other are solutions of scenes by two different programs; $cache is their cache. `all`
/// signals a program and the process that compiles for it.
ChildResult in_shell(const ScratchFolder& folder, const std::string& script) {
  const std::string solve =
                        std::string("solve='" TACTEL_PROGRAM " solve ") + source_file("examples/parabola.toml") + "'; ",
                    other = std::string("other='" TACTEL_PROGRAM " solve --rung patch-8 ") +
                            source_file("examples/parabola.toml") + "'; ";
  return run_child({"env", "-u", "POCL_CACHE_DIR", "TACTEL_CACHE_DIR=" + (folder / "cache").string(), "bash", "-c",
                    "cd " + (folder / "").string() + "; cache=cache/pocl; " + solve + other +
                        "all() { kill -$1 $2 $(pgrep -P $2); }; " + script});
}

using SolveWithCacheSlow = SolveWithCache;
// A program that compiles, and is stopped in the midst of it, holds up neither a warm start nor another compilation.
TEST_F(SolveWithCacheSlow, NobodyWaitsForAStoppedProgram) {
  const ChildResult result = in_shell(folder_, R"(
    $other > warm 2> log || exit 10
    $solve > first 2>> log & compiling=$!
    until pgrep -P $compiling > children; do sleep 0.01; done; sleep 0.3
    all STOP $compiling
    timeout 60 $other > again 2>> log || exit 11
    timeout 60 $solve > second 2>> log || exit 12
    all CONT $compiling
    wait $compiling || exit 13
    cmp warm again && cmp first second)");
  EXPECT_EQ(result.exit_code, 0) << result.out << result.err << text_of(folder_ / "log");
}

// Programs on hosts that do not see each other's locks: each gets every lock at once. None loses the files that it
// compiles or loads, and what they keep serves the next one.
TEST_F(SolveWithCacheSlow, LocksThatDoNotReachOtherHosts) {
  const ChildResult result = in_shell(folder_, R"(
    export LD_PRELOAD=)" TACTEL_NO_LOCKS R"(
    for k in 1 2; do $solve > answer$k 2> log$k & all="$all $!"; sleep 0.4; done
    for process in $all; do wait $process || exit 1$process; done
    $solve > last || exit 10
    for k in 1 2; do cmp answer$k last || exit 11; done)");
  EXPECT_EQ(result.exit_code, 0) << result.out << result.err;
  EXPECT_EQ(kept_and_left(folder_ / "cache/pocl"), std::pair(1, 0));
}

// Two programs that need the same kernels at once: one waits for the other, and answers as ever.
TEST_F(SolveWithCacheSlow, TwoProgramsNeedTheSameKernels) {
  const ChildResult result = in_shell(folder_, R"(
    $solve > first 2> log1 & one=$!
    $solve > second 2> log2 || exit 10
    wait $one || exit 11
    cmp first second && ls $cache/programs | wc -l > programs)");
  EXPECT_EQ(result.exit_code, 0) << result.out << result.err;
  EXPECT_EQ(text_of(folder_ / "programs"), "1\n");
}

// What a kill in the midst of it leaves costs the next program a compilation.
TEST_F(SolveWithCacheSlow, KilledWhileItCompiles) {
  const ChildResult result = in_shell(folder_, R"(
    for wait in 0.1 0.8; do
      rm -rf cache
      $solve > first 2> log & compiling=$!
      until pgrep -P $compiling > children; do sleep 0.01; kill -0 $compiling || break; done; sleep $wait
      all KILL $compiling
      wait $compiling
      $solve > second 2>> log || exit 10
      $solve > third 2>> log || exit 11
      cmp second third || exit 12
    done 2> noise)");
  EXPECT_EQ(result.exit_code, 0) << result.out << result.err << text_of(folder_ / "log");
}

using SolveWithCacheNightly = SolveWithCache;
// Batch systems limit the address space. Whether the kernels compile within it or not, the program ends in time; warm,
// it needs little.
TEST_F(SolveWithCacheNightly, LittleAddressSpaceEndsInWords) {
  int failed = 0;
  for (const char* megabytes : {"300", "400", "500", "600", "700", "800", "900"}) {
    const ChildResult result =
        in_shell(folder_, std::string("rm -rf cache; ulimit -v ") + megabytes + "000; timeout 60 $solve > answer");
    EXPECT_THAT(result.exit_code, testing::AnyOf(0, 3)) << megabytes << " MB: " << result.err;
    if (result.exit_code == 0) continue;
    ++failed;
    EXPECT_THAT(result.err, HasSubstr("the address space is limited to")) << megabytes << " MB";
    EXPECT_THAT(result.err, HasSubstr("ulimit -v 2097152")) << megabytes << " MB";
  }
  EXPECT_GT(failed, 2);
  ASSERT_EQ(solve().exit_code, 0);
  EXPECT_EQ(in_shell(folder_, "ulimit -v 700000; timeout 60 $solve > answer").exit_code, 0);
}

TEST_F(SolveWithCache, ThreadsLeaveAddressSpaceToTheWork) {
  const ChildResult result = in_shell(folder_, "ulimit -v 6000000; TACTEL_THREADS=1024 timeout 60 $solve > answer");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("of 1024 threads could be created"));
}

TEST_F(SolveWithCache, NoThreadsEndInWords) {
  const ChildResult result = in_shell(folder_, "LD_PRELOAD=" TACTEL_NO_THREADS " $solve");
  EXPECT_TRUE(is_refused(result, {"Resource temporarily unavailable", "ulimit -u"}, 3));
}

// The compiler of a driver that nobody knows runs in another process first, for each program once.
TEST_F(SolveWithCache, AnUnknownDriverMayCrash) {
  const std::string preload = "export LD_PRELOAD=" TACTEL_UNKNOWN_DRIVER "; ";
  const ChildResult crash = in_shell(folder_, preload + "CRASH=1 $solve > answer");
  EXPECT_TRUE(is_refused(crash, {"compiling gap_sweep.cl", "signal 11", "choose another --device"}, 3));
  const ChildResult good = in_shell(folder_, "$solve > known; " + preload + R"(
    $solve > first || exit 10
    cmp known first || exit 11
    ls $cache/programs > programs
    $solve > second && cmp first second && ls $cache/programs | cmp - programs)");
  EXPECT_EQ(good.exit_code, 0) << good.err;
  EXPECT_EQ(kept_and_left(folder_ / "cache/pocl"), std::pair(2, 0));
}

TEST_F(SolveWithCache, AKernelThatWritesNothingIsRefused) {
  for (const std::string scene : {"", "solve='" TACTEL_PROGRAM " solve " TACTEL_SOURCE_DIR "/examples/pad.toml'; "}) {
    const ChildResult idle =
        in_shell(folder_, scene + "export LD_PRELOAD=" TACTEL_UNKNOWN_DRIVER "; IDLE=1 $solve > answer");
    EXPECT_TRUE(is_refused(idle, {"left answers unwritten", "choose another --device"}, 3)) << scene;
  }
}

TEST_F(SolveWithCache, ANetworkOfAKernelThatWritesNothingIsRefused) {
  folder_.write("small.toml", SmallSweep{.contacts = 20}.text());
  const std::string train = TACTEL_PROGRAM " train set.h5 --network 10-3-1 --cycles 3 --output ",
                    idle = "export IDLE=1 LD_PRELOAD=" TACTEL_UNKNOWN_DRIVER "; timeout 60 ";
  const ChildResult made =
      in_shell(folder_, TACTEL_PROGRAM " generate small.toml --output set.h5 && " + train + "trained");
  ASSERT_EQ(made.exit_code, 0) << made.err;
  for (const std::string& command :
       {train + "online", train + "batch --schedule batch", std::string(TACTEL_PROGRAM " recall trained set.h5")})
    EXPECT_TRUE(is_refused(in_shell(folder_, idle + command), {"left answers unwritten"}, 3)) << command;
}

// A log has one line for all compilations.
TEST_F(SolveWithCache, SaysOnceThatItCompiles) {
  const ChildResult result = in_shell(folder_, "$solve > answer");
  std::istringstream lines(result.err);
  int said = 0;
  for (std::string line; std::getline(lines, line);) {
    EXPECT_THAT(line, testing::Not(HasSubstr("gap_sweep.cl")));
    said += line.find("compiling") != line.npos;
  }
  EXPECT_LE(said, 1) << result.err;
}

TEST_F(SolveWithCache, AFolderThatOthersCanWriteIsNotUsed) {
  const ChildResult result = in_shell(folder_, "mkdir cache tmp; chmod 777 cache; TMPDIR=$PWD/tmp $solve > answer");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("compiled kernels are kept in " + (folder_ / "tmp/tactel-").string()));
  EXPECT_THAT(result.err,
              HasSubstr("others can write to " + (folder_ / "cache").string() + ": empty it, then chmod go-w "));
  EXPECT_TRUE(fs::is_empty(folder_ / "cache"));
}

/// On a full disk, `full`, beside one with room, `free` (in a mount namespace of its own).
class OnAFullDisk : public SolveWithCache {
 protected:
  void SetUp() override {
    for (const char* name : {"full", "free"}) fs::create_directory(folder_ / name);
    if (run_child({"unshare", "--user", "--map-root-user", "--mount", "true"}).exit_code != 0)
      GTEST_SKIP() << "this user cannot make a mount namespace";
  }
  /// The caches of tactel are on the full disk, but for `tmp`, the folder of temporary files; `home` is where PoCL
  /// keeps kernels if it is not told.
  ChildResult solve_in(const std::string& tmp, const std::string& home) const {
    const auto at = [&](const std::string& name) { return (folder_ / name).string(); };
    const std::string full = at("full");
    return run_child({"unshare", "--user", "--map-root-user", "--mount", "sh", "-c",
                      "mount -t tmpfs -o mode=700,size=1m none " + full + " && mount --bind " + full +
                          " /dev/shm && ! cat /dev/zero > " + full +
                          "/zero && exec env -u POCL_CACHE_DIR -u XDG_CACHE_HOME TACTEL_CACHE_DIR=" + full +
                          " TMPDIR=" + at(tmp) + " HOME=" + at(home) + " " TACTEL_PROGRAM " solve " +
                          source_file("examples/parabola.toml")});
  }
  std::string full_cache() const { return (folder_ / "full/pocl").string(); }
};

TEST_F(OnAFullDisk, AnotherPlaceIsTakenAndNamed) {
  const ChildResult result = solve_in("free", "full");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("compiled kernels are kept in " + (folder_ / "free/tactel-").string()));
  EXPECT_THAT(result.err, HasSubstr(full_cache() + " ("));
}

// PoCL then compiles in its own folder, if that has room.
TEST_F(OnAFullDisk, WhereNoPlaceIsLeftAWarningSaysWhatToDo) {
  for (const char* home : {"free", "full"}) {
    const ChildResult result = solve_in("full", home);
    EXPECT_EQ(result.exit_code, home == std::string("free") ? 0 : 3) << result.err;
    EXPECT_THAT(result.err, HasSubstr("warning: compiled kernels need a folder, and none can be used: "));
    EXPECT_THAT(result.err, HasSubstr(full_cache() + " ("));
    EXPECT_THAT(result.err, HasSubstr("set TACTEL_CACHE_DIR to a folder that can be written"));
  }
}

using OnAFullDiskNightly = OnAFullDisk;
// The compiler fails, or PoCL aborts in the middle of it. With room again, the kernel is compiled and the answer as
// ever.
TEST_F(OnAFullDiskNightly, ThatFillsDuringACompilationTheErrorSaysSo) {
  const ChildResult expected = solve();
  ASSERT_EQ(expected.exit_code, 0) << expected.err;
  const std::string full = (folder_ / "full").string();
  const std::string command = "env -u POCL_CACHE_DIR TACTEL_CACHE_DIR=" + full + " " TACTEL_PROGRAM " solve " +
                              source_file("examples/parabola.toml");
  int failed = 0;
  for (const char* seconds : {"0", "0.3", "0.6", "1", "1.5"}) {
    const ChildResult first =
        run_child({"unshare", "--user", "--map-root-user", "--mount", "sh", "-c",
                   "mount -t tmpfs -o mode=700,size=20m none " + full + "; (until [ -e " + full +
                       "/pocl/compiling ]; do sleep 0.01; done; sleep " + seconds + "; cat /dev/zero > " + full +
                       "/zero) 2> /dev/null & " + command + " > /dev/null; code=$?; wait; rm " + full + "/zero; " +
                       command + " || exit 99; exit $code"});
    EXPECT_THAT(first.exit_code, testing::AnyOf(0, 3)) << seconds << " s: " << first.err;
    EXPECT_EQ(first.out, expected.out) << seconds << " s";
    if (first.exit_code == 0) continue;
    ++failed;
    EXPECT_THAT(first.err, HasSubstr("found no room in " + full +
                                     "/pocl: the disk is full; make room there, or set "
                                     "TACTEL_CACHE_DIR to another folder"));
  }
  EXPECT_GT(failed, 0);
}

// Ctrl-C reaches the compiler's linker, too: wherever it comes, the run ends as interrupted, or is done.
TEST_F(SolveWithCacheNightly, InterruptedWhileItCompilesEndsAsSuch) {
  const std::string sweep = folder_.write("sweep.toml", SmallSweep{.contacts = 40000, .indentation = "0.1"}.text());
  for (int tenths = 2; tenths <= 14; tenths += 2) {
    const std::string name = std::to_string(tenths);
    const ChildResult result =
        run_child({"env", "-u", "POCL_CACHE_DIR", "TACTEL_CACHE_DIR=" + (folder_ / ("cache" + name)).string(),
                   "timeout", "--preserve-status", "-s", "INT", std::to_string(0.1 * tenths), TACTEL_PROGRAM,
                   "generate", sweep, "--output", (folder_ / (name + ".h5")).string()});
    EXPECT_THAT(result.exit_code, testing::AnyOf(0, 130)) << tenths << " tenths: " << result.err;
  }
}

}  // namespace tactel::host::kernel_cache_test
