// `tactel train` under mpirun: the networks of one process.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "network_files.h"
#include "tests/host/run_tactel.h"

namespace tactel::host {
namespace {

using tactel::testing::networks_in;
using tactel::testing::PaperSetFiles;

class RankTraining : public ::testing::Test {
 protected:
  std::string arguments(const std::string& directory) const {
    return " train " + PaperSetFiles::learning() + " --output " + (folder_ / directory).string() +
           " --network 3 --network 6 --seeds 5 --cycles 60 --noise 0 --noise 0.1";
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
  EXPECT_FALSE(std::filesystem::exists(folder_ / "three" / "rank-1"));
}

// All processes are killed, as by a node that fails, and started again.
TEST_F(RankTraining, GoesOnAfterAKill) {
  ASSERT_EQ(shell(TACTEL_PROGRAM + arguments("one")).exit_code, 0);
  const std::string command = mpirun + TACTEL_PROGRAM + arguments("three") + " --checkpoint-seconds 0 --resume";
  shell("timeout -s KILL 0.8 sh -c '" + command + "'");
  const ChildResult rest = shell(command);
  ASSERT_EQ(rest.exit_code, 0) << rest.err;
  EXPECT_EQ(networks_in(folder_ / "three"), networks_in(folder_ / "one"));
}

}  // namespace
}  // namespace tactel::host
