// SPDX-License-Identifier: Apache-2.0

// Every scene in examples/ runs, by both solvers, and meets its tolerance.
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "tests/host/support/run_tactel.h"

namespace tactel::host::examples_test {

/// Of lines or of pads.
std::vector<std::string> examples(bool pads) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(source_file("examples"))) {
    const bool scene =
        entry.path().extension() == ".toml" && text_of(entry.path()).find("[sweep]") == std::string::npos;
    const bool pad = text_of(entry.path()).find("kind = \"pad\"") != std::string::npos;
    if (scene && pad == pads) names.push_back(entry.path().stem().string());
  }
  std::ranges::sort(names);
  return names;
}

class Example : public testing::TestWithParam<std::string> {};

nlohmann::json solved(const std::vector<std::string>& arguments) {
  const ChildResult result = run_tactel({"solve", "--json", "-"}, arguments);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  auto json = nlohmann::json::parse(result.out);
  const bool fine_mesh =
      json["scene"]["sensor"]["columns"] > 81 && json["model"].get<std::string>().starts_with("mesh");
  const std::string of_layers = "warning: errors were not measured for scenes like this one: layers upon layers\n";
  std::string said = without_progress(result.err);
  if (said.starts_with(of_layers)) said.erase(0, of_layers.size());
  EXPECT_EQ(said, fine_mesh ? "warning: the error of this answer is not estimated: its mesh "
                              "has more than 81 columns or 33 rows (--accuracy estimates)\n"
                            : "");
  return json;
}

/// A copy of the example that names the mesh, in a folder with the files that it names.
std::string on_mesh(const ScratchFolder& folder, const std::string& scene) {
  folder.write("measured.csv", text_of(source_file("examples/measured.csv")));
  std::string text = text_of(scene);
  const std::string table = "[sensor]\n", with_model = "[sensor]\nmodel = \"mesh\"\n";
  if (const std::size_t at = text.find(table); at != std::string::npos)
    text.replace(at, table.size(), with_model);
  else
    text += "\n" + with_model;
  return folder.write("mesh.toml", text);
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
  const ScratchFolder folder;
  const std::string mesh = on_mesh(folder, scene);
  // fp64 both; forces are told apart by the contact laws to about 1e-11 of the largest, P by less
  expect_same_course(solved({mesh, "--solver", "reference"}), solved({mesh}));
}

/// As its file says, and on the finest patch beside the reference: within the 95 % of docs/claims.md, doubled.
TEST_P(Example, RunsAsItStandsAndOnAPatch) {
  const std::string scene = source_file("examples/" + GetParam() + ".toml");
  EXPECT_FALSE(solved({scene})["steps"].empty());
  const nlohmann::json patch = solved({scene, "--rung", "patch-24"}), exact = solved({scene, "--rung", "reference"});
  for (std::size_t k = 0; k < std::min(patch["steps"].size(), exact["steps"].size()); ++k) {
    const nlohmann::json &a = patch["steps"][k]["slip_index"], &b = exact["steps"][k]["slip_index"];
    ASSERT_EQ(a.is_null(), b.is_null()) << "step " << k + 1;
    if (a.is_null()) continue;
    EXPECT_NEAR(a.get<double>(), b.get<double>(), 0.01) << "step " << k + 1;
  }
}

INSTANTIATE_TEST_SUITE_P(All, Example, testing::ValuesIn(examples(false)), [](const auto& info) { return info.param; });

class PadExample : public testing::TestWithParam<std::string> {};

// The twin shares no code with the kernel. Its S is exact, where four rounds of the kernel leave 1e-3.
TEST_P(PadExample, RunsBySolversThatAgree) {
  const std::string scene = source_file("examples/" + GetParam() + ".toml");
  EXPECT_EQ(text_of(scene).substr(0, 2), "# ") << "an example says in its first line what it shows";
  const auto answer = [&](const std::string& solver) {
    const ChildResult result = run_tactel({"solve", scene, "--json", "-", "--solver", solver});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    // One warning at most: of a deep face, that strain is left out; of a new model, that errors were not measured.
    const std::string said = without_progress(result.err);
    EXPECT_TRUE(said.empty() || (said.find('\n') + 1 == said.size() &&
                                 (said.starts_with("warning: the face is") ||
                                  said.starts_with("warning: errors were not measured for scenes like this one"))))
        << said;
    return nlohmann::json::parse(result.out);
  };
  const auto a = answer("batched"), b = answer("twin");
  ASSERT_EQ(a["steps"].size(), b["steps"].size());
  ASSERT_FALSE(a["steps"].empty());
  for (std::size_t k = 0; k < a["steps"].size(); ++k) {
    const auto &p = a["steps"][k], &q = b["steps"][k];
    const double P = p["P"];
    EXPECT_NEAR(P, q["P"].get<double>(), 1e-5 * P) << "step " << k + 1;
    for (const int axis : {0, 1}) EXPECT_NEAR(p["Q"][axis].get<double>(), q["Q"][axis].get<double>(), 1e-5 * P);
    EXPECT_NEAR(p["slip_index"].get<double>(), q["slip_index"].get<double>(), 1e-3) << "step " << k + 1;
  }
}

INSTANTIATE_TEST_SUITE_P(All, PadExample, testing::ValuesIn(examples(true)),
                         [](const auto& info) { return info.param; });

}  // namespace tactel::host::examples_test
