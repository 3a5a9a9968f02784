// SPDX-License-Identifier: Apache-2.0

// Frames block by block, and networks that learn from them.
#include <gmock/gmock.h>

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "host/support/errors.h"
#include "host/training/streams.h"
#include "host/training/training.h"
#include "test_paths.h"
#include "tests/host/device/test_device.h"
#include "tests/host/sets/network_files.h"
#include "tests/host/support/run_tactel.h"
#include "tests/thrown_message.h"

namespace tactel::host::stream_training_test {

using tactel::tests::PaperSetFiles;
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

void without_times(nlohmann::json& report) {
  for (const char* time : {"seconds", "patterns_per_second"}) report.erase(time);
  for (nlohmann::json& network : report["networks"]) network.erase("seconds");
}

class Stream : public ::testing::Test {
 protected:
  ScratchFolder folder_;
  std::string sweep_ = folder_.write("sweep.toml", sweep_text);
  Executor executor_{Device("")};
};

TEST_F(Stream, SimulatedBlocksAreTheRowsOfTheSet) {
  ASSERT_EQ(run_tactel({"generate", sweep_, "--output", (folder_ / "set.h5").string()}).exit_code, 0);
  const ContactSet set = read_contact_set(folder_ / "set.h5");
  const auto stream = simulated_stream(executor_, sweep_, 250, "", {});
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
  const nn::FrameSet sticks =
      simulated_stream(executor_, sweep_, 250, "", {}, {.target = nn::Target::stick_fraction})->block(0);
  for (Eigen::Index i = 0; i < sticks.rows(); ++i)
    EXPECT_EQ(sticks.slip_index(i), set.stick_fraction[static_cast<std::size_t>(i)]);
  EXPECT_GT(stream->block(9).rows(), 0);  // beyond sweep.contacts: there is no end
}

TEST_F(Stream, ContactsAreModelledByTheirRung) {
  const std::string pads = folder_.write("pads.toml",
                                         "[sweep]\ncontacts = 8\n[sensor]\nkind = \"pad\"\nthickness = 2\n"
                                         "[indenter]\nshape = \"sphere\"\nradius = { uniform = [5, 9] }\n"
                                         "[load]\nindentation = 0.2\ntangential = [[0.1, 0], [0.2, 0.1]]\n");
  for (const auto& [sweep, rung] : {std::pair(pads, "pad-8"), {sweep_, "patch-8"}}) {
    const std::string set = (folder_ / rung).string() + ".h5";
    ASSERT_EQ(run_tactel({"generate", sweep, "--rung", rung, "--output", set}).exit_code, 0);
    const std::vector<float> expected = read_contact_set(set).slip_index;
    const nn::FrameSet block = simulated_stream(executor_, sweep, 8, rung, {})->block(0);
    ASSERT_GT(block.rows(), 0);
    for (Eigen::Index i = 0; i < block.rows(); ++i)
      EXPECT_EQ(block.slip_index(i), expected[static_cast<std::size_t>(i)]) << rung;
  }
  EXPECT_THAT(thrown_message<ConfigError>([&] { simulated_stream(executor_, pads, 8, "reference", {}); }),
              HasSubstr("--rung = reference"));
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

/// Trains in a directory, or goes on there, and stops after so many blocks.
TrainingEnd train_blocks(TrainRequest request, const std::filesystem::path& output, int blocks) {
  request.output = output;
  request.resume = std::filesystem::exists(output);
  std::filesystem::create_directories(output);
  const auto progress = [&](std::size_t, std::size_t, double) { return --blocks > 0; };
  return train(request, Ranks(), {.progress = progress}).end;
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
  /// training.json but for the times.
  nlohmann::json report(const std::string& output) const {
    auto all = nlohmann::json::parse(text_of(folder_ / output / "training.json"));
    without_times(all);
    return all;
  }
};

// Stopped after any of its blocks of 8192 contacts: the report is that of one run.
TEST_F(StreamTraining, ResumedReportIsThatOfOneRun) {
  TrainRequest request;
  request.stream = sweep_, request.rows = 250'000, request.networks = {"42-5-1"};
  const auto run = [&](const std::string& output, int blocks) {
    return train_blocks(request, folder_ / output, blocks);
  };
  ASSERT_EQ(run("whole", 1000), TrainingEnd::finished);
  ASSERT_GT(report("whole")["networks"][0]["curve"]["rows"].size(), 3u);
  for (const int first : {1, 3, 4}) {
    const std::string stopped = "stopped" + std::to_string(first);
    ASSERT_EQ(run(stopped, first), TrainingEnd::stopped);
    ASSERT_EQ(run(stopped, 1000), TrainingEnd::finished);
    EXPECT_EQ(report(stopped), report("whole")) << "stopped after " << first;
    EXPECT_EQ(tactel::tests::networks_in(folder_ / stopped), tactel::tests::networks_in(folder_ / "whole"));
  }
}

// A learning rate of 1e38 overflows fp32 in the first steps.
TEST_F(StreamTraining, ANetworkThatDivergedHasNoFile) {
  EXPECT_TRUE(is_refused(run_tactel({"train", "--stream", sweep_, "--rows", "2000", "--network", "42-5-1",
                                     "--learning-rate", "1e38", "--output", folder_ / "net"}),
                         {"1 of 1 networks diverged and have no file"}, 4));
  EXPECT_EQ(report("net")["networks"][0]["status"], "not finite");
  EXPECT_TRUE(report("net")["networks"][0]["file"].is_null());
  EXPECT_TRUE(tactel::tests::networks_in(folder_ / "net").empty());
}

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
  EXPECT_EQ(report("killed"), report("whole"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "killed" / "checkpoint"));
}

// Frames of one class of indenters with a mu that the network never sees: a constant answer errs by 0.25 on average
// when S is spread evenly over 0 to 1.
TEST_F(StreamTraining, LearnsFromFreshContacts) {
  ASSERT_EQ(run_tactel({"generate", sweep_, "--output", (folder_ / "set.h5").string()}).exit_code, 0);
  ASSERT_EQ(train("net", "--scaling frame --learning-rate 0.01 --recall " + (folder_ / "set.h5").string()).exit_code,
            0);
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

/// Trainings on blocks of the paper's learning set: 233 rows.
class BlockTraining : public ::testing::Test {
 protected:
  ChildResult train(const std::string& output, std::vector<std::string> options) const {
    return run_tactel({"train", PaperSetFiles::learning(), "--output", folder_ / output, "--network", "42-5-1"},
                      options);
  }
  nlohmann::json report(const std::string& output) const {
    return nlohmann::json::parse(text_of(folder_ / output / "training.json"));
  }
  std::string network(const std::string& output) const {
    return text_of(folder_ / output / "42-5-1_noise0_seed1.onnx");
  }
  ScratchFolder folder_;
};

TEST_F(BlockTraining, AFewRowsAreEnoughForAReport) {
  for (const char* rows : {"1", "50", "100", "700"}) {
    const ChildResult result = train(rows, {"--block", "50", "--rows", rows});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(without_progress(result.err), "");
    const auto curve = report(rows)["networks"][0]["curve"];
    EXPECT_GE(curve["rows"].back(), 1);
    EXPECT_EQ(curve["rows"].size(), curve["mean_squared_error"].size());
    EXPECT_THAT(text_of(folder_ / rows / "learning_curves.svg"), HasSubstr("rows seen"));
  }
}

// A learning rate of 1e38 overflows fp32 in the first steps.
TEST_F(BlockTraining, ANetworkThatDivergedHasNoFile) {
  EXPECT_TRUE(is_refused(
      train("net", {"--block", "50", "--rows", "2000", "--learning-rate", "1e38", "--recall", PaperSetFiles::recall()}),
      {"1 of 1 networks diverged and have no file"}, 4));
  const auto network = report("net")["networks"][0];
  EXPECT_EQ(network["status"], "not finite");
  EXPECT_TRUE(network["file"].is_null());
  EXPECT_TRUE(tactel::tests::networks_in(folder_ / "net").empty());
  EXPECT_FALSE(std::filesystem::exists(folder_ / "net" / "checkpoint"));
}

TEST_F(BlockTraining, PrecisionAndOrderAreObeyed) {
  ASSERT_EQ(train("plain", {"--block", "50", "--rows", "700"}).exit_code, 0);
  ASSERT_EQ(train("fp64", {"--block", "50", "--rows", "700", "--precision", "fp64"}).exit_code, 0);
  ASSERT_EQ(train("order", {"--block", "50", "--rows", "700", "--order", "sequential"}).exit_code, 0);
  EXPECT_EQ(report("plain")["precision"], "fp32");
  EXPECT_EQ(report("fp64")["precision"], "fp64");
  EXPECT_EQ(report("order")["options"]["order"], "sequential");
  EXPECT_NE(network("fp64"), network("plain"));
  EXPECT_NE(network("order"), network("plain"));
}

TEST_F(BlockTraining, SequentialBlocksAreThoseOfTheFile) {
  const ContactSet set = read_contact_set(PaperSetFiles::learning());
  const auto stream = file_stream(PaperSetFiles::learning(), 50, 1, nn::PresentationOrder::sequential);
  ASSERT_EQ(stream->blocks(), 5u);
  std::size_t row = 0;
  for (std::uint64_t k = 0; k < 10; ++k) {
    const nn::FrameSet block = stream->block(k);
    for (Eigen::Index i = 0; i < block.rows(); ++i, ++row)
      EXPECT_EQ(block.slip_index(i), set.slip_index[row % set.rows()]);
  }
  EXPECT_EQ(row, 2 * set.rows());
}

TEST_F(BlockTraining, ABlockWithoutAnswersIsPassedOver) {
  ContactSet set = read_contact_set(PaperSetFiles::learning());
  std::fill_n(set.slip_index.begin(), 100, NAN);
  write_contact_set(folder_ / "half.h5", set);
  const ChildResult result = run_tactel({"train", folder_ / "half.h5", "--output", folder_ / "net", "--network",
                                         "42-5-1", "--block", "50", "--rows", "1000"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("a block without a row"));
  EXPECT_GE(report("net")["rows"], 1000);
}

TEST_F(BlockTraining, IsForOneProcess) {
  EXPECT_TRUE(
      is_refused(run_child({"sh", "-c",
                            "OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 mpirun "
                            "--oversubscribe --bind-to none -n 2 " TACTEL_PROGRAM " train " +
                                PaperSetFiles::learning() + " --block 50 --output " + (folder_ / "net").string()}),
                 {"trained by one process"}));
}

using TrainingSources = BlockTraining;
TEST_F(TrainingSources, StreamAndBlockExclude) {
  const std::string sweep = folder_.write("sweep.toml", sweep_text);
  EXPECT_TRUE(is_refused(run_tactel({"train", "--stream", sweep, "--block", "50", "--output", folder_ / "net"}),
                         {"--block = 50: must be left out with --stream"}));
}

// Stopped after any of its blocks and taken up again, a training reports what it reports undisturbed: networks, curve,
// everything but the time it took.
TEST_F(BlockTraining, ResumedReportIsThatOfOneRun) {
  for (const bool judged : {false, true}) {
    TrainRequest request;
    request.set = PaperSetFiles::learning(), request.block = 50, request.rows = 1500;
    if (judged) {
      request.recall_set = PaperSetFiles::recall();
      request.schedule = "cosine", request.average = 0.9, request.loss = "absolute", request.batch = 16;
      request.validation_set = PaperSetFiles::recall(), request.patience = 40;
    }
    request.networks = {"42-5-1"};
    request.seeds = 2;
    const auto run = [&](const std::string& output, int blocks) {
      return train_blocks(request, folder_ / output, blocks);
    };
    const std::string whole = judged ? "whole judged" : "whole";
    ASSERT_EQ(run(whole, 1000), TrainingEnd::finished);
    auto expected = report(whole);
    without_times(expected);
    if (judged) {
      const auto& curve = expected["networks"][0]["curve"];
      for (std::size_t i = 0; i < curve["rows"].size(); ++i)  // one set in both places
        EXPECT_FLOAT_EQ(curve["validation_mean_error"][i], curve["recall_mean_error"][i]);
      EXPECT_EQ(expected["options"]["last_learning_rate"], 0);
      EXPECT_THAT(text_of(folder_ / whole / "learning_curves.svg"), HasSubstr("dashed: validation set"));
    }
    for (const int first : {1, 2, 3, 7, 20}) {
      const std::string stopped = whole + std::to_string(first);
      ASSERT_EQ(run(stopped, first), TrainingEnd::stopped);
      ASSERT_EQ(run(stopped, 3), TrainingEnd::stopped);
      ASSERT_EQ(run(stopped, 1000), TrainingEnd::finished);
      auto resumed = report(stopped);
      without_times(resumed);
      EXPECT_EQ(resumed, expected) << "stopped after " << first;
      EXPECT_EQ(tactel::tests::networks_in(folder_ / stopped), tactel::tests::networks_in(folder_ / whole));
    }
  }
}

}  // namespace tactel::host::stream_training_test
