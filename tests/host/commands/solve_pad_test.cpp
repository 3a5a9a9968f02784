// SPDX-License-Identifier: Apache-2.0

// `tactel solve` of a pad, and the other commands, which take lines: outputs, exit codes, messages.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "tests/host/support/run_tactel.h"

namespace tactel::host::solve_pad_test {

using nlohmann::json;
using testing::HasSubstr;
using testing::UnorderedElementsAre;

const std::string pad = source_file("examples/pad.toml"), twist = source_file("examples/pad_twist.toml");

std::vector<std::string> keys(const json& object) {
  std::vector<std::string> names;
  for (const auto& [key, value] : object.items()) names.push_back(key);
  return names;
}

TEST(SolvePad, TableHasALineAStep) {
  const ChildResult result = run_tactel({"solve", pad});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("sphere on a 4 x 4 pad\nsphere on 4 x 4 tactels"));
  EXPECT_THAT(result.out, HasSubstr("\n   9  0.5000  0.4800  0.1600     0 "));
  EXPECT_THAT(result.out, HasSubstr("\n9 of 9 steps met the tolerance"));
  EXPECT_THAT(result.out, HasSubstr("error in S to expect: "));
  std::istringstream lines(result.out);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 79u) << line;
}

TEST(SolvePad, JsonHasTheDocumentedKeys) {
  const json answer = json::parse(run_tactel({"solve", twist, "--json", "-"}).out);
  EXPECT_THAT(keys(answer), UnorderedElementsAre("tactel", "scene", "solver", "precision", "device", "model", "rung",
                                                 "tactel_x", "tactel_y", "cell_x", "cell_y", "cell_width", "fallback",
                                                 "warnings", "steps", "discretisation_error"));
  EXPECT_THAT(keys(answer["discretisation_error"]),
              UnorderedElementsAre("slip_index", "P", "Q", "M", "sigma_z", "tau", "largest", "strain", "scenes",
                                   "outside", "from"));
  EXPECT_EQ(answer["scene"]["sensor"]["kind"], "pad");
  EXPECT_EQ(answer["scene"]["sensor"]["axes"], 3);  // a default
  EXPECT_EQ(answer["rung"], "pad-12");
  ASSERT_EQ(answer["steps"].size(), 6u);
  const json& step = answer["steps"][3];
  EXPECT_THAT(keys(step),
              UnorderedElementsAre("indentation", "tangential", "twist", "P", "Q", "M", "slip_index", "force_ratio",
                                   "stick_fraction", "slip_distance", "sigma_z", "tau_x", "tau_y", "status",
                                   "normal_force", "tangential_force", "converged", "iterations", "residual"));
  EXPECT_THAT(keys(step["residual"]), UnorderedElementsAre("penetration", "complementarity", "cone", "drift", "angle"));
  EXPECT_EQ(step["tangential"], (json{0.1, 0.0}));
  EXPECT_EQ(step["twist"], 6);  // degrees
  for (const char* key : {"sigma_z", "tau_x", "tau_y"}) EXPECT_EQ(step[key].size(), 16u) << key;
  for (const char* key : {"status", "normal_force", "tangential_force"}) EXPECT_EQ(step[key].size(), 144u) << key;
  EXPECT_EQ(answer["cell_x"].size(), 144u);
  EXPECT_EQ(answer["cell_width"].size(), 2u);
  // Totals are the sums over the cells, M about the axis at (0, 0); P is the force that was asked for.
  double P = 0, Qx = 0, M = 0, sticking = 0, touching = 0;
  for (std::size_t i = 0; i < 144; ++i) {
    const json& t = step["tangential_force"][i];
    P += step["normal_force"][i].get<double>();
    Qx += t[0].get<double>();
    M +=
        answer["cell_x"][i].get<double>() * t[1].get<double>() - answer["cell_y"][i].get<double>() * t[0].get<double>();
    sticking += step["status"][i] == "stick";
    touching += step["status"][i] != "open";
  }
  EXPECT_NEAR(P, 5, 1e-3);
  EXPECT_NEAR(step["P"].get<double>(), P, 1e-6);
  EXPECT_NEAR(step["Q"][0].get<double>(), Qx, 1e-6);
  EXPECT_NEAR(step["M"].get<double>(), M, 1e-5);
  EXPECT_NEAR(step["stick_fraction"].get<double>(), sticking / touching, 1e-6);
}

