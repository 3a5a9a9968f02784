// Sets: the paper's families, and the file that holds them.
#include "host/contact_set.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <set>

#include "host/errors.h"
#include "host/paper_sets.h"
#include "tests/host/run_tactel.h"

namespace {

using namespace tactel;
using namespace tactel::host;
namespace fs = std::filesystem;

fs::path scratch(const std::string& name) {
  const fs::path directory = fs::path(::testing::TempDir()) / ("contact_set_" + std::to_string(getpid()));
  fs::create_directories(directory);
  return directory / name;
}

const ContactSet& recall_set() {
  static const ContactSet set = [] {
    Executor executor{Device()};
    return simulate_family(executor, paper_recall_family(paper_set_scene()), Precision::fp64, 0);
  }();
  return set;
}

/// All sums of the powers 1 ... 5 with coefficient 1, the empty one included: 2^5, each once (section V.C).
TEST(PaperSets, ThirtyTwoTaylorShapes) {
  const auto family = paper_learning_family(paper_set_scene(), 10, 10);
  std::set<std::vector<int>> powers;
  for (const auto& scene : family.scenes) powers.insert(std::get<fem::Taylor>(scene.indenter.shape).powers);
  EXPECT_EQ(family.scenes.size(), 32u);
  EXPECT_EQ(powers.size(), 32u);
}

TEST(PaperSets, SevenClassesOfFourShapesDraggedUntilTheySlide) {
  const ContactSet& set = recall_set();
  EXPECT_EQ(set.indenter_names.size(), 7u);
  std::set<std::pair<int, std::uint64_t>> contacts;
  for (std::size_t row = 0; row < set.rows(); ++row) {
    contacts.emplace(set.indenter[row], set.contact[row]);
    EXPECT_NEAR(set.slip_index[row], set.tangential_force[row] / (set.friction[row] * set.normal_force[row]),
                1e-6);  // fp32 storage
    const bool last = row + 1 == set.rows() || set.contact[row + 1] != set.contact[row];
    EXPECT_EQ(set.status[row] == 1, last) << row;  // slides in its last row, and only there
    EXPECT_EQ(set.stick_fraction[row] == 0, last) << row;
  }
  EXPECT_EQ(contacts.size(), 28u);
}

TEST(ContactSetFile, GivesBackWhatWasWritten) {
  ContactSet set = recall_set();
  set.sweep = "[sweep]\nset = \"paper-recall\"\n";
  set.seed = 18446744073709551615ull;
  set.rung = "fp64";
  write_contact_set(scratch("set.h5"), set);
  const ContactSet back = read_contact_set(scratch("set.h5"));
  EXPECT_EQ(back.frames, set.frames);
  EXPECT_EQ(back.inputs, set.inputs);
  EXPECT_EQ(back.slip_index, set.slip_index);
  EXPECT_EQ(back.contact_nodes, set.contact_nodes);
  EXPECT_EQ(back.contact, set.contact);
  EXPECT_EQ(back.status, set.status);
  EXPECT_EQ(back.indenter_names, set.indenter_names);
  EXPECT_EQ(back.sweep, set.sweep);
  EXPECT_EQ(back.seed, set.seed);
}

TEST(ContactSetFile, OpensInH5pyAsDocumented) {
  const std::string path = scratch("python.h5");
  ASSERT_EQ(run_tactel({"generate", source_file("examples/paper_recall.toml"), "--output", path, "--force"}).exit_code,
            0);
  const ChildResult result = run_child({"/usr/bin/python3", source_file("tests/host/open_set.py"), path});
  EXPECT_EQ(result.exit_code, 0) << result.err;
}

TEST(ContactSetFile, RefusesWhatIsNoSet) {
  EXPECT_THROW(read_contact_set(scratch("absent.h5")), ConfigError);
  std::ofstream(scratch("text.h5")) << "not HDF5";
  EXPECT_THROW(read_contact_set(scratch("text.h5")), ConfigError);
  write_contact_set(scratch("cut.h5"), recall_set());
  fs::resize_file(scratch("cut.h5"), fs::file_size(scratch("cut.h5")) / 2);
  EXPECT_THROW(read_contact_set(scratch("cut.h5")), ConfigError);
}

TEST(ContactSetFile, LeavesNothingHalfWritten) {
  EXPECT_THROW(write_contact_set("/nowhere/set.h5", recall_set()), ConfigError);
  const fs::path path = scratch("whole.h5");
  write_contact_set(path, recall_set());
  for (const auto& entry : fs::directory_iterator(path.parent_path())) EXPECT_NE(entry.path().extension(), ".part");
}

}  // namespace
