// SPDX-License-Identifier: Apache-2.0

// What the commands write survives a power cut: system calls as strace sees them; and one program at a time writes a
// folder.
#include <gtest/gtest.h>

#include "host/support/durable_file.h"
#include "tests/host/commands/small_sweep.h"
#include "tests/host/support/run_tactel.h"

namespace tactel::host::durability_test {

/// Runs a command of tactel under strace; fails where a target was not written, synced, renamed and its folder synced.
ChildResult in_order(const std::vector<std::string>& targets, const std::vector<std::string>& command,
                     const std::vector<std::string>& launcher = {}) {
  std::vector<std::string> all = {"/usr/bin/python3", source_file("tests/host/support/sync_order.py")};
  all.insert(all.end(), targets.begin(), targets.end());
  all.emplace_back("--");
  all.insert(all.end(), launcher.begin(), launcher.end());
  all.emplace_back(TACTEL_PROGRAM);
  all.insert(all.end(), command.begin(), command.end());
  return run_child(all);
}

/// A set of some hundred rows, made as quickly as can be.
class Durability : public ::testing::Test {
 protected:
  static const ScratchFolder& folder() {
    static const ScratchFolder made;
    static const std::string sweep =
        made.write("sweep.toml", SmallSweep{.contacts = 100, .drag = "tangential = [0.02, 0.05]"}.text());
    static const int code = run_tactel({"generate", sweep, "--output", made / "set.h5"}).exit_code;
    EXPECT_EQ(code, 0);
    return made;
  }
  static std::string at(const std::string& name) { return (folder() / name).string(); }
};

TEST_F(Durability, NetworksCheckpointAndReportOfATraining) {
  const std::string net = at("net");
  EXPECT_EQ(in_order({net + "/checkpoint", net + "/training.json", net + "/learning_curves.svg",
                      net + "/10-3-1_noise0_seed1.onnx"},
                     {"train", at("set.h5"), "--network", "10-3-1", "--cycles", "50", "--checkpoint-seconds", "1e-6",
                      "--output", net, "--quiet"})
                .exit_code,
            0);
}

using DurabilityNightly = Durability;
// Those of two processes, which rank 0 puts together in DIR.
TEST_F(DurabilityNightly, NetworksOfSeveralProcesses) {
  const std::string net = at("ranks");
  const ChildResult result = in_order(
      {net + "/training.json", net + "/learning_curves.svg", net + "/10-3-1_noise0_seed1.onnx",
       net + "/10-3-1_noise0_seed2.onnx"},
      {"train", at("set.h5"), "--network", "10-3-1", "--seeds", "2", "--cycles", "5", "--output", net, "--quiet"},
      {"env", "OMPI_ALLOW_RUN_AS_ROOT=1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1", "mpirun", "--oversubscribe", "--bind-to",
       "none", "-n", "2"});
  EXPECT_EQ(result.exit_code, 0) << result.err << result.out;
}

TEST_F(Durability, Answers) {
  EXPECT_EQ(
      in_order({at("a.json"), at("a.svg"), at("a.vtu")}, {"solve", source_file("examples/parabola.toml"), "--json",
                                                          at("a.json"), "--plot", at("a.svg"), "--field", at("a.vtu")})
          .exit_code,
      0);
}

TEST_F(Durability, OneProgramAtATimeTrainsInADirectory) {
  std::filesystem::create_directory(folder() / "busy");
  const FileLock lock = FileLock::of_folder("--output", folder() / "busy", "free");
  EXPECT_TRUE(
      is_refused(run_tactel({"train", at("set.h5"), "--network", "10-3-1", "--cycles", "5", "--output", at("busy")}),
                 {"no other program is training"}));
}

TEST_F(Durability, OneProgramAtATimeReproducesInADirectory) {
  std::filesystem::create_directory(folder() / "reproduced");
  const FileLock lock = FileLock::of_folder("--output", folder() / "reproduced", "free");
  EXPECT_TRUE(is_refused(run_child({"timeout", "60", TACTEL_PROGRAM, "reproduce", "--seeds", "1", "--cycles", "5",
                                    "--output", at("reproduced")}),
                         {"no other program is training"}));
  EXPECT_TRUE(std::filesystem::is_empty(folder() / "reproduced"));
}

TEST_F(Durability, Recording) {
  EXPECT_EQ(in_order({"in-place:" + at("recording")}, {"record", "--source",
                                                       "simulate:" + source_file("examples/parabola.toml") +
                                                           "?paced=0&press=0.5&hold=0&drag=0&slip=0&noise=0",
                                                       "--output", at("recording")})
                .exit_code,
            0);
}

// Of a sensor that moves: --force takes it all the same.
TEST_F(Durability, Calibration) {
  EXPECT_EQ(in_order({at("cal.toml")}, {"tare", "--source",
                                        "simulate:" + source_file("examples/parabola.toml") +
                                            "?paced=0&press=9&hold=0&drag=0&slip=0&noise=0",
                                        "--output", at("cal.toml"), "--force"})
                .exit_code,
            0);
}

}  // namespace tactel::host::durability_test
