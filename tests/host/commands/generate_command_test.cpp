// SPDX-License-Identifier: Apache-2.0

// Sets of many contacts through the program: the same rows whatever happened on the way.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "fem/gap/gap_reference.h"
#include "host/contact/lines/gap_sweep.h"
#include "host/scenes/sweep_file.h"
#include "host/sets/set_production.h"
#include "host/support/checksum.h"
#include "host/support/errors.h"
#include "test_paths.h"
#include "tests/host/commands/small_sweep.h"
#include "tests/host/device/test_device.h"
#include "tests/host/support/run_tactel.h"

namespace tactel::host::generate_command_test {

using testing::HasSubstr;

// Four chunks, two sensors, depth and force side by side.
const std::string sweep_text = R"([sweep]
contacts = 26000
seed = 11
[[sensor]]
model = "mesh"
[[sensor]]
model = "mesh"
poisson = 0.3
weight = 0.25
[contact]
friction = { uniform = [0.1, 1.0] }
[[indenter]]
shape = "parabola"
radius = { log_uniform = [2, 50] }
position = { uniform = [-3, 3] }
[[indenter]]
shape = "wedge"
edge_angle = { uniform = [120, 170] }
[[load]]
indentation = { uniform = [0.05, 0.2] }
tangential = [0.05, { uniform = [-0.1, 0.1] }]
[[load]]
normal_force = { uniform = [0.2, 1.0] }
slip_index = { uniform = [0.0, 0.8] }
weight = 0.2
)";

class Generate : public ::testing::Test {
 protected:
  std::string output(const std::string& name) const { return (folder_ / name).string(); }
  ChildResult run(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {"generate", sweep_});
    return run_tactel(arguments);
  }
  /// Under a shell, so that it can be killed or kept short of room.
  ChildResult shell(const std::string& before, const std::string& output, const std::string& options = "") const {
    return run_child(
        {"sh", "-c", before + " " + TACTEL_PROGRAM + " generate " + sweep_ + " --output " + output + " " + options});
  }

  /// Until no process writes the set: mpirun may end before a killed process that waits for the disk, and that one has
  /// the lock.
  static void wait_for_processes_of(const std::string& set) {
    run_child(
        {"sh", "-c", "while pgrep -f '" + set.substr(0, set.size() - 1) + "[5]' > /dev/null; do sleep 0.02; done"});
  }

  ScratchFolder folder_;
  std::string sweep_ = folder_.write("sweep.toml", sweep_text);
};

TEST_F(Generate, SaysWhatTablesOfFreeSidesTake) {
  const std::string sweep = folder_.write("pads.toml", R"([sweep]
contacts = 2
sensors = 2
[sensor]
kind = "pad"
tactels = [4, 4]
pitch = 4
length = 25
width = 24
sides = "free"
thickness = 3.5
poisson = { choice = [0.46, 0.461] }
[indenter]
shape = "sphere"
radius = 9
[load]
indentation = 0.2
)");
  const auto begun = [&] {
    return run_child({"env", "TACTEL_CACHE_DIR=" + (folder_ / "cache").string(), TACTEL_PROGRAM, "generate", sweep,
                      "--force", "--output", output("pads.h5")});
  };
  EXPECT_THAT(begun().err, testing::ContainsRegex("note: tables of free sides take about [1-9]+ s, for 2 sensors"));
  EXPECT_THAT(begun().err, testing::Not(HasSubstr("free sides")));
}

// Three chunks of contacts on pads.
TEST_F(Generate, WithoutADeviceLeavesNothing) {
  const std::string set = output("none.h5");
  EXPECT_EQ(
      run_child({"env", "OCL_ICD_VENDORS=/nonexistent", TACTEL_PROGRAM, "generate", sweep_, "--output", set}).exit_code,
      3);
  EXPECT_FALSE(std::filesystem::exists(set + ".parts"));
}

TEST_F(Generate, PadsKilledAndResumedGiveTheSameBytes) {
  const std::string pads = folder_.write("pads.toml",
                                         "[sweep]\ncontacts = 20000\n[sensor]\nkind = \"pad\"\nthickness = 2\n"
                                         "young = { uniform = [1, 2] }\n[indenter]\nshape = \"sphere\"\n"
                                         "radius = { log_uniform = [3, 20] }\n[load]\n"
                                         "indentation = { uniform = [0.1, 0.2] }\ntangential_step = [0.03, 0.01]\n"
                                         "twist_step = 1\ntangential_steps = 2\n[markers]\ncounts = [3, 2]\n");
  const auto generate = [&](const std::string& before, const std::string& name, const std::string& options) {
    return run_child(
        {"sh", "-c",
         before + " " TACTEL_PROGRAM " generate " + pads + " --rung pad-8 --output " + output(name) + " " + options});
  };
  ASSERT_EQ(generate("", "whole.h5", "").exit_code, 0);
  const std::string whole = text_of(output("whole.h5"));
  int killed = 0;
  for (int attempt = 0; attempt < 4; ++attempt)
    killed +=
        generate("timeout -s KILL " + std::to_string(0.3 + 0.3 * attempt), "killed.h5", "--resume").exit_code == 137;
  EXPECT_GT(killed, 0);
  ASSERT_EQ(generate("", "killed.h5", "--resume").exit_code, 0);
  EXPECT_EQ(checksum(text_of(output("killed.h5"))), checksum(whole));
  EXPECT_EQ(run_tactel({"check", output("killed.h5")}).exit_code, 0);
  EXPECT_TRUE(is_refused(run_tactel({"generate", pads, "--output", output("killed.h5"), "--resume"}), {"rung pad-8"}));
}

