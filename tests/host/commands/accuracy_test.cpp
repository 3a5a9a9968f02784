// What --accuracy promises, and sensors whose mesh does not carry every rung, through the program.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "host/sets/contact_set.h"
#include "tests/host/support/run_tactel.h"

namespace tactel::host {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::Not;

std::string scene(const std::string& name) { return source_file("tests/host/contact/scenes/" + name + ".toml"); }

// 41 columns of a rung on 20 mm of rubber 1.5 mm thick are (41 - 1) * 3.75 + 1 = 151 on 20 mm of 0.4 mm, and
// (41 - 1) * 9 + 1 = 361 on 60 mm of 0.5 mm.
TEST(Accuracy, ThinAndLongSensorsGetAMeshOfTheirOwn) {
  for (const auto& [name, factor] : {std::pair{"thin_sensor", 3.75}, {"long_sensor", 9.0}}) {
    const ChildResult result = run_tactel({"solve", scene(name), "--accuracy", "0.1", "--json", "-"});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_THAT(result.err, Not(HasSubstr("warning")));
    EXPECT_THAT(result.err, HasSubstr("the accuracy holds for S alone"));
    const json answer = json::parse(result.out);
    EXPECT_EQ(answer["planner"]["kept"], true) << name;
    EXPECT_LE(answer["planner"]["estimate"], 0.1) << name;
    const int columns = answer["scene"]["sensor"]["columns"];
    EXPECT_GE(columns, 40 * factor + 1) << name;
    const std::string mesh = std::to_string(columns) + " x ";
    EXPECT_THAT(answer["planner"]["model"], testing::StartsWith(mesh));
    EXPECT_THAT(result.err, HasSubstr("(" + mesh));
  }
}

// `finest` has 321 columns: 1201 on the thin sensor, and 2881 on the long one, more than a mesh may have.
TEST(Accuracy, ARungBeyondTheLargestMeshIsCoarserAndSaysSo) {
  const ChildResult thin = run_tactel({"solve", scene("thin_sensor"), "--rung", "finest"});
  EXPECT_EQ(thin.exit_code, 0) << thin.err;
  EXPECT_THAT(thin.err, Not(HasSubstr("warning")));
  EXPECT_THAT(thin.out, HasSubstr("mesh 1201 x "));
  const ChildResult wide = run_tactel({"solve", scene("long_sensor"), "--rung", "finest"});
  EXPECT_EQ(wide.exit_code, 0) << wide.err;
  EXPECT_THAT(wide.err, HasSubstr("warning: rung finest requires more than the 2001 columns that a mesh may have"));
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
  EXPECT_THAT(read_attributes(set).rung, HasSubstr("the accuracy of 0.9 holds for S alone, not for stresses"));
  EXPECT_EQ(run_tactel({"generate", sweep, "--output", set, "--accuracy", "0.9", "--resume"}).exit_code, 0);
  ASSERT_EQ(run_tactel({"generate", sweep, "--output", set, "--rung", "draft", "--force"}).exit_code, 0);
  EXPECT_THAT(read_attributes(set).rung, Not(HasSubstr("accuracy")));
}

}  // namespace
}  // namespace tactel::host
