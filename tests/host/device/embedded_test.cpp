// SPDX-License-Identifier: Apache-2.0

// Kernel sources inside the library: what the compiler gets, and what it says when it does not like it.
#include "kernels/embedded.h"

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>

#include "host/device/program.h"
#include "test_paths.h"
#include "tests/host/device/test_device.h"

namespace tactel::host::embedded_test {

namespace fs = std::filesystem;
using testing::HasSubstr;

const fs::path kernel_folder = fs::path(TACTEL_SOURCE_DIR) / "kernels";

std::string content(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::string log_of(const std::string& text, const Defines& defines) {
  try {
    Program::from_text(device(), "broken.cl", text, defines);
  } catch (const KernelBuildError& error) {
    EXPECT_EQ(error.source, "broken.cl");
    EXPECT_THAT(error.what(), HasSubstr(error.log));
    return error.log;
  }
  return "it compiled";
}

TEST(Embedded, EveryFileAsItIsOnDisk) {
  std::size_t files = 0;
  for (const fs::path& folder :
       {kernel_folder, kernel_folder / "pad", kernel_folder / "patch", kernel_folder / "shared"})
    for (const auto& entry : fs::directory_iterator(folder)) {
      const std::string name = fs::relative(entry.path(), kernel_folder).generic_string();
      if (!name.ends_with(".cl") && !(folder != kernel_folder && name.ends_with(".h"))) continue;
      ++files;
      const auto source = std::ranges::find(kernels::sources(), name, &kernels::Source::name);
      ASSERT_NE(source, kernels::sources().end()) << name;
      EXPECT_EQ(source->text, content(entry.path())) << name;
    }
  EXPECT_EQ(files, kernels::sources().size());
}

// The executor can compile ahead only those.
TEST(Embedded, EveryKernelTakesItsGroup) {
  const std::regex kernel("kernel void (\\w+)\\(([^)]*)\\)\\s*\\{\\s*([^;]*;)");
  for (const kernels::Source& source : kernels::sources()) {
    const std::string text(source.text);
    for (auto match = std::sregex_iterator(text.begin(), text.end(), kernel); match != std::sregex_iterator();
         ++match) {
      EXPECT_TRUE((*match)[2].str().starts_with("uint first_group")) << source.name << ": " << (*match)[1];
      EXPECT_EQ((*match)[3], "TAKE_GROUP(group);") << source.name << ": " << (*match)[1];
    }
  }
}

TEST(Embedded, IncludesAreReplacedOnceAndLinesKept) {
  const std::string text =
      expand_includes("a.cl", "#include \"shared/group.h\"\n  # include \"shared/group.h\"\nint x;");
  EXPECT_EQ(text.find("#line 1 \"a.cl\"\n"), 0u);
  const std::size_t first = text.find("#line 1 \"shared/group.h\"\n");
  ASSERT_NE(first, text.npos);
  EXPECT_EQ(text.find("#line 1 \"shared/group.h\"", first + 1), text.npos);
  EXPECT_TRUE(text.ends_with("#line 3 \"a.cl\"\nint x;\n"));
  EXPECT_THROW(expand_includes("a.cl", "#include \"shared/nothing.h\""), std::out_of_range);
}

TEST(EmbeddedOnDevice, AnUnknownSourceIsNamed) {
  EXPECT_THAT([] { Program(device(), "nothing.cl", {}); },
              testing::ThrowsMessage<std::out_of_range>(HasSubstr("nothing.cl")));
}

TEST(EmbeddedOnDevice, BuildLogNamesFileAndLine) {
  EXPECT_THAT(log_of("#include \"shared/group.h\"\n\nint x = nonsense;\n", {}), HasSubstr("broken.cl:3:"));
  EXPECT_THAT(log_of("#include \"shared/lanes.h\"\n", {{"REAL", "quux"}, {"LANES", "4"}}),
              HasSubstr("shared/lanes.h:"));
}

TEST(EmbeddedOnDevice, BuildErrorNamesTheOptions) {
  const std::string options = "-cl-std=CL1.2 -cl-denorms-are-zero -DLANES=16 -DREAL=float";
  EXPECT_THAT(
      [] {
        Program::from_text(device(), "broken.cl", "?", {{"LANES", "16"}, {"REAL", "float"}});
      },
      testing::Throws<KernelBuildError>(AllOf(testing::Field(&KernelBuildError::options, options),
                                              testing::Property(&KernelBuildError::what, HasSubstr(options)))));
}

}  // namespace tactel::host::embedded_test
