// Frames block by block, and networks that learn from them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>

#include "host/errors.h"
#include "host/frame_stream.h"
#include "host/paper_sets.h"
#include "test_device.h"
#include "tests/host/run_tactel.h"

namespace tactel::host {
namespace {

using ::testing::HasSubstr;

const std::string sweep_text = R"(preset = "paper"
[sweep]
contacts = 1000
seed = 3
[contact]
friction = { uniform = [0.2, 0.8] }
[indenter]
shape = "parabola"
radius = { log_uniform = [5, 50] }
[load]
indentation = 0.15
indentation_steps = 1
tangential_step = 0.05
tangential_steps = 3
)";

class Stream : public ::testing::Test {
 protected:
  ScratchFolder folder_;
  std::string sweep_ = folder_.write("sweep.toml", sweep_text);
  Executor executor_{Device("")};
};

TEST_F(Stream, SimulatedBlocksAreTheRowsOfTheSet) {
  ASSERT_EQ(run_tactel({"generate", sweep_, "--output", (folder_ / "set.h5").string()}).exit_code, 0);
  const ContactSet set = read_contact_set(folder_ / "set.h5");
  const auto stream = simulated_stream(executor_, sweep_, 250, {});
  std::size_t row = 0;
  for (std::uint64_t k = 0; k < 4; ++k) {
    const nn::FrameSet block = stream->block(k);
    for (Eigen::Index i = 0; i < block.rows(); ++i, ++row) {
      ASSERT_LT(row, set.rows());
      EXPECT_EQ(block.slip_index(i), set.slip_index[row]);
      EXPECT_EQ(block.frames(i, 7), set.frames[row * 42 + 7]);
    }
  }
  EXPECT_EQ(row, set.rows());
  EXPECT_GT(stream->block(9).rows(), 0);  // beyond sweep.contacts: there is no end
}

TEST_F(Stream, FileBlocksShowEveryRowOnceAPassInAnotherOrder) {
  ASSERT_EQ(run_tactel({"generate", sweep_, "--output", (folder_ / "set.h5").string()}).exit_code, 0);
  const ContactSet set = read_contact_set(folder_ / "set.h5");
  const auto stream = file_stream(folder_ / "set.h5", 300, 5);
  const std::uint64_t blocks = (set.rows() + 299) / 300;
  std::vector<std::vector<float>> firsts;
  for (std::uint64_t pass = 0; pass < 2; ++pass) {
    std::map<float, int> count;
    firsts.emplace_back();
    for (std::uint64_t k = 0; k < blocks; ++k) {
      const nn::FrameSet block = stream->block(pass * blocks + k);
      firsts.back().push_back(block.slip_index(0));
      for (Eigen::Index i = 0; i < block.rows(); ++i) ++count[block.slip_index(i)];
    }
    std::map<float, int> expected;
    for (const float s : set.slip_index) ++expected[s];
    EXPECT_EQ(count, expected);
  }
  EXPECT_NE(firsts[0], firsts[1]);
  EXPECT_THAT(firsts[0], ::testing::UnorderedElementsAreArray(firsts[1]));
}

class StreamTraining : public Stream {
 protected:
  ChildResult train(const std::string& output, const std::string& more, const std::string& before = "") const {
    return run_child({"sh", "-c",
                      before + " " TACTEL_PROGRAM " train --stream " + sweep_ +
                          " --rows 400000 --network 42-21-1 --output " + (folder_ / output).string() +
                          " --checkpoint-seconds 0 " + more});
  }
  std::string network(const std::string& output) const {
    return text_of(folder_ / output / "42-21-1_noise0_seed1.onnx");
  }
};

TEST_F(StreamTraining, KilledAndResumedGivesTheSameNetwork) {
  const ChildResult whole = train("whole", "");
  ASSERT_EQ(whole.exit_code, 0) << whole.err;
  int killed = 0;
  for (const char* moment : {"0.15", "0.3", "0.5", "0.7"}) {
    const ChildResult result = train("killed", "--resume", std::string("timeout -s KILL ") + moment);
    killed += result.exit_code == 137;
  }
  EXPECT_GT(killed, 0);
  ASSERT_EQ(train("killed", "--resume").exit_code, 0);
  EXPECT_EQ(network("killed"), network("whole"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "killed" / "checkpoint"));
}

// Frames of one class of indenters with a mu that the network never sees: a constant answer errs by 0.25 on average
// when S is spread evenly over 0 to 1.
TEST_F(StreamTraining, LearnsFromFreshContacts) {
  ASSERT_EQ(run_tactel({"generate", sweep_, "--output", (folder_ / "set.h5").string()}).exit_code, 0);
  const ChildResult result =
      train("net", "--scaling frame --learning-rate 0.01 --recall " + (folder_ / "set.h5").string());
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto report = nlohmann::json::parse(text_of(folder_ / "net" / "training.json"));
  const auto& network = report["networks"][0];
  EXPECT_GE(report["rows"], 400000);
  EXPECT_LT(network["curve"]["recall_mean_error"].back(), 0.08);
  EXPECT_LT(network["curve"]["mean_squared_error"].back(), network["curve"]["mean_squared_error"].front());
}

TEST_F(StreamTraining, SaysWhatDoesNotFit) {
  EXPECT_THAT(run_tactel({"train", "--output", "x"}).err, HasSubstr("--stream SWEEP.toml instead"));
  const std::string listed = folder_.write("listed.toml", "[sweep]\nset = \"paper-recall\"\n");
  EXPECT_THAT(run_tactel({"train", "--stream", listed, "--output", (folder_ / "y").string()}).err,
              HasSubstr("sweep.set"));
  EXPECT_THAT(train("z", "--network 16-8-1").err, HasSubstr("42 inputs"));
}

}  // namespace
}  // namespace tactel::host
