// The cache of compiled kernels: what PoCL would abort on is found first, and nothing else is thrown away.
#include "host/device/compile_cache.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

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
    const CompileCache::Use use{CompileCache(folder())};
    SetUp();
    use.seal();
  }
  std::size_t damaged() const { return CompileCache::Use{CompileCache(folder())}.damaged(); }

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
    const CompileCache::Use found{CompileCache(folder())};
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
  add("sealed", std::string(1000, '\0') + "\nno list\n\n0 0 0 0\n");
  EXPECT_EQ(damaged(), 0u);
  EXPECT_FALSE(there("AB/FIRST") || there("CD/SECOND"));
}

// The files of a compilation are listed when it ends: until then nobody else may take them for leftovers.
TEST_F(Cache, WaitsForAnotherProcessThatCompiles) {
  fs::remove_all(folder_ / "AB");
  fs::remove_all(folder_ / "CD");
  int ready[2];
  ASSERT_EQ(pipe(ready), 0);
  const pid_t other = fork();
  if (other == 0) {
    const CompileCache::Use at_work{CompileCache(folder())};
    SetUp();
    (void)!write(ready[1], "x", 1);
    usleep(200'000);
    at_work.seal();
    _exit(0);
  }
  char byte = 0;
  ASSERT_EQ(read(ready[0], &byte, 1), 1);
  EXPECT_EQ(damaged(), 0u);
  EXPECT_TRUE(there("AB/FIRST/kernel/1-1-1/kernel.so"));
  waitpid(other, nullptr, 0);
}

// What a process leaves that is killed as it compiles is not loaded.
TEST_F(Cache, DropsWhatAKilledCompilationLeft) {
  fill();
  {
    const CompileCache::Use killed{CompileCache(folder())};
    add("CD/SECOND/kernel/1-1-1/kernel.so", "obj");
  }
  EXPECT_EQ(damaged(), 0u);
  EXPECT_FALSE(there("CD/SECOND"));
  EXPECT_TRUE(there("AB/FIRST/program.bc"));
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
  EXPECT_THAT(none.trouble, HasSubstr(ours.string() + " (other users can enter it)"));
  // no disk has so much room: as a full one
  EXPECT_THAT(choose_cache(own, {}, std::size_t{1} << 62).trouble, HasSubstr("the disk is full"));
}

}  // namespace
}  // namespace tactel::host
