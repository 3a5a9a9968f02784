// SPDX-License-Identifier: Apache-2.0

// The cache of compiled kernels: what PoCL would abort on is found first, and nothing else is removed.
#include "host/device/compile_cache.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <functional>
#include <stdexcept>

#include "tests/host/support/run_tactel.h"

namespace tactel::host {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

/// A folder as PoCL fills it: two programs, and what lies beside them.
class Cache : public testing::Test {
 protected:
  void SetUp() override {
    add("AB/FIRST/program.bc", "first");
    add("AB/FIRST/kernel/1-1-1/kernel.so", "object");
    add("AB/FIRST/last_accessed", "now");
    add("CD/SECOND/program.bc", "second");
    add("tempfile_x", "");
  }
  void add(const std::string& name, const std::string& content) {
    fs::create_directories((folder_ / name).parent_path());
    folder_.write(name, content);
  }
  bool there(const std::string& name) const { return fs::exists(folder_ / name); }
  fs::path folder() const { return folder_ / "."; }
  /// As a process that compiles both programs.
  void fill() {
    const CompileCache cache(folder());
    SetUp();
    cache.seal();
  }
  std::size_t damaged() const { return CompileCache(folder()).damaged(); }

  ScratchFolder folder_;
};

TEST_F(Cache, KeepsWhatIsListedAndWhole) {
  EXPECT_EQ(damaged(), 0u);
  EXPECT_FALSE(there("AB/FIRST"));  // nothing is listed: two programs go
  fill();
  add("AB/FIRST/last_accessed", "later");  // PoCL's own stamp counts for nothing
  EXPECT_EQ(damaged(), 0u);
  EXPECT_TRUE(there("AB/FIRST/kernel/1-1-1/kernel.so"));
  EXPECT_TRUE(there("CD/SECOND/program.bc"));
}

struct Damage {
  const char* name;
  void (*to)(const fs::path& file);
};
class DamagedCache : public Cache, public testing::WithParamInterface<Damage> {};

TEST_P(DamagedCache, LosesThatProgramAlone) {
  fill();
  GetParam().to(folder_ / "AB/FIRST/kernel/1-1-1/kernel.so");
  {
    const CompileCache found(folder());
    EXPECT_EQ(found.damaged(), 1u);
    EXPECT_FALSE(there("AB/FIRST"));
    EXPECT_TRUE(there("CD/SECOND/program.bc"));
    add("AB/FIRST/program.bc", "compiled anew");
    found.seal();
  }
  EXPECT_EQ(damaged(), 0u);
  EXPECT_EQ(text_of(folder_ / "AB/FIRST/program.bc"), "compiled anew");
}

INSTANTIATE_TEST_SUITE_P(
    By, DamagedCache,
    testing::Values(Damage{"truncation", [](const fs::path& file) { fs::resize_file(file, 2); }},
                    Damage{"growth", [](const fs::path& file) { fs::resize_file(file, 4096); }},
                    Damage{"other_bytes", [](const fs::path& file) { std::ofstream(file) << "OBJECT"; }},
                    Damage{"a_link",
                           [](const fs::path& file) { fs::remove(file), fs::create_symlink("/etc/hostname", file); }}),
    [](const auto& info) { return info.param.name; });

// A copied cache has other times of change, but the same content.
TEST_F(Cache, ReadsTheContentWhereTheTimeDiffers) {
  fill();
  fs::last_write_time(folder_ / "AB/FIRST/program.bc", fs::file_time_type::clock::now() + std::chrono::hours(1));
  EXPECT_EQ(damaged(), 0u);
  EXPECT_TRUE(there("AB/FIRST/program.bc"));
}

// A list that a power cut has torn, or that holds anything: its files count as not listed.
TEST_F(Cache, BelievesNoDamagedList) {
  fill();
  const std::string list = text_of(folder_ / "sealed");
  add("sealed", list.substr(0, list.size() - 3));
  EXPECT_EQ(damaged(), 0u);
  EXPECT_NE(there("AB/FIRST"), there("CD/SECOND"));  // the last line was one of theirs
  add("sealed", std::string(1000, '\0').append("\nno list\n\n0 0 0 0\n"));
  EXPECT_EQ(damaged(), 0u);
  EXPECT_FALSE(there("AB/FIRST") || there("CD/SECOND"));
}

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

// PoCL loads and compiles outside of any lock of ours: what another process has is left alone, whatever its state.
TEST_F(Cache, LeavesTheFilesOfOtherProcesses) {
  fill();
  {
    const Other other(
        [&](const CompileCache&) {
          add("EF/THIRD/program.bc", "not listed");
          add("AB/FIRST/program.bc", "changed by another process");
        },
        folder());
    EXPECT_EQ(damaged(), 0u);
    EXPECT_TRUE(there("EF/THIRD/program.bc"));
    EXPECT_TRUE(there("AB/FIRST/program.bc"));
  }
  EXPECT_EQ(damaged(), 1u);  // now alone
  EXPECT_FALSE(there("EF/THIRD"));
  EXPECT_FALSE(there("AB/FIRST"));
}

// A file that was listed while another process wrote it counts as damaged later; that costs a compilation.
TEST_F(Cache, AFileListedTooEarlyIsCompiledAnew) {
  fill();
  {
    const CompileCache cache(folder());
    add("EF/THIRD/kernel.so", "half");
    cache.seal();
    add("EF/THIRD/kernel.so", "half and half");
  }
  EXPECT_EQ(damaged(), 1u);
  EXPECT_FALSE(there("EF/THIRD"));
  EXPECT_TRUE(there("AB/FIRST/program.bc"));
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

// A process that is stopped in the middle of its check keeps the folder for itself.
TEST_F(Cache, AStoppedProcessHoldsUpNobody) {
  fill();
  const int held = open((folder_ / "processes").c_str(), O_RDWR);
  ASSERT_EQ(flock(held, LOCK_EX), 0);
  const auto start = std::chrono::steady_clock::now();
  {
    const CompileCache cache(folder());
    cache.keep_program("key", "binary");
    cache.seal();
    EXPECT_EQ(cache.program("key"), "binary");
    EXPECT_TRUE(there("AB/FIRST/program.bc"));
  }
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(10));  // 2 s, on a machine with other work
  close(held);
}

// What a process leaves that is killed as it compiles is not loaded.
TEST_F(Cache, DropsWhatAKilledCompilationLeft) {
  fill();
  {
    const CompileCache killed(folder());
    add("CD/SECOND/kernel/1-1-1/kernel.so", "obj");
  }
  EXPECT_EQ(damaged(), 0u);
  EXPECT_FALSE(there("CD/SECOND"));
  EXPECT_TRUE(there("AB/FIRST/program.bc"));
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

}  // namespace
}  // namespace tactel::host
