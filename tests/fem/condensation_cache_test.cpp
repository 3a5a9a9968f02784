// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstring>
#include <sstream>
#include <thread>

#include "fem/mesh/condensation.h"
#include "fem/numbers/cache_directory.h"
#include "sensors.h"
#include "tests/fem/resealed.h"
#include "tests/scratch.h"

namespace tactel::fem::condensation_cache_test {

namespace fs = std::filesystem;

Sensor little() { return {.columns = 9, .rows = 3, .tactels = 5}; }

bool same_bits(const Condensation& a, const Condensation& b) {
  const auto same = [](const auto& p, const auto& q) {
    return p.rows() == q.rows() && p.cols() == q.cols() &&
           std::memcmp(p.data(), q.data(), sizeof(double) * static_cast<std::size_t>(p.size())) == 0;
  };
  return same(a.compliance, b.compliance) && same(a.base_force, b.base_force) &&
         same(a.tactel_stress, b.tactel_stress) && same(a.surface_x, b.surface_x) && same(a.base_x, b.base_x) &&
         same(a.tactel_x, b.tactel_x);
}

const auto read = text_of;
void write(const fs::path& path, const std::string& bytes) { std::ofstream(path, std::ios::binary) << bytes; }

class CondensationCache : public testing::Test {
 protected:
  std::vector<fs::path> files() const {
    std::vector<fs::path> found;
    if (fs::exists(directory))
      for (const auto& entry : fs::directory_iterator(directory)) found.push_back(entry.path());
    return found;
  }
  fs::path only_file() const {
    EXPECT_EQ(files().size(), 1u);
    return files().at(0);
  }

  const ScratchFolder folder;
  const fs::path directory = folder / "";
  const Condensation computed = condense(little());
};

TEST_F(CondensationCache, FnvIsThePublishedOne) {
  // Test vectors of the FNV specification (RFC 9923).
  EXPECT_EQ(fnv(""), 0xcbf29ce484222325u);
  EXPECT_EQ(fnv("a"), 0xaf63dc4c8601ec8cu);
  EXPECT_EQ(fnv("foobar"), 0x85944171f73967e8u);
}

TEST_F(CondensationCache, AHitIsWhatWasComputedBitForBit) {
  EXPECT_TRUE(same_bits(condense_cached(little(), directory), computed));  // miss
  const std::string bytes = read(only_file());
  EXPECT_TRUE(same_bits(condense_cached(little(), directory), computed));  // hit
  EXPECT_EQ(read(only_file()), bytes);
}

TEST_F(CondensationCache, AHitIsReadFromTheFile) {
  // A value changed under a right checksum comes back: so the cache was asked, not the solver.
  condense_cached(little(), directory);
  std::string bytes = read(only_file());
  const double marker = 12345;
  std::memcpy(bytes.data() + bytes.size() - 16, &marker, 8);  // the last tactel's place
  write(only_file(), resealed(bytes));
  EXPECT_EQ(condense_cached(little(), directory).tactel_x[4], marker);
}

/// The first value of a name in /proc/cpuinfo.
std::string of_cpuinfo(const std::string& name) {
  std::istringstream lines(read("/proc/cpuinfo"));
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with(name)) return line.substr(line.find(": ") + 2);
  return "";
}

// Eigen blocks its products by the caches, and the C library chooses instructions by the model: a cache that machines
// share keeps them apart.
TEST_F(CondensationCache, TheKeyHoldsTheProcessor) {
  condense_cached(little(), directory);
  const std::string bytes = read(only_file()), model = of_cpuinfo("model name");
  const auto at = bytes.find("\nprocessor ");
  ASSERT_NE(at, std::string::npos);
  const std::string line = bytes.substr(at + 1, bytes.find('\n', at + 1) - at - 1);
  EXPECT_NE(line.find(model), std::string::npos) << line << " / " << model;
  EXPECT_NE(line.find(" " + std::to_string(Eigen::l3CacheSize())), std::string::npos) << line;
}

// A file of another processor is none of this one's, whatever its checksum.
TEST_F(CondensationCache, AFileOfAnotherProcessorIsNotRead) {
  condense_cached(little(), directory);
  std::string bytes = read(only_file());
  const std::size_t at = bytes.find("\nprocessor ") + 11;
  ASSERT_LT(at, bytes.size());
  bytes[at] ^= 1;
  const double marker = 12345;
  std::memcpy(bytes.data() + bytes.size() - 16, &marker, 8);
  write(only_file(), resealed(bytes));
  EXPECT_TRUE(same_bits(condense_cached(little(), directory), computed));
}

TEST_F(CondensationCache, MakesItsDirectory) {
  condense_cached(little(), directory / "a" / "b");
  EXPECT_EQ(std::distance(fs::directory_iterator(directory / "a" / "b"), {}), 1);
}

