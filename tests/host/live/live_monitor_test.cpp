// SPDX-License-Identifier: Apache-2.0
#include "host/live/live_monitor.h"

#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <optional>
#include <random>

#include "host/support/errors.h"
#include "hw/formats.h"
#include "tests/host/live/shear_network.h"
#include "tests/host/live/simulated_frames.h"
#include "tests/thrown_message.h"

namespace tactel::host::live_monitor_test {

using ::testing::HasSubstr;

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

std::vector<float> answers(const MonitorOptions& options, hw::FrameSource& source, const SensorProfile& profile,
                           MonitorSummary& summary) {
  LiveMonitor monitor(network(21), profile, options);
  std::vector<float> all;
  summary = monitor.run(source, {.line = [&](const MonitorLine& line) { all.push_back(line.answer.slip_index); }});
  return all;
}

TEST(LiveMonitor, LateFramesAreDroppedAndCounted) {
  const auto [bytes, profile] = simulated_bytes();
  MonitorSummary summary;
  GivenSource late(bytes, true, 0.2);  // 0.2 s old, 0.1 s is allowed
  EXPECT_TRUE(answers({}, late, profile, summary).empty());
  EXPECT_EQ(summary.late, 321u);
  EXPECT_EQ(summary.decoder.frames, 321u);

  GivenSource in_time(bytes, true, 0.05);
  EXPECT_EQ(answers({}, in_time, profile, summary).size(), 321u);
  EXPECT_EQ(summary.late, 0u);

  GivenSource replayed(bytes, false, 0.2);
  EXPECT_EQ(answers({}, replayed, profile, summary).size(), 321u) << "a recording is never late";
}

/// A live source by a script: at each wait the clock goes to a time, and a frame may come that is older.
class ScriptedSource final : public hw::FrameSource {
 public:
  struct Turn {
    double now = 0;                   ///< s
    std::optional<double> arrival{};  ///< s, of a frame; none: nothing came
  };
  explicit ScriptedSource(std::vector<Turn> turns) : ScriptedSource(std::move(turns), simulated_bytes().first, 321) {}
  /// bytes: of so many frames of one length.
  ScriptedSource(std::vector<Turn> turns, std::vector<std::uint8_t> bytes, std::size_t frames)
      : bytes_(std::move(bytes)), length_(bytes_.size() / frames), turns_(std::move(turns)) {}
  std::optional<hw::Packet> wait(double) override {
    const Turn turn = turns_[turn_++];
    now_ = turn.now;
    if (!turn.arrival) return std::nullopt;
    return hw::Packet{hw::Bytes(bytes_).subspan(length_ * frame_++, length_), *turn.arrival};
  }
  bool finished() const override { return turn_ == turns_.size(); }
  bool live() const override { return true; }
  double now() const override { return now_; }
  hw::TransportCounts counts() const override { return {}; }

