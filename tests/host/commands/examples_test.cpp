// Every scene in examples/ runs, by both solvers, and meets its tolerance.
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "tests/host/support/run_tactel.h"

namespace tactel::host {
namespace {

std::vector<std::string> examples() {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(source_file("examples"))) {
    const bool scene =
        entry.path().extension() == ".toml" && text_of(entry.path()).find("[sweep]") == std::string::npos;
    if (scene) names.push_back(entry.path().stem().string());
  }
  std::ranges::sort(names);
  return names;
}

class Example : public testing::TestWithParam<std::string> {};

nlohmann::json solved(const std::string& scene, const std::string& solver) {
  const ChildResult result = run_tactel({"solve", scene, "--json", "-", "--solver", solver});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(without_progress(result.err), "");
  return nlohmann::json::parse(result.out);
}

/// Scale of the stick-slip ratios that different solvers must share: the last S, where there is one.
void expect_same_course(const nlohmann::json& a, const nlohmann::json& b) {
  ASSERT_EQ(a["steps"].size(), b["steps"].size());
  for (std::size_t k = 0; k < a["steps"].size(); ++k) {
    const double force = a["steps"][k]["P"];
    EXPECT_NEAR(force, b["steps"][k]["P"].get<double>(), 1e-8 * force) << "step " << k + 1;
    EXPECT_NEAR(a["steps"][k]["Q"].get<double>(), b["steps"][k]["Q"].get<double>(), 1e-8 * force) << "step " << k + 1;
  }
}

TEST_P(Example, RunsBySolversThatAgree) {
  const std::string scene = source_file("examples/" + GetParam() + ".toml");
  EXPECT_EQ(text_of(scene).substr(0, 2), "# ") << "an example says in its first line what it shows";
  // fp64 both; forces are told apart by the contact laws to about 1e-11 of the largest, P by less
  expect_same_course(solved(scene, "reference"), solved(scene, "batched"));
}

INSTANTIATE_TEST_SUITE_P(All, Example, testing::ValuesIn(examples()), [](const auto& info) { return info.param; });

}  // namespace
}  // namespace tactel::host