TEST_F(Generate, KilledAtAnyMomentAndResumedGivesTheSameBytes) {
  ASSERT_EQ(run({"--output", output("whole.h5")}).exit_code, 0);
  const std::string whole = text_of(output("whole.h5"));
  int killed = 0;
  for (int attempt = 0; attempt < 12; ++attempt) {
    const std::string name = output("killed.h5");
    // Later and later: in the set-up, between chunks, while a chunk is written, when the set is put together.
    const std::string moment = std::to_string(0.1 + 0.12 * attempt);
    const ChildResult result = shell("timeout -s KILL " + moment, name, "--resume");
    killed += result.exit_code == 137;
    EXPECT_THAT(result.exit_code, testing::AnyOf(0, 137)) << result.err;
  }
  EXPECT_GT(killed, 0);
  ASSERT_EQ(run({"--output", output("killed.h5"), "--resume"}).exit_code, 0);
  EXPECT_EQ(checksum(text_of(output("killed.h5"))), checksum(whole));
  EXPECT_FALSE(std::filesystem::exists(SetSpool::folder(output("killed.h5"))));
}

// A tenth of the usual length, so that the finest rungs are small.
TEST_F(Generate, SaysWhereNoRungKeepsTheAccuracy) {
  const std::string small = folder_.write("small.toml",
                                          "[sweep]\ncontacts = 2\nseed = 1\n[sensor]\nlength = 2\n[indenter]\n"
                                          "shape = \"parabola\"\nradius = 2\n[load]\nindentation = 0.05\n"
                                          "tangential = [{ uniform = [0.01, 0.02] }]\n");
  const auto generate = [&](const char* accuracy) {
    return run_tactel({"generate", small, "--output", output("small.h5"), "--force", "--accuracy", accuracy});
  };
  EXPECT_TRUE(is_refused(generate("1e-9"), {"no rung is known to keep this accuracy"}, 4));
  EXPECT_TRUE(std::filesystem::exists(output("small.h5")));
  EXPECT_EQ(generate("0.9").exit_code, 0);
}

TEST_F(Generate, InterruptKeepsWhatIsDoneAndSaysHowToGoOn) {
  // The program's own exit code: timeout's would be 124 whatever the program ends with.
  const ChildResult result = shell("timeout --preserve-status -s INT 0.6", output("set.h5"));
  ASSERT_THAT(result.exit_code, testing::AnyOf(0, 130)) << result.err;
  // On a machine with much else to do the signal may come before there is anything to keep.
  const bool begun = std::filesystem::exists(output("set.h5.parts"));
  if (begun && result.exit_code == 130) {
    // A signal that reaches the compiler of kernels ends the job there.
    EXPECT_THAT(result.err, testing::AnyOf(HasSubstr("--resume continues"),
                                           HasSubstr("a command with --resume goes on with what is done")));
    EXPECT_FALSE(std::filesystem::exists(output("set.h5")));
    EXPECT_TRUE(is_refused(run({"--output", output("set.h5")}), {"--resume continues it, --force starts anew"}));
  }
  EXPECT_EQ(run({"--output", output("set.h5"), "--resume"}).exit_code, 0);
  EXPECT_THAT(run({"--output", output("set.h5"), "--resume"}).out, HasSubstr("complete already"));
}

// Clusters set the variable; a set that another program reads or holds is read, too.
TEST_F(Generate, LocksOfHdf5AreNotTaken) {
  const std::vector<std::string> generate = {"generate", output("small.toml"), "--force", "--output",
                                             output("locked.h5")};
  std::ofstream(output("small.toml")) << SmallSweep{.contacts = 50}.text();
  for (const char* value : {"FALSE", "TRUE", "1", "BEST_EFFORT"}) {
    const Environment locks("HDF5_USE_FILE_LOCKING", value);
    EXPECT_EQ(run_tactel(generate).exit_code, 0) << value;
    EXPECT_EQ(run_tactel(generate, {"--compress"}).exit_code, 0) << value;
    EXPECT_EQ(run_child({"flock", "-x", output("locked.h5"), TACTEL_PROGRAM, "check", output("locked.h5")}).exit_code,
              0);
  }
  EXPECT_TRUE(is_refused(run_tactel({"check", output("")}), {"(file) = a folder"}));
}

// A chunk of fine pads takes minutes. Batch systems send SIGTERM, a terminal that closes SIGHUP.
TEST_F(Generate, ASignalEndsItInTheMidstOfAChunk) {
  const std::string pads = output("pads.toml");
  std::ofstream(pads)
      << "[sweep]\ncontacts = 4000\n[sensor]\nkind = \"pad\"\nthickness = 4.0\n[[indenter]]\nshape = \"sphere\"\n"
         "radius = { uniform = [5, 20] }\n[contact]\nfriction = 0.6\n[load]\nindentation = 0.4\n"
         "tangential_step = [0.05, 0.02]\ntangential_steps = 40\n";
  for (const char* signal : {"TERM", "HUP"}) {
    const ChildResult result = run_child({"timeout", "--preserve-status", "-k", "20", "-s", signal, "3", TACTEL_PROGRAM,
                                          "generate", pads, "--rung", "pad-24", "--output", output(signal)});
    EXPECT_EQ(result.exit_code, 130) << signal << ": " << result.err;
    EXPECT_THAT(result.err, HasSubstr("stopped"));
  }
}

// `timeout -s INT` sends the signal to the program and to its group. Sent a moment apart, so that the kernel does not
// make one of them.
TEST_F(Generate, TwoSignalsInARowStopAsOneDoes) {
  const ChildResult result =
      run_child({"sh", "-c",
                 TACTEL_PROGRAM " generate " + sweep_ + " --output " + output("set.h5") + " & while ! [ -e " +
                     output("set.h5.parts/plan") +
                     " ]; do sleep 0.01; done; for i in 1 2 3; do kill -INT $!; sleep 0.02; done; wait $!"});
  if (result.exit_code == 0) return;  // done before the first of them
  EXPECT_EQ(result.exit_code, 130);
  EXPECT_THAT(result.err, HasSubstr("--resume continues"));
}

