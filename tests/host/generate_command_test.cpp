// Sets of many contacts through the program: the same rows whatever happened on the way.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "fem/gap_reference.h"
#include "host/checksum.h"
#include "host/errors.h"
#include "host/gap_sweep.h"
#include "host/set_production.h"
#include "host/sweep_file.h"
#include "test_device.h"
#include "tests/host/run_tactel.h"

namespace tactel::host {
namespace {

using testing::HasSubstr;

// Four chunks, two sensors, depth and force side by side.
const std::string sweep_text = R"([sweep]
contacts = 26000
seed = 11
[[sensor]]
[[sensor]]
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

  ScratchFolder folder_;
  std::string sweep_ = folder_.write("sweep.toml", sweep_text);
};

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
  const ChildResult impossible = generate("1e-9");
  EXPECT_EQ(impossible.exit_code, 4);
  EXPECT_THAT(impossible.err, HasSubstr("no rung is known to keep this accuracy"));
  EXPECT_TRUE(std::filesystem::exists(output("small.h5")));
  const ChildResult easy = generate("0.9");
  EXPECT_EQ(easy.exit_code, 0) << easy.err;
}

TEST_F(Generate, InterruptKeepsWhatIsDoneAndSaysHowToGoOn) {
  const ChildResult result = shell("timeout -s INT 0.6", output("set.h5"));
  if (result.exit_code == 124 || result.exit_code == 130) {
    EXPECT_THAT(result.err, HasSubstr("--resume goes on"));
    EXPECT_FALSE(std::filesystem::exists(output("set.h5")));
    const ChildResult fresh = run({"--output", output("set.h5")});
    EXPECT_EQ(fresh.exit_code, 2);
    EXPECT_THAT(fresh.err, HasSubstr("--resume goes on with it, --force starts anew"));
  }
  EXPECT_EQ(run({"--output", output("set.h5"), "--resume"}).exit_code, 0);
  EXPECT_THAT(run({"--output", output("set.h5"), "--resume"}).out, HasSubstr("complete already"));
}

// A limit on the size of files (in blocks of 512 bytes) stands for a full disk: 6 MB hold one chunk of 4.5 MB.
TEST_F(Generate, FullDiskKeepsWholeChunks) {
  const ChildResult full = shell("trap '' XFSZ; ulimit -f 12000;", output("set.h5"));
  EXPECT_EQ(full.exit_code, 2) << full.err;
  EXPECT_THAT(full.err, HasSubstr("room"));
  EXPECT_FALSE(std::filesystem::exists(output("set.h5")));
  const ChildResult rest = run({"--output", output("set.h5"), "--resume"});
  ASSERT_EQ(rest.exit_code, 0) << rest.err;
  EXPECT_THAT(rest.out, HasSubstr("1 of 4 chunks are there"));
  ASSERT_EQ(run({"--output", output("whole.h5")}).exit_code, 0);
  EXPECT_EQ(checksum(text_of(output("set.h5"))), checksum(text_of(output("whole.h5"))));
}

