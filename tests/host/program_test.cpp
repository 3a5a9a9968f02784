// Programs and the cache of their binaries.
#include "host/program.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "host/binary_cache.h"
#include "host/buffer.h"
#include "tests/host/test_device.h"

namespace tactel::host {
namespace {

namespace fs = std::filesystem;

std::string content(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void overwrite(const fs::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary | std::ios::trunc) << bytes;
}

class ProgramCache : public testing::Test {
 protected:
  void SetUp() override { fs::remove_all(folder_); }
  void TearDown() override { fs::remove_all(folder_); }

  Program program(const Defines& defines = {{"FACTOR", "3"}}) const {
    const char* text =
        "#include \"shared/group.h\"\n"
        "kernel void scale(uint first_group, global int *out) { TAKE_GROUP(group); out[group] = FACTOR * (int)group; "
        "}\n"
        "kernel void negate(uint first_group, global int *out) { TAKE_GROUP(group); out[group] = -(int)group; }\n";
    return Program::from_text(device(), "scale.cl", text, defines, {.cache_directory = folder_});
  }

  /// out[group] of a launch.
  int result(const Program& program, const std::string& kernel, std::size_t group) const {
    Executor executor(device());
    std::vector<int> numbers(group + 1, -1000);
    Buffer<int> out(device(), std::span<const int>(numbers));
    executor.run(program, kernel, group + 1, [&](cl::Kernel& bound) { bound.setArg(1, out.cl_buffer()); });
    out.read(numbers);
    return numbers[group];
  }

  std::vector<fs::path> files() const {
    std::vector<fs::path> found;
    if (fs::exists(folder_))
      for (const auto& entry : fs::directory_iterator(folder_)) found.push_back(entry.path());
    return found;
  }

