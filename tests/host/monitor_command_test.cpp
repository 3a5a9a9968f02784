// tactel monitor, record and tare as a user runs them, on a simulated sensor.
#include <gmock/gmock.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "host/forward.h"
#include "host/live_monitor.h"
#include "host/onnx_file.h"
#include "host/open_source.h"
#include "host/scene_file.h"
#include "host/simulated_sensor.h"
#include "nn/weights.h"
#include "tests/host/network_cases.h"
#include "tests/host/run_tactel.h"

namespace tactel::host {
namespace {

using ::testing::HasSubstr;

/// An untrained network: any S will do to follow frames through.
nn::Model network(int tactels) {
  const nn::Topology topology({2 * tactels, 2 * tactels, 1});
  return {nn::initial_weights(topology, 7), {nn::ScalingKind::frame, 1.0f}, 7, 0, "", 0, {}};
}

const std::string scene = source_file("examples/parabola.toml");
/// As fast as it is taken: 1 + 320 frames.
const std::string simulation = "simulate:" + scene + "?rate=100&paced=0";

std::vector<nlohmann::json> lines_of(const std::string& text) {
  std::vector<nlohmann::json> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(nlohmann::json::parse(line));
  return lines;
}

class Monitor : public ::testing::Test {
 protected:
  ScratchFolder folder_;
  std::string network_ = (folder_ / "n.onnx").string(), recording_ = (folder_ / "r.tactel").string();
  Monitor() { write_onnx(network_, network(21)); }
};

TEST_F(Monitor, GivesALineForEachFrameAndASummary) {
  const ChildResult result = run_tactel({"monitor", "--source", simulation, "--network", network_});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto lines = lines_of(result.out);
  ASSERT_EQ(lines.size(), 321u);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    EXPECT_EQ(lines[i]["frame"], i);
    EXPECT_NEAR(lines[i]["device_time"].get<double>(), 0.01 * static_cast<double>(i), 1e-6);
    EXPECT_GE(lines[i]["latency_us"].get<double>(), 0);
    const double s = lines[i]["slip_index"];
    EXPECT_TRUE(s > 0 && s < 1);
  }
  const auto summary = lines_of(result.err).back();
  EXPECT_EQ(summary["frames"], 321);
  for (const char* key : {"lost", "bad", "resynchronised", "late"}) EXPECT_EQ(summary[key], 0) << key;
  for (const char* key : {"p50", "p99", "p99.9", "max"}) EXPECT_TRUE(summary["latency_us"].contains(key)) << key;
}

TEST_F(Monitor, ARecordingReplaysToTheSameFramesAndTheSameS) {
  const ChildResult recorded =
      run_tactel({"record", "--source", simulation, "--output", recording_, "--frames", (folder_ / "a.csv").string()});
  ASSERT_EQ(recorded.exit_code, 0) << recorded.err;
  const std::string replay = "replay:" + recording_;
  const ChildResult again = run_tactel({"record", "--source", replay, "--output", (folder_ / "again.tactel").string(),
                                        "--frames", (folder_ / "b.csv").string()});
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(text_of(folder_ / "a.csv"), text_of(folder_ / "b.csv"));
  EXPECT_EQ(text_of(recording_), text_of(folder_ / "again.tactel"));

  const auto live = lines_of(run_tactel({"monitor", "--source", simulation, "--network", network_}).out);
  const auto replayed = lines_of(run_tactel({"monitor", "--source", replay, "--network", network_}).out);
  ASSERT_EQ(live.size(), replayed.size());
  for (std::size_t i = 0; i < live.size(); ++i) {
    EXPECT_EQ(live[i]["slip_index"].get<double>(), replayed[i]["slip_index"].get<double>()) << i;
    EXPECT_EQ(live[i]["device_time"], replayed[i]["device_time"]) << i;
  }
}

TEST_F(Monitor, EveryThinsTheLinesAndViewDrawsThem) {
  const auto thinned =
      run_tactel({"monitor", "--source", simulation, "--network", network_, "--every", "100", "--quiet"});
  EXPECT_EQ(lines_of(thinned.out).size(), 4u);
  const auto view = run_tactel({"monitor", "--source", simulation, "--network", network_, "--view"});
  EXPECT_EQ(view.exit_code, 0);
  EXPECT_THAT(view.out, HasSubstr("normal |"));
}

TEST_F(Monitor, WrongInputIsNamed) {
  write_onnx(folder_ / "eight.onnx", network(8));
  const auto width = run_tactel({"monitor", "--source", simulation, "--network", (folder_ / "eight.onnx").string()});
  EXPECT_EQ(width.exit_code, 2);
  EXPECT_THAT(width.err, HasSubstr("42 inputs"));
  EXPECT_EQ(run_tactel({"monitor", "--source", "replay:" + network_, "--network", network_}).exit_code, 2);
  EXPECT_EQ(run_tactel({"monitor", "--source", "usb:mitten", "--network", network_}).exit_code, 2);
  const auto absent = run_tactel({"monitor", "--source", "usb:glove", "--network", network_});
  EXPECT_EQ(absent.exit_code, 3) << absent.err;
  EXPECT_THAT(absent.err, HasSubstr("plugged in"));
}

TEST_F(Monitor, TareWritesTheOffsetsAtRest) {
  const std::string rest = "simulate:" + scene + "?paced=0&press=9&hold=0&drag=0&slip=0&noise=0";
  const std::string calibration = (folder_ / "c.toml").string();
  const auto tared = run_tactel({"tare", "--source", rest, "--output", calibration});
  ASSERT_EQ(tared.exit_code, 0) << tared.err;
  const auto used =
      run_tactel({"monitor", "--source", simulation, "--network", network_, "--calibration", calibration});
  EXPECT_EQ(used.exit_code, 0) << used.err;
}

/// A source that hands out what it is given, in one packet, as old as it is told.
class GivenSource final : public hw::FrameSource {
 public:
  GivenSource(std::vector<std::uint8_t> bytes, bool live, double age)
      : bytes_(std::move(bytes)), live_(live), age_(age) {}
  std::optional<hw::Packet> wait(double) override {
    done_ = true;
    return hw::Packet{bytes_, 0.0};
  }
  bool finished() const override { return done_; }
  bool live() const override { return live_; }
  double now() const override { return age_; }
  hw::TransportCounts counts() const override { return {}; }