 private:
  std::vector<std::uint8_t> bytes_;
  std::size_t length_;  ///< of a frame
  std::vector<Turn> turns_;
  std::size_t turn_ = 0, frame_ = 0;
  double now_ = 0;
};

std::uint64_t silences(std::vector<ScriptedSource::Turn> turns) {
  ScriptedSource source(std::move(turns));
  MonitorSummary summary;
  answers({.late = 1e9}, source, simulated_bytes().second, summary);
  return summary.silences;
}

/// Waits in vain from `from` to `to` s.
void wait_in_vain(std::vector<ScriptedSource::Turn>& turns, double from, double to) {
  const long waits = std::lround((to - from) / 0.05);
  for (long i = 1; i <= waits; ++i) turns.push_back({from + 0.05 * static_cast<double>(i)});
}

TEST(LiveMonitor, EachSilenceCountsOnce) {
  std::vector<ScriptedSource::Turn> turns{{0.0, 0.0}};
  wait_in_vain(turns, 0, 5);
  turns.push_back({5, 5.0});
  wait_in_vain(turns, 5, 5.9);
  turns.push_back({6, 6.0});
  EXPECT_EQ(silences(turns), 1u);
  wait_in_vain(turns, 6, 8);
  EXPECT_EQ(silences(turns), 2u);
}

// The reader lags by 2 s: the source was never silent.
TEST(LiveMonitor, AReaderWhoLagsHearsNoSilence) {
  std::vector<ScriptedSource::Turn> turns;
  turns.reserve(200);
  for (int i = 0; i < 200; ++i) turns.push_back({2 + 0.01 * i, 0.01 * i});
  EXPECT_EQ(silences(turns), 0u);
}

// The program was stopped for 3 s, twice; what came meanwhile waits.
TEST(LiveMonitor, APauseOfTheReaderIsNoSilence) {
  std::vector<ScriptedSource::Turn> turns{{0.0, 0.0}, {3.0}, {3.0, 0.5}, {3.0, 2.9}, {3.05}, {6.0}, {6.0, 3.1}};
  EXPECT_EQ(silences(turns), 0u);
}

/// A frame at rest, then one of contact: S of the first is NaN, its alarm value 0.
TEST(LiveMonitor, BelowTheThresholdOfTouchThereIsNoContact) {
  const auto [bytes, profile] = simulated_bytes();
  GivenSource with_threshold(bytes, false, 0);
  std::size_t contacts = 0, others = 0;
  LiveMonitor(network(21), profile, {.touch = 0.01}).run(with_threshold, {.line = [&](const MonitorLine& line) {
                                                           float largest = 0;
                                                           for (int k = 0; k < 21; ++k)
                                                             largest = std::max(largest, std::abs(line.stresses[k]));
                                                           ASSERT_TRUE(line.contact.has_value());
                                                           EXPECT_EQ(*line.contact, largest >= 0.01f)
                                                               << line.frame.number;
                                                           EXPECT_EQ(std::isnan(line.answer.slip_index),
                                                                     !*line.contact);
                                                           EXPECT_EQ(line.acted_on == 0, !*line.contact);
                                                           ++(*line.contact ? contacts : others);
                                                         }});
  EXPECT_GT(contacts, 200u);
  EXPECT_GT(others, 0u) << "the play begins at rest";
  GivenSource source(bytes, false, 0);
  SensorProfile without_noise = profile;
  without_noise.map.calibration.noise.clear();
  LiveMonitor monitor(network(21), without_noise, {});
  monitor.run(source, {.line = [](const MonitorLine& line) { EXPECT_FALSE(line.contact.has_value()); }});
}

/// A network of two frames of 16 tactels with three axes.
nn::Model pad_network(std::uint64_t seed) {
  nn::Model model = network(24);
  model.weights = nn::initial_weights(nn::Topology({96, 8, 1}), seed);
  model.scaling.history = model.history.frames = 2, model.scaling.axes = 3;
  return model;
}

/// A uSkin whose noise is a count: 7 counts of z are the threshold of touch.
SensorProfile quiet_pad() {
  SensorProfile pad = read_profile("uskin-4x4");
  pad.map.calibration.has_zero = true;
  pad.map.calibration.noise.assign(48, 1.0);
  return pad;
}

/// Answers about frames [48 a pad] from lines of numbers.
std::vector<MonitorLine> pad_lines(const std::vector<nn::Model>& networks, const SensorProfile& profile,
                                   const std::vector<std::vector<double>>& frames,
                                   const std::optional<Device>& device = {}) {
  std::vector<std::uint8_t> bytes;
  for (std::size_t i = 0; i < frames.size(); ++i) hw::append_csv_frame(i, std::nullopt, frames[i], bytes);
  GivenSource source(bytes, false, 0);
  LiveMonitor monitor(networks, profile, {}, device);
  EXPECT_TRUE(knows_touch(profile));
  std::vector<MonitorLine> lines;
  monitor.run(source, {.line = [&](const MonitorLine& line) { lines.push_back(line); }});
  return lines;
}

bool same(float a, float b) { return a == b || (std::isnan(a) && std::isnan(b)); }

// Each pad as if it were alone, with its own history and threshold; S of the line is the larger one.
TEST(LiveMonitor, TwoPadsOfALine) {
  std::mt19937 random(3);
  std::normal_distribution<double> reading(0, 200);
  std::vector<std::vector<double>> left(60, std::vector<double>(48)), right = left, both;
  for (std::size_t i = 0; i < left.size(); ++i) {
    const bool left_touches = i % 3 != 0, right_touches = i >= 20;
    for (double& value : left[i]) value = left_touches ? reading(random) : 0;
    for (double& value : right[i]) value = right_touches ? reading(random) : 0;
    both.push_back(left[i]);
    both.back().insert(both.back().end(), right[i].begin(), right[i].end());
  }
  const nn::Model first = pad_network(7), second = pad_network(8);
  const SensorProfile pads = joined_profile({quiet_pad(), quiet_pad()});
  const auto of_left = pad_lines({first}, quiet_pad(), left), of_right = pad_lines({second}, quiet_pad(), right);
  const auto of_both = pad_lines({first, second}, pads, both), by_one = pad_lines({first}, pads, both);
  ASSERT_EQ(of_both.size(), 60u);
  std::size_t left_leads = 0, right_leads = 0;
  for (std::size_t i = 0; i < 60; ++i) {
    const MonitorLine& line = of_both[i];
    ASSERT_EQ(line.pads.size(), 2u);
    EXPECT_TRUE(of_left[i].pads.empty());
    const float a = of_left[i].answer.slip_index, b = of_right[i].answer.slip_index;
    EXPECT_TRUE(same(line.pads[0].answer.slip_index, a) && same(line.pads[1].answer.slip_index, b)) << i;
    EXPECT_EQ(line.pads[0].contact, i % 3 != 0) << i;
    EXPECT_EQ(line.pads[1].contact, i >= 20) << i;
    EXPECT_EQ(line.contact, i % 3 != 0 || i >= 20) << i;
    const bool right_is_larger = std::isnan(a) || b > a;
    EXPECT_TRUE(same(line.answer.slip_index, right_is_larger ? b : a)) << i;
    EXPECT_EQ(line.acted_on, std::isnan(a) && std::isnan(b) ? 0 : line.answer.slip_index) << i;
    if (!std::isnan(a) && !std::isnan(b)) ++(right_is_larger ? right_leads : left_leads);
    EXPECT_TRUE(same(by_one[i].pads[0].answer.slip_index, a)) << i;
  }
  EXPECT_GT(left_leads, 0u);
  EXPECT_GT(right_leads, 0u);
}

// A device answers as host code does. With a bound the line has the larger upper bound and the larger S, perhaps of two
// pads, and is unlike where one is.
TEST(LiveMonitor, BoundsOfTwoPads) {
  std::mt19937 random(5);
  std::normal_distribution<double> reading(0, 200);
  nn::RowMatrix<float> learnt(60, 48);
  for (float& value : learnt.reshaped()) value = static_cast<float>(reading(random) / 600);
  nn::Model networks[] = {network(24), network(24)};
  for (std::uint64_t i = 0; i < 2; ++i) {
    networks[i].weights = nn::initial_weights(nn::Topology({48, 8, 3}), 20 + i), networks[i].scaling.axes = 3;
    networks[i].bound = nn::uncalibrated_bound(learnt, 24);
  }
  std::vector<std::vector<double>> left(60, std::vector<double>(48)), right = left, both;
  for (std::size_t i = 0; i < left.size(); ++i) {
    for (double& value : left[i]) value = reading(random);
    for (double& value : right[i]) value = i % 2 == 0 ? reading(random) : 0;
    both.push_back(left[i]);
    both.back().insert(both.back().end(), right[i].begin(), right[i].end());
  }
  const auto of_left = pad_lines({networks[0]}, quiet_pad(), left),
             of_right = pad_lines({networks[1]}, quiet_pad(), right);
  const auto of_both = pad_lines({networks[0], networks[1]}, joined_profile({quiet_pad(), quiet_pad()}), both);
  ASSERT_EQ(of_both.size(), 60u);
  const auto on_device =
      pad_lines({networks[0], networks[1]}, joined_profile({quiet_pad(), quiet_pad()}), both, Device("basic"));
  std::size_t right_leads = 0, left_leads = 0;
  for (std::size_t i = 0; i < 60; ++i) {
    for (std::size_t pad = 0; pad < 2; ++pad) {
      const Answer &host = of_both[i].pads[pad].answer, &kernel = on_device[i].pads[pad].answer;
      EXPECT_TRUE(same(host.slip_index, kernel.slip_index) && same(host.slip_upper, kernel.slip_upper)) << i;
      EXPECT_EQ(of_both[i].pads[pad].contact, on_device[i].pads[pad].contact) << i;
    }
    const Answer &a = of_left[i].answer, &b = of_right[i].answer, &line = of_both[i].answer;
    ASSERT_TRUE(of_both[i].has_bound);
    EXPECT_TRUE(same(line.slip_index, std::fmax(a.slip_index, b.slip_index))) << i;
    EXPECT_TRUE(same(line.slip_upper, std::fmax(a.slip_upper, b.slip_upper))) << i;
    EXPECT_EQ(line.unlike, a.unlike | b.unlike) << i;
    const bool right_acts = b.slip_upper > a.slip_upper;
    EXPECT_EQ(of_both[i].acted_on, right_acts ? b.slip_upper : a.slip_upper) << i;
    for (int end = 0; end < 2; ++end) EXPECT_EQ(line.slip_interval[end], (right_acts ? b : a).slip_interval[end]) << i;
    if (i % 2 == 0) ++(right_acts ? right_leads : left_leads);
  }
  EXPECT_GT(right_leads, 0u);
  EXPECT_GT(left_leads, 0u);
}

// Two pads of two tactels, whose S is known. While the pad that slips has no answer its alarm stays.
TEST(LiveMonitor, APadWithoutAnAnswerKeepsItsAlarm) {
  const SensorProfile pad = parse_profile(
      "[format]\nkind = \"csv\"\nchannels = 6\n[pad]\ntactels = [2, 1]\npitch = 4\n[channels]\nnormal = [0, 1]\n"
      "shear_x = [2, 3]\nshear_y = [4, 5]\n[calibration]\noffset = 0\ngain = 1\nnoise = 1e-3\n",
      "pad");
  struct Frame {
    float left, right;  ///< S
    bool alarm, no_answer;
  };
  const Frame frames[] = {{0.2f, 0.2f, false, false}, {0.9f, 0.2f, true, false}, {NAN, 0.2f, true, true},
                          {NAN, 0.9f, true, true},    {0.2f, 0.9f, true, false}, {0.2f, NAN, true, true},
                          {0.2f, 0.2f, false, false}, {NAN, 0.2f, false, true}};
  std::vector<std::uint8_t> bytes;
  for (const Frame& f : frames)
    hw::append_csv_frame(static_cast<std::uint64_t>(&f - frames), std::nullopt,
                         std::vector<double>{-0.1, 0, shear_of(f.left), 0, 0, 0, -0.1, 0, shear_of(f.right), 0, 0, 0},
                         bytes);
  GivenSource source(bytes, false, 0);
  LiveMonitor monitor(shear_network(3), joined_profile({pad, pad}), {.at = 0.8f});
  std::size_t i = 0;
  monitor.run(source, {.line = [&](const MonitorLine& line) {
                ASSERT_LT(i, std::size(frames));
                EXPECT_EQ(line.alarm, frames[i].alarm) << i;
                EXPECT_EQ(line.no_answer, frames[i].no_answer) << i;
                EXPECT_EQ(line.cannot_tell, frames[i].no_answer) << i;
                ++i;
              }});
  EXPECT_EQ(i, std::size(frames));
}

/// A line of two tactels in lines of numbers, MPa.
SensorProfile line_of_two() {
  return parse_profile(
      "[format]\nkind = \"csv\"\nchannels = 4\n[channels]\nnormal = [0, 1]\nshear = [2, 3]\n[calibration]\noffset = 0\n"
      "gain = 1\nnoise = 1e-3\n",
      "line");
}

// A peak of 0.05 MPa is no contact for a network that learnt 0.1 and more, but it is no rest, either.
TEST(LiveMonitor, BelowTheSmallestPeakLearntThereIsNoAnswer) {
  const SensorProfile pad = line_of_two();
  nn::Model model = shear_network();
  model.learnt.smallest_peak = 0.1f;
  std::vector<std::uint8_t> bytes;
  std::uint64_t n = 0;
  for (const double normal : {-0.001, -0.05, -0.11})
    hw::append_csv_frame(n++, std::nullopt, std::vector<double>{normal, 0, shear_of(0.9f), 0}, bytes);
  const auto contacts = [&](const MonitorOptions& options) {
    GivenSource source(bytes, false, 0);
    std::vector<bool> all;
    const MonitorSummary summary = LiveMonitor(model, pad, options).run(source, {.line = [&](const MonitorLine& line) {
                                                                          EXPECT_EQ(line.alarm, line.contact == true);
                                                                          all.push_back(*line.contact);
                                                                        }});
    EXPECT_EQ(summary.faint, options.touch ? 0u : 1u);
    return all;
  };
  EXPECT_EQ(contacts({.at = 0.8f}), (std::vector{false, false, true}));
  EXPECT_EQ(contacts({.touch = 0.01, .at = 0.8f}), (std::vector{false, true, true}));
}

// The logit of S is 8 - 10 (mu / (mu + 0.5) + 0.1 spread / (spread + 0.1) - shear). mu is read where it is 3.476 with a
// spread of 0.05: 0.3607 without shear and 0.4418 at a shear of 0.05. It is told with a spread of 0.15, and a minute
// later, by a drift of 0.2, with hypot(0.15, 0.2) = 0.25: logits of 3.209 and 3.094. The second reading counts for
// 0.25^2 / (0.25^2 + 0.15^2) = 0.7353: 0.3607 (0.4418 / 0.3607)^0.7353 = 0.4187.
TEST(LiveMonitor, FrictionIsReadFromASlideAndTrustedLessWithTime) {
  const SensorProfile pad = line_of_two();
  nn::Model model = friction_network();
  model.weights.values[2] = -1, model.weights.values[5] = 0.1f;
  constexpr std::array shears{0.0, 0.0, 0.0, 0.05, 0.0};
  std::vector<std::uint8_t> bytes;
  for (std::size_t k = 0; k < shears.size(); ++k)
    hw::append_csv_frame(k, std::nullopt, std::vector<double>{-0.1, 0, shears[k], 0}, bytes);
  for (const std::optional<Device>& device : {std::optional<Device>(), std::optional<Device>(std::in_place, "basic")}) {
    ScriptedSource source({{0, 0.0}, {1, 1.0}, {60, 60.0}, {60, 60.0}, {60, 60.0}}, bytes, shears.size());
    LiveMonitor monitor(std::span(&model, 1), pad, {.late = 1e9, .friction_drift = 0.2}, device);
    std::vector<float> logits, read;
    int turn = 0;
    monitor.run(source,
                {.line =
                     [&](const MonitorLine& line) {
                       const float s = line.answer.slip_index;
                       logits.push_back(std::log(s / (1 - s)));
                     },
                 .calls = [&] { return MonitorCalls{.slides = turn++ == 0 || turn == 4}; },
                 .friction = [&](std::span<const float> mu) { read.insert(read.end(), mu.begin(), mu.end()); }});
    ASSERT_EQ(logits.size(), 5u);
    EXPECT_NEAR(logits[0], 2, 1e-3) << "8 - 10 (0.5 + 0.1)";
    EXPECT_NEAR(logits[1], 3.209, 5e-3);
    EXPECT_NEAR(logits[3], 3.094 + 0.5, 5e-3);
    ASSERT_EQ(read.size(), 2u);
    EXPECT_NEAR(read[0], 0.3607, 1e-3);
    EXPECT_NEAR(read[1], 0.4187, 1e-3);
  }
}

TEST(LiveMonitor, NetworksThatDoNotFitThePadsAreRefused) {
  const SensorProfile pads = joined_profile({quiet_pad(), quiet_pad()});
  const auto refused = [&](const std::vector<nn::Model>& networks, const SensorProfile& profile) {
    return thrown_message<ConfigError>([&] { LiveMonitor(networks, profile, {}); });
  };
  const nn::Model good = pad_network(1);
  EXPECT_EQ(refused({good}, pads), "no error");
  EXPECT_THAT(refused({good, good, good}, pads), HasSubstr("one network for all pads, or 2, one for each"));
  EXPECT_THAT(refused({good, good}, quiet_pad()), HasSubstr("one network"));
  EXPECT_THAT(refused({network(48)}, pads),  // 96 inputs, all of both pads
              HasSubstr("48 inputs, a normal stress and the shear along x and y for each of the 16 tactels"));
  nn::Model bounded = good;
  bounded.bound.emplace();
  EXPECT_THAT(refused({good, bounded}, pads), HasSubstr("networks that all have a bound, or none"));
}

}  // namespace tactel::host::live_monitor_test