// A limit on the size of files (in blocks of 512 bytes) stands for a full disk: 6 MB hold one chunk of 4.5 MB, and the
// last one of 0.8 MB.
TEST_F(Generate, FullDiskKeepsWholeChunks) {
  EXPECT_TRUE(is_refused(shell("ulimit -f 12000;", output("set.h5")), {"room"}));
  EXPECT_FALSE(std::filesystem::exists(output("set.h5")));
  const ChildResult rest = run({"--output", output("set.h5"), "--resume"});
  ASSERT_EQ(rest.exit_code, 0) << rest.err;
  EXPECT_THAT(rest.out, testing::ContainsRegex("[12] of 4 chunks exist"));
  ASSERT_EQ(run({"--output", output("whole.h5")}).exit_code, 0);
  EXPECT_EQ(checksum(text_of(output("set.h5"))), checksum(text_of(output("whole.h5"))));
}

TEST_F(Generate, DamagedChunksAreMadeAgain) {
  ASSERT_EQ(run({"--output", output("whole.h5")}).exit_code, 0);
  shell("ulimit -f 12000;", output("set.h5"));
  const auto rows = SetSpool::folder(output("set.h5")) / "0000.chunks";
  ASSERT_GT(std::filesystem::file_size(rows), 10000);
  std::fstream file(rows, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(10000);
  file.put('\x55').put('\x55');
  file.close();
  ASSERT_EQ(run({"--output", output("set.h5"), "--resume"}).exit_code, 0);
  EXPECT_EQ(checksum(text_of(output("set.h5"))), checksum(text_of(output("whole.h5"))));
}

TEST_F(Generate, RefusesOtherPlansOtherFilesAndOtherWriters) {
  const std::string set = output("set.h5");
  shell("ulimit -f 6000;", set);
  EXPECT_THAT(run({"--output", set, "--resume", "--precision", "fp64"}).err,
              HasSubstr("another sweep file, seed, precision"));
  {
    SetSpool held(output("held.h5"), "a plan", 42, 1, SetSpool::Open::fresh);
    EXPECT_THAT(run({"--output", output("held.h5"), "--resume"}).err, HasSubstr("no other program is writing"));
    EXPECT_THAT(run({"--output", output("held.h5"), "--force"}).err, HasSubstr("no other program is writing"));
  }
  const std::string foreign = folder_.write("foreign.h5", "no set");
  EXPECT_EQ(run({"--output", foreign}).exit_code, 2);
  EXPECT_THAT(run({"--output", foreign, "--resume"}).err, HasSubstr("not HDF5, or damaged"));
  EXPECT_EQ(text_of(foreign), "no set");
  EXPECT_EQ(run({"--output", foreign, "--force"}).exit_code, 0);
  EXPECT_EQ(run({"--output", output("no/such/folder.h5")}).exit_code, 2);
}

/// The rows of contacts first ... first + count - 1 of a set.
std::vector<std::size_t> rows_of(const ContactSet& set, std::uint64_t first, std::uint64_t count) {
  std::vector<std::size_t> rows;
  for (std::size_t row = 0; row < set.rows(); ++row)
    if (set.contact[row] >= first && set.contact[row] < first + count) rows.push_back(row);
  return rows;
}

TEST_F(Generate, AnyRangeGivesTheSameRows) {
  const Sweep sweep = read_sweep(sweep_);
  Executor executor{Device("")};
  const SetSimulator simulator(executor, sweep.source, {});
  const ContactSet all = simulator.simulate(0, 500);
  for (const auto& [first, count] : {std::pair{0, 1}, {17, 100}, {499, 1}, {250, 49}}) {
    const ContactSet part = simulator.simulate(first, count);
    const auto rows = rows_of(all, first, count);
    ASSERT_EQ(part.rows(), rows.size());
    for (std::size_t i = 0; i < rows.size(); ++i) {
      EXPECT_EQ(part.slip_index[i], all.slip_index[rows[i]]);
      for (int k = 0; k < all.inputs; ++k)
        EXPECT_EQ(part.frames[i * all.inputs + k], all.frames[rows[i] * all.inputs + k]);
    }
  }
}

// Rows against the full-mesh solver, which shares no code with the kernel. fp32: 1e-3 of the largest stress and of S,
// as in gap_sweep_test.
TEST_F(Generate, RowsAreThoseOfTheReference) {
  const Sweep sweep = read_sweep(sweep_);
  Executor executor{Device("")};
  const ContactSet set = SetSimulator(executor, sweep.source, {}).simulate(0, 24);
  std::size_t row = 0;
  for (std::uint64_t k = 0; k < 24; ++k) {
    const fem::Scene scene = sweep.lines("sweep").contact(k).scene;
    const fem::ContactSolution truth = fem::GapReference(scene.sensor).solve(scene);
    for (std::size_t s = fem::load_path(scene.load).indentation_steps - 1; s < truth.steps.size(); ++s, ++row) {
      const fem::ContactStep& step = truth.steps[s];
      ASSERT_LT(row, set.rows());
      EXPECT_EQ(set.contact[row], k);
      EXPECT_EQ(set.step[row], s);
      EXPECT_NEAR(set.slip_index[row], *step.slip_index, 1e-3);
      EXPECT_NEAR(set.normal_force[row], step.P, 1e-3 * step.P);
      const double largest = step.sigma_y.cwiseAbs().maxCoeff();
      for (int i = 0; i < 21; ++i) {
        EXPECT_NEAR(set.frames[row * 42 + i], step.sigma_y[i], 1e-3 * largest);
        EXPECT_NEAR(set.frames[row * 42 + 21 + i], step.tau_xy[i], 1e-3 * largest);
      }
    }
  }
  EXPECT_EQ(row, set.rows());
}

TEST_F(Generate, SeveralDevicesShareTheChunks) {
  ASSERT_EQ(run({"--output", output("one.h5"), "--device", "basic"}).exit_code, 0);
  ASSERT_EQ(run({"--output", output("two.h5"), "--device", "basic", "--also-device", "pthread"}).exit_code, 0);
  const ContactSet one = read_contact_set(output("one.h5")), two = read_contact_set(output("two.h5"));
  EXPECT_THAT(two.device, HasSubstr(", "));
  EXPECT_EQ(one.frames, two.frames);
  EXPECT_EQ(one.slip_index, two.slip_index);
  EXPECT_EQ(one.contact, two.contact);
}

TEST_F(Generate, WarnsOfOtherUnits) {
  const std::string sweep =
      folder_.write("pascal.toml",
                    SmallSweep{.contacts = 20, .indenter = "[indenter]\nshape = \"parabola\"\nradius = 0.01\n"}.text());
  const ChildResult result = run_tactel({"generate", sweep, "--output", output("pascal.h5")});
  EXPECT_THAT(result.err, HasSubstr("warning: indenter.radius = 0.01 mm: usual are 0.05 to 5000 mm; check the unit"));
  EXPECT_EQ(run_tactel({"generate", sweep, "--output", output("quiet.h5"), "--quiet"}).err, "");
}

// Contact k goes down to the depth that the file's seed draws: some 4000 of 10000 beyond 20 % of 1.5 mm, in two chunks,
// one of which comes from an earlier run. Expected: the draws themselves.
TEST_F(Generate, WarnsOnceOfDeepIndentersWithTheirCount) {
  const std::string deep =
      folder_.write("deep.toml", SmallSweep{.contacts = 10000, .indentation = "{ uniform = [0.2, 0.4] }"}.text());
  const Sweep sweep = read_sweep(deep);
  int beyond = 0;
  for (std::uint64_t k = 0; k < 10000; ++k) beyond += sweep.lines("sweep").contact(k).scene.load.indentation[0] > 0.3;
  ASSERT_GT(beyond, 1000);
  const std::string said =
      "warning: in " + std::to_string(beyond) + " of 10000 contacts the indenter is deeper than 20 %";
  const ChildResult whole = run_tactel({"generate", deep, "--output", output("deep.h5")});
  EXPECT_EQ(whole.exit_code, 0);
  EXPECT_THAT(whole.err, HasSubstr(said));
  EXPECT_EQ(whole.err.find("warning"), whole.err.rfind("warning"));
  EXPECT_EQ(run_tactel({"generate", deep, "--output", output("quiet.h5"), "--quiet"}).err, "");
  run_child({"sh", "-c", "ulimit -f 3250; " TACTEL_PROGRAM " generate " + deep + " --output " + output("resumed.h5")});
  ASSERT_FALSE(std::filesystem::exists(output("resumed.h5")));
  const ChildResult resumed = run_tactel({"generate", deep, "--output", output("resumed.h5"), "--resume"});
  EXPECT_THAT(resumed.out, HasSubstr("1 of 2 chunks exist"));
  EXPECT_THAT(resumed.err, HasSubstr(said));
  std::string text = text_of(deep);
  text.replace(text.find("[0.2, 0.4]"), 10, "[0.1, 0.3]");
  const std::string shallow = folder_.write("shallow.toml", text);
  EXPECT_EQ(without_progress(run_tactel({"generate", shallow, "--output", output("shallow.h5")}).err), "");
}

const std::string mpirun =
    "OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 exec mpirun --oversubscribe --bind-to none -n 3";

TEST_F(Generate, SeveralProcessesGiveTheRowsOfOne) {
  ASSERT_EQ(run({"--output", output("one.h5")}).exit_code, 0);
  ASSERT_EQ(shell(mpirun, output("three.h5")).exit_code, 0);
  EXPECT_EQ(checksum(text_of(output("three.h5"))), checksum(text_of(output("one.h5"))));
}

// One of three processes is killed: whole chunks are kept, and one process alone makes the rest.
TEST_F(Generate, AfterTheDeathOfAProcessOneMakesTheRest) {
  const std::string script = folder_.write(
      "killed.sh", "(" + mpirun + " " TACTEL_PROGRAM " generate " + sweep_ + " --output " + output("three.h5") +
                       ") &\nsleep 0.6\nkill -KILL $(pgrep -P $! | tail -1)\nwait $!\n");
  run_child({"timeout", "-s", "KILL", "60", "sh", script});  // mpirun may wait for ever
  wait_for_processes_of(output("three.h5"));
  const ChildResult rest = run({"--output", output("three.h5"), "--resume"});
  ASSERT_EQ(rest.exit_code, 0) << rest.err;
  ASSERT_EQ(run({"--output", output("one.h5")}).exit_code, 0);
  EXPECT_EQ(checksum(text_of(output("three.h5"))), checksum(text_of(output("one.h5"))));
}

// With another number of processes each time; later and later, as with one.
TEST_F(Generate, KilledProcessesAndResumedByOthersGiveTheSameBytes) {
  ASSERT_EQ(run({"--output", output("one.h5")}).exit_code, 0);
  int killed = 0;
  for (int attempt = 0; attempt < 5; ++attempt) {
    std::string ranks = mpirun;
    ranks.back() = static_cast<char>('2' + attempt % 3);
    ranks.replace(ranks.find("exec"), 4, "timeout -s KILL " + std::to_string(0.5 + 0.15 * attempt));
    killed += shell(ranks, output("killed.h5"), "--resume").exit_code != 0;
    wait_for_processes_of(output("killed.h5"));
  }
  EXPECT_GT(killed, 0);
  ASSERT_EQ(shell(mpirun, output("killed.h5"), "--resume").exit_code, 0);
  EXPECT_EQ(checksum(text_of(output("killed.h5"))), checksum(text_of(output("one.h5"))));
}

TEST_F(Generate, AnInterruptOfOneProcessStopsAll) {
  const std::string set = output("three.h5");
  const std::string script = folder_.write(
      "interrupted.sh", "(" + mpirun + " " TACTEL_PROGRAM " generate " + sweep_ + " --output " + set +
                            ") &\nwhile ! [ -e " + set +
                            ".parts/0002.chunks ]; do sleep 0.01; done\nkill -INT $(pgrep -P $! | tail -1)\nwait $!\n");
  const ChildResult result = run_child({"timeout", "60", "sh", script});
  EXPECT_THAT(result.exit_code, testing::AnyOf(0, 130)) << result.err;  // 124: it hung
  if (result.exit_code == 130) {
    EXPECT_THAT(result.err, HasSubstr("--resume continues"));
  }
  wait_for_processes_of(set);
  EXPECT_EQ(run({"--output", set, "--resume"}).exit_code, 0);
}

class SmallSet : public ::testing::Test {
 protected:
  std::string operator/(const std::string& name) const { return (folder_ / name).string(); }
  std::string sweep(const std::string& name, const std::string& text) const { return folder_.write(name, text); }
  ChildResult run(const std::string& sweep, const std::string& output, std::vector<std::string> more = {}) const {
    return run_tactel({"generate", sweep, "--output", *this / output}, more);
  }
  /// Stopped with one chunk of two in the spool: 8192 contacts of two rows of 89 bytes and at most five parameters fit
  /// under the limit of 1.664 MB for a file, 9000 do not.
  void stop_half_way(const std::string& sweep, const std::string& output) const {
    run_child({"sh", "-c", "ulimit -f 3250; " TACTEL_PROGRAM " generate " + sweep + " --output " + (*this / output)});
    ASSERT_GT(std::filesystem::file_size(SetSpool::folder(*this / output) / "0000.chunks"), 0);
  }

  ScratchFolder folder_;
};

TEST_F(SmallSet, ResumeRefusesAFileOfTheSweepThatHasChanged) {
  const std::string profile = "[indenter]\nshape = \"profile\"\nfile = \"tip.csv\"\n";
  const std::string text = sweep("a.toml", SmallSweep{.indenter = profile}.text());
  folder_.write("tip.csv", "x,y\n-5,1.25\n0,0\n5,1.25\n");
  stop_half_way(text, "set.h5");
  folder_.write("tip.csv", "x,y\n-5,1.5\n0,0\n5,1.5\n");
  EXPECT_TRUE(is_refused(run(text, "set.h5", {"--resume"}), {"a file named in it that has changed"}));
  folder_.write("tip.csv", "# measured in May\nx,y\n-5,1.25\n0,0\n5,1.25\n");  // the same numbers
  EXPECT_EQ(run(text, "set.h5", {"--resume"}).exit_code, 0);
  EXPECT_EQ(run(text, "set.h5", {"--resume"}).exit_code, 0);
  folder_.write("tip.csv", "x,y\n-5,1.5\n0,0\n5,1.5\n");
  EXPECT_TRUE(is_refused(run(text, "set.h5", {"--resume"}), {"file 0 tip.csv"}));
}

TEST_F(SmallSet, RefusesChunksOfAnotherPlan) {
  const std::string seven = sweep("7.toml", SmallSweep{.sweep = "seed = 7\n"}.text()),
                    eight = sweep("8.toml", SmallSweep{.sweep = "seed = 8\n"}.text());
  const std::string narrow = sweep("narrow.toml", SmallSweep{.sweep = "seed = 7\n", .tactels = 3}.text());
  stop_half_way(seven, "7.h5");
  for (const std::string& other : {eight, narrow}) {
    const std::string output = std::filesystem::path(other).stem().string() + ".h5";
    stop_half_way(other, output);
    std::filesystem::copy_file(SetSpool::folder(*this / output) / "0000.chunks",
                               SetSpool::folder(*this / "7.h5") / "0001.chunks");
    EXPECT_TRUE(is_refused(run(seven, "7.h5", {"--resume"}), {"7.h5.parts holds some of another sweep file, seed"}));
    std::filesystem::remove(SetSpool::folder(*this / "7.h5") / "0001.chunks");
  }
  const auto plan = SetSpool::folder(*this / "7.h5") / "plan";
  std::filesystem::rename(plan, *this / "plan");
  EXPECT_TRUE(is_refused(run(seven, "7.h5", {"--resume"}), {"its file `plan` is lost; put it back, or --force"}));
  std::filesystem::rename(*this / "plan", plan);
  EXPECT_THAT(run(seven, "7.h5", {"--resume"}).out, HasSubstr("1 of 2 chunks exist"));
  EXPECT_TRUE(std::filesystem::exists(*this / "7.h5"));
}

// A contact is three steps of a press and two of a drag: three rows of 5 tactels, from full indentation on.
TEST_F(SmallSet, ASetLargerThanTheDiskIsRefusedBeforeItBegins) {
  const auto text = [](const std::string& contacts) {
    std::string small = SmallSweep{.drag = "indentation_steps = 3\ntangential = [0.05, 0.1]"}.text();
    return small.replace(small.find("9000"), 4, contacts);
  };
  const std::string large = sweep("large.toml", text("1000000000000"));
  EXPECT_TRUE(
      is_refused(run(large, "set.h5"), {"--output = " + (*this / "set.h5") + ": must be on a disk with room for it"}));
  EXPECT_FALSE(std::filesystem::exists(SetSpool::folder(*this / "set.h5")));
  const std::string whole_chunks = sweep("small.toml", text("16384"));  // and whole chunks of HDF5's
  const Sweep drawn = read_sweep(large), small = read_sweep(whole_chunks);
  const SetColumns columns = columns_of(drawn.source);
  const double parameters = 4 * static_cast<double>(columns.parameter_names.size());
  const double contact = 3 * (2 * 5 * 4 + 8 * 4 + 2 + 8 + 4 + 2 + 1 + 0.0) + parameters;  // as docs/sets.md lists them
  EXPECT_EQ(expected_bytes(drawn.source, columns), 1e12 * contact);
  ASSERT_EQ(run(whole_chunks, "small.h5").exit_code, 0);
  const auto bytes = static_cast<double>(std::filesystem::file_size(*this / "small.h5"));
  EXPECT_NEAR(expected_bytes(small.source, columns) / bytes, 1, 0.02);  // but for HDF5's headers
}

// All three readers say so, and what to do.
TEST_F(SmallSet, AnUnfinishedSetIsCalledUnfinished) {
  const std::string set = *this / "set.h5", network = *this / "net";
  ASSERT_EQ(run(sweep("a.toml", SmallSweep{.contacts = 50}.text()), "whole.h5").exit_code, 0);
  ASSERT_EQ(
      run_tactel({"train", *this / "whole.h5", "--network", "10-3-1", "--cycles", "3", "--output", network}).exit_code,
      0);
  std::filesystem::create_directories(SetSpool::folder(set));
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{"check", set},
        {"recall", network, set},
        {"train", set, "--network", "10-3-1", "--cycles", "3", "--output", *this / "another"}}) {
    EXPECT_TRUE(is_refused(run_tactel(command), {"unfinished", "goes on with " + set + ".parts if --resume is added"}));
  }
}

