// SPDX-License-Identifier: Apache-2.0

// Sets: the paper's families, and the file that holds them.
#include "host/sets/contact_set.h"

#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>
#include <set>

#include "host/scenes/paper_sets.h"
#include "host/sets/check_set.h"
#include "host/sets/set_simulator.h"
#include "host/support/errors.h"
#include "tests/host/support/run_tactel.h"

namespace contact_set_test {

using namespace tactel;
using namespace tactel::host;
namespace fs = std::filesystem;

fs::path scratch(const std::string& name) {
  const fs::path directory = fs::path(::testing::TempDir()) / ("contact_set_" + std::to_string(getpid()));
  fs::create_directories(directory);
  return directory / name;
}

/// What check says of a file.
bool as_written(const fs::path& path) try {
  return check_contact_set(path, {}).damage.empty();
} catch (const ConfigError&) {
  return false;
}

const ContactSet& recall_set() {
  static const ContactSet set = [] {
    Executor executor{Device()};
    return simulate_family(executor, paper_recall_family(paper_set_scene()), Precision::fp64, 0);
  }();
  return set;
}

/// All sums of the powers 1 ... 5 with coefficient 1, the empty one included: 2^5, each once (section V.C).
TEST(PaperShapes, ThirtyTwoTaylorShapes) {
  const auto family = paper_learning_family(paper_set_scene(), 10, 10);
  std::set<std::vector<int>> powers;
  for (const auto& scene : family.scenes) powers.insert(std::get<fem::Taylor>(scene.indenter.shape).powers);
  EXPECT_EQ(family.scenes.size(), 32u);
  EXPECT_EQ(powers.size(), 32u);
}

TEST(PaperSets, WarnOfUnsolvedContacts) {
  ContactSet set;
  set.contacts = 28;
  EXPECT_FALSE(unsolved_warning(set));
  set.unsolved = 3;
  EXPECT_EQ(unsolved_warning(set), "3 of 28 contacts have a load step that did not meet its tolerance");
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
  EXPECT_EQ(back.indentation, set.indentation);
  EXPECT_EQ(back.tangential, set.tangential);
  EXPECT_EQ(back.tactel_x, set.tactel_x);
  EXPECT_EQ(back.parameter_names, set.parameter_names);
  EXPECT_EQ(back.parameter_units, set.parameter_units);
  ASSERT_EQ(back.parameters.size(), 28 * set.parameter_names.size());
  EXPECT_EQ(std::memcmp(back.parameters.data(), set.parameters.data(), sizeof(float) * set.parameters.size()),
            0);  // NaN, too
  EXPECT_EQ(back.contact, set.contact);
  EXPECT_EQ(back.status, set.status);
  EXPECT_EQ(back.indenter_names, set.indenter_names);
  EXPECT_EQ(back.sweep, set.sweep);
  EXPECT_EQ(back.seed, set.seed);
}

TEST(ContactSetInH5py, OpensInH5pyAsDocumented) {
  const std::string path = scratch("python.h5");
  ASSERT_EQ(run_tactel({"generate", source_file("examples/paper_recall.toml"), "--output", path, "--force"}).exit_code,
            0);
  EXPECT_EQ(run_child({"/usr/bin/python3", source_file("tests/host/sets/open_set.py"), path}).exit_code, 0);
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
  const ScratchFolder folder;
  EXPECT_THROW(write_contact_set("/nowhere/set.h5", recall_set()), ConfigError);
  write_contact_set(folder / "whole.h5", recall_set());
  ContactSet half = recall_set();
  half.friction.resize(half.rows() / 2);
  EXPECT_THROW(write_contact_set(folder / "half.h5", half), ConfigError);
  EXPECT_EQ(folder.files(), 1u);
}

TEST(ContactSetFile, HoldsAnyNumberOfRowsAndTexts) {
  const ScratchFolder folder;
  ContactSet none;
  none.inputs = 42;
  write_contact_set(folder / "none.h5", none);
  EXPECT_EQ(read_contact_set(folder / "none.h5").rows(), 0u);
  EXPECT_TRUE(check_contact_set(folder / "none.h5", {}).damage.empty());
  ContactSet set = recall_set();
  set.sweep = std::string(200000, '#');  // longer than an attribute could be in the oldest format of HDF5
  write_contact_set(folder / "long.h5", set);
  EXPECT_EQ(read_contact_set(folder / "long.h5").sweep, set.sweep);
  EXPECT_TRUE(as_written(folder / "long.h5"));
}

/// Every kind of set that tests/host/sets/forge_sets.py makes.
TEST(ContactSetFile, TrustsNoFile) {
  const ScratchFolder folder;
  const ContactSet& set = recall_set();
  write_contact_set(folder / "set.h5", set);
  ASSERT_EQ(
      run_child({"/usr/bin/python3", source_file("tests/host/sets/forge_sets.py"), folder / "set.h5", folder / ""})
          .exit_code,
      0);
  int bad = 0, good = 0;
  for (const auto& entry : fs::directory_iterator(folder / "")) {
    const fs::path& path = entry.path();
    const std::string name = path.filename().string();
    SCOPED_TRACE(name);
    if (name.starts_with("bad_")) {
      ++bad;
      EXPECT_THROW(read_contact_set(path), ConfigError);
    } else if (name.starts_with("good_")) {
      ++good;
      ContactSet back;
      ASSERT_NO_THROW(back = read_contact_set(path));
      EXPECT_EQ(back.frames, set.frames);
      EXPECT_EQ(back.contact, set.contact);
      EXPECT_EQ(back.indenter_names, set.indenter_names);
      ASSERT_NO_THROW(back = ContactSetReader(path).read(7, 20));
      EXPECT_EQ(back.slip_index, std::vector(set.slip_index.begin() + 7, set.slip_index.begin() + 27));
      EXPECT_FALSE(as_written(path));
    }
  }
  EXPECT_EQ(good, 7);
  EXPECT_EQ(bad, 56);
}

/// A set whose chunks are small enough to be several: two and a half.
ContactSet several_chunks() {
  ContactSet set;
  set.inputs = 2;
  const std::size_t rows = 20000;
  set.frames.resize(2 * rows);
  for (auto* list : {&set.slip_index, &set.normal_force, &set.tangential_force, &set.indentation, &set.tangential,
                     &set.friction, &set.stick_fraction, &set.residual})
    list->resize(rows);
  set.contact_nodes.resize(rows), set.indenter.resize(rows), set.status.resize(rows);
  set.contact.resize(rows), set.step.resize(rows);
  for (std::size_t row = 0; row < rows; ++row) set.contact[row] = row, set.slip_index[row] = static_cast<float>(row);
  return set;
}

// Row r of /contact is r: where its 8 bytes stand in the file is found by what they are.
TEST(CheckSet, NamesTheRowsOfADamagedChunk) {
  const ScratchFolder folder;
  write_contact_set(folder / "set.h5", several_chunks());
  const SetCheck whole = check_contact_set(folder / "set.h5", {});
  EXPECT_TRUE(whole.damage.empty());
  EXPECT_EQ(whole.rows, 20000u);
  EXPECT_EQ(whole.chunks, 14u * 3);  // datasets, chunks of 8192 rows
  std::string bytes = text_of(folder / "set.h5");
  const std::uint64_t row = 10000;
  const auto at = bytes.find(std::string(reinterpret_cast<const char*>(&row), 8));
  ASSERT_NE(at, std::string::npos);
  bytes[at] ^= 1;
  folder.write("flipped.h5", bytes);
  const SetCheck check = check_contact_set(folder / "flipped.h5", {});
  ASSERT_EQ(check.damage.size(), 1u);
  EXPECT_EQ(check.damage[0].dataset, "contact");
  EXPECT_EQ(check.damage[0].first, 8192u);
  EXPECT_EQ(check.damage[0].last, 16383u);
  EXPECT_THROW(read_contact_set(folder / "flipped.h5"), ConfigError);
  EXPECT_EQ(ContactSetReader(folder / "flipped.h5").read(0, 8192).contact.back(), 8191u);
  EXPECT_THROW(ContactSetReader(folder / "flipped.h5").read(8000, 1000), ConfigError);
  const ChildResult result = run_tactel({"check", folder / "flipped.h5"});
  EXPECT_EQ(result.exit_code, 4);
  EXPECT_NE(result.out.find("contact: rows 8192 to 16383: damaged"), std::string::npos) << result.out;
  EXPECT_EQ(run_tactel({"check", folder / "set.h5"}).exit_code, 0);
  EXPECT_EQ(run_tactel({"check", folder.write("text.h5", "no set")}).exit_code, 2);
}

// Every kind of edit that tests/host/sets/edit_sets.py makes. The checksums of the chunks are right in all of them.
TEST(CheckSet, FindsEveryEdit) {
  const ScratchFolder folder;
  ContactSet set = several_chunks();
  set.sweep = "contacts = 20000", set.seed = 7, set.press_rows = true;
  set.device = "a device", set.rung = "fp32: a model", set.transducer = "none", set.plan = "precision fp32";
  set.indenter_names = {"wedge", "parabola"};
  set.contacts = 2, set.parameter_names = {"contact.friction", "indenter.radius"}, set.parameter_units = {"1", "mm"};
  set.parameters = {0.5, 2, 0.25, 4}, set.tactel_x = {0};
  write_contact_set(folder / "set.h5", set);
  fs::create_directory(folder / "edited");
  ASSERT_TRUE(as_written(folder / "set.h5"));
  const ChildResult edited = run_child(
      {"/usr/bin/python3", source_file("tests/host/sets/edit_sets.py"), folder / "set.h5", folder / "edited"});
  ASSERT_EQ(edited.exit_code, 0) << edited.err;
  std::size_t edits = 0;
  for (const auto& entry : fs::directory_iterator(folder / "edited")) {
    EXPECT_FALSE(as_written(entry.path())) << entry.path();
    ++edits;
  }
  EXPECT_GE(edits, 50u);
  const auto check = [&](const std::string& name) { return run_tactel({"check", folder / "edited" / (name + ".h5")}); };
  const ChildResult exchanged = check("exchanged_names"), attribute = check("edited_seed"), link = check("soft_link");
  EXPECT_EQ(exchanged.exit_code, 4);
  EXPECT_NE(exchanged.out.find("normal_force: rows 0 to 19999: other numbers, name"), std::string::npos);
  EXPECT_NE(exchanged.out.find("tangential_force: rows 0 to 19999: other numbers, name"), std::string::npos);
  EXPECT_EQ(attribute.exit_code, 4);
  EXPECT_NE(attribute.out.find("edited_seed.h5: attributes, or names of datasets, other"), std::string::npos);
  EXPECT_EQ(link.exit_code, 4);
  EXPECT_NE(link.out.find("slip_index: rows 0 to 19999: a link"), std::string::npos) << link.out;
  for (const char* form : {"copied_gzip", "copied_float64", "copied_big_endian"})
    EXPECT_NE(check(form).out.find("slip_index: rows 0 to 19999: copied in another form"), std::string::npos) << form;
  EXPECT_NE(check("copied_lzf").out.find("packed by the filter lzf"), std::string::npos) << check("copied_lzf").out;
  const ChildResult old = check("deleted_checksum");
  EXPECT_EQ(old.exit_code, 2);
  EXPECT_NE(old.err.find("generate it anew"), std::string::npos) << old.err;
}

// Any byte of the file, the index of the chunks and the headers included: what is read is what was written, or refused;
// and what check calls whole is whole.
TEST(CheckSetBytes, FindsEveryFlippedByte) {
  const ScratchFolder folder;
  ContactSet set = several_chunks();
  set.sweep = "contacts = 20000", set.indenter_names = {"a", "b"};
  write_contact_set(folder / "set.h5", set);
  const std::string bytes = text_of(folder / "set.h5");
  // A third of the flips in the first 16 KiB, where headers stand, a third in the blocks that hold links and indices.
  std::vector<std::size_t> blocks;
  for (const char* name : {"FRHP", "FHDB", "BTHD", "BTLF"})
    for (std::size_t at = 0; (at = bytes.find(name, at)) != std::string::npos; ++at) blocks.push_back(at);
  ASSERT_GT(blocks.size(), 6);
  int found = 0, refused = 0;
  const auto same = [&](const ContactSet& other) {
    bool equal = other.sweep == set.sweep && other.indenter_names == set.indenter_names;
    std::vector<std::string> one, two;
    each_dataset(set, [&](const char*, const auto& v, int, const char*) {
      one.emplace_back(reinterpret_cast<const char*>(v.data()), v.size() * sizeof(v[0]));
    });
    each_dataset(other, [&](const char*, const auto& v, int, const char*) {
      two.emplace_back(reinterpret_cast<const char*>(v.data()), v.size() * sizeof(v[0]));
    });
    return equal && one == two;
  };
  std::mt19937 random(5);
  for (int flip = 0; flip < 600; ++flip) {
    std::size_t at = random() % (flip % 3 ? bytes.size() : 16 << 10);
    if (flip % 3 == 2) at = blocks[random() % blocks.size()] + random() % 256;
    std::string damaged = bytes;
    damaged[at] = static_cast<char>(damaged[at] ^ (1 << random() % 8));
    folder.write("damaged.h5", damaged);
    const bool clean = as_written(folder / "damaged.h5");
    found += !clean;
    try {
      const ContactSet back = read_contact_set(folder / "damaged.h5");
      EXPECT_TRUE(!clean || same(back)) << "byte " << at;
    } catch (const ConfigError&) {
      EXPECT_FALSE(clean) << "byte " << at;
      ++refused;
    }
  }
  EXPECT_GT(found, 250);
  EXPECT_GT(refused, 250);
}

}  // namespace contact_set_test
