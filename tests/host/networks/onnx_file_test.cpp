// SPDX-License-Identifier: Apache-2.0

// Network files: judged by the standard's own checker, by a runtime that does not know tactel, and read back.
#include "host/networks/onnx_file.h"

#include <gmock/gmock.h>
#include <onnx/checker.h>
#include <tactel/infer.h>

#include <cfenv>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>

#include "host/networks/forward.h"
#include "host/support/errors.h"
#include "nn/infer/network_file.h"
#include "tests/host/networks/bounded_model.h"
#include "tests/host/networks/crafted_network.h"
#include "tests/host/networks/network_cases.h"
#include "tests/host/networks/onnx_evaluator.h"
#include "tests/scratch.h"
#include "tests/thrown_message.h"

namespace onnx_file_test {

using namespace tactel;
using namespace tactel::host;
using nn::ScalingKind;
using tactel::tests::begin_with;
using tactel::tests::bumps;
using tactel::tests::executor;
using tactel::tests::initializer;
using tactel::tests::metadata;
using tactel::tests::OnnxEvaluator;
using tactel::tests::parsed;
using tactel::tests::sealed;
namespace fs = std::filesystem;

nn::Model some_model(const char* topology, ScalingKind kind) {
  nn::Weights<float> weights = nn::initial_weights(nn::Topology::parse(topology), 7);
  for (float& w : weights.values) w *= 3;  // S well away from 0.5
  return {
      weights, {kind, 1.37f}, 7, 0.1, "bumps, \"quoted\" and \xc2\xb5", 10000, {1234, 0.31, 0.0123456789012345, 0.02}};
}

class OnnxFile : public ::testing::Test {
 protected:
  void put(const std::string& bytes) const { std::ofstream(path_, std::ios::binary) << bytes; }
  static std::string refusal(const fs::path& path) {
    return thrown_message<ConfigError>([&] { read_onnx(path); });
  }
  std::string message() const { return refusal(path_); }
  const tactel::ScratchFolder folder_;
  const fs::path directory_ = folder_ / "", path_ = directory_ / "network.onnx";
};

TEST_F(OnnxFile, SatisfiesTheStandardsChecker) {
  for (const char* topology : {"1", "5", "16-16-8-1", "2-1-1", "16-16-8-1_leaky-relu"})
    for (const ScalingKind kind : {ScalingKind::set, ScalingKind::frame})
      EXPECT_NO_THROW(onnx::checker::check_model(parsed(some_model(topology, kind))))
          << topology << ' ' << nn::name(kind);
}

// libprotobuf parses a file and writes it with the same bytes: no field is unknown, out of order or longer than needed.
TEST_F(OnnxFile, HasTheBytesOfLibprotobuf) {
  std::vector<nn::Model> models;
  for (const ScalingKind kind : {ScalingKind::set, ScalingKind::frame}) {
    for (const char* topology :
         {"1", "2", "3", "4", "5", "6", "16-16-8-1", "2-1-1", "384-384-384-1", "16-9-1_leaky-relu"})
      models.push_back(some_model(topology, kind));
    models.push_back(tactel::tests::bounded_model("16-9-3", kind));
    models.push_back(tactel::tests::bounded_model("42-42-21-3", kind, false));
  }
  for (const nn::Model& model : models)
    EXPECT_EQ(parsed(model).SerializeAsString(), infer::network_bytes(model)) << model.weights.topology.text();
}

// The graph holds 1 / 1.37, which rounds up or down; the metadata hold texts that are read as numbers.
TEST_F(OnnxFile, IsTheSameInEveryRoundingMode) {
  const nn::Model model = some_model("2-1-1", ScalingKind::set);
  const std::string nearest = infer::network_bytes(model);
  put(nearest);
  for (const int mode : {FE_UPWARD, FE_DOWNWARD, FE_TOWARDZERO}) {
    ASSERT_EQ(std::fesetround(mode), 0);
    const std::string bytes = infer::network_bytes(model), read = message();
    EXPECT_EQ(std::fegetround(), mode);
    std::fesetround(FE_TONEAREST);
    EXPECT_EQ(bytes, nearest);
    EXPECT_EQ(read, "no error");
  }
}

using OnnxFileOnDevice = OnnxFile;
// Another runtime on the file gives the S of tactel's own recall within 1e-5, on every row, frames without stress
// included.
TEST_F(OnnxFileOnDevice, MeansTheSameToAnotherRuntime) {
  for (const char* topology : {"6", "16-16-8-1", "16-16-8-1_leaky-relu"}) {
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
      const OnnxEvaluator::Tensor s = OnnxEvaluator(parsed(model)).run(frames.cast<double>());
      ASSERT_TRUE(s.rows() == 150 && s.cols() == 1);
      for (int row = 0; row < 150; ++row)
        EXPECT_NEAR(s(row), own.slip_index(row), 1e-5) << topology << ' ' << nn::name(kind) << " row " << row;
      EXPECT_GT(s.maxCoeff() - s.minCoeff(), 0.05);
    }
  }
}

