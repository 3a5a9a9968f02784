// SPDX-License-Identifier: Apache-2.0

// Networks in a runtime that is not ours: OpenCV's.
#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/dnn.hpp>

#include "host/training/named_network.h"
#include "tests/host/sets/network_files.h"

namespace onnx_runtime_test {

using namespace tactel;
using namespace tactel::host;
using tactel::tests::PaperSetFiles;

std::vector<double> column(const std::filesystem::path& csv, int which) {
  std::istringstream lines(text_of(csv));
  std::vector<double> values;
  std::string line, field;
  std::getline(lines, line);
  while (std::getline(lines, line)) {
    std::istringstream fields(line);
    for (int i = 0; i <= which; ++i) std::getline(fields, field, ',');
    values.push_back(std::stod(field));
  }
  return values;
}

// Every row of the paper's recall set within 1e-5 of `tactel recall`. Scaling by the set;
// OpenCV 4.6 has no Where, which scaling by the frame needs: see MeansTheSameToAnotherRuntime in onnx_file_test.cpp for
// that.
void expect_same_slip_index(const std::vector<std::string>& topologies) {
  const ScratchFolder folder;
  std::vector<std::string> words{"train",  PaperSetFiles::learning(), "--output", folder / "net", "--cycles", "300",
                                 "--quiet"};
  for (const std::string& topology : topologies) words.insert(words.end(), {"--network", topology});
  ASSERT_EQ(run_tactel(words).exit_code, 0);
  ASSERT_EQ(run_tactel({"recall", folder / "net", PaperSetFiles::recall(), "--rows", folder / "rows.csv"}).exit_code,
            0);
  ContactSet set = read_contact_set(PaperSetFiles::recall());
  const cv::Mat frames(static_cast<int>(set.rows()), set.inputs, CV_32F, set.frames.data());
  const std::vector<NamedNetwork> networks = read_networks(folder / "net");
  ASSERT_EQ(networks.size(), topologies.size());
  for (std::size_t i = 0; i < networks.size(); ++i) {
    cv::dnn::Net net = cv::dnn::readNetFromONNX((folder / "net" / networks[i].file).string());
    net.setInput(frames, "frame");
    const cv::Mat answer = net.forward("slip_index");
    const std::vector<double> own = column(folder / "rows.csv", 2 + static_cast<int>(i));
    ASSERT_EQ(answer.total(), own.size());
    for (std::size_t row = 0; row < own.size(); ++row)
      EXPECT_NEAR(answer.ptr<float>()[row], own[row], 1e-5) << networks[i].file << " row " << row;
    EXPECT_GT(*std::ranges::max_element(own) - *std::ranges::min_element(own), 0.3);  // it says something
  }
}
TEST(OnnxRuntime, OpenCvGivesTheSameSlipIndex) { expect_same_slip_index({"1", "6"}); }
TEST(OnnxRuntimeNightly, OpenCvGivesTheSameSlipIndexOfEveryTopology) {
  expect_same_slip_index({"1", "2", "3", "4", "5", "6"});
}

// Four frames of irregular paths, leaky rectifiers: OpenCV on the inputs that with_history forms, within 1e-5 of
// `tactel recall`, and of `tactel recall` in one frame's network beside it.
TEST(OnnxRuntimeNightly, OpenCvGivesTheSameSlipIndexOfSeveralFrames) {
  const ScratchFolder folder;
  const std::string sweep = folder.write(
      "sweep.toml",
      "[sweep]\ncontacts = 60\nseed = 3\npress_rows = true\n[sensor]\ntactel_span = 18\n[contact]\nfriction = { "
      "uniform = [0.2, 1] }\n[indenter]\nshape = \"parabola\"\nradius = { uniform = [5, 40] }\n[load]\nindentation = "
      "0.15\n[load.irregular]\nstrokes = 2\nreversal = 0.5\n");
  ASSERT_EQ(run_tactel({"generate", sweep, "--output", folder / "set.h5", "--quiet"}).exit_code, 0);
  for (const auto& [name, history] : {std::pair{"one", "1"}, {"four", "4:2"}})
    ASSERT_EQ(run_tactel({"train", folder / "set.h5", "--output", folder / "net", "--cycles", "60", "--network", "3",
                          "--history", history, "--magnitude", "--schedule", "batch", "--activation", "leaky-relu",
                          "--quiet", "--force"})
                  .exit_code,
              0)
        << name;
  ASSERT_EQ(run_tactel({"recall", folder / "net", folder / "set.h5", "--rows", folder / "rows.csv"}).exit_code, 0);
  const std::vector<NamedNetwork> networks = read_networks(folder / "net");
  ASSERT_EQ(networks.size(), 1u);
  const nn::Model& model = networks[0].model;
  EXPECT_EQ(model.history, (nn::InputHistory{.frames = 4, .stride = 2, .change = 0.1}));
  EXPECT_TRUE(model.magnitude);
  EXPECT_EQ(model.weights.topology.text(), "168-21-1_leaky-relu");
  const ContactSet set = read_contact_set(folder / "set.h5");
  nn::FrameSet formed = nn::with_history(set.frames_with_answers(), model.history);
  const cv::Mat frames(static_cast<int>(formed.rows()), static_cast<int>(formed.frames.cols()), CV_32F,
                       formed.frames.data());
  cv::dnn::Net net = cv::dnn::readNetFromONNX((folder / "net" / networks[0].file).string());
  net.setInput(frames, "frame");
  const cv::Mat answer = net.forward("slip_index");
  const std::vector<double> own = column(folder / "rows.csv", 2);
  ASSERT_EQ(answer.total(), own.size());
  for (std::size_t row = 0; row < own.size(); ++row) EXPECT_NEAR(answer.ptr<float>()[row], own[row], 1e-5) << row;
  EXPECT_GT(*std::ranges::max_element(own) - *std::ranges::min_element(own), 0.3);
}

}  // namespace onnx_runtime_test
