// SPDX-License-Identifier: Apache-2.0

// Network files that tactel did not write, under a checksum that fits: tactel::infer and the program refuse each.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tactel/infer.h>

#include <cmath>
#include <functional>

#include "host/networks/onnx_file.h"
#include "host/support/errors.h"
#include "tests/host/networks/bounded_model.h"
#include "tests/host/networks/crafted_network.h"
#include "tests/host/support/run_tactel.h"

namespace crafted_networks_test {

using namespace tactel;
using nn::ScalingKind;
using tactel::tests::begin_with;
using tactel::tests::bounded_model;
using tactel::tests::each_change;
using tactel::tests::initializer;
using tactel::tests::metadata;
using tactel::tests::parsed;
using tactel::tests::sealed;

bool infer_accepts(const std::string& bytes) {
  try {
    SlipEstimator::parse(std::as_bytes(std::span(bytes)));
    return true;
  } catch (const InputError&) {
    return false;
  }
}

bool program_accepts(const std::filesystem::path& file) {
  try {
    host::read_onnx(file);
    return true;
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("must be"));
    return false;
  }
}

nn::Model plain_model(ScalingKind kind) {
  nn::Model model{nn::initial_weights(nn::Topology::parse("12-2-2-1"), 7), {kind, 2.0f}, 7, 0.1, "set.h5", 20, {}};
  model.history = {.frames = 3, .stride = 2, .change = 0.07};
  model.scaling.history = 3;
  return model;
}

// Texts are free where they name a set. The order of metadata means nothing.
TEST(CraftedNetworksSlow, NoChangeOfAnyFieldIsAccepted) {
  const host::ScratchFolder folder;
  int changes = 0;
  const std::vector<nn::Model> models = {bounded_model("4-2-3_leaky-relu", ScalingKind::frame),
                                         bounded_model("4-2-3", ScalingKind::set, false),
                                         plain_model(ScalingKind::frame), plain_model(ScalingKind::set)};
  for (const nn::Model& model : models) {
    onnx::ModelProto proto = parsed(model);
    const std::string whole = sealed(proto);
    ASSERT_TRUE(infer_accepts(whole) && program_accepts(folder.write("file", whole)));
    each_change(proto, "model", [&](const std::string& change) {
      if (change == "model: metadata_props in another order") return;
      const std::size_t entry = change.find("metadata_props[");
      if (entry != std::string::npos && change.ends_with("value more")) {
        const std::string& key = proto.metadata_props(std::stoi(change.substr(entry + 15))).key();
        if (key == "learning_set" || key == "bound_set" || key == "checksum") return;
      }
      const std::string bytes = sealed(proto);
      if (bytes == whole) return;  // two equal parts changed places
      EXPECT_FALSE(infer_accepts(bytes)) << change;
      EXPECT_FALSE(program_accepts(folder.write("file", bytes))) << change;
      ++changes;
    });
  }
  EXPECT_GT(changes, 5000);
}

// A stress to divide by that is no number above 0; a history whose frames, doubled, overflow an int.
TEST(CraftedNetworks, NumbersOutOfRangeAreRefused) {
  const host::ScratchFolder folder;
  for (const ScalingKind kind : {ScalingKind::set, ScalingKind::frame}) {
    const nn::Model model = plain_model(kind);
    EXPECT_EQ(host::read_onnx(folder.write("good", sealed(parsed(model)))).history, model.history);
    for (const auto& [key, values] : std::map<std::string, std::vector<const char*>>{
             {"largest_stress", {"nan", "inf", "-inf", "0", "-0", "-1", "1e-13", "1e38", "1e39", "", "2 ", "two"}},
             {"history",
              {"2147483647", "1073741825", "1073741824", "2147483648", "99999999999", "-1", "-3", "0", "1", "4", "5",
               "12", "0x3", "x"}},
             {"stride", {"0", "-1", "1001", "2000000", "2147483647"}},
             {"history_change", {"nan", "-0.1", "1.5", "7"}},
             {"noise", {"nan", "0.10", "inf", "1e999"}},
             {"seed", {"-1", "18446744073709551616", "+7", "07"}},
             {"error_mean", {"nan", "inf"}},
             {"topology", {"12-2-2-1-1", "12-2-2-2", "13-2-2-1", "12-0-2-1", "2147483647-2-2-1", "12-2-2-1_relu", ""}},
             {"scaling", {"", "sideways", kind == ScalingKind::set ? "frame" : "set"}},
             {"tactel", {"", "1"}}}) {
      for (const char* value : values) {
        onnx::ModelProto proto = parsed(model);
        metadata(proto, key) = value;
        EXPECT_FALSE(infer_accepts(sealed(proto))) << key << " = " << value;
        EXPECT_FALSE(program_accepts(folder.write("file", sealed(proto)))) << key << " = " << value;
      }
    }
  }
}

