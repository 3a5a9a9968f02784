// SPDX-License-Identifier: Apache-2.0

// Readings of white noise, whose offsets and noise hw::Tare measured, or which are known.
#include "host/live/drift_watch.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

namespace tactel::host::drift_watch_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using ::testing::UnorderedElementsAre;

constexpr std::size_t tactels = 21, channels = 2 * tactels;
constexpr double sigma = 3, gain = 0.001;  // the device's units, MPa by it

/// Offsets 0 and the noise of all channels known exactly; channel c is at place c of a frame.
hw::ChannelMap known_map() {
  hw::ChannelMap map;
  for (int i = 0; i < static_cast<int>(tactels); ++i)
    map.normal.push_back(i), map.shear.push_back(i + static_cast<int>(tactels));
  map.calibration = {std::vector<double>(channels, 0), std::vector<double>(channels, gain),
                     std::vector<double>(channels, sigma)};
  return map;
}

/// White noise from a pool of a million numbers, each time from another place of it.
class Noise {
 public:
  explicit Noise(unsigned seed) : random_(seed), pool_(1 << 20) {
    std::normal_distribution<double> normal;
    for (double& x : pool_) x = normal(random_);
  }
  double operator()() {
    if (left_-- == 0) at_ = random_() % pool_.size(), left_ = 1 + random_() % 4096;
    return pool_[at_++ % pool_.size()];
  }

 private:
  std::mt19937_64 random_;
  std::vector<double> pool_;
  std::size_t at_ = 0, left_ = 0;
};

/// Feeds frames of white noise at a rate to a watch. `change` alters the readings, in deviations of the noise.
struct Player {
  using Change = std::function<void(std::size_t frame, std::vector<double>& readings)>;
  DriftWatch watch;
  double rate;
  hw::ChannelMap map = known_map();
  Noise noise{7};
  std::function<bool(std::size_t)> contact = [](std::size_t) { return false; };
  std::size_t frame = 0;
  double paused = 0;  // s
  std::vector<double> readings = std::vector<double>(channels);
  std::vector<float> stresses = std::vector<float>(channels);

  std::vector<Drift> one(const Change& change = {}) {
    for (double& x : readings) x = noise();
    if (change) change(frame, readings);
    for (double& x : readings) x *= sigma;
    map.apply(readings, stresses);
    const double arrival = 5 + paused + static_cast<double>(frame) / rate;
    const bool touching = contact(frame);
    ++frame;
    return watch.next(stresses, touching, arrival);
  }
  std::vector<Drift> play(std::size_t frames, const Change& change = {}) {
    std::vector<Drift> all;
    for (std::size_t i = 0; i < frames; ++i)
      for (Drift& drift : one(change)) all.push_back(std::move(drift));
    return all;
  }
};

/// The mean of a block of 100 frames has a variance of 0.01, the offset of a tare of 100 frames another 0.01, its noise
/// 0.0083 (by neighbouring differences): together they pass 1 with erfc(1 / sqrt(2 * 0.0283)) = 3e-9. 450 000 are
/// judged here: 0.001 false warnings.
TEST(DriftWatch, HoursOfNoiseAfterATareRaiseNoWarning) {
  Noise noise(3);
  std::size_t hours = 0;
  for (int sensor = 0; sensor < 6; ++sensor) {
    hw::Tare tare(channels);
    std::vector<double> readings(channels);
    for (int frame = 0; frame < 100; ++frame) {
      for (double& x : readings) x = sigma * noise();
      tare.add(readings);
    }
    hw::ChannelMap map = known_map();
    map.calibration.offset = tare.offset();
    map.calibration.noise = tare.noise();
    Player player{.watch = DriftWatch(map, 2), .rate = 50, .map = map, .noise = Noise(40 + sensor)};
    EXPECT_THAT(player.play(50 * 3600), IsEmpty()) << sensor;
    ++hours;
  }
  EXPECT_EQ(hours, 6u);
}

