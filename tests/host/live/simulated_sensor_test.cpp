// SPDX-License-Identifier: Apache-2.0
#include "host/live/simulated_sensor.h"

#include <gmock/gmock.h>

#include <chrono>
#include <cmath>
#include <thread>

#include "host/live/live_monitor.h"
#include "host/scenes/scene_file.h"
#include "hw/decoder.h"
#include "hw/tare.h"
#include "tests/host/live/simulated_frames.h"
#include "tests/host/networks/network_cases.h"

namespace tactel::host::simulated_sensor_test {

// Without decay, spread and noise the chain gives back the stresses of the solved steps within half a converter step.
TEST(SimulatedSensor, TheChainWithoutItsFaultsGivesTheSceneBack) {
  OpenSource opened =
      open_source("simulate:" + scene + "?rate=1000&paced=0&noise=0&gain_spread=0&time_constant=0", "", "");
  const fem::ContactSolution solution = solve(read_scene(scene), {}).solution;
  hw::Decoder decoder(opened.profile.format());
  std::vector<float> frame(42);
  const double step = opened.profile.map.calibration.gain[0];
  const auto compare = [&](const fem::ContactStep& expected) {
    for (Eigen::Index i = 0; i < 21; ++i) {
      EXPECT_NEAR(frame[static_cast<std::size_t>(i)], expected.sigma_y[i], 0.51 * step);
      EXPECT_NEAR(frame[static_cast<std::size_t>(21 + i)], expected.tau_xy[i], 0.51 * step);
    }
  };
  while (const auto packet = opened.source->wait(0)) {
    decoder.feed(packet->bytes,
                 [&](const hw::DecodedFrame& decoded) { opened.profile.map.apply(decoded.values, frame); });
    if (decoder.counts().frames == 501) compare(solution.steps.front());  // pressed in after 0.5 s
  }
  compare(solution.steps.back());
  EXPECT_EQ(decoder.counts().frames, 3201u);
  EXPECT_EQ(decoder.counts().lost, 0u);
}

// S of a load step where the play reaches it; between two steps the quotient of the means of S P and P; none at rest.
TEST(SimulatedSensor, KnowsItsTrueS) {
  const OpenSource opened = open_source("simulate:" + scene + "?rate=1000&paced=0&repeat=2", "", "");
  const std::vector<fem::ContactStep> steps = solve(read_scene(scene), {}).solution.steps;
  const auto drags = steps.size() - 1;  // in 2 s, after 0.5 s of pressing and a hold of 0.2 s
  const auto s = [&](std::size_t step) { return *steps[step].slip_index; };
  EXPECT_TRUE(std::isnan(opened.true_slip_index(0)));
  for (const std::uint64_t begin : {0, 3200}) {  // ms, of a play
    EXPECT_NEAR(opened.true_slip_index(begin + 600), s(0), 1e-6);
    EXPECT_NEAR(opened.true_slip_index(begin + 3000), s(drags), 1e-6);
    ASSERT_EQ(2000 % (2 * drags), 0u);
    for (std::size_t i = 1; i <= drags; ++i) {
      const std::uint64_t at = begin + 700 + 2000 * i / drags;
      EXPECT_NEAR(opened.true_slip_index(at), s(i), 1e-5);
      const double demand = s(i) * steps[i].P + s(i - 1) * steps[i - 1].P;
      EXPECT_NEAR(opened.true_slip_index(at - 1000 / drags), demand / (steps[i].P + steps[i - 1].P), 1e-5);
    }
  }
}

// A reader that sleeps gets the frames of the sensor's own time, no more and no fewer: rate times seconds.
TEST(SimulatedSensor, EndsByItsOwnTime) {
  OpenSource opened = open_source("simulate:" + scene + "?rate=1000", "", "");
  EXPECT_TRUE(opened.source->end_after(0.25));
  hw::Decoder decoder(opened.profile.format());
  while (!opened.source->finished()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(30));
    if (const auto packet = opened.source->wait(0)) decoder.feed(packet->bytes, [](const hw::DecodedFrame&) {});
  }
  EXPECT_EQ(decoder.counts().frames, 250u);
  EXPECT_TRUE(opened.source->end_after(1e9));  // no longer than it was
  EXPECT_TRUE(opened.source->finished());
}

TEST(SimulatedSensor, GainsSpreadAndNoiseAsAsked) {
  const fem::ContactSolution solution = solve(read_scene(scene), {}).solution;
  const auto readings = [&](SimulationOptions options) {
    options.paced = false;
    SimulatedSensor sensor(ScenePlay(solution, 1, options), options);
    hw::Decoder decoder(parse_profile(sensor.profile_text(), "test").format());
    std::vector<std::vector<double>> all;
    const hw::FrameSink keep = [&](const hw::DecodedFrame& f) { all.emplace_back(f.values.begin(), f.values.end()); };
    while (const auto packet = sensor.wait(0)) decoder.feed(packet->bytes, keep);
    return all;
  };
  EXPECT_EQ(readings({.seed = 3}), readings({.seed = 3}));
  EXPECT_NE(readings({.seed = 3}), readings({.seed = 4}));
  // Before contact only noise is there: 42 channels of the first frame, 0.01 of 2048 steps.
  const auto noisy = readings({.noise = 0.01});
  double squares = 0;
  for (const double code : noisy.front()) squares += (code - 2048) * (code - 2048);
  EXPECT_NEAR(std::sqrt(squares / 42), 20.48, 20.48 * 0.45);  // four standard errors of 42 samples
}