  const fs::path folder_ = fs::temp_directory_path() / ("tactel_program_test_" + std::to_string(getpid()));
};

TEST_F(ProgramCache, StoredOnceLaunchedAndFoundAgain) {
  const Program first = program();
  EXPECT_FALSE(first.from_cache());
  EXPECT_TRUE(files().empty());  // nothing is compiled yet
  EXPECT_EQ(result(first, "scale", 5), 15);
  ASSERT_EQ(files().size(), 1u);
  const Program second = program();
  EXPECT_TRUE(second.from_cache());
  EXPECT_EQ(result(second, "scale", 5), 15);
}

TEST_F(ProgramCache, AKernelThatTheStoredBinaryLacksIsAdded) {
  result(program(), "scale", 1);
  const auto stored = content(files().at(0));
  EXPECT_EQ(result(program(), "negate", 5), -5);
  EXPECT_NE(content(files().at(0)), stored);
  const auto both = content(files().at(0));
  EXPECT_EQ(result(program(), "scale", 5), 15);  // now nothing is new
  EXPECT_EQ(content(files().at(0)), both);
}

TEST_F(ProgramCache, OtherDefinesAreAnotherProgram) {
  result(program(), "scale", 1);
  const Program other = program({{"FACTOR", "4"}});
  EXPECT_FALSE(other.from_cache());
  EXPECT_EQ(result(other, "scale", 5), 20);
  EXPECT_EQ(files().size(), 2u);
}

TEST_F(ProgramCache, DamagedFilesAreRebuilt) {
  result(program(), "scale", 1);
  const fs::path path = files().at(0);
  const std::string good = content(path);
  std::string flipped = good;
  flipped[good.size() - 100] ^= 1;
  for (const std::string& bad : {flipped, good.substr(0, good.size() / 2), std::string(), std::string("not ours")}) {
    overwrite(path, bad);
    const Program rebuilt = program();
    EXPECT_FALSE(rebuilt.from_cache());
    EXPECT_EQ(result(rebuilt, "scale", 5), 15);
    EXPECT_TRUE(program().from_cache());
  }
}

// A binary that is intact but that the driver does not take.
TEST_F(ProgramCache, ABinaryThatTheDriverRefusesIsRebuilt) {
  std::vector<std::string> messages;
  const Device logging("basic", [&](LogLevel level, std::string_view message) {
    if (level == LogLevel::warning) messages.emplace_back(message);
  });
  const char* text = "kernel void nothing(uint first_group) {}";
  const auto build = [&] { return Program::from_text(logging, "n.cl", text, {}, {.cache_directory = folder_}); };
  const Program first = build();
  first.note_launched("nothing");
  const fs::path path = files().at(0);
  const DeviceInfo& info = logging.info();
  const std::string key = info.platform + "\n" + info.name + "\n" + info.driver + "\n" + first.options() + "\n" +
                          expand_includes("n.cl", text);
  const BinaryCache cache(folder_, "n.cl", key);
  ASSERT_EQ(cache.path(), path);
  ASSERT_TRUE(cache.store({{"nothing"}, std::vector<unsigned char>(1000, 0x42)}));
  const Program rebuilt = build();
  EXPECT_FALSE(rebuilt.from_cache());
  EXPECT_NO_THROW(rebuilt.kernel("nothing"));
  EXPECT_THAT(messages, testing::ElementsAre(testing::HasSubstr("stored binary refused")));
}

TEST_F(ProgramCache, AnUnwritableDirectoryCostsOnlyTheCaching) {
  overwrite(folder_, "a file where the directory should be");
  EXPECT_EQ(result(program(), "scale", 5), 15);
  EXPECT_FALSE(program().from_cache());
}

TEST_F(ProgramCache, EveryFlippedByteAndEveryTruncationIsNoticed) {
  const BinaryCache cache(folder_, "a.cl", "the key");
  ASSERT_TRUE(cache.store({{"one", "two"}, {1, 2, 3, 4}}));
  const auto stored = cache.load();
  ASSERT_TRUE(stored);
  EXPECT_EQ(stored->kernels, (std::set<std::string>{"one", "two"}));
  EXPECT_EQ(stored->binary, (std::vector<unsigned char>{1, 2, 3, 4}));
  const std::string good = content(cache.path());
  for (std::size_t i = 0; i < good.size(); ++i) {
    std::string bad = good;
    bad[i] ^= 0x10;
    overwrite(cache.path(), bad);
    EXPECT_FALSE(cache.load()) << "byte " << i;
    overwrite(cache.path(), good.substr(0, i));
    EXPECT_FALSE(cache.load()) << "cut at " << i;
  }
}

TEST_F(ProgramCache, AnotherKeyInTheFileIsNotTaken) {
  const BinaryCache one(folder_, "a.cl", "one"), other(folder_, "a.cl", "other");
  ASSERT_TRUE(one.store({{"k"}, {1}}));
  fs::rename(one.path(), other.path());
  EXPECT_FALSE(other.load());
}

TEST(Fnv, PublishedValues) {  // http://www.isthe.com/chongo/src/fnv/test_fnv.c
  EXPECT_EQ(fnv1a(""), 0xcbf29ce484222325u);
  EXPECT_EQ(fnv1a("a"), 0xaf63dc4c8601ec8cu);
  EXPECT_EQ(fnv1a("foobar"), 0x85944171f73967e8u);
}

TEST(Program, KnowsWhichKernelsTakeTheirGroup) {
  const Program program = Program::from_text(device(), "two.cl",
                                             "#include \"shared/group.h\"\n"
                                             "kernel void without(uint first_group) {}\n"
                                             "kernel void with(uint first_group) { TAKE_GROUP(group); (void)group; }\n",
                                             {}, {.cache = false});
  EXPECT_TRUE(program.takes_group("with"));
  EXPECT_FALSE(program.takes_group("without"));
  EXPECT_FALSE(program.takes_group("nonesuch"));
  EXPECT_THROW(program.kernel("nonesuch"), DeviceError);
}

}  // namespace
}  // namespace tactel::host