/// The share of channels that are named, where the limit is so low that noise passes it: of n = 100 readings
/// erfc(0.35 sqrt(n / 2)) = 4.65e-4 a block and channel.
TEST(DriftWatch, FalseWarningsAreAsRareAsStated) {
  constexpr double limit = 0.35;
  constexpr int sensors = 20, blocks = 400;
  const double share = 1 - std::pow(1 - std::erfc(limit * std::sqrt(100 / 2.0)), blocks);
  std::size_t named = 0;
  for (int sensor = 0; sensor < sensors; ++sensor) {
    Player player{.watch = DriftWatch(known_map(), 2, limit), .rate = 50, .noise = Noise(100 + sensor)};
    for (const Drift& drift : player.play(100 * (blocks + 2) + 1)) named += drift.channels.size();
  }
  const double expected = share * sensors * channels;  // 142 of 840; their number scatters as a binomial one
  EXPECT_NEAR(static_cast<double>(named), expected, 4 * std::sqrt(expected * (1 - share)));
}

/// Blocks of 100 frames: 0 only rests, and block k is judged with the first frame after block k + 1. A shift of 1.5
/// deviations from a block's first frame on is 5 standard errors above the limit of 1.
TEST(DriftWatch, AShiftIsNamedAfterTwoBlocks) {
  Player player{.watch = DriftWatch(known_map(), 1), .rate = 100};
  const Player::Change shift = [](std::size_t frame, std::vector<double>& readings) {
    if (frame >= 1000) readings[4] += 1.5, readings[30] -= 3;
  };
  EXPECT_THAT(player.play(1200, shift), IsEmpty());
  const std::vector<Drift> found = player.play(1, shift);
  ASSERT_THAT(found, SizeIs(1));
  EXPECT_EQ(found[0].kind, Drift::Kind::offset);
  EXPECT_THAT(found[0].channels, ElementsAre(30, 4)) << "the worst first";
  EXPECT_NEAR(found[0].size, 3, 0.4);  // the mean of 100 readings scatters by 0.1
  EXPECT_THAT(found[0].text,
              HasSubstr("channel 30 (shear stress of tactel 9), channel 4 (normal stress of tactel 4);"));
  EXPECT_THAT(found[0].text, HasSubstr("tactel tare"));
  EXPECT_THAT(player.play(5000, shift), IsEmpty()) << "each channel is named once";
}

TEST(DriftWatch, AShiftWithinTheNoiseIsTolerated) {
  Player player{.watch = DriftWatch(known_map(), 1), .rate = 100};
  EXPECT_THAT(player.play(100000, [](std::size_t, std::vector<double>& readings) { readings[4] += 0.5; }), IsEmpty());
}

/// 0.1 deviations a second pass the limit in the block whose middle is at 10 s.
TEST(DriftWatch, ASlowDriftIsNamedAsItPassesTheNoise) {
  Player player{.watch = DriftWatch(known_map(), 1), .rate = 100};
  std::size_t at = 0;
  while (at < 3000 && player
                          .one([](std::size_t frame, std::vector<double>& readings) {
                            readings[0] += 0.001 * static_cast<double>(frame);
                          })
                          .empty())
    ++at;
  EXPECT_GE(at, 900u + 200);  // the standard error of a block is 0.1, a second of drift
  EXPECT_LE(at, 1300u + 200);
}

TEST(DriftWatch, GrownNoiseIsNoShift) {
  Player player{.watch = DriftWatch(known_map(), 1), .rate = 100};
  player.contact = [&](std::size_t) {  // by the threshold of touch: a reading of 2.3 of its deviations passes it
    return std::any_of(player.readings.begin(), player.readings.begin() + tactels,
                       [](double x) { return std::abs(x) >= 7 * sigma; });
  };
  const std::vector<Drift> found = player.play(1000, [](std::size_t, std::vector<double>& readings) {
    readings[7] *= 3;  // the mean of 100 scatters by 0.3; the deviation is found within a tenth
  });
  ASSERT_THAT(found, SizeIs(1));
  EXPECT_EQ(found[0].kind, Drift::Kind::noise);
  EXPECT_THAT(found[0].channels, ElementsAre(7));
  EXPECT_NEAR(found[0].size, 3, 0.6);
  EXPECT_THAT(found[0].text, HasSubstr("check cable"));
}

