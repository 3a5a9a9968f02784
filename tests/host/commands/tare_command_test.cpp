// SPDX-License-Identifier: Apache-2.0

// tactel tare as a user runs it, on a simulated sensor.
#include <gmock/gmock.h>

#include <filesystem>

#include "tests/host/commands/live_command.h"

namespace tactel::host::tare_command_test {

using ::testing::HasSubstr;

class TareCommand : public LiveCommand {
 protected:
  ChildResult tare(const std::string& source, std::vector<std::string> more = {}) const {
    return run_tactel({"tare", "--source", source, "--output", calibration_}, more);
  }
  std::string calibration_ = (folder_ / "c.toml").string();
  // Pressed at once and held, without the amplifiers' decay: constant stresses and noise.
  const std::string rest_ = "simulate:" + scene + "?paced=0&press=0&hold=9&drag=0&slip=0&time_constant=0";
};

TEST_F(TareCommand, WritesTheOffsetsAtRest) {
  const auto tared = tare(rest_);
  ASSERT_EQ(tared.exit_code, 0) << tared.err;
  EXPECT_THAT(tared.err, HasSubstr("the mean of 201 frames")) << "2 s at 100 Hz, and the frame at 0";
  const auto used =
      run_tactel({"monitor", "--source", simulation, "--network", network_, "--calibration", calibration_});
  EXPECT_EQ(used.exit_code, 0) << used.err;
  EXPECT_TRUE(lines_of(used.out).front().contains("contact")) << "the noise is in the file, too";
}

TEST_F(TareCommand, AMovingSensorIsNotAtRest) {
  EXPECT_TRUE(is_refused(tare(simulation), {"not at rest", "stress of tactel"}, 4));
  EXPECT_FALSE(std::filesystem::exists(calibration_));
  EXPECT_EQ(tare(simulation, {"--force"}).exit_code, 0);
  EXPECT_TRUE(std::filesystem::exists(calibration_));
}

TEST_F(TareCommand, TooFewFramesTellNothing) {
  const auto few = tare(rest_ + "&rate=3");
  EXPECT_EQ(few.exit_code, 3) << few.err;
  EXPECT_THAT(few.err, HasSubstr("7 frames arrived"));
}

// A board may boot for longer than the sensor is listened to.
TEST_F(TareCommand, CountsItsSecondsFromTheFirstFrame) {
  const std::string profile = folder_.write(
      "p.toml", "[format]\nkind = \"csv\"\nchannels = 2\n[channels]\nnormal = [0, 1]\n[calibration]\ngain = 1\n");
  const std::string board = "sleep 1; for k in $(seq 60); do echo 1,$((k % 2)); sleep 0.01; done; sleep 1";
  const ChildResult tared = run_child({"/bin/sh", "-c",
                                       "(" + board + ") | " + TACTEL_PROGRAM + " tare --source csv:- --profile " +
                                           profile + " --output " + calibration_ + " --seconds 0.5"});
  EXPECT_EQ(tared.exit_code, 0) << tared.err;
  EXPECT_THAT(tared.err, HasSubstr("the mean of "));
}

TEST_F(TareCommand, CtrlCWritesNoCalibration) {
  const std::string paced = "simulate:" + scene + "?press=0&hold=90&drag=0&slip=0&time_constant=0";
  EXPECT_EQ(run_child({"/usr/bin/timeout", "--preserve-status", "--signal=INT", "4", TACTEL_PROGRAM, "tare", "--source",
                       paced, "--output", calibration_, "--seconds", "60"})
                .exit_code,
            130);
  EXPECT_FALSE(std::filesystem::exists(calibration_));
}

TEST_F(TareCommand, AContactIsFoundAboveTheNoise) {
  const std::string quiet = "simulate:" + scene + "?paced=0&press=0.5&hold=2.5&time_constant=0";
  const auto lines = lines_of(run_tactel({"monitor", "--source", quiet, "--network", network_, "--touch", "0.01"}).out);
  EXPECT_EQ(lines.front()["contact"], false);
  EXPECT_EQ(lines.back()["contact"], true);
  EXPECT_TRUE(lines.back()["slip_index"].is_number());
  for (const char* value : {"-1", "nan", "soon"})
    EXPECT_EQ(run_tactel({"monitor", "--source", quiet, "--network", network_, "--touch", value}).exit_code, 2);
}

}  // namespace tactel::host::tare_command_test
