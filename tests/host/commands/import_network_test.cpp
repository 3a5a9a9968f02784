// SPDX-License-Identifier: Apache-2.0

// `tactel import-network` as a user meets it. Networks are tactel's own files: chains of dense layers, too, whose
// answers are known. Those of other programs: onnx_chain_test.
#include <gmock/gmock.h>

#include "host/networks/onnx_file.h"
#include "nn/forward.h"
#include "tests/host/support/run_tactel.h"

namespace {

using namespace tactel;
using namespace tactel::host;
using ::testing::HasSubstr;

const std::string profile = R"([device]
name = "two tactels"
[format]
kind = "csv"
channels = 4
[channels]
normal = [0, 1]
shear = [2, 3]
[calibration]
offset = 0
gain = 1
)";

class ImportNetwork : public ::testing::Test {
 protected:
  ImportNetwork() {
    model_.weights = nn::initial_weights(model_.weights.topology, 3);
    write_onnx(folder_ / "own.onnx", model_);
  }
  ChildResult run(const std::vector<std::string>& more) const {
    return run_tactel({"import-network", folder_ / "own.onnx", "--output", folder_ / "new.onnx"}, more);
  }
  /// Three frames and S of the other program, which divides stresses by 2 MPa.
  std::string frames(float error = 0) const {
    nn::RowMatrix<float> frames(3, 4);
    frames << -0.5f, -1, 0.25f, 0.5f, -2, -1, 1, -0.5f, -0.1f, 0, 0.05f, 0;
    const nn::Vector<float> s = nn::recall(model_.weights, {nn::ScalingKind::set, 2}, frames).slip_index;
    std::string text;
    for (Eigen::Index i = 0; i < 3; ++i) {
      for (const float number : frames.row(i)) text += std::to_string(number) + ", ";
      text += std::to_string(s[i] + error) + (i < 2 ? "\r\n" : "");
    }
    return folder_.write("frames.csv", text);
  }

  const ScratchFolder folder_;
  nn::Model model_{.weights = nn::Weights<float>(nn::Topology::parse("4-6-3-1"))};
};

TEST_F(ImportNetwork, IsCheckedByItsFramesAndWritten) {
  const ChildResult result =
      run({"--frames", frames(), "--largest-stress", "2", "--profile", folder_.write("p.toml", profile)});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("new.onnx: 4-6-3-1, within "));
  EXPECT_THAT(result.out, HasSubstr("on the 3 frames of "));
  const nn::Model made = read_onnx(folder_ / "new.onnx");
  EXPECT_EQ(made.scaling.largest_stress, 2);
  EXPECT_EQ(made.learning_set, "own.onnx");
}

TEST_F(ImportNetwork, HistoryIsKept) {
  ASSERT_EQ(run({"--history", "2:3", "--history-change", "0.2", "--scaling", "frame"}).exit_code, 0);
  const nn::Model made = read_onnx(folder_ / "new.onnx");
  EXPECT_EQ(made.history, (nn::InputHistory{2, 3, 0.2}));
  EXPECT_EQ(made.scaling.kind, nn::ScalingKind::frame);
}

// The rest of the grip is one more frame of an input; the network itself has as many inputs as without it.
TEST_F(ImportNetwork, DifferencesToRestAndAnotherTarget) {
  const ChildResult result =
      run({"--scaling", "rest", "--target", "slid", "--profile", folder_.write("p.toml", profile)});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const nn::Model made = read_onnx(folder_ / "new.onnx");
  EXPECT_EQ(made.scaling.kind, nn::ScalingKind::rest);
  EXPECT_TRUE(made.history.rest);
  EXPECT_EQ(made.numbers(), 8);
  EXPECT_EQ(made.target, nn::Target::slid);
  EXPECT_TRUE(is_refused(run({"--target", "slide"}), {"--target", "slip_index", "slid"}));
}

// The divisor is the largest of the normal stresses, a third of the inputs.
TEST_F(ImportNetwork, APadsFramesHaveThreeAxes) {
  std::string pad = profile;
  pad.replace(pad.find("channels = 4"), 12, "channels = 6");
  pad.replace(pad.find("shear = [2, 3]"), 14, "shear_x = [2, 3]\nshear_y = [4, 5]");
  pad.replace(pad.find("[channels]"), 10, "[pad]\ntactels = [2, 1]\n[channels]");
  write_onnx(folder_ / "own.onnx", {.weights = nn::initial_weights(nn::Topology::parse("6-3-1"), 1)});
  ASSERT_EQ(run({"--profile", folder_.write("pad.toml", pad), "--scaling", "frame"}).exit_code, 0);
  EXPECT_EQ(read_onnx(folder_ / "new.onnx").scaling.normals(6), 2);
}

// Frames that the other program divided by 2 MPa; and an S that it never gave.
TEST_F(ImportNetwork, OtherAnswersWriteNoFile) {
  EXPECT_TRUE(is_refused(run({"--frames", frames()}), {"S differs by ", "was not written; give the scaling"}, 4));
  EXPECT_TRUE(is_refused(run({"--frames", frames(2e-4f), "--largest-stress", "2"}), {"S differs by 0.0002"}, 4));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "new.onnx"));
}

// Sums beyond fp32 that the next layer adds with both signs: infinity less infinity is no number, and agrees with
// nothing.
TEST_F(ImportNetwork, AnswersThatAreNoNumbersWriteNoFile) {
  const std::string given = frames();
  model_.weights = nn::initial_weights(nn::Topology::parse("4-6-3-1_leaky-relu"), 3);
  model_.weights.layer(0).setConstant(3e38f);
  write_onnx(folder_ / "own.onnx", model_);
  EXPECT_TRUE(is_refused(run({}), {"an S on 1000 random frames is no number"}, 4));
  EXPECT_TRUE(is_refused(run({"--frames", given}), {"is no number"}, 4));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "new.onnx"));
}

TEST_F(ImportNetwork, WrongInputIsNamed) {
  const auto file = [&](const std::string& text) { return folder_.write("wrong.csv", text); };
  EXPECT_TRUE(is_refused(run({"--frames", file("1,2,3,4,0.5\n1,2,3,4\n")}),
                         {"wrong.csv:2: fields = 4: must be 5", "an input in MPa, then S"}));
  EXPECT_TRUE(is_refused(run({"--frames", file("1,2,x,4,0.5\n")}), {"wrong.csv:1: column 3"}));
  EXPECT_TRUE(is_refused(run({"--frames", file("1,2,nan,4,0.5\n")}), {"wrong.csv:1: column 3"}));
  EXPECT_TRUE(is_refused(run({"--frames", file("\n")}), {"frames = none"}));
  EXPECT_TRUE(is_refused(run({"--frames", folder_ / "no.csv"}), {"no.csv", "a readable CSV file"}));
  EXPECT_TRUE(is_refused(run({"--largest-stress", "0"}), {"largest_stress"}));
  EXPECT_TRUE(is_refused(run({"--history", "3"}), {"4 inputs for a history of 3 frames"}));
  std::string wide = profile;
  wide.replace(wide.find("normal = [0, 1]"), 15, "normal = [0, 1, -1]");
  wide.replace(wide.find("shear = [2, 3]"), 14, "shear = [2, 3, -1]");
  EXPECT_TRUE(is_refused(run({"--profile", folder_.write("wide.toml", wide)}), {"4 inputs", "a network of 6 inputs"}));
}

}  // namespace
