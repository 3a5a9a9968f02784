// SPDX-License-Identifier: Apache-2.0

// `tactel recall` on recordings, beside `tactel monitor`, whose host code shares nothing with the kernel; and its
// warning of stresses in another unit.
#include <gmock/gmock.h>

#include <cstdlib>

#include "host/sets/contact_set.h"
#include "tests/host/commands/live_command.h"

namespace tactel::host::recall_recording_test {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;

class RecallRecording : public LiveCommand {
 protected:
  void SetUp() override {
    ASSERT_EQ(run_tactel({"record", "--source", simulation, "--output", recording_, "--quiet"}).exit_code, 0);
  }
  ChildResult recall(const std::vector<std::string>& more) const {
    return run_tactel({"recall", network_, recording_}, more);
  }
};

TEST_F(RecallRecording, GivesTheAnswersOfTheMonitor) {
  const auto lines = lines_of(run_tactel({"monitor", "--source", "replay:" + recording_, "--network", network_}).out);
  const ChildResult result = recall({"--json", "-", "--rows", folder_ / "rows.csv"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  std::istringstream rows(text_of(folder_ / "rows.csv"));
  std::string row;
  std::getline(rows, row);
  EXPECT_EQ(row, "frame,arrival,pad,n.onnx");
  double sum = 0, most = 0;
  std::size_t answered = 0;
  for (std::size_t k = 0; k < lines.size(); ++k) {
    std::getline(rows, row);
    EXPECT_THAT(row, ::testing::StartsWith(std::to_string(k) + ","));
    const std::string s = row.substr(row.rfind(',') + 1);
    ASSERT_FALSE(s.empty()) << row;
    sum += std::stod(s), most = std::max(most, std::stod(s));
    if (lines[k]["slip_index"].is_null()) continue;  // nothing touches
    EXPECT_EQ(std::strtof(s.c_str(), nullptr), lines[k]["slip_index"].get<float>()) << row;
    ++answered;
  }
  EXPECT_FALSE(std::getline(rows, row));
  ASSERT_GT(answered, 300u);
  const json report = json::parse(result.out), pad = report["networks"][0]["pads"][0];
  EXPECT_EQ(report["frames"], lines.size());
  EXPECT_NEAR(pad["mean"].get<double>(), sum / static_cast<double>(lines.size()), 1e-6);  // nine digits
  EXPECT_NEAR(pad["max"].get<double>(), most, 1e-6);
  std::size_t frames = 0;
  for (const auto& [status, count] : pad["frames"].items()) frames += count.get<std::size_t>();
  EXPECT_EQ(frames, lines.size());
}

TEST_F(RecallRecording, PrintsALineForEachPad) {
  const ChildResult result = recall({});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out,
              HasSubstr("slip_index of 1 networks on 321 frames of " + recording_ + ", those at rest among them"));
  EXPECT_THAT(result.out, HasSubstr("device: "));
}

TEST_F(RecallRecording, RefusesWhatNeedsATrueS) {
  EXPECT_TRUE(is_refused(recall({"--html", folder_ / "page.html"}), {"--html", "no true S"}));
  EXPECT_TRUE(is_refused(recall({"--decision"}), {"--decision", "no true S"}));
  EXPECT_TRUE(is_refused(recall({"--precision", "fp64"}), {"--precision = fp64"}));
  write_onnx(network_, network(8));
  EXPECT_TRUE(is_refused(recall({}), {"42"}));
}

/// A set of two rows whose normal stresses reach `peak`, MPa, and a network that learnt peaks of 0.01 to 0.2 MPa.
ChildResult recall_of(double peak, const std::vector<std::string>& more = {}) {
  const ScratchFolder folder;
  ContactSet set;
  set.inputs = 42;
  each_dataset(set, [](const char*, auto& values, int width, const char*) {
    values.resize(2 * static_cast<std::size_t>(std::max(width, 1)));
  });
  set.frames[5] = set.frames[42 + 5] = static_cast<float>(-peak);
  set.contact_nodes = {1, 1}, set.indenter_names = {"ball"}, set.contacts = 2;
  write_contact_set(folder / "set.h5", set);
  nn::Model model = network(21);
  model.learnt = {.smallest_peak = 0.01f, .largest_peak = 0.2f, .least_friction = 0.1f, .most_friction = 1.0f};
  write_onnx(folder / "n.onnx", model);
  return run_tactel({"recall", folder / "n.onnx", folder / "set.h5"}, more);
}

TEST(RecallUnit, StressesBeyondAllThatWasLearntAreNamed) {
  for (const double peak : {2.1, 9e-4}) {  // more than ten times from the ends of what was learnt
    const ChildResult result = recall_of(peak);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_THAT(result.err, HasSubstr("learnt peaks of 0.01 to 0.2 MPa; are they MPa?")) << peak;
  }
  for (const double peak : {1.9, 1.1e-3}) EXPECT_THAT(recall_of(peak).err, Not(HasSubstr("MPa?"))) << peak;
  EXPECT_THAT(recall_of(2.1, {"--quiet"}).err, Not(HasSubstr("MPa?")));
}

}  // namespace tactel::host::recall_recording_test