 private:
  std::vector<std::uint8_t> bytes_;
  bool live_, done_ = false;
  double age_;
};

/// The bytes of the simulation and the profile that reads them.
std::pair<std::vector<std::uint8_t>, SensorProfile> simulated_bytes() {
  OpenSource opened = open_source(simulation, "", "");
  std::vector<std::uint8_t> bytes;
  while (const auto packet = opened.source->wait(0))
    bytes.insert(bytes.end(), packet->bytes.begin(), packet->bytes.end());
  return {bytes, opened.profile};
}

std::vector<float> answers(const MonitorOptions& options, hw::FrameSource& source, const SensorProfile& profile,
                           MonitorSummary& summary) {
  LiveMonitor monitor(tactel::testing::executor(), network(21), profile, options);
  std::vector<float> all;
  summary = monitor.run(source, {.line = [&](const MonitorLine& line) { all.push_back(line.answer.slip_index); }});
  return all;
}

TEST(LiveMonitor, ABatchAnswersAsSingleFramesDo) {
  const auto [bytes, profile] = simulated_bytes();
  MonitorSummary batched, single;
  GivenSource first(bytes, false, 0), second(bytes, false, 0);
  const auto in_batch = answers({}, first, profile, batched);
  const auto one_by_one = answers({.batch_from = 100000}, second, profile, single);
  ASSERT_EQ(in_batch.size(), 321u);
  EXPECT_EQ(batched.batched, 321u);
  EXPECT_EQ(single.batched, 0u);
  EXPECT_EQ(in_batch, one_by_one);
}

TEST(LiveMonitor, LateFramesAreDroppedAndCounted) {
  const auto [bytes, profile] = simulated_bytes();
  MonitorSummary summary;
  GivenSource late(bytes, true, 0.2);  // 0.2 s old, 0.1 s is allowed
  EXPECT_TRUE(answers({}, late, profile, summary).empty());
  EXPECT_EQ(summary.late, 321u);
  EXPECT_EQ(summary.decoder.frames, 321u);

  GivenSource too_many(bytes, true, 0.0);
  EXPECT_EQ(answers({.queue = 100}, too_many, profile, summary).size(), 100u);
  EXPECT_EQ(summary.late, 221u);

  GivenSource replayed(bytes, false, 0.2);
  EXPECT_EQ(answers({}, replayed, profile, summary).size(), 321u) << "a recording is never late";
}

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

}  // namespace
}  // namespace tactel::host