// Both chunks fit under the limit. The set does not: behind its rows are the headers of HDF5, some ten thousand bytes.
TEST_F(SmallSet, AFullDiskInTheAssemblyIsAnErrorAndKeepsTheChunks) {
  const std::string narrow = sweep("narrow.toml", SmallSweep{.tactels = 3}.text());
  ASSERT_EQ(run(narrow, "whole.h5").exit_code, 0);
  const std::string blocks = std::to_string(std::filesystem::file_size(*this / "whole.h5") / 512 - 2);
  EXPECT_TRUE(is_refused(run_child({"sh", "-c",
                                    "ulimit -f " + blocks + "; " TACTEL_PROGRAM " generate " + narrow + " --output " +
                                        (*this / "set.h5")}),
                         {"on a disk with room for it"}));
  const ChildResult rest = run(narrow, "set.h5", {"--resume"});
  EXPECT_EQ(rest.exit_code, 0);
  EXPECT_THAT(rest.out, HasSubstr("2 of 2 chunks exist"));
  EXPECT_EQ(checksum(text_of(*this / "set.h5")), checksum(text_of(*this / "whole.h5")));
}

TEST_F(SmallSet, ResumeRefusesACompleteSetMadeOtherwise) {
  const std::string text = sweep("a.toml", SmallSweep{}.text());
  ASSERT_EQ(run(text, "set.h5").exit_code, 0);
  EXPECT_EQ(run(text, "set.h5", {"--resume"}).exit_code, 0);
  const std::vector<std::vector<std::string>> others = {
      {"--precision", "fp64"}, {"--tolerance", "1e-3"}, {"--rung", "draft"}};
  for (std::vector<std::string> other : others) {
    const std::string name = other[0].substr(2);
    other.push_back("--resume");
    EXPECT_TRUE(is_refused(run(text, "set.h5", other), {"the requested conditions; it has", name + " "}));
  }
  EXPECT_TRUE(is_refused(run(sweep("b.toml", SmallSweep{.sweep = "seed = 5\n"}.text()), "set.h5", {"--resume"}), {}));
  // Another version.
  const std::string python = "import h5py,sys\nwith h5py.File(sys.argv[1], 'r+') as f:\n";
  const auto edit = [&](const std::string& lines) {
    return run_child({"/usr/bin/python3", "-c", python + lines, *this / "set.h5"});
  };
  ASSERT_EQ(edit("  f.attrs['plan'] = 'tactel 0.0.1\\n'\n").exit_code, 0);
  EXPECT_THAT(run(text, "set.h5", {"--resume"}).err, HasSubstr("tactel 0.0.1"));
}

