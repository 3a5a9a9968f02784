// SPDX-License-Identifier: Apache-2.0

// The cache of compiled kernels: processes share whole programs alone, and a damaged one is not believed.
#include "host/device/compile_cache.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <functional>
#include <stdexcept>

#include "host/support/durable_file.h"
#include "tests/host/support/run_tactel.h"

namespace tactel::host::compile_cache_test {

namespace fs = std::filesystem;
using testing::HasSubstr;

class Cache : public testing::Test {
 protected:
  fs::path folder() const { return folder_ / "."; }
  ScratchFolder folder_;
};

/// Another process in the folder, which compiles and ends when it is told to.
class Other {
 public:
  explicit Other(const std::function<void(const CompileCache&)>& compile, const fs::path& folder) {
    if (pipe(ready_) != 0 || pipe(end_) != 0) throw std::runtime_error("no pipe");
    child_ = fork();
    if (child_ != 0) {
      char byte = 0;
      if (read(ready_[0], &byte, 1) != 1) throw std::runtime_error("the other process ended");
      return;
    }
    const CompileCache cache(folder);
    compile(cache);
    char byte = 'x';
    (void)!write(ready_[1], &byte, 1);
    (void)!read(end_[0], &byte, 1);
    _exit(0);
  }
  ~Other() {
    (void)!write(end_[1], "x", 1);
    waitpid(child_, nullptr, 0);
    for (const int each : {ready_[0], ready_[1], end_[0], end_[1]}) close(each);
  }
  pid_t process() const { return child_; }
  Other(const Other&) = delete;
  Other& operator=(const Other&) = delete;

