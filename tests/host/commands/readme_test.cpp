// SPDX-License-Identifier: Apache-2.0

// What README.md shows is what the program prints.
#include <gtest/gtest.h>

#include "tests/host/support/run_tactel.h"

namespace tactel::host::readme_test {

/// Lines of a table of steps, without iterations and residual, which differ between processors, and of the error.
std::vector<std::string> step_lines(const std::string& text) {
  constexpr std::size_t step_to_slip = 60;
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    if (line.find(" yes ") != std::string::npos || line.starts_with("step "))
      lines.push_back(line.substr(0, step_to_slip));
    if (line.starts_with("error of the patch") || line.ends_with("% of the largest")) lines.push_back(line);
  }
  return lines;
}

TEST(Readme, TableIsWhatTheProgramPrints) {
  const std::string readme = text_of(source_file("README.md"));
  ASSERT_NE(readme.find("$ build/tactel solve examples/cylinder.toml\n"), std::string::npos);
  const auto shown = step_lines(readme),
             printed = step_lines(run_tactel({"solve", source_file("examples/cylinder.toml")}).out);
  EXPECT_EQ(shown.size(), 12u);
  EXPECT_EQ(shown, printed);
}

TEST(ReadmeFiles, FilesItNamesAreThere) {
  const std::string readme = text_of(source_file("README.md"));
  for (const char* name :
       {"docs/contact.webp", "docs/contact-dark.webp", "docs/pages.md", "docs/scenes.md", "docs/networks.md",
        "examples", "fem", "kernels", "host", "nn", "hw", "CHANGELOG.md", "LICENSE", "scripts/run", "scripts/test"}) {
    EXPECT_NE(readme.find(name), std::string::npos) << name;
    EXPECT_TRUE(std::filesystem::exists(source_file(name))) << name;
  }
}

}  // namespace tactel::host::readme_test
