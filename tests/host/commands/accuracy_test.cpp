// SPDX-License-Identifier: Apache-2.0

// What --accuracy promises, and sensors that are long for their thickness, through the program.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "host/sets/contact_set.h"
#include "tests/host/support/run_tactel.h"

namespace tactel::host::accuracy_test {

using nlohmann::json;
using testing::HasSubstr;
using testing::Not;

std::string scene(const std::string& name) { return source_file("tests/host/contact/scenes/" + name + ".toml"); }

// A patch needs no mesh: thickness and length of the sensor do not matter.
TEST(Accuracy, ThinAndLongSensorsAreServed) {
  for (const char* name : {"thin_sensor", "long_sensor"}) {
    const ChildResult result = run_tactel({"solve", scene(name), "--accuracy", "0.1", "--json", "-"});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_THAT(result.err, Not(HasSubstr("warning")));
    EXPECT_THAT(result.err, HasSubstr("the accuracy holds for S alone"));
    const json answer = json::parse(result.out);
    EXPECT_EQ(answer["planner"]["kept"], true) << name;
    EXPECT_LE(answer["planner"]["estimate"], 0.1) << name;
    EXPECT_THAT(answer["model"], testing::StartsWith("patch of "));
    EXPECT_EQ(answer["model_reason"], "--accuracy 0.1");
    EXPECT_EQ(answer["surface_width"].size(), answer["surface_x"].size());
  }
}

// 321 columns are 1201 on the thin sensor, and 2881 on the long one, more than a mesh may have.
TEST(AccuracyNightly, ARungBelowTheLargestMeshIsTaken) {
  const ChildResult thin = run_tactel({"solve", scene("thin_sensor"), "--rung", "mesh-321"});
  EXPECT_EQ(thin.exit_code, 0) << thin.err;
  EXPECT_THAT(thin.err, Not(HasSubstr("warning: rung")));
  EXPECT_THAT(thin.err, HasSubstr("warning: the error of this answer is not estimated: its mesh has more than 81"));
  EXPECT_THAT(thin.out, HasSubstr("mesh 1201 x "));
}

TEST(Accuracy, ARungBeyondTheLargestMeshIsCoarserAndSaysSo) {
  const ChildResult wide = run_tactel({"solve", scene("long_sensor"), "--rung", "mesh-321"});
  EXPECT_EQ(wide.exit_code, 0) << wide.err;
  EXPECT_THAT(wide.err, HasSubstr("warning: rung mesh-321 requires more than the 2001 columns that a mesh may have"));
  EXPECT_THAT(wide.out, HasSubstr("mesh 2001 x "));
}

// A tenth of the usual length, so that the rungs are small.
TEST(Accuracy, OfASetIsSaidToHoldForSAlone) {
  const ScratchFolder folder;
  const std::string sweep = folder.write("sweep.toml",
                                         "[sweep]\ncontacts = 2\nseed = 1\n[sensor]\nlength = 2\n[indenter]\n"
                                         "shape = \"parabola\"\nradius = 2\n[load]\nindentation = 0.05\n"
                                         "tangential = [{ uniform = [0.01, 0.02] }]\n");
  const std::string set = folder / "set.h5";
  const ChildResult chosen = run_tactel({"generate", sweep, "--output", set, "--accuracy", "0.9"});
  ASSERT_EQ(chosen.exit_code, 0) << chosen.err;
  EXPECT_THAT(chosen.err, HasSubstr("the accuracy holds for S alone"));
  EXPECT_THAT(chosen.err, HasSubstr("note: the outermost tactels stand at the ends of the glued base"));
  EXPECT_THAT(read_attributes(set).rung, HasSubstr("the accuracy of 0.9 holds for S alone, not for stresses"));
  EXPECT_EQ(run_tactel({"generate", sweep, "--output", set, "--accuracy", "0.9", "--resume"}).exit_code, 0);
  ASSERT_EQ(run_tactel({"generate", sweep, "--output", set, "--rung", "draft", "--force"}).exit_code, 0);
  EXPECT_THAT(read_attributes(set).rung, Not(HasSubstr("accuracy")));
}

}  // namespace tactel::host::accuracy_test