// The requested residual gives the sweeps of `solve`, on a patch and on the file's mesh: the same bits of S.
TEST_F(SmallSet, TheToleranceIsThatOfSolve) {
  const std::string scene =
      "[indenter]\nshape = \"parabola\"\nradius = 10\n[contact]\nfriction = 0.5\n[load]\nindentation = 0.15\n"
      "tangential = [0.05]\n";
  for (const std::string model : {"patch", "mesh"}) {
    const std::string sensor = "[sensor]\nmodel = \"" + model + "\"\n";
    ASSERT_EQ(
        run(sweep("one.toml", "[sweep]\ncontacts = 1\n" + sensor + scene), "one.h5", {"--tolerance", "5e-3", "--force"})
            .exit_code,
        0);
    const ChildResult solved = run_tactel({"solve", sweep("scene.toml", sensor + scene), "--tolerance", "5e-3",
                                           "--precision", "fp32", "--json", "-", "--quiet"});
    const double S = nlohmann::json::parse(solved.out)["steps"].back()["slip_index"];
    EXPECT_EQ(read_contact_set(*this / "one.h5").slip_index.back(), static_cast<float>(S)) << model;
  }
}

TEST_F(SmallSet, ColumnsLeaveDatasetsOut) {
  const std::string text = sweep("a.toml", SmallSweep{}.text());
  ASSERT_EQ(run(text, "all.h5").exit_code, 0);
  const ChildResult unknown = run(text, "set.h5", {"--columns", "inputs,slip"});
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_THAT(unknown.err, HasSubstr("--columns = slip"));
  EXPECT_THAT(unknown.err, HasSubstr("tangential_force"));
  ASSERT_EQ(run(text, "few.h5", {"--columns", "inputs,parameters,status"}).exit_code, 0);
  const ContactSet all = read_contact_set(*this / "all.h5"), few = read_contact_set(*this / "few.h5");
  EXPECT_EQ(few.frames, all.frames);
  EXPECT_EQ(few.slip_index, all.slip_index);  // always there
  EXPECT_EQ(few.status, all.status);
  EXPECT_EQ(few.parameters, all.parameters);
  EXPECT_TRUE(few.contact.empty());
  EXPECT_TRUE(few.tactel_x.empty());
  EXPECT_EQ(run_tactel({"check", *this / "few.h5"}).exit_code, 0);
  EXPECT_EQ(run(text, "few.h5", {"--columns", "inputs,parameters,status", "--resume"}).exit_code, 0);
  EXPECT_THAT(run(text, "few.h5", {"--resume"}).err,
              HasSubstr("columns inputs,parameters,status (requested: unknown)"));
  for (const std::vector<std::string>& more : {std::vector<std::string>{}, {"--rows", "1000", "--block", "1000"}}) {
    std::vector<std::string> train = {"train", *this / "few.h5", "--network", "1", "--output", *this / "networks"};
    train.insert(train.end(), more.begin(), more.end());
    EXPECT_TRUE(is_refused(run_tactel(train),
                           {"few.h5", "contact_nodes = missing", "generate it with this name among --columns"}));
  }
}

