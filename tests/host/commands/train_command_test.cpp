// SPDX-License-Identifier: Apache-2.0

// `tactel train` and `tactel recall` as a user meets them: files, tables, wrong calls, and sets at their extremes.
#include <gmock/gmock.h>
#include <tactel/infer.h>

#include <cmath>
#include <cstdio>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>

#include "host/networks/onnx_file.h"
#include "host/sets/contact_set.h"
#include "host/training/answered_rows.h"
#include "nn/forward.h"
#include "tests/host/sets/network_files.h"

namespace train_command_test {

using namespace tactel;
using namespace tactel::host;
using nlohmann::json;
using tactel::tests::networks_in;
using tactel::tests::PaperSetFiles;
using ::testing::HasSubstr;
using ::testing::Not;
namespace fs = std::filesystem;

constexpr float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();

ChildResult train(const std::string& directory, const std::vector<std::string>& options = {}) {
  return run_tactel({"train", PaperSetFiles::learning(), "--output", directory, "--cycles", "20"}, options);
}

/// Two small trainings that several tests look at: scaled by the set and by the frame.
const ScratchFolder& trained() {
  static const ScratchFolder folder;
  static const bool made = [] {
    EXPECT_EQ(train(folder / "set", {"--network", "6", "--network", "42-5-1"}).exit_code, 0);
    EXPECT_EQ(train(folder / "frame", {"--network", "6", "--scaling", "frame"}).exit_code, 0);
    return true;
  }();
  EXPECT_TRUE(made);
  return folder;
}

json recall_json(const std::string& networks, const std::string& set) {
  const ChildResult result = run_tactel({"recall", networks, set, "--json", "-"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  return json::parse(result.out);
}

TEST(RecallCommand, OutputThatTakesNotAllIsAnError) {
  for (const char* options : {"", "--json -"}) {
    EXPECT_TRUE(is_refused(run_child({"sh", "-c",
                                      TACTEL_PROGRAM " recall " + (trained() / "set").string() + " " +
                                          PaperSetFiles::recall() + " " + options + " >/dev/full"}),
                           {"standard output"}));
  }
}

TEST(TrainCommand, WritesNetworksReportAndFigure) {
  const ScratchFolder folder;
  const ChildResult result = train(folder / "net", {"--network", "3", "--network", "42-5-1", "--seeds", "2", "--noise",
                                                    "0", "--noise", "0.1", "--recall", PaperSetFiles::recall()});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(without_progress(result.err), "");
  EXPECT_THAT(result.out, HasSubstr("42-5-1 10%"));
  const json report = json::parse(text_of(folder / "net" / "training.json"));
  ASSERT_EQ(report["networks"].size(), 8u);
  EXPECT_EQ(report["patterns"].get<double>(), 8.0 * 20 * report["rows"].get<double>());
  EXPECT_GT(report["patterns_per_second"].get<double>(), 0);
  for (const json& network : report["networks"]) {
    EXPECT_EQ(network["status"], "cycle limit");
    EXPECT_EQ(network["curve"]["cycle"].back(), 20);
    EXPECT_GT(network["recalling"]["mean"].get<double>(), 0);
    const nn::Model model = read_onnx(folder / "net" / network["file"]);
    EXPECT_EQ(model.weights.topology.text(), network["topology"]);
    EXPECT_EQ(model.seed, network["seed"]);
    EXPECT_EQ(model.noise, network["noise"]);
    EXPECT_EQ(model.learning_errors.mean, network["learning"]["mean"]);
  }
  EXPECT_EQ(report["networks"][0]["network"], 3);
  EXPECT_TRUE(report["networks"][4]["network"].is_null());
  EXPECT_EQ(networks_in(folder / "net").size(), 8u);
  EXPECT_THAT(text_of(folder / "net" / "learning_curves.svg"), HasSubstr("median of up to 2 seeds"));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder / "net"), {}), 11);  // and no checkpoint
  // A line a point of each curve, with the numbers of the report.
  std::istringstream lines(text_of(folder / "net" / "learning_curves.jsonl"));
  std::string line;
  for (const json& network : report["networks"])
    for (std::size_t i = 0; i < network["curve"]["cycle"].size(); ++i) {
      ASSERT_TRUE(std::getline(lines, line));
      const json point = json::parse(line);
      EXPECT_EQ(point["network"], network["file"]);
      EXPECT_EQ(point["cycle"], network["curve"]["cycle"][i]);
      EXPECT_EQ(point["mean_squared_error"], network["curve"]["mean_squared_error"][i]);
    }
  EXPECT_FALSE(std::getline(lines, line));
}

TEST(TrainCommand, PadsLearnWithFeatures) {
  const ScratchFolder folder;
  const std::string sweep = folder.write("pads.toml",
                                         "[sweep]\ncontacts = 20\n[sensor]\nkind = \"pad\"\nthickness = 4\n"
                                         "[indenter]\nshape = \"sphere\"\nradius = { uniform = [5, 9] }\n"
                                         "position = [{ uniform = [-5, 5] }, { uniform = [-5, 5] }]\n"
                                         "[load]\nindentation = 0.3\ntangential = [[0.1, 0.05], [0.2, 0.1]]\n");
  const std::string set = folder / "pads.h5", nets = folder / "nets";
  ASSERT_EQ(run_tactel({"generate", sweep, "--output", set}).exit_code, 0);
  const std::vector<std::string> own{"train", set, "--output", nets, "--features"};
  EXPECT_TRUE(is_refused(run_tactel(own, {"pad", "--network", "48-8-1"}), {"--scaling = set", "--features pad"}));
  EXPECT_TRUE(is_refused(run_tactel(own, {"line", "--scaling", "frame", "--network", "48-8-1"}), {"features = line"}));
  const ChildResult result = run_tactel(own, {"pad", "--scaling", "frame", "--network", "48-8-1", "--schedule", "batch",
                                              "--cycles", "20", "--bound", "--bound-set", set});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(json::parse(text_of(folder / "nets" / "training.json"))["options"]["features"], "pad");
  const auto files = networks_in(nets);
  ASSERT_EQ(files.size(), 1u);
  const nn::Model model = read_onnx(folder / "nets" / files.begin()->first);
  EXPECT_EQ(model.weights.topology.text(), "66-8-3");  // 48 stresses, 17 sums, the share of the peak
  EXPECT_EQ(model.scaling.columns, 4);
  EXPECT_TRUE(model.scaling.square);
  nn::Model turned = model;
  turned.scaling.columns = 2, turned.scaling.square = false;
  write_onnx(folder / "turned.onnx", turned);
  EXPECT_TRUE(
      is_refused(run_tactel({"recall", folder / "turned.onnx", set}), {"tactel_columns = 2", "4 tactels along x"}));
  EXPECT_GT(recall_json(nets, set)["networks"][0]["bound"]["coverage"].get<double>(), 0.5);
}