TEST(SimulatedSensor, TakesAsManyTactelsAsAsked) {
  EXPECT_EQ(open_source(simulation + "&tactels=8", "", "").profile.map.tactels(), 8u);
}

/// Noise of a sensor at rest for some seconds at 100 Hz, then 1 MPa at every tactel.
SimulatedSensor resting(double seconds) {
  const SimulationOptions options{.press = 0, .hold = seconds, .drag = 0, .slip = 0.1, .paced = false};
  fem::ContactSolution solution{.tactel_x = Eigen::VectorXd::Zero(21)};
  solution.steps.resize(2);
  for (int k = 0; k < 2; ++k) solution.steps[k].sigma_y = solution.steps[k].tau_xy = Eigen::VectorXd::Constant(21, -k);
  return {ScenePlay(solution, 1, options), options};
}

// Two seconds teach the noise; the untrained network answers about 0.5 to any frame.
TEST(SimulatedSensor, AnHourOfNoiseAtRestRaisesNoAlarm) {
  SimulatedSensor quiet = resting(2);
  SensorProfile profile = parse_profile(quiet.profile_text(), "test");
  // Noise of 0.001 of full scale, 1.5 MPa, and 1 % by the rounding of the converter.
  EXPECT_NEAR(profile.map.touch(), 7 * 0.0015, 0.02 * 7 * 0.0015) << "the simulation knows its noise";
  hw::Tare tare(42);
  hw::Decoder decoder(profile.format());
  while (const auto packet = quiet.wait(0))
    decoder.feed(packet->bytes, [&](const hw::DecodedFrame& frame) {
      if (tare.frames() < 200) tare.add(frame.values);
    });
  profile.map.calibration.offset = tare.offset(), profile.map.calibration.noise = tare.noise();
  // Noise of 0.001 of full scale, 1.5 MPa, in steps of a converter that are half of it
  EXPECT_NEAR(profile.map.touch(), 7 * 0.0015, 0.25 * 7 * 0.0015) << "the noisiest of 21";

  const auto alarms = [&](double seconds, MonitorOptions options) {
    SimulatedSensor source = resting(seconds);
    options.at = 0.01f;
    LiveMonitor monitor(network(21), profile, options);
    std::vector<std::uint64_t> began;
    bool on = false;
    monitor.run(source, {.line = [&](const MonitorLine& line) {
                  if (line.alarm && !on) began.push_back(line.frame.number);
                  on = line.alarm;
                }});
    return began;
  };
  EXPECT_THAT(alarms(3600, {}), ::testing::ElementsAre(360000)) << "at the contact alone";
  EXPECT_THAT(alarms(2, {.touch = 0}), ::testing::ElementsAre(0)) << "without a threshold at once";
}

/// The last frame of a scene whose chain has no faults, and the profile.
std::pair<std::vector<float>, SensorProfile> last_frame(const std::string& path) {
  OpenSource opened =
      open_source("simulate:" + path + "?rate=100&paced=0&noise=0&gain_spread=0&time_constant=0", "", "");
  hw::Decoder decoder(opened.profile.format());
  std::vector<float> frame(opened.profile.map.places());
  while (const auto packet = opened.source->wait(0))
    decoder.feed(packet->bytes,
                 [&](const hw::DecodedFrame& decoded) { opened.profile.map.apply(decoded.values, frame); });
  return {frame, opened.profile};
}

TEST(SimulatedSensor, APadGivesItsSceneBackInTheOrderOfNetworks) {
  const std::string pad = source_file("examples/pad.toml");
  const auto [frame, profile] = last_frame(pad);
  ASSERT_EQ(profile.pads.size(), 1u);
  EXPECT_THAT(profile.pads[0].tactels, ::testing::ElementsAre(4, 4));
  EXPECT_THAT(profile.pads[0].pitch, ::testing::ElementsAre(4.7, 4.7));
  ASSERT_EQ(frame.size(), 48u);
  const auto scene = std::get<fem::PadScene>(read_any_scene(pad));
  const Eigen::MatrixX3d stress = solve(scene, {}).solution.steps.back().stress;
  for (Eigen::Index i = 0; i < 48; ++i)
    EXPECT_NEAR(frame[static_cast<std::size_t>(i)], stress(i % 16, i / 16), 0.51 * profile.map.calibration.gain[0]);
  EXPECT_GT(frame[16 + 10], 0) << "dragged to +x";
}

TEST(SimulatedSensor, APadOfOneAxisSendsNormalStressesAlone) {
  const ScratchFolder folder;
  std::string text = text_of(source_file("examples/pad.toml"));
  text.replace(text.find("tactels ="), 0, "axes = 1\n");
  const auto [frame, profile] = last_frame(folder.write("one.toml", text));
  EXPECT_EQ(frame.size(), 16u);
  EXPECT_TRUE(profile.map.shear.empty() && profile.map.shear_y.empty());
  EXPECT_THROW(open_source("simulate:" + source_file("examples/pad.toml") + "?tactels=8", "", ""), ConfigError);
}

}  // namespace tactel::host::simulated_sensor_test