TEST_F(SmallSet, CompressedItHoldsTheSameRowsAndSaysWhereTheTimeGoes) {
  const std::string text = sweep("a.toml", SmallSweep{}.text());
  const ChildResult made = run(text, "plain.h5");
  ASSERT_EQ(made.exit_code, 0);
  EXPECT_THAT(made.out, testing::ContainsRegex("draw [0-9]+ %, lay-out [0-9]+ %, solve [0-9]+ %, solve again [0-9]+ %, "
                                               "gather [0-9]+ %, write [0-9]+ %"));
  ASSERT_EQ(run(text, "small.h5", {"--compress"}).exit_code, 0);
  EXPECT_LT(std::filesystem::file_size(*this / "small.h5"), 0.8 * std::filesystem::file_size(*this / "plain.h5"));
  const ContactSet plain = read_contact_set(*this / "plain.h5"), small = read_contact_set(*this / "small.h5");
  EXPECT_EQ(plain.frames, small.frames);
  EXPECT_EQ(plain.contact, small.contact);
  EXPECT_EQ(run_tactel({"check", *this / "small.h5"}).exit_code, 0);
}

TEST_F(SmallSet, ResumeOfACompleteSetEndsInEveryProcess) {
  const std::string text = sweep("a.toml", SmallSweep{}.text());
  ASSERT_EQ(run(text, "set.h5").exit_code, 0);
  const ChildResult result =
      run_child({"sh", "-c",
                 "OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 exec timeout 120 mpirun "
                 "--oversubscribe --bind-to none -n 2 " TACTEL_PROGRAM " generate " +
                     text + " --output " + (*this / "set.h5") + " --resume"});
  EXPECT_EQ(result.exit_code, 0) << result.err;  // 124: it hung
  EXPECT_THAT(result.out, HasSubstr("complete already"));
}

