// SPDX-License-Identifier: Apache-2.0

// Frames of a sensor, one after the other: `tactel monitor` and tactel::SlipHistory take the same ones.
#include <gtest/gtest.h>
#include <tactel/infer.h>

#include "host/live/live_monitor.h"
#include "host/support/errors.h"
#include "nn/infer/network_file.h"
#include "tests/host/live/simulated_frames.h"

namespace tactel::host::history_test {

TEST(History, MonitorTakesTheFramesOfTheLibrary) {
  const nn::Topology topology({3 * 42, 20, 1});
  nn::Model model{nn::initial_weights(topology, 7), {nn::ScalingKind::frame, 1.0f, 3}, 7, 0, "", 0, {}};
  model.history = {.frames = 3, .stride = 2, .change = 0.05};
  const std::string file = infer::network_bytes(model);
  const SlipEstimator estimator = SlipEstimator::parse(std::as_bytes(std::span(file)));
  OpenSource moving = open_source(simulation, "", "");
  LiveMonitor monitor(model, moving.profile, {.touch = 0.0});  // the library answers every frame
  SlipHistory history(estimator);
  std::size_t frames = 0, differ = 0;
  float last = 0;
  const auto compare = [&](const MonitorLine& line) {
    const float expected = history.estimate(line.stresses).slip_index;
    EXPECT_TRUE(line.answer.slip_index == expected || std::isnan(expected)) << frames;
    ++frames, differ += expected != last, last = expected;
  };
  monitor.run(*moving.source, {.line = compare});
  EXPECT_EQ(frames, 321u);
  EXPECT_GT(differ, 100u);
  // and the profile's 21 tactels must fit
  nn::Model narrow = model;
  narrow.weights = nn::initial_weights(nn::Topology({3 * 40, 20, 1}), 7);
  const OpenSource opened = open_source(simulation, "", "");
  EXPECT_THROW(LiveMonitor(narrow, opened.profile, {}), ConfigError);
}

}  // namespace tactel::host::history_test