 private:
  int ready_[2], end_[2];
  pid_t child_;
};

// PoCL aborts where another process removes what it compiled, or has half written it. So each has files of its own,
// whatever locks there are.
TEST_F(Cache, ProcessesShareNoFilesOfPoCL) {
  const CompileCache first(folder()), second(folder());
  EXPECT_NE(first.own(), second.own());
  EXPECT_TRUE(fs::is_directory(first.own()));
  first.leave();
  EXPECT_FALSE(fs::exists(first.own()));
  EXPECT_TRUE(fs::is_directory(second.own()));
}

// What a fork of this process does at its end.
TEST_F(Cache, AForkLeavesTheFolderToItsParent) {
  const CompileCache cache(folder());
  if (const pid_t child = fork(); child == 0) {
    cache.leave();
    _exit(0);
  } else {
    waitpid(child, nullptr, 0);
  }
  EXPECT_TRUE(fs::is_directory(cache.own()));
}

struct Left {
  const char* name;
  std::string kernel;  ///< under which the process ran
  int minutes;         ///< since the last change
  bool removed;
};
class LeftFolder : public Cache, public testing::WithParamInterface<Left> {};

// Nobody holds these locked. Where locks do not reach other hosts, that says nothing of a process there.
TEST_P(LeftFolder, GoesWhereItsProcessCannotLive) {
  const fs::path left = folder_ / ("process." + GetParam().kernel + ".1.abcdef");
  fs::create_directories(left / "AB/PROGRAM");
  fs::last_write_time(left, fs::file_time_type::clock::now() - std::chrono::minutes(GetParam().minutes));
  const CompileCache cache(folder());
  EXPECT_EQ(fs::exists(left), !GetParam().removed);
}

INSTANTIATE_TEST_SUITE_P(Of, LeftFolder,
                         testing::Values(Left{"this_kernel_now", running_kernel(), 0, false},
                                         Left{"this_kernel_earlier", running_kernel(), 1, true},
                                         Left{"another_kernel_earlier", "0123456789abcdef", 120, false},
                                         Left{"another_kernel_long_ago", "0123456789abcdef", 1500, true}),
                         [](const auto& info) { return info.param.name; });

TEST_F(Cache, LeavesTheFolderOfALivingProcess) {
  const Other other([](const CompileCache& its) { fs::create_directory(its.own() / "AB"); }, folder());
  for (const auto& entry : fs::directory_iterator(folder_ / ""))
    if (entry.is_directory())
      fs::last_write_time(entry.path(), fs::file_time_type::clock::now() - std::chrono::hours(100));
  const CompileCache cache(folder());
  int there = 0;
  for (const auto& entry : fs::directory_iterator(folder_ / "")) there += fs::exists(entry.path() / "AB");
  EXPECT_EQ(there, 1);
}

// Only who needs the same program waits, and knows for whom.
TEST_F(Cache, TheTurnIsForOneProgram) {
  const CompileCache cache(folder());
  CompileCache::Turn same(cache, "program"), another(cache, "another program");
  {
    const Other other(
        [](const CompileCache& its) {
          auto* const turn = new CompileCache::Turn(its, "program");  // until its end
          if (turn->take() != 0) _exit(1);
        },
        folder());
    EXPECT_EQ(same.take(), other.process());
    EXPECT_EQ(another.take(), 0);
  }
  EXPECT_EQ(same.take(), 0);
}

TEST_F(Cache, AKilledProcessGivesItsTurnBack) {
  const CompileCache cache(folder());
  const Other other([](const CompileCache& its) { (new CompileCache::Turn(its, "program"))->take(); }, folder());
  CompileCache::Turn turn(cache, "program");
  EXPECT_EQ(turn.take(), other.process());
  kill(other.process(), SIGKILL);
  waitpid(other.process(), nullptr, 0);
  EXPECT_EQ(turn.take(), 0);
}

/// The only file of a built program.
fs::path kept_file(const ScratchFolder& folder) { return fs::directory_iterator(folder / "programs")->path(); }

TEST_F(Cache, KeepsBinariesOfPrograms) {
  const std::string key = "compiler, options, source", binary = std::string("a\nb\0c", 5);
  const CompileCache cache(folder());
  EXPECT_EQ(cache.program(key), "");
  cache.keep_program(key, binary);
  EXPECT_EQ(cache.program(key), binary);
  EXPECT_EQ(cache.program("another key"), "");
  cache.keep_program("another key", "x");
  EXPECT_EQ(cache.program(key), binary);
}

TEST_F(Cache, BelievesNoDamagedBinary) {
  const CompileCache cache(folder());
  cache.keep_program("key", "binary");
  const std::string good = text_of(kept_file(folder_));
  for (std::size_t k = 0; k < good.size(); ++k) {
    std::string bad = good;
    bad[k] = static_cast<char>(bad[k] ^ 1);
    std::ofstream(kept_file(folder_)) << bad;
    EXPECT_EQ(cache.program("key"), "") << "byte " << k;
    std::ofstream(kept_file(folder_)) << good.substr(0, k);
    EXPECT_EQ(cache.program("key"), "") << k << " bytes";
  }
  // Under the name of another key.
  std::ofstream(kept_file(folder_)) << good;
  const fs::path mine = kept_file(folder_);
  cache.keep_program("other", "another binary");
  for (const auto& entry : fs::directory_iterator(folder_ / "programs"))
    if (entry.path() != mine) fs::copy_file(mine, entry.path(), fs::copy_options::overwrite_existing);
  EXPECT_EQ(cache.program("other"), "");
  EXPECT_EQ(cache.program("key"), "binary");
}

// Machine code is loaded from it: neither the folder nor the one that holds it may be another's.
TEST(CachePlace, IsNoFolderThatOthersCanWrite) {
  const ScratchFolder folder;
  const fs::path own = folder / "own/pocl";
  fs::create_directories(own);
  for (const fs::path& open : {own, own.parent_path()}) {
    chmod(open.c_str(), 0777);
    EXPECT_THAT(choose_cache(own, {}).trouble, HasSubstr("others can write to")) << open;
    chmod(open.c_str(), 0755);
    EXPECT_EQ(choose_cache(own, {}).folder, own);
  }
}

TEST(CachePlace, IsTheFirstThatCanBeWritten) {
  const ScratchFolder folder;
  fs::create_directory(folder / "shared");
  const std::vector<fs::path> shared = {folder / "shared"};
  const fs::path own = folder / "own/pocl", ours = folder / "shared" / ("tactel-" + std::to_string(getuid()));
  EXPECT_EQ(choose_cache(own, shared).folder, own);
  const CachePlace second = choose_cache("/dev/null/no/place", shared);
  EXPECT_EQ(second.folder, ours);
  EXPECT_THAT(second.trouble, HasSubstr("/dev/null/no/place ("));
  chmod(ours.c_str(), 0777);
  const CachePlace none = choose_cache("/dev/null/no/place", shared);
  EXPECT_EQ(none.folder, "");
  EXPECT_THAT(none.trouble, HasSubstr(ours.string() + " (others can write to"));
  EXPECT_THAT(choose_cache("", {}).trouble, HasSubstr("HOME is not set"));
  // no disk has so much room: as a full one
  EXPECT_THAT(choose_cache(own, {}, std::size_t{1} << 62).trouble, HasSubstr("the disk is full"));
}

}  // namespace tactel::host::compile_cache_test