// A network of a pad, four frames of two tactels with three axes: file, kernel and library divide by the two normal
// stresses of the newest frame.
TEST_F(OnnxFileOnDevice, KeepsTheAxesOfAPad) {
  nn::Model model = some_model("24-9-1", ScalingKind::frame);
  model.scaling.axes = 3, model.scaling.history = model.history.frames = 4;
  write_onnx(path_, model);
  EXPECT_EQ(read_onnx(path_).scaling, model.scaling);
  nn::RowMatrix<float> frames = bumps(150, 24, 9).frames;
  frames.leftCols(2).array() -= 0.1f;  // some stress in every frame
  const nn::RowMatrix<float> divided =
      frames.array().colwise() / frames.leftCols(2).cwiseAbs().rowwise().maxCoeff().array();
  const auto recalled = [&](const nn::InputScaling& scaling, const nn::RowMatrix<float>& rows) {
    return Forward<float>(executor(), std::span(&model.weights, 1), scaling).recall(rows).slip_index;
  };
  const nn::Vector<float> own = recalled(model.scaling, frames);
  const nn::Vector<float> by_hand = recalled({ScalingKind::set, 1.0f, 4, 3}, divided);
  const OnnxEvaluator::Tensor s = OnnxEvaluator(parsed(model)).run(frames.cast<double>());
  const SlipEstimator library = SlipEstimator::load(path_.string());
  for (int row = 0; row < 150; ++row) {
    EXPECT_NEAR(own(row), by_hand(row), 1e-5) << row;  // another order of rounding
    EXPECT_NEAR(s(row), own(row), 1e-5) << row;
    EXPECT_EQ(library.estimate({frames.row(row).data(), 24}).slip_index, own(row)) << row;
  }
  model.weights = nn::Weights<float>(nn::Topology::parse("20-9-1"));
  put(infer::network_bytes(model));
  EXPECT_THAT(message(), ::testing::HasSubstr("3 axes"));
}