using CondensationCacheSlow = CondensationCache;
TEST_F(CondensationCacheSlow, AnyFlippedByteIsFoundAndMended) {
  condense_cached(little(), directory);
  const fs::path file = only_file();
  const std::string good = read(file);
  // Every byte of the header and of the checksum; of the payload every 97th.
  const std::size_t header = 900;
  for (std::size_t k = 0; k < good.size(); k += (k < header || k + 16 > good.size()) ? 1 : 97) {
    std::string bad = good;
    bad[k] = static_cast<char>(bad[k] ^ (1 << (k % 8)));
    write(file, bad);
    ASSERT_TRUE(same_bits(condense_cached(little(), directory), computed)) << "byte " << k;
    ASSERT_EQ(read(file), good) << "byte " << k;
  }
}

TEST_F(CondensationCache, AWrongHeaderUnderARightChecksumIsForeign) {
  // Magic, format version, byte order, length of the key, key, sizes: whoever sealed the file, it is not ours.
  condense_cached(little(), directory);
  const fs::path file = only_file();
  const std::string good = read(file);
  const std::size_t values = 18 * 18 + 18 * 18 + 10 * 18 + 9 + 9 + 5, header = good.size() - 8 * values - 8;
  for (std::size_t k = 0; k < header; ++k) {
    std::string bad = good;
    bad[k] = static_cast<char>(bad[k] + 1);
    write(file, resealed(bad));
    ASSERT_TRUE(same_bits(condense_cached(little(), directory), computed)) << "byte " << k;
    ASSERT_EQ(read(file), good) << "byte " << k;
  }
}

TEST_F(CondensationCache, TruncatedLongerAndForeignFilesAreMended) {
  condense_cached(little(), directory);
  const fs::path file = only_file();
  const std::string good = read(file);
  for (const std::string& bad :
       {std::string(), good.substr(0, 8), good.substr(0, good.size() / 2), good.substr(0, good.size() - 1), good + "x",
        std::string("not a cache file\n"), std::string(good.size(), '\0')}) {
    write(file, bad);
    EXPECT_TRUE(same_bits(condense_cached(little(), directory), computed)) << bad.size() << " bytes";
    EXPECT_EQ(read(file), good);
  }
}

TEST_F(CondensationCache, AFileUnderAnotherSensorsNameIsNotBelieved) {
  Sensor other = little();
  other.poisson = 0.3;
  condense_cached(little(), directory);
  const fs::path mine = only_file();
  condense_cached(other, directory / "other");
  const fs::path theirs = fs::directory_iterator(directory / "other")->path();
  fs::copy_file(mine, theirs, fs::copy_options::overwrite_existing);
  EXPECT_TRUE(same_bits(condense_cached(other, directory / "other"), condense(other)));
}

TEST_F(CondensationCache, ADirectoryThatCannotBeWrittenCostsOnlyTheCaching) {
  write(directory / "file", "in the way");
  EXPECT_TRUE(same_bits(condense_cached(little(), directory / "file"), computed));
  EXPECT_TRUE(same_bits(condense_cached(little(), directory / "file" / "below"), computed));
  EXPECT_TRUE(same_bits(condense_cached(little(), "/proc/no-such-place"), computed));
  EXPECT_TRUE(same_bits(condense_cached(little(), ""), computed));
  fs::permissions(directory, fs::perms::owner_read | fs::perms::owner_exec);
  EXPECT_TRUE(same_bits(condense_cached(little(), directory), computed));
  fs::permissions(directory, fs::perms::owner_all);
}

TEST_F(CondensationCache, AFileThatCannotBeReplacedCostsOnlyTheCaching) {
  condense_cached(little(), directory);
  const fs::path file = only_file();
  fs::remove(file);
  fs::create_directories(file / "in the way");  // a directory of that name: rename fails even for root
  EXPECT_TRUE(same_bits(condense_cached(little(), directory), computed));
  EXPECT_EQ(files().size(), 1u) << "no temporary file may stay behind";
}

TEST_F(CondensationCache, EveryMemberButYoungIsInTheKey) {
  const auto count_after = [&](auto change) {
    Sensor sensor = little();
    change(sensor);
    EXPECT_TRUE(same_bits(condense_cached(sensor, directory), condense(sensor)));
    return files().size();
  };
  EXPECT_EQ(count_after([](Sensor&) {}), 1u);
  EXPECT_EQ(count_after([](Sensor& s) { s.young = 3; }), 1u) << "E only scales";
  EXPECT_EQ(count_after([](Sensor& s) { s.length = std::nextafter(s.length, 100); }), 2u) << "to the last digit";
  EXPECT_EQ(count_after([](Sensor& s) { s.thickness = 1.25; }), 3u);
  EXPECT_EQ(count_after([](Sensor& s) { s.poisson = 0.3; }), 4u);
  EXPECT_EQ(count_after([](Sensor& s) { s.columns = 11; }), 5u);
  EXPECT_EQ(count_after([](Sensor& s) { s.rows = 4; }), 6u);
  EXPECT_EQ(count_after([](Sensor& s) { s.grading = 2; }), 7u);
  EXPECT_EQ(count_after([](Sensor& s) { s.element = Element::q4; }), 8u);
  EXPECT_EQ(count_after([](Sensor& s) { s.element = Element::q4i; }), 9u);
  EXPECT_EQ(count_after([](Sensor& s) { s.element = Element::q8; }), 10u);
  EXPECT_EQ(count_after([](Sensor& s) { s.tactels = 4; }), 11u);
  EXPECT_EQ(count_after([](Sensor& s) { s.stress = StressRecovery::element; }), 12u);
  EXPECT_EQ(count_after([](Sensor& s) { s.tactel_span = 12; }), 13u);
  EXPECT_EQ(count_after([](Sensor& s) { s.tactel_width = 1; }), 14u);
  EXPECT_EQ(count_after([](Sensor& s) { s.layers = {{0.5, 1, 0.45}, {1, 2, 0.45}}; }), 15u);
  EXPECT_EQ(count_after([](Sensor& s) { s.young = 4, s.layers = {{0.5, 2, 0.45}, {1, 4, 0.45}}; }), 15u);
  EXPECT_EQ(count_after([](Sensor& s) { s.layers = {{0.5, 1, 0.4}, {1, 2, 0.45}}; }), 16u);
  // A member added to Sensor must be added to the key and here.
  static_assert(sizeof(Sensor) == sizeof(double) * 6 + sizeof(int) * 6 + sizeof(std::optional<double>) +
                                      sizeof(std::vector<RubberLayer>));
}

