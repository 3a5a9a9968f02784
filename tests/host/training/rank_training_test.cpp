// SPDX-License-Identifier: Apache-2.0

// `tactel train` under mpirun: the networks of one process.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <thread>

#include "test_paths.h"
#include "tests/host/sets/network_files.h"
#include "tests/host/support/run_tactel.h"

namespace tactel::host::rank_training_test {

using tactel::tests::networks_in;
using tactel::tests::PaperSetFiles;
using namespace std::chrono_literals;

class RankTraining : public ::testing::Test {
 protected:
  std::string arguments(const std::string& directory, int cycles = 60) const {
    return " train " + PaperSetFiles::learning() + " --output " + (folder_ / directory).string() +
           " --network 3 --network 6 --seeds 5 --noise 0 --noise 0.1 --cycles " + std::to_string(cycles);
  }
  ChildResult shell(const std::string& command) const { return run_child({"sh", "-c", command}); }

  ScratchFolder folder_;
};

const std::string mpirun =
    "OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 mpirun --oversubscribe --bind-to none -n 3 ";

TEST_F(RankTraining, SeveralProcessesMakeTheNetworksOfOne) {
  const ChildResult one = shell(TACTEL_PROGRAM + arguments("one"));
  ASSERT_EQ(one.exit_code, 0) << one.err;
  const ChildResult three = shell(mpirun + TACTEL_PROGRAM + arguments("three"));
  ASSERT_EQ(three.exit_code, 0) << three.err;
  EXPECT_EQ(networks_in(folder_ / "three"), networks_in(folder_ / "one"));
  const auto of = [&](const char* name) { return nlohmann::json::parse(text_of(folder_ / name / "training.json")); };
  const auto whole = of("one"), joined = of("three");
  ASSERT_EQ(joined["networks"].size(), 20u);
  EXPECT_EQ(joined["patterns"], whole["patterns"]);
  EXPECT_EQ(joined["processes"], 3);
  for (std::size_t i = 0; i < 20; ++i) {
    EXPECT_EQ(joined["networks"][i]["file"], whole["networks"][i]["file"]);
    EXPECT_EQ(joined["networks"][i]["sse"], whole["networks"][i]["sse"]);
  }
  EXPECT_TRUE(std::filesystem::exists(folder_ / "three" / "learning_curves.svg"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "three" / "checkpoint-1"));
}

// The best weights of a validation set and the mean of the weights come from all checkpoints.
TEST_F(RankTraining, SeveralProcessesKeepTheBestWeightsOfOne) {
  const std::string more = " --schedule cosine --average 0.9 --patience 5 --validation " + PaperSetFiles::recall();
  ASSERT_EQ(shell(TACTEL_PROGRAM + arguments("one", 20) + more).exit_code, 0);
  const ChildResult three = shell(mpirun + TACTEL_PROGRAM + arguments("three", 20) + more);
  ASSERT_EQ(three.exit_code, 0) << three.err;
  EXPECT_EQ(networks_in(folder_ / "three"), networks_in(folder_ / "one"));
}

// All processes are killed, as by a node that fails, once each has kept something; then they are started again.
TEST_F(RankTraining, GoesOnAfterAKill) {
  const int cycles = 1500;  // some seconds
  ASSERT_EQ(shell(TACTEL_PROGRAM + arguments("one", cycles) + " --stop-error 0").exit_code, 0);
  const std::string three = folder_ / "three";
  const std::string command =
      mpirun + TACTEL_PROGRAM + arguments("three", cycles) + " --stop-error 0 --checkpoint-seconds 0 --resume";
  const ChildResult kept = shell(command + " >/dev/null 2>&1 & for i in $(seq 1500); do [ $(ls " + three +
                                 "/checkpoint-? | wc -l) = 3 ] && exit 0; sleep 0.02; done; exit 1");
  ASSERT_EQ(kept.exit_code, 0) << "no checkpoints: " << kept.err;
  run_child({"pkill", "-KILL", "-f", "--", "--output " + three});
  while (run_child({"pgrep", "-f", "--", "--output " + three}).exit_code == 0) std::this_thread::sleep_for(20ms);
  ASSERT_FALSE(std::filesystem::exists(folder_ / "three" / "training.json")) << "done before it was killed";
  ASSERT_EQ(shell(command).exit_code, 0);
  EXPECT_EQ(networks_in(folder_ / "three"), networks_in(folder_ / "one"));
}

}  // namespace tactel::host::rank_training_test