// An error in a thread of the set-up is an error of the program, as it is in `solve`.
TEST_F(SmallSet, ErrorsOfThreadsReachTheUser) {
  std::string text = SmallSweep{}.text();
  text.replace(text.find("tactels = 5"), 11, "tactels = 5\npoisson = 0.4999999999");
  EXPECT_TRUE(is_refused(run(sweep("a.toml", text), "set.h5"), {"poisson"}));
}

// The same where several threads condense several sensors: none of these can be condensed, so each thread meets one.
TEST_F(SmallSet, ErrorsOfThreadsThatCondenseReachTheUser) {
  std::string text = SmallSweep{}.text(), sensors;
  for (const char* poisson : {"0.4999999999", "0.49999999991", "0.49999999992", "0.49999999993"})
    sensors += std::string("[[sensor]]\ncolumns = 11\nrows = 4\ntactels = 5\npoisson = ") + poisson + "\n";
  const auto from = text.find("[sensor]"), to = text.find("[contact]");
  text.replace(from, to - from, sensors);
  EXPECT_TRUE(is_refused(run_child({"env", "TACTEL_THREADS=4", TACTEL_PROGRAM, "generate", sweep("a.toml", text),
                                    "--output", *this / "set.h5"}),
                         {"poisson"}));
}

using GenerateOutputs = SmallSet;
TEST_F(GenerateOutputs, OutputsThatCannotBeAreWrongInput) {
  const std::string text = sweep("a.toml", SmallSweep{}.text());
  for (const std::string& output :
       {std::string(300, 'x') + ".h5", std::string("a.toml/set.h5"), std::string("no/set.h5")}) {
    EXPECT_TRUE(is_refused(run(text, output), {"--output = "}));
  }
}

// friction is 0 or 0.5, one as likely as the other; expected: the draws themselves.
TEST_F(SmallSet, CountsContactsWithoutRows) {
  const std::string path = sweep("a.toml", SmallSweep{.friction = "{ choice = [0, 0.5] }"}.text());
  const Sweep drawn = read_sweep(path);
  std::uint64_t without = 0;
  for (std::uint64_t k = 0; k < 9000; ++k) without += drawn.lines("sweep").contact(k).scene.friction == 0;
  ASSERT_GT(without, 4000u);
  const ChildResult result = run(path, "set.h5");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.out, HasSubstr(std::to_string(without) + " of 9000 contacts have no row"));
  const ContactSet set = read_contact_set(*this / "set.h5");
  EXPECT_EQ(set.without_rows, without);
  EXPECT_EQ(set.contacts, 9000u);
}