TEST_F(Generate, DamagedChunksAreMadeAgain) {
  ASSERT_EQ(run({"--output", output("whole.h5")}).exit_code, 0);
  shell("trap '' XFSZ; ulimit -f 12000;", output("set.h5"));
  const auto spool = SetSpool::folder(output("set.h5")) / "0000.spool";
  ASSERT_TRUE(std::filesystem::exists(spool));
  std::fstream file(spool, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(1000);
  file.put('\x55').put('\x55');
  file.close();
  ASSERT_EQ(run({"--output", output("set.h5"), "--resume"}).exit_code, 0);
  EXPECT_EQ(checksum(text_of(output("set.h5"))), checksum(text_of(output("whole.h5"))));
}

TEST_F(Generate, RefusesOtherPlansOtherFilesAndOtherWriters) {
  const std::string set = output("set.h5");
  shell("trap '' XFSZ; ulimit -f 6000;", set);
  EXPECT_THAT(run({"--output", set, "--resume", "--precision", "fp64"}).err,
              HasSubstr("another sweep file, seed, precision"));
  {
    SetSpool held(output("held.h5"), "a plan", 0, SetSpool::Open::fresh);
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
    const fem::Scene scene = sweep.source.contact(k).scene;
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
  const ChildResult result = run({"--output", output("two.h5"), "--device", "basic", "--also-device", "pthread"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const ContactSet one = read_contact_set(output("one.h5")), two = read_contact_set(output("two.h5"));
  EXPECT_THAT(two.device, HasSubstr(", "));
  EXPECT_EQ(one.frames, two.frames);
  EXPECT_EQ(one.slip_index, two.slip_index);
  EXPECT_EQ(one.contact, two.contact);
}

// Contact k goes down to the depth that the file's seed draws: some 4000 of 10000 beyond 20 % of 1.5 mm, in two chunks,
// one of which comes from an earlier run. Expected: the draws themselves.
TEST_F(Generate, WarnsOnceOfDeepIndentersWithTheirCount) {
  const std::string deep =
      folder_.write("deep.toml",
                    "[sweep]\ncontacts = 10000\n[sensor]\ncolumns = 11\nrows = 4\ntactels = 5\n[contact]\n"
                    "friction = 0.5\n[indenter]\nshape = \"parabola\"\nradius = 10\n[load]\n"
                    "indentation = { uniform = [0.2, 0.4] }\ntangential = [0.05]\n");
  const Sweep sweep = read_sweep(deep);
  int beyond = 0;
  for (std::uint64_t k = 0; k < 10000; ++k) beyond += sweep.source.contact(k).scene.load.indentation[0] > 0.3;
  ASSERT_GT(beyond, 1000);
  const std::string said =
      "warning: in " + std::to_string(beyond) + " of 10000 contacts the indenter is deeper than 20 %";
  const ChildResult whole = run_tactel({"generate", deep, "--output", output("deep.h5")});
  EXPECT_EQ(whole.exit_code, 0);
  EXPECT_THAT(whole.err, HasSubstr(said));
  EXPECT_EQ(whole.err.find("warning"), whole.err.rfind("warning"));
  EXPECT_EQ(run_tactel({"generate", deep, "--output", output("quiet.h5"), "--quiet"}).err, "");
  run_child(
      {"sh", "-c",
       "trap '' XFSZ; ulimit -f 3000; " TACTEL_PROGRAM " generate " + deep + " --output " + output("resumed.h5")});
  ASSERT_FALSE(std::filesystem::exists(output("resumed.h5")));
  const ChildResult resumed = run_tactel({"generate", deep, "--output", output("resumed.h5"), "--resume"});
  EXPECT_THAT(resumed.out, HasSubstr("1 of 2 chunks are there"));
  EXPECT_THAT(resumed.err, HasSubstr(said));
  std::string text = text_of(deep);
  text.replace(text.find("[0.2, 0.4]"), 10, "[0.1, 0.3]");
  const std::string shallow = folder_.write("shallow.toml", text);
  EXPECT_EQ(run_tactel({"generate", shallow, "--output", output("shallow.h5")}).err, "");
}

const std::string mpirun =
    "OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 exec mpirun --oversubscribe --bind-to none -n 3";

TEST_F(Generate, SeveralProcessesGiveTheRowsOfOne) {
  ASSERT_EQ(run({"--output", output("one.h5")}).exit_code, 0);
  const ChildResult result = shell(mpirun, output("three.h5"));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(checksum(text_of(output("three.h5"))), checksum(text_of(output("one.h5"))));
}

// One of three processes is killed: what the others did is kept, and one process alone makes the rest.
TEST_F(Generate, AProcessThatDiesCostsItsOwnChunksOnly) {
  const std::string script = folder_.write(
      "killed.sh", "(" + mpirun + " " TACTEL_PROGRAM " generate " + sweep_ + " --output " + output("three.h5") +
                       ") &\nsleep 0.6\nkill -KILL $(pgrep -P $! | tail -1)\nwait $!\n");
  const ChildResult result = run_child({"sh", script});
  ASSERT_EQ(run({"--output", output("three.h5"), "--resume"}).exit_code, 0) << result.err;
  ASSERT_EQ(run({"--output", output("one.h5")}).exit_code, 0);
  EXPECT_EQ(checksum(text_of(output("three.h5"))), checksum(text_of(output("one.h5"))));
}

}  // namespace
}  // namespace tactel::host
