// Network files: judged by the standard's own checker, by a runtime that does not know tactel, and read back.
#include "host/onnx_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <onnx/checker.h>

#include <fstream>
#include <iterator>

#include "host/errors.h"
#include "host/forward.h"
#include "network_cases.h"
#include "onnx_evaluator.h"

namespace {

using namespace tactel;
using namespace tactel::host;
using nn::ScalingKind;
using tactel::testing::bumps;
using tactel::testing::executor;
using tactel::testing::OnnxEvaluator;
namespace fs = std::filesystem;

nn::Model some_model(const char* topology, ScalingKind kind) {
  nn::Weights<float> weights = nn::initial_weights(nn::Topology::parse(topology), 7);
  for (float& w : weights.values) w *= 3;  // S well away from 0.5
  return {
      weights, {kind, 1.37f}, 7, 0.1, "bumps, \"quoted\" and \xc2\xb5", 10000, {1234, 0.31, 0.0123456789012345, 0.02}};
}

onnx::ModelProto parsed(const nn::Model& model) {
  onnx::ModelProto proto;
  EXPECT_TRUE(proto.ParseFromString(onnx_bytes(model)));
  return proto;
}

class OnnxFile : public ::testing::Test {
 protected:
  void SetUp() override {
    directory_ = fs::temp_directory_path() /
                 ("tactel_onnx_" + std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(directory_);
    fs::create_directories(directory_);
    path_ = directory_ / "network.onnx";
  }
  void TearDown() override { fs::remove_all(directory_); }
  void put(const std::string& bytes) const { std::ofstream(path_, std::ios::binary) << bytes; }
  std::string message() const {
    try {
      read_onnx(path_);
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "no error";
  }
  fs::path directory_, path_;
};

}  // namespace

TEST_F(OnnxFile, SatisfiesTheStandardsChecker) {
  for (const char* topology : {"1", "5", "16-16-8-1", "2-1-1"})
    for (const ScalingKind kind : {ScalingKind::set, ScalingKind::frame})
      EXPECT_NO_THROW(onnx::checker::check_model(parsed(some_model(topology, kind))))
          << topology << ' ' << nn::name(kind);
}

// Another runtime on the file gives the S of tactel's own recall within 1e-5, on every row, frames without stress
// included.
TEST_F(OnnxFile, MeansTheSameToAnotherRuntime) {
  for (const char* topology : {"6", "16-16-8-1"}) {
    for (const ScalingKind kind : {ScalingKind::set, ScalingKind::frame}) {
      const nn::Model model = some_model(topology, kind);
      const int inputs = model.weights.topology.inputs();
      nn::RowMatrix<float> frames = bumps(150, inputs, 9).frames;
      frames.row(3).setZero();
      frames.row(4) *= 1e4f;
      frames.row(5) *= 1e-9f;
      frames.row(6).head(inputs / 2).setZero();
      const nn::Recall<float> own =
          Forward<float>(executor(), std::span(&model.weights, 1), model.scaling).recall(frames);
      const OnnxEvaluator::Tensor input{{150, inputs}, {frames.data(), frames.data() + frames.size()}};
      const OnnxEvaluator::Tensor s = OnnxEvaluator(parsed(model)).run(input);
      ASSERT_EQ(s.shape, (std::vector<std::int64_t>{150, 1}));
      double lowest = 1, highest = 0;
      for (int row = 0; row < 150; ++row) {
        EXPECT_NEAR(s.data[row], own.slip_index(row), 1e-5) << topology << ' ' << nn::name(kind) << " row " << row;
        lowest = std::min(lowest, s.data[row]);
        highest = std::max(highest, s.data[row]);
      }
      EXPECT_GT(highest - lowest, 0.05);
    }
  }
}

TEST_F(OnnxFile, IsReadBackAsItWas) {
  for (const char* topology : {"6", "16-9-1"}) {
    for (const ScalingKind kind : {ScalingKind::set, ScalingKind::frame}) {
      const nn::Model model = some_model(topology, kind);
      write_onnx(path_, model);
      const nn::Model read = read_onnx(path_);
      EXPECT_EQ(read.weights.topology, model.weights.topology);
      EXPECT_EQ(read.weights.values, model.weights.values);
      EXPECT_EQ(read.scaling, model.scaling);
      EXPECT_EQ(read.seed, model.seed);
      EXPECT_EQ(read.noise, model.noise);
      EXPECT_EQ(read.learning_set, model.learning_set);
      EXPECT_EQ(read.cycles, model.cycles);
      EXPECT_EQ(read.learning_errors.count, model.learning_errors.count);
      EXPECT_EQ(read.learning_errors.mean, model.learning_errors.mean);
      EXPECT_EQ(read.learning_errors.std, model.learning_errors.std);
      EXPECT_EQ(std::distance(fs::directory_iterator(directory_), {}), 1);  // no temporary file is left
    }
  }
}

TEST_F(OnnxFile, SaysWhatIsWrongWithABadFile) {
  EXPECT_THAT(message(), ::testing::HasSubstr("cannot be read"));
  put("");
  EXPECT_THAT(message(), ::testing::HasSubstr("empty"));
  put("[sensor]\nlength = 20.0\n");
  EXPECT_THAT(message(), ::testing::HasSubstr("network.onnx"));
  const std::string good = onnx_bytes(some_model("16-16-8-1", ScalingKind::set));
  put(good.substr(0, good.size() / 2));
  EXPECT_THAT(message(), ::testing::HasSubstr("must be"));
  put(good);
  EXPECT_EQ(message(), "no error");
}

// A byte changed anywhere, or an end lost, is noticed.
TEST_F(OnnxFile, NoticesEveryDamage) {
  const std::string good = onnx_bytes(some_model("2-1-1", ScalingKind::frame));
  for (std::size_t i = 0; i < good.size(); i += 7) {  // every byte was tried once
    std::string bad = good;
    bad[i] = static_cast<char>(bad[i] ^ 0x10);
    put(bad);
    EXPECT_NE(message(), "no error") << "byte " << i;
    put(good.substr(0, i));
    EXPECT_NE(message(), "no error") << "first " << i << " bytes";
  }
}

TEST_F(OnnxFile, RefusesModelsThatTactelDidNotWrite) {
  onnx::ModelProto foreign = parsed(some_model("16-16-8-1", ScalingKind::set));
  foreign.set_producer_name("pytorch");
  put(foreign.SerializeAsString());
  EXPECT_THAT(message(), ::testing::HasSubstr("pytorch"));

  onnx::ModelProto bare = parsed(some_model("16-16-8-1", ScalingKind::set));
  bare.clear_metadata_props();
  put(bare.SerializeAsString());
  EXPECT_THAT(message(), ::testing::HasSubstr("metadata"));

  onnx::ModelProto changed = parsed(some_model("16-16-8-1", ScalingKind::set));
  changed.mutable_graph()->mutable_node(2)->set_op_type("Relu");
  put(changed.SerializeAsString());
  EXPECT_THAT(message(), ::testing::HasSubstr("damaged"));

  onnx::ModelProto other = parsed(some_model("16-16-8-1", ScalingKind::set));
  for (onnx::StringStringEntryProto& entry : *other.mutable_metadata_props())
    if (entry.key() == "topology") entry.set_value("16-16-9-1");
  put(other.SerializeAsString());
  EXPECT_THAT(message(), ::testing::HasSubstr("damaged"));

  onnx::ModelProto newer = parsed(some_model("16-16-8-1", ScalingKind::set));
  newer.mutable_opset_import(0)->set_version(17);
  put(newer.SerializeAsString());
  EXPECT_THAT(message(), ::testing::HasSubstr("another form"));
}

TEST_F(OnnxFile, SaysWhenItCannotWrite) {
  EXPECT_THROW(write_onnx(directory_ / "nowhere" / "network.onnx", some_model("2-1-1", ScalingKind::set)), ConfigError);
}