TEST_F(OnnxFile, IsReadBackAsItWas) {
  for (const char* topology : {"6", "16-9-1", "16-9-1_leaky-relu"}) {
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

TEST_F(OnnxFileOnDevice, KeepsTheRangesThatWereLearnt) {
  nn::Model model = some_model("16-9-1", ScalingKind::set);
  model.learnt = {.smallest_peak = 0.1f, .largest_peak = 1.7f, .least_friction = 0.3f, .most_friction = 0.8f};
  write_onnx(path_, model);
  const nn::Learnt read = read_onnx(path_).learnt;
  EXPECT_EQ(read.smallest_peak, 0.1f);
  EXPECT_EQ(read.largest_peak, 1.7f);
  EXPECT_EQ(read.least_friction, 0.3f);
  EXPECT_EQ(read.most_friction, 0.8f);
  const SlipEstimator library = SlipEstimator::load(path_.string());
  EXPECT_EQ(library.metadata("smallest_peak"), "0.1");
  EXPECT_EQ(library.metadata("most_friction"), "0.8");
  EXPECT_EQ(library.smallest_peak(), 0.1f);
  write_onnx(path_, some_model("16-9-1", ScalingKind::set));
  EXPECT_EQ(SlipEstimator::load(path_.string()).metadata("smallest_peak"), "") << "of a network that does not know it";
}

// The alarm of such a file never comes, or nothing is a contact.
TEST_F(OnnxFile, RefusesRangesThatNoSetHas) {
  nn::Model model = some_model("16-9-1", ScalingKind::set);
  model.learnt = {
      .smallest_peak = 0.1f, .largest_peak = 1.7f, .least_friction = 0.3f, .most_friction = 0.8f, .alarm_at = 0.2f};
  const std::pair<const char*, const char*> bad[] = {
      {"alarm_at", "1"},         {"alarm_at", "100"},      {"alarm_at", "-0.2"},   {"smallest_peak", "-1"},
      {"smallest_peak", "1e30"}, {"smallest_peak", "1.8"}, {"smallest_peak", "0"}, {"least_friction", "0.9"}};
  for (const auto& [key, value] : bad) {
    onnx::ModelProto crafted = parsed(model);
    metadata(crafted, key) = value;
    put(sealed(crafted));
    EXPECT_THAT(message(), ::testing::AllOf(::testing::HasSubstr("network.onnx"), ::testing::HasSubstr(key))) << value;
    EXPECT_THROW(SlipEstimator::load(path_.string()), InputError) << key << ' ' << value;
  }
}

TEST_F(OnnxFile, AnotherTargetNamesTheOutput) {
  nn::Model model = some_model("16-9-1", ScalingKind::frame);
  const nn::RowMatrix<float> frames = bumps(20, 16, 9).frames;
  const OnnxEvaluator::Tensor s = OnnxEvaluator(parsed(model)).run(frames.cast<double>());
  for (const nn::Target target : {nn::Target::force_ratio, nn::Target::stick_fraction, nn::Target::slid,
                                  nn::Target::slip_path, nn::Target::net_slip, nn::Target::slid_ahead}) {
    model.target = target;
    const onnx::ModelProto file = parsed(model);
    EXPECT_NO_THROW(onnx::checker::check_model(file));
    ASSERT_EQ(file.graph().output_size(), 1);
    EXPECT_EQ(file.graph().output(0).name(), nn::name(target));
    EXPECT_EQ(OnnxEvaluator(file).run(frames.cast<double>()), s);
    write_onnx(path_, model);
    EXPECT_EQ(read_onnx(path_).target, target);
    onnx::ModelProto crafted = file;
    metadata(crafted, "target") = "mu";
    put(sealed(crafted));
    EXPECT_THAT(message(), ::testing::HasSubstr(
                               "slip_index, force_ratio, stick_fraction, slid, slip_path, net_slip or slid_ahead"));
  }
}

/// Files of before did not say what their `slid` is: it is what sets of grips had under that name, their cells' slips.
TEST_F(OnnxFile, ASlideWithoutADefinitionIsThatOfCells) {
  nn::Model model = some_model("16-9-1", ScalingKind::frame);
  model.target = nn::Target::slid;
  onnx::ModelProto file = parsed(model);
  EXPECT_EQ(metadata(file, "target_definition"), nn::definition(nn::Target::slid));
  for (int k = 0; k < file.metadata_props_size(); ++k)
    if (file.metadata_props(k).key() == "target_definition") file.mutable_metadata_props()->DeleteSubrange(k--, 1);
  put(sealed(file));
  EXPECT_EQ(read_onnx(path_).target, nn::Target::slip_path);
}

TEST_F(OnnxFile, SaysWhatIsWrongWithABadFile) {
  EXPECT_THAT(message(), ::testing::HasSubstr("cannot be read"));
  put("");
  EXPECT_THAT(message(), ::testing::HasSubstr("empty"));
  put("[sensor]\nlength = 20.0\n");
  EXPECT_THAT(message(), ::testing::HasSubstr("network.onnx"));
  const std::string good = infer::network_bytes(some_model("16-16-8-1", ScalingKind::set));
  put(good.substr(0, good.size() / 2));
  EXPECT_THAT(message(), ::testing::HasSubstr("must be"));
  put(good);
  EXPECT_EQ(message(), "no error");
}

// A byte changed anywhere, or an end lost, is noticed.
TEST_F(OnnxFile, NoticesEveryDamage) {
  const std::string good = infer::network_bytes(some_model("2-1-1", ScalingKind::frame));
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

  onnx::ModelProto other = parsed(some_model("16-16-8-1", ScalingKind::set));
  for (onnx::StringStringEntryProto& entry : *other.mutable_metadata_props())
    if (entry.key() == "topology") entry.set_value("16-16-9-1");
  put(other.SerializeAsString());
  EXPECT_THAT(message(), ::testing::HasSubstr("damaged"));
}

// Joining two halves of a message gives its fields another order, which means nothing.
TEST_F(OnnxFile, FieldsHaveNoOrder) {
  for (const ScalingKind kind : {ScalingKind::set, ScalingKind::frame}) {
    const nn::Model model = some_model("16-16-8-1", kind);
    onnx::ModelProto rest = parsed(model), graph;
    graph.mutable_graph()->Swap(rest.mutable_graph());
    rest.clear_graph();
    put(graph.SerializeAsString() + rest.SerializeAsString());
    ASSERT_EQ(message(), "no error");
    EXPECT_EQ(read_onnx(path_).weights.values, model.weights.values);
  }
}

/// A model whose graph somebody changed, with the checksum that its content then has.
struct Crafted {
  const char* name;
  std::function<void(onnx::ModelProto&)> change;
};

// Beside the changes of single fields (CraftedNetworks): none may crash, hang, or ask for memory by a number that the
// file names, once more with a right checksum.
TEST_F(OnnxFile, CraftedFilesAreRefused) {
  const std::vector<Crafted> all = {
      {"huge dimension", [](auto& m) { initializer(m, "weight1").set_dims(0, std::int64_t{1} << 62); }},
      {"negative dimension", [](auto& m) { initializer(m, "weight1").set_dims(1, -16); }},
      {"too little data", [](auto& m) { initializer(m, "bias1").mutable_raw_data()->resize(3); }},
      {"too much data", [](auto& m) { initializer(m, "bias1").mutable_raw_data()->append(64, 'x'); }},
      {"NaN", [](auto& m) { begin_with(initializer(m, "weight1"), std::numeric_limits<float>::quiet_NaN()); }},
      {"infinity", [](auto& m) { begin_with(initializer(m, "bias2"), std::numeric_limits<float>::infinity()); }},
      {"graph in an attribute",
       [](auto& m) {
         onnx::AttributeProto& attribute = *m.mutable_graph()->mutable_node(0)->add_attribute();
         attribute.set_name("body");
         onnx::GraphProto* inner = attribute.mutable_g();
         for (int depth = 0; depth < 20; ++depth) inner = inner->add_node()->add_attribute()->mutable_g();
       }},
      {"huge topology", [](auto& m) { metadata(m, "topology") = "2147483646-9999-1"; }},
      {"long topology", [](auto& m) { metadata(m, "topology") = std::string(1 << 20, '1'); }},
      {"metadata twice",
       [](auto& m) {
         onnx::StringStringEntryProto& entry = *m.add_metadata_props();
         entry.set_key("seed");
         entry.set_value("8");
       }},
  };
  for (const Crafted& crafted : all) {
    onnx::ModelProto proto = parsed(some_model("16-16-8-1", ScalingKind::set));
    crafted.change(proto);
    put(proto.SerializeAsString());
    EXPECT_THAT(message(), ::testing::HasSubstr("must be")) << crafted.name;
    put(sealed(proto));
    EXPECT_THAT(message(), ::testing::HasSubstr("must be")) << crafted.name << ", right checksum";
    EXPECT_LT(message().size(), 1000u) << crafted.name;
  }
  put(sealed(parsed(some_model("16-16-8-1", ScalingKind::set))));
  EXPECT_EQ(message(), "no error");
}

TEST_F(OnnxFile, IsNoDeviceAndNotEndless) {
  EXPECT_THAT(refusal("/dev/zero"), ::testing::HasSubstr("must be"));
  EXPECT_THAT(refusal(directory_), ::testing::HasSubstr("must be"));
  put(infer::network_bytes(some_model("2-1-1", ScalingKind::set)));
  fs::resize_file(path_, std::uintmax_t{1} << 40);  // a hole: it takes no room
  EXPECT_THAT(message(), ::testing::HasSubstr("must be"));
}

TEST_F(OnnxFile, SaysWhenItCannotWrite) {
  EXPECT_THROW(write_onnx(directory_ / "nowhere" / "network.onnx", some_model("2-1-1", ScalingKind::set)), ConfigError);
}

}  // namespace onnx_file_test