// Tables of a bound of a wrong size, type or kind of number.
TEST(CraftedNetworks, OtherTablesOfABoundAreRefused) {
  using Change = std::function<void(onnx::TensorProto&)>;
  const host::ScratchFolder folder;
  const auto accepted = [&](const std::string& name, const Change& change) {
    onnx::ModelProto proto = parsed(bounded_model("16-9-3", ScalingKind::set));
    change(initializer(proto, name));
    const bool by_infer = infer_accepts(sealed(proto));
    EXPECT_EQ(program_accepts(folder.write("file", sealed(proto))), by_infer) << name;
    return by_infer;
  };
  EXPECT_TRUE(accepted("centre", [](onnx::TensorProto&) {}));
  const Change changes[] = {[](onnx::TensorProto& tensor) { begin_with(tensor, INFINITY); },
                            [](onnx::TensorProto& tensor) { tensor.clear_raw_data(); },
                            [](onnx::TensorProto& tensor) { tensor.set_data_type(onnx::TensorProto::DOUBLE); },
                            [](onnx::TensorProto& tensor) {
                              tensor.set_raw_data(tensor.raw_data().substr(4));
                              tensor.set_dims(0, tensor.dims(0) - 1);
                            }};
  const std::vector<std::string> tables = {"upper_corrections", "interval_corrections", "centre",
                                           "touching_edges",    "slip_index_edges",     "width_edges",
                                           "distance_edges"};
  for (const std::string& name : tables)
    for (const Change& change : changes)
      EXPECT_FALSE(accepted(name, change)) << name << ", change " << &change - changes;
  for (const std::string name : {"whitening", "unlike_above"})
    EXPECT_FALSE(accepted(name, [](onnx::TensorProto& tensor) { begin_with(tensor, NAN); })) << name;
  const auto number = [](std::int64_t value) {
    return [value](onnx::TensorProto& tensor) { tensor.set_raw_data(&value, sizeof value); };
  };
  for (const std::int64_t tactels : {-1, 0, 7, 9, 1 << 30})
    EXPECT_FALSE(accepted("tactels", number(tactels))) << tactels;
  EXPECT_TRUE(accepted("tactels", number(4)));  // two frames of four tactels
  EXPECT_FALSE(accepted("column1", number(7)));
}

// The weights stand in the file: no runtime then looks for them elsewhere.
TEST(CraftedNetworks, DataElsewhereIsRefused) {
  onnx::ModelProto proto = parsed(plain_model(ScalingKind::set));
  onnx::TensorProto& tensor = *proto.mutable_graph()->mutable_initializer(2);
  tensor.set_data_location(onnx::TensorProto::EXTERNAL);
  onnx::StringStringEntryProto& location = *tensor.add_external_data();
  location.set_key("location"), location.set_value("/etc/passwd");
  const host::ScratchFolder folder;
  EXPECT_FALSE(infer_accepts(sealed(proto)));
  EXPECT_FALSE(program_accepts(folder.write("file", sealed(proto))));
}

// Files that libprotobuf wrote, when the program still did so by it.
TEST(CraftedNetworks, FilesOfEarlierVersionsAreRead) {
  for (const char* seed : {"seed", "seed_by_frame", "seed_bound"}) {
    const std::string file = host::source_file(std::string("tests/fuzz/corpus/network/") + seed);
    EXPECT_TRUE(infer_accepts(host::text_of(file))) << seed;
    EXPECT_TRUE(program_accepts(file)) << seed;
  }
}

}  // namespace crafted_networks_test