// Tactel (i, j), x fastest, of a press beside the middle: the one at the indenter carries most.
TEST(SolvePad, OneAxisGivesPressureAlone) {
  const ScratchFolder folder;
  const std::string scene = folder.write("scene.toml", R"([sensor]
kind = "pad"
tactels = [3, 2]
pitch = 2
axes = 1
thickness = 2
[indenter]
shape = "sphere"
radius = 5
position = [2, -1]
[load]
indentation = 0.2
)");
  const json step = json::parse(run_tactel({"solve", scene, "--json", "-"}).out)["steps"][0];
  EXPECT_FALSE(step.contains("tau_x") || step.contains("tau_y"));
  ASSERT_EQ(step["sigma_z"].size(), 6u);
  for (const std::size_t k : {0, 1, 3, 4, 5}) EXPECT_LT(step["sigma_z"][2], step["sigma_z"][k]);
}

TEST(SolvePad, RungsSolversAndAccuracy) {
  const auto answer = [](const std::vector<std::string>& options) {
    const ChildResult result = run_tactel({"solve", pad, "--json", "-"}, options);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return std::pair(json::parse(result.out), result.err);
  };
  EXPECT_EQ(answer({"--rung", "pad-8"}).first["cell_x"].size(), 64u);
  EXPECT_EQ(answer({"--precision", "fp32"}).first["precision"], "fp32");
  EXPECT_EQ(answer({"--solver", "twin"}).first["device"], "host");
  const auto [chosen, said] = answer({"--accuracy", "0.5"});
  EXPECT_EQ(chosen["rung"], "pad-8");
  EXPECT_EQ(chosen["accuracy"], (json{{"asked", 0.5}, {"kept", true}}));
  EXPECT_THAT(said, HasSubstr("rung pad-8 (8 x 8 cells, 2 increments): expected error in S"));
}

TEST(SolvePad, WhatItRefuses) {
  const auto refused = [](const std::vector<std::string>& options, const std::vector<std::string>& says) {
    EXPECT_TRUE(is_refused(run_tactel({"solve", pad}, options), says));
  };
  refused({"--rung", "patch-12"}, {"--rung = patch-12", "a rung of pads, one of pad-8"});
  refused({"--solver", "full-mesh"}, {"batched or twin for a pad"});
  refused({"--step", "10"}, {"--step = 10", "1 to 9"});
  refused({"--json", "no/such/folder/a.json"}, {"--json"});
  EXPECT_TRUE(is_refused(run_tactel({"solve", source_file("examples/parabola.toml"), "--rung", "pad-8"}),
                         {"--rung = pad-8", "a rung of lines, one of patch-8"}));
}

TEST(SolvePad, NamesTheLineOfAnErrorThatTheAnswerShows) {
  const ScratchFolder folder;
  std::string text = text_of(twist);
  text.insert(text.find("yaw = 30.0"), "position = [15.0, 0.0]\n");
  text.insert(text.find("[indenter]"), "sides = \"held\"\n\n");
  const std::string scene = folder.write("scene.toml", text);
  EXPECT_TRUE(is_refused(run_tactel({"solve", scene}), {"scene.toml:20: indenter.position = [15, 0]", "free sides"}));
}

TEST(SolvePad, HelpNamesItsWords) {
  const std::string help = run_tactel({"solve", "--help"}).out;
  for (const char* word : {"pad-8, pad-12, pad-16", "twin"}) EXPECT_THAT(help, HasSubstr(word));
}

}  // namespace tactel::host::solve_pad_test