// A drag of 5 mm at mu = 0.1, where the rubber follows by less than 0.1 mm, is far on elements of 2 mm; one of 0.05 mm
// is not. Which of the two a contact has the sweep draws; expected: the draws themselves.
TEST_F(SmallSet, CountsContactsThatSlideFar) {
  const std::string path =
      sweep("a.toml", SmallSweep{.friction = "0.1", .drag = "tangential = [{ choice = [0.05, 5] }]"}.text());
  const Sweep drawn = read_sweep(path);
  std::uint64_t far = 0;
  for (std::uint64_t k = 0; k < 9000; ++k) far += drawn.lines("sweep").contact(k).scene.load.tangential[0] == 5;
  ASSERT_GT(far, 4000u);
  stop_half_way(path, "set.h5");  // the counts of chunks that are there count, too
  const ChildResult result = run(path, "set.h5", {"--resume"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.out, HasSubstr(std::to_string(far) + " of 9000 contacts slide further than"));
  EXPECT_THAT(result.out, testing::Not(HasSubstr("do not slide as a whole")));
}

// 1000 steps of 1e-6 mm never make mu = 0.5 slide; where nothing touches (mu is any) there is no row, and the drag
// ends.
TEST_F(SmallSet, CountsDragsUntilSlidingThatNeverSlide) {
  const SmallSweep few{.contacts = 40, .indentation = "{ choice = [0, 0.1] }", .drag = "tangential_step = 1e-6"};
  const std::string path = sweep("a.toml", few.text());
  const Sweep drawn = read_sweep(path);
  std::uint64_t pressed = 0;
  for (std::uint64_t k = 0; k < 40; ++k) pressed += drawn.lines("sweep").contact(k).scene.load.indentation[0] > 0;
  ASSERT_GT(pressed, 5u);
  ASSERT_LT(pressed, 35u);
  const ChildResult result = run(path, "set.h5");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.out, HasSubstr(std::to_string(pressed) + " of 40 contacts do not slide as a whole within 1000"));
  EXPECT_THAT(result.out, HasSubstr(std::to_string(40 - pressed) + " of 40 contacts have no row"));
  EXPECT_EQ(read_contact_set(*this / "set.h5").rows(), 1001 * pressed);
}

/// What is in the folder beside the sweep file.
std::vector<std::string> outputs_in(const std::filesystem::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (entry.path().extension() != ".toml") names.push_back(entry.path().filename().string());
  return names;
}

// Killed as it syncs the set (the first fsync of the temporary), and as it syncs the folder behind the renaming.
TEST_F(SmallSet, AKillInTheAssemblyLeavesNothingForGood) {
  const OwnCache cache;  // the programs that run beside it sync kernels that they compile into a shared one
  const std::string text = sweep("a.toml", SmallSweep{}.text());
  ASSERT_EQ(run(text, "whole.h5").exit_code, 0);
  const std::string whole = text_of(*this / "whole.h5");
  std::filesystem::remove(*this / "whole.h5");
  int in_assembly = 0;
  for (int fsync = 1; fsync <= 12; ++fsync) {
    const ChildResult result =
        run_child({"sh", "-c",
                   "strace -f -o /dev/null -e trace=fsync -e inject=fsync:signal=KILL:when=" + std::to_string(fsync) +
                       " " TACTEL_PROGRAM " generate " + text + " --resume --output " + (*this / "set.h5")});
    const std::vector<std::string> left = outputs_in(folder_ / "");
    in_assembly += left.size() > 1;
    ASSERT_EQ(run(text, "set.h5", {"--resume"}).exit_code, 0);
    EXPECT_THAT(outputs_in(folder_ / ""), testing::ElementsAre("set.h5")) << "killed at fsync " << fsync;
    EXPECT_EQ(checksum(text_of(*this / "set.h5")), checksum(whole));
    std::filesystem::remove(*this / "set.h5");
    if (result.exit_code == 0) break;  // fewer fsyncs than that
  }
  EXPECT_GE(in_assembly, 1);  // the spool beside the set
}

TEST_F(SmallSet, SurvivesAPowerCut) {
  const std::string text = sweep("a.toml", SmallSweep{}.text());
  const std::string order = source_file("tests/host/support/sync_order.py");
  EXPECT_EQ(run_child({"/usr/bin/python3", order, *this / "set.h5", SetSpool::folder(*this / "set.h5") / "plan", "--",
                       TACTEL_PROGRAM, "generate", text, "--output", *this / "set.h5", "--quiet"})
                .exit_code,
            0);
  // Of a run that is stopped, what --resume takes.
  const std::string many = sweep("many.toml", SmallSweep{.contacts = 10'000'000}.text()), set = *this / "many.h5";
  const ChildResult stopped = run_child(
      {"/usr/bin/python3", order, "in-place:" + (SetSpool::folder(set) / "0000.chunks").string(), "--", "sh", "-c",
       "timeout --preserve-status -s INT 2 " TACTEL_PROGRAM " generate " + many + " --output " + set +
           "; test $? = 130"});
  EXPECT_EQ(stopped.exit_code, 0) << stopped.err;
}

/// The first block of Python in docs/sets.md.
std::string documented_python() {
  const std::string text = text_of(source_file("docs/sets.md")), begin = "```python\n";
  const auto from = text.find(begin) + begin.size();
  return text.substr(from, text.find("```", from) - from);
}

TEST_F(SmallSet, TheDocumentedPythonNamesTheIndenters) {
  const std::string text = sweep(
      "a.toml", SmallSweep{.indenter = "[[indenter]]\nshape = \"profile\"\npoints = 9\nhalf_width = 4\nheight = 0.5\n"
                                       "[[indenter]]\nshape = \"rounded_flat\"\nhalf_width = 1\nradius = 5\n"}
                    .text());
  ASSERT_EQ(run(text, "random.h5").exit_code, 0);
  const std::string script = folder_.write("read.py", documented_python());
  const ChildResult result = run_child({"sh", "-c", "cd " + (*this / "") + " && exec /usr/bin/python3 " + script});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("{0: 'random profile', 1: 'rounded_flat'}"));
}

}  // namespace tactel::host::generate_command_test