TEST(DriftWatch, AStuckChannelIsNamedInContactToo) {
  Player player{.watch = DriftWatch(known_map(), 1), .rate = 100, .contact = [](std::size_t) { return true; }};
  const Player::Change stuck = [](std::size_t frame, std::vector<double>& readings) {
    if (frame >= 500) readings[2] = 4, readings[3] = std::nan("");
  };
  EXPECT_THAT(player.play(1000, stuck), IsEmpty());
  const std::vector<Drift> found = player.play(120, stuck);
  ASSERT_THAT(found, SizeIs(1));
  EXPECT_EQ(found[0].kind, Drift::Kind::stuck);
  EXPECT_THAT(found[0].channels, UnorderedElementsAre(2, 3));
}

/// A board that samples at 5 Hz and sends at 100 Hz, and stops sending for a minute.
TEST(DriftWatch, APauseIsNoStuckChannel) {
  Player player{.watch = DriftWatch(known_map(), 2), .rate = 100};
  std::vector<double> held(channels);
  const Player::Change hold = [&](std::size_t frame, std::vector<double>& readings) {
    if (frame % 20 == 0) held = readings;
    readings = held;
  };
  EXPECT_THAT(player.play(510, hold), IsEmpty());
  player.paused = 60;
  EXPECT_THAT(player.play(3000, hold), IsEmpty());
}

/// One frame a second, of whole numbers with a noise of 0.8: a tenth of five blocks' ten readings stay the same three
/// times, as 0.37 of the neighbours are equal. A channel that is stuck indeed is named after 320 readings.
TEST(DriftWatch, FewReadingsASecondAreNotStuck) {
  hw::ChannelMap map = known_map();
  map.calibration.noise.assign(channels, 0.8);
  Player player{.watch = DriftWatch(map, 2), .rate = 1, .map = map};
  bool stuck = false;
  const Player::Change whole = [&](std::size_t, std::vector<double>& readings) {
    for (double& x : readings) x = std::round(0.8 * x) / sigma;
    if (stuck) readings[5] = 2 / sigma;
  };
  EXPECT_THAT(player.play(20000, whole), IsEmpty());
  stuck = true;
  EXPECT_THAT(player.play(319, whole), testing::Each(testing::Field(&Drift::kind, testing::Ne(Drift::Kind::stuck))));
  const std::vector<Drift> found = player.play(10, whole);
  EXPECT_THAT(found, testing::Contains(testing::Field(&Drift::kind, Drift::Kind::stuck)));
}

/// Touches that begin and end slowly, below the threshold of touch of 7 deviations, within the blocks beside them.
TEST(DriftWatch, TouchesAreNoDrift) {
  Player player{.watch = DriftWatch(known_map(), 1), .rate = 100};
  const auto press = [](std::size_t frame) {  // deviations: up and down within 4 of 10 s
    const double t = static_cast<double>(frame % 1000) / 100;
    return t < 4 ? 20 * std::min(t, 4 - t) : 0;
  };
  player.contact = [&](std::size_t frame) { return press(frame) >= 7; };
  EXPECT_THAT(player.play(20000,
                          [&](std::size_t frame, std::vector<double>& readings) {
                            for (double& x : readings) x += press(frame);
                          }),
              IsEmpty());
}

/// The last bit may toggle or change: a tare of readings that rarely change gives half a step as noise.
TEST(DriftWatch, AChangeOfTheLastBitIsTolerated) {
  hw::ChannelMap map = known_map();
  map.calibration.noise.assign(channels, 0.5);
  Player player{.watch = DriftWatch(map, 1), .rate = 100, .map = map};
  const auto play = [&](double bits) {
    return player.play(2000, [&](std::size_t frame, std::vector<double>& readings) {
      for (double& x : readings) x = (bits + (frame % 997 == 0)) / sigma;
    });
  };
  EXPECT_THAT(play(0), IsEmpty());
  EXPECT_THAT(play(1), IsEmpty());
  EXPECT_THAT(play(3), SizeIs(1));
}

TEST(DriftWatch, WithoutNoiseInTheCalibrationThereIsNothingToWatch) {
  hw::ChannelMap map = known_map();
  map.calibration.noise.clear();
  Player player{.watch = DriftWatch(map, 1), .rate = 100, .map = map};
  EXPECT_THAT(player.play(1000, [](std::size_t, std::vector<double>& readings) { readings[0] += 9; }), IsEmpty());
}

}  // namespace tactel::host::drift_watch_test