TEST_F(CondensationCache, ProcessesAndThreadsShareItSafely) {
  // Four processes of two threads fight over three files; a fifth hand keeps spoiling them.
  const auto work = [&] {
    bool good = true;
    for (int k = 0; k < 30; ++k) {
      Sensor sensor = little();
      sensor.rows = 3 + k % 3;
      good = good && same_bits(condense_cached(sensor, directory), condense(sensor));
    }
    return good;
  };
  std::vector<pid_t> children;
  for (int p = 0; p < 4; ++p) {
    children.push_back(fork());
    ASSERT_GE(children.back(), 0);
    if (children.back() == 0) {
      bool beside = false;
      std::thread other([&] { beside = work(); });
      const bool good = work();
      other.join();
      _exit(good && beside ? 0 : 1);
    }
  }
  for (int k = 0; k < 50; ++k) {
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(directory, error))
      if (entry.path().extension() == ".condensation")
        fs::resize_file(entry.path(), 100 + 7 * static_cast<std::uintmax_t>(k), error);
    usleep(200);
  }
  for (pid_t child : children) {
    int status = 0;
    waitpid(child, &status, 0);
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
  }
  EXPECT_TRUE(work());
  EXPECT_EQ(files().size(), 3u) << "no temporary file may stay behind";
}

TEST(CacheDirectory, FollowsTheEnvironment) {
  using Value = std::optional<std::string>;
  const auto with = [](const Value& own, const Value& cache, const Value& home) {
    const Environment first("TACTEL_CACHE_DIR", own), second("XDG_CACHE_HOME", cache), third("HOME", home);
    return default_cache_directory();
  };
  EXPECT_EQ(with("/a", "/b", "/c"), "/a");
  EXPECT_EQ(with("", "/b", "/c"), "/b/tactel");
  EXPECT_EQ(with({}, {}, "/c"), "/c/.cache/tactel");
  EXPECT_EQ(with({}, "", {}), "");
}

/// A folder in one that is removed after the test.
struct Nested {
  const ScratchFolder scratch;
  const fs::path outer = scratch / "outer", inner = outer / "inner";
  Nested() { fs::create_directories(inner), mode(outer, 0700), mode(inner, 0700); }
  static void mode(const fs::path& folder, unsigned bits) { fs::permissions(folder, static_cast<fs::perms>(bits)); }
};

TEST(CacheDirectory, OfOthersIsNotTrusted) {
  const Nested folders;
  EXPECT_EQ(distrust(folders.inner), "");
  EXPECT_EQ(distrust(folders.inner / "to/be/made"), "");
  for (const unsigned open : {0777u, 0702u}) {
    Nested::mode(folders.inner, open);
    EXPECT_NE(distrust(folders.inner), "") << open;
  }
  Nested::mode(folders.inner, 0755);  // others may read
  EXPECT_EQ(distrust(folders.inner), "");
  // Who can write to the folder above can exchange this one, unless it is sticky.
  Nested::mode(folders.outer, 0777);
  EXPECT_NE(distrust(folders.inner), "");
  EXPECT_NE(distrust(folders.inner / "to/be/made"), "");
  Nested::mode(folders.outer, 01777);
  EXPECT_EQ(distrust(folders.inner), "");
  const char* const of_another = geteuid() == 0 ? folders.inner.c_str() : "/usr";
  if (geteuid() == 0) {
    ASSERT_EQ(chown(of_another, 65534, 65534), 0);
  }
  EXPECT_EQ(distrust(of_another), std::string(of_another) + " belongs to another user");
}

// Nothing is read from it, nor written.
TEST(CacheDirectory, ThatOthersCanWriteIsNotUsed) {
  const Nested folders;
  const Environment named("TACTEL_CACHE_DIR", folders.inner.string());
  EXPECT_EQ(default_cache_directory(), folders.inner);
  Nested::mode(folders.inner, 0777);
  EXPECT_EQ(default_cache_directory(), "");
}

}  // namespace tactel::fem::condensation_cache_test