TEST(TrainCommand, GoesOnWithoutItsFigure) {
  const ScratchFolder folder;
  fs::create_directories(folder / "net" / "learning_curves.svg" / "mine");
  const ChildResult result = train(folder / "net", {"--network", "3"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.err, HasSubstr("learning_curves.svg is not drawn"));
  EXPECT_TRUE(fs::exists(folder / "net" / "training.json"));
  EXPECT_EQ(networks_in(folder / "net").size(), 1u);
}

// Underscores in names are no markup of figures.
TEST(TrainCommand, PageOfARecallNamesIndenters) {
  const ScratchFolder folder;
  const std::string sweep = folder.write(
      "sweep.toml",
      "[sweep]\ncontacts = 20\n[indenter]\nshape = \"rounded_flat\"\nhalf_width = 1\nradius = 5\n[contact]\nfriction "
      "= { uniform = [0.2, 0.9] }\n[load]\nindentation = 0.1\ntangential_step = 0.03\ntangential_steps = 3\n");
  const std::string set = folder / "set.h5", page = folder / "recall.html";
  ASSERT_EQ(run_tactel({"generate", sweep, "--output", set, "--quiet"}).exit_code, 0);
  ASSERT_EQ(run_tactel({"recall", trained() / "set", set, "--html", page, "--quiet"}).exit_code, 0);
  EXPECT_THAT(text_of(page), HasSubstr(R"("rounded\\_flat")"));
  EXPECT_THAT(text_of(page), Not(HasSubstr(R"("rounded_flat")")));
}

// A network's bits are its own: not its company's.
TEST(TrainCommand, SixNetworksAreTheDefault) {
  const ScratchFolder folder;
  ASSERT_EQ(train(folder / "all", {"--quiet"}).exit_code, 0);
  const auto all = networks_in(folder / "all"), some = networks_in(trained() / "set");
  EXPECT_EQ(all.size(), 6u);
  EXPECT_EQ(all.at("42-42-21-1_noise0_seed1.onnx"), some.at("42-42-21-1_noise0_seed1.onnx"));
}

TEST(TrainCommand, GuardsWhatADirectoryHolds) {
  const ScratchFolder folder;
  const std::string net = folder / "net";
  ASSERT_EQ(train(net, {"--network", "3"}).exit_code, 0);
  const auto before = networks_in(net);
  EXPECT_THAT(train(net, {"--network", "1"}).err, HasSubstr("without a finished training, or --force"));
  EXPECT_THAT(train(net, {"--network", "1", "--resume"}).err, HasSubstr("of another training"));
  const ChildResult again = train(net, {"--network", "3", "--resume"});
  EXPECT_EQ(again.exit_code, 0);
  EXPECT_THAT(again.out, HasSubstr("this training is complete"));
  EXPECT_EQ(networks_in(net), before);

  EXPECT_EQ(train(net, {"--network", "1", "--force"}).exit_code, 0);
  EXPECT_EQ(networks_in(net).size(), 1u);
  EXPECT_EQ(networks_in(net).count("42-42-1_noise0_seed1.onnx"), 1u);
  fs::copy_file(trained() / "set" / "42-5-1_noise0_seed1.onnx", folder / "net" / "mine.onnx");
  EXPECT_THAT(train(net, {"--force"}).err, HasSubstr("without networks of another origin (mine.onnx)"));
  EXPECT_TRUE(fs::exists(folder / "net" / "mine.onnx"));
}

TEST(TrainCommand, RefusesACheckpointOfAnotherTraining) {
  const ScratchFolder folder;
  fs::create_directories(folder / "net");
  folder.write("net/checkpoint", "something else");
  EXPECT_THAT(train(folder / "net").err, HasSubstr("without an interrupted training, or --resume"));
  EXPECT_TRUE(is_refused(train(folder / "net", {"--resume"}), {"not a checkpoint"}));
}

TEST(TrainCommand, RefusesAReportThatIsNone) {
  const ScratchFolder folder;
  fs::create_directories(folder / "net");
  for (const char* text : {"", "[", R"({"fingerprint": 7})", R"({"fingerprint": null, "networks": {"file": 1}})"}) {
    folder.write("net/training.json", text);
    EXPECT_TRUE(is_refused(train(folder / "net", {"--resume"}), {"of another training"}));
  }
}

// A learning rate of 1e38 overflows fp32 in the first steps. The network has no file, and the program says so.
TEST(TrainCommand, SaysThatANetworkDiverged) {
  const ScratchFolder folder;
  for (const char* schedule : {"online", "batch"}) {
    const ChildResult result = train(
        folder / schedule, {"--network", "3", "--learning-rate", "1e38", "--schedule", schedule, "--stop-error", "0"});
    const json network = json::parse(text_of(folder / schedule / "training.json"))["networks"][0];
    EXPECT_EQ(network["status"], "not finite") << schedule;
    EXPECT_EQ(result.exit_code, 4) << schedule;
    EXPECT_THAT(result.err, HasSubstr("1 of 1 networks diverged"));
    EXPECT_TRUE(network["file"].is_null());
    EXPECT_TRUE(networks_in(folder / schedule).empty());
  }
}

TEST(RecallCommand, FiguresAreThoseOfItsRows) {
  const ScratchFolder folder;
  const ChildResult result = run_tactel({"recall", trained() / "set", PaperSetFiles::recall(), "--json",
                                         folder / "a.json", "--rows", folder / "rows.csv"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  const json report = json::parse(text_of(folder / "a.json"));
  const ContactSet set = read_contact_set(PaperSetFiles::recall());
  std::istringstream rows(text_of(folder / "rows.csv"));
  std::string line;
  std::getline(rows, line);
  EXPECT_EQ(line, "row,slip_index,42-42-21-1_noise0_seed1.onnx,42-5-1_noise0_seed1.onnx");
  double sum = 0, most = 0;
  std::size_t count = 0;
  for (; std::getline(rows, line); ++count) {
    double row = 0, s = 0, first = 0, second = 0;
    ASSERT_EQ(std::sscanf(line.c_str(), "%lf,%lf,%lf,%lf", &row, &s, &first, &second), 4) << line;
    EXPECT_EQ(row, static_cast<double>(count));
    EXPECT_EQ(static_cast<float>(s), set.slip_index[count]);
    sum += std::abs(first - s);
    most = std::max(most, std::abs(first - s));
  }
  EXPECT_EQ(count, set.rows());
  // nine digits of S in the table
  EXPECT_NEAR(report["networks"][0]["recalling"]["mean"].get<double>(), sum / static_cast<double>(count), 1e-8);
  EXPECT_NEAR(report["networks"][0]["recalling"]["max"].get<double>(), most, 1e-8);
  std::size_t by_indenter = 0, by_nodes = 0;
  for (const json& kind : report["networks"][0]["by_indenter"]) by_indenter += kind["rows"].get<std::size_t>();
  for (const json& kind : report["networks"][0]["by_contact_nodes"]) by_nodes += kind["rows"].get<std::size_t>();
  EXPECT_EQ(by_indenter, set.rows());
  EXPECT_EQ(by_nodes, set.rows());
  EXPECT_THAT(result.out, HasSubstr("spherical"));
}

TEST(RecallCommand, TakesOneNetworkAndBothPrecisions) {
  const std::string file = trained() / "set" / "42-5-1_noise0_seed1.onnx";
  const json single = recall_json(file, PaperSetFiles::recall());
  ASSERT_EQ(single["networks"].size(), 1u);
  const json exact =
      json::parse(run_tactel({"recall", file, PaperSetFiles::recall(), "--json", "-", "--precision", "fp64"}).out);
  // sums of 42 products in fp32
  EXPECT_NEAR(single["networks"][0]["recalling"]["mean"].get<double>(),
              exact["networks"][0]["recalling"]["mean"].get<double>(), 1e-6);
}

/// The recall set with frames that no rubber ever gave: rows 0 and 1 not finite, 2 zero, 3 and 4 huge, 5 without S, 6
/// over tolerance.
ContactSet extreme_set() {
  ContactSet set = read_contact_set(PaperSetFiles::recall());
  const auto frame = [&](std::size_t row) {
    return set.frames.begin() + static_cast<std::ptrdiff_t>(row) * set.inputs;
  };
  *frame(0) = nan;
  *(frame(1) + 41) = inf;
  std::fill_n(frame(2), set.inputs, 0.0f);
  std::fill_n(frame(3), set.inputs, 1e4f);
  std::fill_n(frame(4), set.inputs, -1e4f);
  set.slip_index[5] = nan;
  set.status[6] = 2;
  return set;
}

TEST(RecallCommand, FramesAtTheirExtremesHaveAStatus) {
  const ScratchFolder folder;
  const ContactSet set = extreme_set();
  write_contact_set(folder / "extreme.h5", set);
  for (const char* scaling : {"set", "frame"}) {
    const std::string networks = trained() / scaling;
    const json report = recall_json(networks, folder / "extreme.h5");
    EXPECT_EQ(report["rows"], set.rows() - 2);
    EXPECT_EQ(report["rows_left_out"], 2);
    for (const json& network : report["networks"]) {
      EXPECT_EQ(network["frames"]["not finite"], 2) << scaling;
      EXPECT_EQ(network["frames"]["no stress"], std::string(scaling) == "frame" ? 1 : 0);
      EXPECT_EQ(network["without_answer"], 2);
      EXPECT_EQ(network["recalling"]["rows"], set.rows() - 4);
      for (const char* figure : {"max", "mean", "std"}) EXPECT_TRUE(network["recalling"][figure].is_number());
    }
    ASSERT_EQ(run_tactel({"recall", networks, folder / "extreme.h5", "--rows", folder / "rows.csv"}).exit_code, 0);
    EXPECT_THAT(text_of(folder / "rows.csv"), ::testing::Not(HasSubstr("nan")));
  }
}

TEST(RecallCommand, ASetWithoutAnyGoodFrameHasNoFigures) {
  const ScratchFolder folder;
  ContactSet set = read_contact_set(PaperSetFiles::recall());
  std::fill(set.frames.begin(), set.frames.end(), nan);
  write_contact_set(folder / "nan.h5", set);
  const json network = recall_json(trained() / "set", folder / "nan.h5")["networks"][0];
  EXPECT_TRUE(network["recalling"]["mean"].is_null());
  EXPECT_EQ(network["recalling"]["rows"], 0);
  EXPECT_EQ(network["without_answer"], set.rows());
}

/// Sets that nothing can be learnt from, and networks that are none.
class BadFiles : public ::testing::Test {
 protected:
  std::string written(const std::string& name, const ContactSet& set) const {
    write_contact_set(folder_ / name, set);
    return folder_ / name;
  }
  static void expect_refusal(const std::vector<std::string>& arguments, const std::vector<std::string>& says) {
    EXPECT_TRUE(is_refused(run_tactel(arguments), says));
  }
  ScratchFolder folder_;
};

TEST_F(BadFiles, SetsThatNothingCanBeLearntFrom) {
  const std::string net = folder_ / "net";
  expect_refusal({"train", written("extreme.h5", extreme_set()), "--output", net},
                 {"extreme.h5: inputs[0] = NaN or infinity: must be finite"});
  ContactSet set = read_contact_set(PaperSetFiles::recall());
  std::fill(set.frames.begin(), set.frames.end(), 0.0f);
  expect_refusal({"train", written("zero.h5", set), "--output", net}, {"zero.h5", "scaling"});
  std::fill(set.slip_index.begin(), set.slip_index.end(), nan);
  const std::string unanswered = written("unanswered.h5", set);
  expect_refusal({"train", unanswered, "--output", net}, {"unanswered.h5: slip_index", "none of them solved"});
  expect_refusal({"recall", trained() / "set", unanswered}, {"unanswered.h5: slip_index"});
  ContactSet none;
  none.inputs = 42;
  const std::string empty = written("empty.h5", none);
  expect_refusal({"train", empty, "--output", net}, {"empty.h5: slip_index = 0 rows"});
  expect_refusal({"recall", trained() / "set", empty}, {"empty.h5: slip_index = 0 rows"});
  for (const std::string& file : {empty, unanswered})
    expect_refusal({"train", file, "--output", net, "--block", "100"}, {fs::path(file).filename(), "slip_index"});
  fs::remove_all(net);
  EXPECT_FALSE(fs::exists(net));
}

// Rows are named as the file counts them, though rows without an answer are left out; by the blocks of --block, too.
TEST_F(BadFiles, FileAndRowOfAFrameThatIsNotFinite) {
  ContactSet set = read_contact_set(PaperSetFiles::recall());
  set.status[0] = 2;
  set.slip_index[3] = nan;
  set.frames[117 * 42 + 5] = nan;
  const std::string file = written("odd.h5", set);
  expect_refusal({"train", file, "--output", folder_ / "net"}, {"odd.h5: inputs[117] = NaN or infinity"});
  expect_refusal({"train", file, "--output", folder_ / "net", "--block", "50", "--rows", "1000"},
                 {"odd.h5: inputs[117] = NaN or infinity"});
  set.frames[117 * 42 + 5] = 0;
  set.slip_index[118] = 2e3f;
  expect_refusal({"train", written("far.h5", set), "--output", folder_ / "net"}, {"far.h5: slip_index[118] = 2000"});
}

using BadFilesNightly = BadFiles;
// Finite, but the shear stress over the normal one is not, in fp32.
TEST_F(BadFilesNightly, FileOfAFrameThatOverflowsWhenItIsScaled) {
  ContactSet set = read_contact_set(PaperSetFiles::recall());
  std::fill_n(set.frames.begin(), 21, 1e-11f);
  std::fill_n(set.frames.begin() + 21, 21, 3e38f);
  const std::string file = written("steep.h5", set);
  for (const char* more : {"", "--block 50 --rows 1000"})
    EXPECT_TRUE(is_refused(run_tactel({"train", file, "--output", folder_ / "net", "--scaling", "frame"}, words(more)),
                           {"steep.h5: inputs["}));
}

TEST_F(BadFiles, SetsOfAnotherWidth) {
  ContactSet set = read_contact_set(PaperSetFiles::recall());
  set.inputs = 16;
  set.tactel_x.clear();
  set.frames.resize(set.rows() * 16);
  const std::string narrow = written("narrow.h5", set);
  expect_refusal({"train", narrow, "--output", folder_ / "net"},
                 {"--network = 42-42-1: must be a network with 16 inputs, as many as", "narrow.h5"});
  expect_refusal({"train", PaperSetFiles::learning(), "--output", folder_ / "net", "--recall", narrow},
                 {"--network = 42-42-1", "narrow.h5"});
  expect_refusal({"recall", trained() / "frame", narrow},
                 {"42-42-21-1_noise0_seed1.onnx: topology = 42-42-21-1: must be a network with 16 inputs"});
  EXPECT_EQ(
      run_tactel({"train", narrow, "--output", folder_ / "net", "--network", "16-8-1", "--cycles", "3"}).exit_code, 0);
}

TEST_F(BadFiles, NetworksThatAreNone) {
  const std::string recall = PaperSetFiles::recall();
  expect_refusal({"recall", folder_ / "absent", recall}, {"absent: must be an existing directory or file"});
  expect_refusal({"recall", recall, trained() / "set"}, {recall, "the set stands behind it"});
  fs::create_directories(folder_ / "bare");
  expect_refusal({"recall", folder_ / "bare", recall}, {"a directory with networks (*.onnx)"});
  const std::string good = text_of(trained() / "set" / "42-5-1_noise0_seed1.onnx");
  expect_refusal({"recall", folder_.write("cut.onnx", good.substr(0, 900)), recall}, {"cut.onnx"});
  std::string other = good;
  other[500] = static_cast<char>(other[500] ^ 1);
  expect_refusal({"recall", folder_.write("damaged.onnx", other), recall}, {"damaged.onnx"});
  expect_refusal({"recall", folder_.write("text.onnx", "[sensor]\n"), recall}, {"text.onnx"});
}

/// A set of balls on a pad of 2 x 2 tactels: lines of [sweep], and all behind the shape of [indenter].
std::string ball_set(const ScratchFolder& folder, const std::string& name, const std::string& sweep,
                     const std::string& rest) {
  const std::string file = folder.write(name + ".toml", "[sweep]\n" + sweep + R"(
[sensor]
kind = "pad"
tactels = [2, 2]
thickness = 2
[indenter]
shape = "sphere"
)" + rest);
  const ChildResult result = run_tactel({"generate", file, "--rung", "pad-8", "--output", folder / name, "--quiet"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  return folder / name;
}

// A network of another column is one of S on a set that holds that column in the place of S, to the bit.
TEST(TrainTarget, IsThatColumnOfTheSet) {
  const ScratchFolder folder;
  const std::string set = ball_set(folder, "set.h5", "contacts = 40", R"(radius = { uniform = [4, 9] }
[load]
indentation = { uniform = [0.05, 0.2] }
[load.irregular]
stroke_steps = 5
direction = { uniform = [0, 360] }
twist = { uniform = [0, 20] }
)");
  const std::string swapped = folder / "swapped.h5";
  struct Case {
    const char* target;
    std::vector<float> ContactSet::*column;
    std::vector<std::string> how;  ///< from a set in memory, or block by block
  };
  for (const Case& c : {Case{"force_ratio", &ContactSet::force_ratio, {"--cycles", "20"}},
                        {"stick_fraction", &ContactSet::stick_fraction, {"--block", "20", "--rows", "2000"}}}) {
    ContactSet other = read_contact_set(set);
    ASSERT_NE(other.slip_index, other.*c.column);
    other.slip_index = other.*c.column;
    write_contact_set(swapped, other);
    const auto trained_on = [&](const std::string& file, const char* name, const char* target) {
      const ChildResult result = run_tactel({"train", file, "--output", folder / name, "--target", target, "--recall",
                                             file, "--network", "12-5-1", "--force", "--quiet"},
                                            c.how);
      EXPECT_EQ(result.exit_code, 0) << result.err;
      return json::parse(text_of(folder / name / "training.json"));
    };
    const json report = trained_on(set, "ours", c.target), expected = trained_on(swapped, "theirs", "slip_index");
    EXPECT_EQ(report["options"]["target"], c.target);
    EXPECT_EQ(report["networks"][0]["recalling"], expected["networks"][0]["recalling"]);
    const std::string file = report["networks"][0]["file"];
    const nn::Model model = read_onnx(folder / "ours" / file), same = read_onnx(folder / "theirs" / file);
    EXPECT_EQ(model.weights.values, same.weights.values) << c.target;
    EXPECT_STREQ(nn::name(model.target), c.target);
    EXPECT_EQ(same.target, nn::Target::slip_index);

    EXPECT_EQ(recall_json(folder / "ours", set)["networks"][0]["recalling"],
              recall_json(folder / "theirs", swapped)["networks"][0]["recalling"]);
    const ChildResult recalled = run_tactel({"recall", folder / "ours", set, "--rows", folder / "rows.csv"});
    EXPECT_THAT(recalled.out, HasSubstr(std::string("errors |") + c.target + " - " + c.target + " of the set|"));
    EXPECT_THAT(text_of(folder / "rows.csv"), ::testing::StartsWith(std::string("row,") + c.target + ","));
    EXPECT_TRUE(is_refused(run_tactel({"recall", folder / "ours", set, "--html", folder / "page.html"}), {"--html"}));
  }
  EXPECT_TRUE(is_refused(run_tactel({"recall", folder / "ours", set, "--decision"}), {"which rise toward sliding"}));
  fs::copy(folder / "ours" / "12-5-1_noise0_seed1.onnx", folder / "theirs" / "other.onnx");
  EXPECT_TRUE(is_refused(run_tactel({"recall", folder / "theirs", set}), {"networks of one target"}));
}

/// 60 contacts of balls with 6 markers in the skin.
std::string marked_set(const ScratchFolder& folder, const std::string& name, int seed, const std::string& more = "") {
  return ball_set(folder, name, "contacts = 60\nseed = " + std::to_string(seed) + more, R"(radius = { uniform = [4, 9] }
[contact]
friction = 0.6
[load]
indentation = 0.2
tangential = [[{ uniform = [0, 0.1] }, { uniform = [-0.1, 0.1] }], [0.1, 0.1]]
[markers]
counts = [3, 2]
pitch = 1.5
depth = 0.3
)");
}

const std::vector<std::string> of_markers{"--inputs", "markers", "--network", "12-8-1", "--quiet"};

/// x and y of every marker [rows, 12].
std::vector<float> seen_of(const ContactSet& set) {
  std::vector<float> seen;
  for (std::size_t row = 0; row < set.rows(); ++row)
    for (std::size_t marker = 0; marker < 6; ++marker)
      for (std::size_t axis = 0; axis < 2; ++axis) seen.push_back(set.markers[(row * 6 + marker) * 3 + axis]);
  return seen;
}

/// A network of markers is one of stresses on a set that holds x and y of the markers in their place, to the bit.
TEST(TrainMarkers, TakeThePlaceOfStresses) {
  const ScratchFolder folder;
  const std::string set = marked_set(folder, "set.h5", 1), swapped = folder / "swapped.h5";
  ContactSet other = read_contact_set(set);
  ASSERT_EQ(other.marker_numbers, 18);
  other.frames = seen_of(other);
  write_contact_set(swapped, other);
  for (const std::vector<std::string>& how :
       {std::vector<std::string>{"--cycles", "30", "--noise", "0.02"}, {"--block", "50", "--rows", "1000"}}) {
    std::vector<std::string> options = how;
    options.insert(options.end(), {"--network", "12-8-1", "--force", "--quiet"});
    for (const auto& [name, file, inputs] : {std::tuple("ours", set, "markers"), {"theirs", swapped, "stresses"}}) {
      const ChildResult result =
          run_tactel({"train", file, "--output", folder / name, "--recall", file, "--inputs", inputs}, options);
      ASSERT_EQ(result.exit_code, 0) << result.err;
    }
    const json report = json::parse(text_of(folder / "ours" / "training.json")),
               expected = json::parse(text_of(folder / "theirs" / "training.json"));
    EXPECT_EQ(report["options"]["inputs"], "markers");
    EXPECT_FALSE(expected["options"].contains("inputs"));
    EXPECT_EQ(report["networks"][0]["recalling"], expected["networks"][0]["recalling"]);
    const std::string file = report["networks"][0]["file"];
    const nn::Model model = read_onnx(folder / "ours" / file), same = read_onnx(folder / "theirs" / file);
    EXPECT_EQ(model.weights.values, same.weights.values);
    EXPECT_EQ(model.scaling.largest_stress, same.scaling.largest_stress);
    EXPECT_TRUE(model.scaling.markers);
    EXPECT_EQ(model.learnt.largest_peak, 0) << "of no stress";
    EXPECT_FALSE(same.scaling.markers);
    EXPECT_EQ(recall_json(folder / "ours", set)["networks"][0]["recalling"]["mean"],
              recall_json(folder / "theirs", swapped)["networks"][0]["recalling"]["mean"]);
  }
}

/// Better than the best constant, on contacts that it has not learnt from; its kernel, the twin and the library agree.
TEST(TrainMarkers, TeachS) {
  const ScratchFolder folder;
  const std::string set = marked_set(folder, "set.h5", 1), recall = marked_set(folder, "recall.h5", 2);
  std::vector<std::string> options = of_markers;
  options.insert(options.end(), {"--schedule", "batch", "--cycles", "200", "--validation", recall});
  const ChildResult result = run_tactel({"train", set, "--output", folder / "net"}, options);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const std::string file = folder / "net" / networks_in(folder / "net").begin()->first;
  ASSERT_EQ(run_tactel({"recall", file, recall, "--rows", folder / "rows.csv", "--quiet"}).exit_code, 0);
  const ContactSet rows = read_contact_set(recall);
  const std::vector<float> seen = seen_of(rows);
  const nn::Model model = read_onnx(file);
  const SlipEstimator estimator = SlipEstimator::load(file);
  EXPECT_EQ(estimator.metadata("inputs"), "markers");
  std::istringstream lines(text_of(folder / "rows.csv"));
  std::string line;
  std::getline(lines, line);
  std::vector<float> truth;
  double error = 0, of_constant = std::numeric_limits<double>::infinity();
  while (std::getline(lines, line)) {
    std::size_t row = 0;
    float s = 0, answer = 0;
    ASSERT_EQ(std::sscanf(line.c_str(), "%zu,%f,%f", &row, &s, &answer), 3) << line;
    const std::span<const float> frame = std::span(seen).subspan(12 * row, 12);
    EXPECT_EQ(answer, estimator.estimate(frame).slip_index) << row;
    const nn::RowMatrix<float> one = Eigen::Map<const nn::RowMatrix<float>>(frame.data(), 1, 12);
    EXPECT_NEAR(answer, nn::recall(model.weights, model.scaling, one).slip_index(0), 1e-5) << row;
    truth.push_back(s), error += std::abs(s - answer);
  }
  ASSERT_GT(truth.size(), 100u);
  for (const float constant : truth) {
    double sum = 0;
    for (const float s : truth) sum += std::abs(s - constant);
    of_constant = std::min(of_constant, sum);
  }
  EXPECT_LT(error, of_constant / 2);
}

TEST(TrainMarkers, AreNoStresses) {
  const ScratchFolder folder;
  const std::string set = marked_set(folder, "set.h5", 1, "\npress_rows = true"), net = folder / "net";
  const auto train_on = [&](const std::string& file, const std::vector<std::string>& more) {
    return run_tactel({"train", file, "--output", net, "--cycles", "3"}, more);
  };
  ContactSet rows = read_contact_set(set);
  ContactSet odd = rows;
  odd.markers[18 * 7 + 2] = nan;  // z, which no network takes
  write_contact_set(folder / "odd.h5", odd);
  EXPECT_EQ(train_on(folder / "odd.h5", of_markers).exit_code, 0);
  odd.markers[18 * 7 + 1] = nan;
  write_contact_set(folder / "odd.h5", odd);
  EXPECT_TRUE(is_refused(train_on(folder / "odd.h5", {"--inputs", "markers", "--network", "12-8-1", "--force"}),
                         {"odd.h5: markers[7] = NaN or infinity"}));
  ContactSet bare = rows;
  bare.marker_numbers = 0, bare.markers.clear();
  write_contact_set(folder / "bare.h5", bare);
  for (const std::string& file : {std::string(folder / "bare.h5"), PaperSetFiles::recall()})
    for (const std::vector<std::string>& more : {std::vector<std::string>{}, {"--block", "50", "--rows", "100"}}) {
      std::vector<std::string> all{"train", file, "--output", folder / "none", "--inputs", "markers"};
      all.insert(all.end(), more.begin(), more.end());
      EXPECT_TRUE(is_refused(run_tactel(all), {fs::path(file).filename(), "markers = missing: must be a set of pads"}));
    }
  EXPECT_TRUE(is_refused(train_on(set, {"--inputs", "markers", "--network", "18-8-1", "--force"}),
                         {"--network = 18-8-1: must be a network with 12 inputs"}));

  // What takes stresses refuses a network of markers.
  const std::string file = net + "/12-8-1_noise0_seed1.onnx";
  EXPECT_TRUE(is_refused(run_tactel({"recall", file, folder / "bare.h5"}), {"bare.h5", "markers = missing"}));
  EXPECT_TRUE(is_refused(run_tactel({"recall", file, set, "--decision"}), {"--decision", "of markers"}));
  EXPECT_TRUE(
      is_refused(run_tactel({"monitor", "--source", "simulate:" + source_file("examples/pad.toml"), "--network", file}),
                 {"--network = of markers: must be a network of stresses"}));
  EXPECT_TRUE(is_refused(run_tactel({"calibrate", "bound", file, set}), {"a network with a bound"}));
  EXPECT_THROW(Alarm(SlipEstimator::load(file), {}), InputError);
  ASSERT_EQ(train_on(set, {"--network", "12-5-1", "--force", "--quiet"}).exit_code, 0);
  write_onnx(net + "/marked.onnx", [&] {
    nn::Model model = read_onnx(net + "/12-5-1_noise0_seed1.onnx");
    model.scaling.markers = true, model.scaling.axes = 2, model.learnt = {};
    return model;
  }());
  EXPECT_TRUE(is_refused(run_tactel({"recall", net, set}), {"marked.onnx: inputs = markers: must be stresses"}));

  // Nor does a training of one go on as one of the other, though both have 12 inputs.
  EXPECT_TRUE(is_refused(train_on(set, {"--inputs", "markers", "--network", "12-5-1", "--resume"}), {"training.json"}));
}

/// A damaged chunk of /markers is heard of by those alone who read it.
TEST(TrainMarkers, AreReadWhereTheyAreTaken) {
  const ScratchFolder folder;
  const std::string set = marked_set(folder, "set.h5", 1, "\npress_rows = true");
  std::string bytes = text_of(set);
  const ContactSet rows = read_contact_set(set);
  const std::size_t at = bytes.find(std::string(reinterpret_cast<const char*>(&rows.markers[36]), 72));
  ASSERT_NE(at, std::string::npos);
  bytes[at + 2] = static_cast<char>(bytes[at + 2] ^ 1);
  folder.write("set.h5", bytes);
  const std::vector<std::string> train{"train", set, "--cycles", "2", "--output"};
  EXPECT_EQ(run_tactel(train, {folder / "net", "--network", "12-8-1", "--quiet"}).exit_code, 0);
  std::vector<std::string> more{folder / "none"};
  more.insert(more.end(), of_markers.begin(), of_markers.end());
  EXPECT_TRUE(is_refused(run_tactel(train, more), {"set.h5: markers"}));
}

/// Sets of grips had the cells' slips as /slid: such a set is no judge of either slide.
TEST(TrainCommand, KeepsTheTwoSlidesApart) {
  const ScratchFolder folder;
  const std::string set = ball_set(folder, "set.h5", "contacts = 4\nseed = 3", R"(radius = { uniform = [4, 9] }
[contact]
friction = 0.5
[load]
normal_force = { uniform = [0.5, 2] }
[load.hold]
frames = 30
)");
  const std::string former = folder / "former.h5";
  ContactSet without = read_contact_set(set);
  EXPECT_NE(without.slid, without.slip_path);
  without.left_out.insert("slip_path");
  write_contact_set(former, without);
  const auto train = [&](const std::string& file, const char* target) {
    return run_tactel({"train", file, "--output", folder / target, "--target", target, "--cycles", "5", "--network",
                       "12-3-1", "--force", "--quiet"});
  };
  for (const char* target : {"slid", "slip_path"}) {
    ASSERT_EQ(train(set, target).exit_code, 0);
    const nn::Model model = read_onnx(folder / target / "12-3-1_noise0_seed1.onnx");
    EXPECT_STREQ(nn::name(model.target), target);
    EXPECT_THAT(run_tactel({"recall", folder / target, set}).out,
                HasSubstr(std::string("errors |") + target + " - " + target + " of the set|"));
    EXPECT_TRUE(is_refused(run_tactel({"recall", folder / target, former}), {"slip_path"}));
    EXPECT_TRUE(is_refused(train(former, target), {"slip_path"}));
  }
}

/// The way that cells got, of both directions, and the slide to come, which the last 0.2 s of a grip do not know.
TEST(TrainCommand, TeachesHowFarGripsGotAndWhatIsToCome) {
  const ScratchFolder folder;
  const auto generate = [&](const char* name, const char* rate) {
    return ball_set(folder, name, "contacts = 3\nseed = 3", std::string(R"(radius = 6
[contact]
friction = 0.4
[load]
normal_force = 1
[load.hold]
by = "motion"
moves = 1
size = { uniform = [1, 3] }
move_frames = 20
rest = 5
frames = 40
)") + rate);
  };
  const std::string file = generate("set.h5", "rate = 60\n"), without = generate("without.h5", "");
  const ContactSet set = read_contact_set(file);
  const AnsweredRows net = answered_rows(set, file, nn::Target::net_slip),
                     ahead = answered_rows(set, file, nn::Target::slid_ahead);
  float most = 0;
  for (std::size_t i = 0; i < net.row.size(); ++i) {
    const float D = std::hypot(set.net_slip[2 * net.row[i]], set.net_slip[2 * net.row[i] + 1]);
    EXPECT_FLOAT_EQ(net.frames.slip_index(static_cast<Eigen::Index>(i)), D / (1 + D));
    most = std::max(most, D);
  }
  EXPECT_GT(most, 1);
  EXPECT_EQ(ahead.row.size(), net.row.size() - 3 * 12);  // 12 frames in 0.2 s
  for (std::size_t i = 0; i < ahead.row.size(); ++i) {
    const float D = set.slid_ahead[ahead.row[i]];
    EXPECT_FLOAT_EQ(ahead.frames.slip_index(static_cast<Eigen::Index>(i)), D / (1 + D));
  }
  for (const char* target : {"net_slip", "slid_ahead"}) {
    const std::vector<std::string> words{"--target", target,      "--scaling", "rest",   "--cycles",
                                         "3",        "--network", "12-3-1",    "--quiet"};
    const auto train = [&](const std::string& from) {
      std::vector<std::string> all{"train", from, "--output", folder / target};
      all.insert(all.end(), words.begin(), words.end());
      return run_tactel(all);
    };
    EXPECT_TRUE(is_refused(train(without), {target, "a set of grips with [load.hold] rate"}));
    ASSERT_EQ(train(file).exit_code, 0);
    EXPECT_STREQ(nn::name(read_onnx(folder / target / "12-3-1_noise0_seed1.onnx").target), target);
    EXPECT_THAT(run_tactel({"recall", folder / target, file}).out,
                HasSubstr(std::string("errors |") + target + " - " + target + " of the set|"));
  }
}

// S of the validation set is that of the learning set turned round: learning makes it worse from some early cycle on.
TEST(TrainCommand, StopsEarlyAndSaysWhy) {
  const ScratchFolder folder;
  ContactSet set = read_contact_set(PaperSetFiles::learning());
  for (float& s : set.slip_index) s = 1 - s;
  write_contact_set(folder / "against.h5", set);
  const auto train_for = [&](const char* name, const char* cycles) {
    const ChildResult result =
        run_tactel({"train", PaperSetFiles::learning(), "--output", folder / name, "--network", "42-5-1", "--schedule",
                    "batch", "--cycles", cycles, "--validation", folder / "against.h5"},
                   {"--patience", "6", "--force"});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return result.out;
  };
  const std::string said = train_for("net", "100");
  const json network = json::parse(text_of(folder / "net" / "training.json"))["networks"][0];
  const int best = network["best_cycle"];
  EXPECT_EQ(network["status"], "early stop");
  EXPECT_LT(best, 90);
  EXPECT_EQ(network["curve"]["cycle"].back(), best + 6);
  EXPECT_GT(network["curve"]["validation_mean_error"].back(), network["best_validation_mean_error"]);
  EXPECT_THAT(said, HasSubstr("1 early stop"));
  EXPECT_THAT(said, HasSubstr("42-5-1 seed 1: weights of cycle " + std::to_string(best) + ", mean error "));
  EXPECT_THAT(said, HasSubstr("ended at cycle " + std::to_string(best + 6) + ": no smaller one for 6 cycles"));
  EXPECT_NE(text_of(folder / "net" / "learning_curves.svg").find("Validation set"), std::string::npos);
  // The weights are those that a training of so many cycles ends with.
  EXPECT_THAT(train_for("best", std::to_string(best).c_str()), HasSubstr("ended at cycle " + std::to_string(best)));
  const char* const file = "42-5-1_noise0_seed1.onnx";
  EXPECT_EQ(read_onnx(folder / "net" / file).weights.values, read_onnx(folder / "best" / file).weights.values);
}

class WrongTrainingTest : public ::testing::TestWithParam<WrongCall> {};

TEST_P(WrongTrainingTest, EndsWithTwoAndSaysWhy) {
  const ScratchFolder folder;
  EXPECT_TRUE(is_refused(
      run_tactel({"train", PaperSetFiles::learning(), "--output", folder / "net"}, words(GetParam().arguments)),
      {GetParam().says}));
  EXPECT_EQ(folder.files(), 0u);
}

const WrongCall wrong_calls[] = {
    {"SeventhNetwork", "--network 7", "--network = 7"},
    {"WrongWidths", "--network 42-x-1", "--network = 42-x-1"},
    {"SameNetworkTwice", "--network 1 --network 42-42-1", "named once"},
    {"SameNoiseTwice", "--noise 0.1 --noise 0.1", "levels that differ"},
    {"NegativeNoise", "--noise -0.1", "--noise = -0.1"},
    {"NoiseInPercent", "--noise 10", "--noise = 10"},
    {"NoiseJustAboveOne", "--noise 1.001", "0 to 1: 0.1 for 10 %"},
    {"RowsOfAWholeSet", "--rows 100", "--rows = 100: must be left out"},
    {"MomentumOfAdam", "--schedule batch --momentum 0.5",
     "--momentum = 0.5: must be left out, or with --optimizer delta"},
    {"OnlineBlocks", "--block 50 --schedule online",
     "--schedule = online: must be batch, cosine, or left out, with --stream and --block"},
    {"CyclesOfBlocks", "--block 50 --cycles 7", "--rows sets the end"},
    {"StopErrorOfBlocks", "--block 50 --stop-error 0.1", "--stop-error = 0.1: must be left out"},
    {"NegativeCycles", "--cycles -1", "--cycles"},
    {"RateZero", "--learning-rate 0", "--learning-rate = 0"},
    {"MomentumOne", "--momentum 1", "--momentum = 1"},
    {"NegativeStop", "--stop-error -1", "--stop-error = -1"},
    {"BatchOnline", "--batch 64", "--batch = 64: must be left out, or with --schedule batch"},
    {"OptimizerOnline", "--optimizer adam", "--optimizer = adam: must be left out"},
    {"ActivationOnline", "--activation leaky-relu",
     "--activation = leaky-relu: must be logistic, left out, or with --schedule batch"},
    {"RectifiersOnline", "--network 42-9-1_leaky-relu", "logistic neurons, or --schedule batch"},
    {"UnknownActivation", "--schedule batch --activation tanh",
     "--activation = tanh: must be one of logistic, leaky-relu"},
    {"RatioOfALine", "--target force_ratio", "force_ratio = missing: must be a set of pads"},
    {"UnknownTarget", "--target mu",
     "--target = mu: must be one of slip_index, force_ratio, stick_fraction, slid, slip_path, net_slip, slid_ahead"},
    {"BoundOfAnotherTarget", "--schedule batch --bound --target stick_fraction",
     "--target = stick_fraction: must be slip_index with --bound"},
    {"BatchZero", "--schedule batch --batch 0", "--batch = 0"},
    {"UnknownSchedule", "--schedule linear", "--schedule = linear: must be one of online, batch, cosine"},
    {"WarmUpOfAConstantRate", "--schedule batch --warm-up 0.1",
     "--warm-up = 0.1: must be left out, or with --schedule cosine"},
    {"WarmUpOfTheWholeTraining", "--schedule cosine --warm-up 1", "--warm-up = 1.000000: must be a share"},
    {"LossOnline", "--loss absolute", "--loss = absolute: must be left out, or with --schedule batch or cosine"},
    {"LossOfQuantiles", "--schedule batch --bound --loss absolute", "quantiles have the pinball loss"},
    {"AverageOnline", "--average 0.9", "--average = 0.9: must be left out, or with --schedule batch or cosine"},
    {"AverageOne", "--schedule batch --average 1", "--average = 1.000000: must be at least 0 and below 1"},
    {"ValidationOnline", "--validation /nowhere.h5",
     "--validation = /nowhere.h5: must be left out, or with --schedule batch or cosine"},
    {"NoValidationSet", "--schedule batch --validation /nowhere.h5", "/nowhere.h5"},
    {"PatienceAlone", "--schedule batch --patience 3", "--patience = 3: must be left out, or with --validation"},
    {"NoPatience", "--schedule batch --validation /nowhere.h5 --patience 0", "--patience = 0: must be at least 1"},
    {"NoRecallSet", "--recall /nowhere.h5", "/nowhere.h5"},
    {"OtherInputs", "--inputs pixels", "--inputs = pixels: must be one of stresses, markers"},
    {"MarkersByFrame", "--inputs markers --scaling frame",
     "--scaling = frame: must be set, or left out, with --inputs"},
    {"MarkersAtRest", "--inputs markers --scaling rest", "--scaling = rest: must be set"},
    {"MarkersWithFeatures", "--inputs markers --features pad", "--features = pad: must be frame, or left out"},
    {"MarkersWithABound", "--inputs markers --schedule batch --bound", "it goes by the tactels that touch"},
    {"MarkersWithAnAlarm", "--inputs markers --target slid --alarm-at 0.1", "an alarm goes by stresses"},
    {"MarkersOfALine", "--inputs markers", "learning.h5: markers = missing: must be a set of pads with [markers]"}};
INSTANTIATE_TEST_SUITE_P(All, WrongTrainingTest, ::testing::ValuesIn(wrong_calls),
                         [](const auto& info) { return info.param.name; });

TEST(WrongTrainingOutput, IsRefusedBeforeTheWork) {
  const ScratchFolder folder;
  EXPECT_TRUE(is_refused(train(folder.write("file", "text")), {"--output"}));
}

}  // namespace train_command_test
