// SPDX-License-Identifier: Apache-2.0

// AlarmSignal::left: a rest that follows the hand, a score free of force, units and gains, and what cannot tell.
#include <gmock/gmock.h>
#include <tactel/infer.h>

#include <cmath>
#include <random>

#include "nn/infer/grip_score.h"
#include "tests/thrown_message.h"

namespace tactel::left_test {

using ::testing::HasSubstr;

/// Two by two tactels of three axes, x fastest: normal stresses, shear along x, shear along y.
using Frame = std::array<float, 12>;

/// P = 0.4 MPa, spread unevenly, shear of 0.2 P along y.
constexpr Frame held{-0.07f, -0.09f, -0.11f, -0.13f, 0.004f, -0.004f, 0.002f, -0.002f, 0.02f, 0.02f, 0.02f, 0.02f};
/// What a turning object does: pressure and shear move to one corner.
constexpr Frame turning{-0.02f, 0.01f, -0.01f, 0.02f, 0.01f, 0.02f, -0.01f, 0.01f, 0.02f, -0.01f, 0.01f, -0.02f};

Frame with(float turned, float force = 1) {
  Frame frame;
  for (std::size_t k = 0; k < frame.size(); ++k) frame[k] = force * (held[k] + turned * turning[k]);
  return frame;
}

AlarmOptions left(double rate = 60) {
  AlarmOptions options{.touch = 0.002};
  options.signal = AlarmSignal::left, options.rate = rate;
  return options;
}

/// A hand that trembles by 0.2 % of P.
class Hand {
 public:
  AlarmAnswer next(Alarm& alarm, float turned, float force = 1) {
    Frame frame = with(turned, force);
    for (float& stress : frame) stress += force * noise_(random_);
    return alarm.next(frame);
  }
  /// A second of a grip at rest.
  void rest(Alarm& alarm, int frames = 60) {
    for (int i = 0; i < frames; ++i) last = next(alarm, 0);
    EXPECT_EQ(last.rest, true);
    EXPECT_FALSE(last.on || last.cannot_tell);
  }
  AlarmAnswer last;

 private:
  std::mt19937 random_{5};
  std::normal_distribution<float> noise_{0, 0.0002f};  // of 12 numbers: sqrt(12) 0.0002 / 0.4 is 0.17 % of P
};

// Tactels at (-1, -1), (1, -1), (-1, 1), (1, 1) over sqrt 2. A slip by mu everywhere has friction mu, by a way or a
// turn.
TEST(Left, MomentsByHand) {
  const infer::PadMoments pad({4, 3, 2, 1});
  ASSERT_EQ(pad.count(), 8u);
  const Frame rest{-1, -1, -1, -1}, now{-1, -2, -3, -4, 1, 0, 0, 0, 0, 0, 0, 2};
  const infer::Change change = pad.change(now, rest);
  const double r = std::sqrt(0.5) / 10;  // over P = 10; uniform rest has no moments
  const double expected[] = {0.1, 0.2, 2 * r, 4 * r, -r, -r, 2 * r, 2 * r};
  for (std::size_t m = 0; m < 8; ++m) EXPECT_NEAR(change.moments[m], expected[m], 1e-7) << m;
  // Normal parts 0.1 .. 0.4 less 0.25: 0.15, 0.05, 0.05, 0.15.
  EXPECT_NEAR(change.pressure, 2 * std::sqrt(0.05), 1e-6);
  EXPECT_NEAR(change.shear, 2 * std::sqrt(0.01 - 0.01 / 4 + 0.04 - 0.04 / 4), 1e-6) << "less the mean of each axis";
  EXPECT_NEAR(change.moved, std::sqrt(1 + 4 + 9 + 1 + 4) / 4, 1e-6);
  const Frame way{-1, -2, -3, -4, 0.3f, 0.6f, 0.9f, 1.2f},
      turn{-1, -1, -1, -1, 0.3f, 0.3f, -0.3f, -0.3f, -0.3f, 0.3f, -0.3f, 0.3f};
  EXPECT_NEAR(pad.friction(way), 0.3, 1e-6);
  EXPECT_NEAR(pad.friction(turn), 0.3 * std::sqrt(2.0), 1e-6) << "shear of sqrt 2 times 0.3 on each tactel";
  EXPECT_EQ(infer::PadMoments({4, 1, 2, 1}).count(), 2u) << "normal stresses alone";
  EXPECT_EQ(infer::PadMoments({21, 2, 21, 1}).count(), 3u) << "a line: Q, z x, tau x";
}

// The norm by a covariance of 0.04 and -0.02, 0.02: of (0.2, 0) 1 / sqrt(1 - 1/2), by hand.
TEST(Left, NormByACovariance) {
  const std::vector<float> covariance{0.04f, -0.02f, 0.02f}, d{0.2f, 0};
  EXPECT_NEAR(infer::norm(infer::whitening(covariance, 2), std::span(d)), std::sqrt(2.0), 1e-6);
  EXPECT_TRUE(infer::whitening(std::vector<float>{1, 1, 1}, 2).empty()) << "singular";
}

// All stresses fall to a half and rise to 1.2 times: the hand eases and squeezes, and holds. A turn is heard in it.
TEST(Left, SqueezingAndEasingAreNoChange) {
  Alarm alarm(4, 3, left());
  Hand hand;
  hand.rest(alarm);
  for (int i = 0; i < 90; ++i) EXPECT_LT(alarm.next(with(0, 1 - 0.5f * static_cast<float>(i) / 90)).left, 0.2f) << i;
  for (int i = 0; i < 90; ++i) EXPECT_FALSE(alarm.next(with(0, 0.5f + 0.7f * static_cast<float>(i) / 90)).on) << i;
  for (const float force : {0.8f, 1.2f}) {  // a fall to 0.7 at once is a hand that opens
    Alarm one(4, 3, left()), other(4, 3, left());
    for (int i = 0; i < 40; ++i) one.next(with(0)), other.next(with(0));
    AlarmAnswer plain, scaled;
    for (int i = 0; i < 3; ++i) {
      const float turned = 3 + 0.001f * static_cast<float>(i);
      plain = one.next(with(turned)), scaled = other.next(with(turned, force));
    }
    EXPECT_NEAR(plain.left, scaled.left, 1e-5);
    EXPECT_TRUE(plain.on && scaled.on);
  }
}

// Another unit, another gain of all axes, a pad turned by 90 degrees or mirrored: the same numbers.
TEST(Left, UnitsAndMountingDropOut) {
  AlarmOptions counts = left();
  counts.touch = 200;  // 1e5 counts a MPa
  Alarm alarm(4, 3, left()), in_counts(4, 3, counts), turned(4, 3, left());
  std::mt19937 random(3);
  std::normal_distribution<float> noise(0, 0.0002f);
  bool on = false;
  for (int i = 0; i < 100; ++i) {
    Frame frame = with(i < 60 ? 0 : 0.02f * static_cast<float>(i - 60)), scaled, other;
    for (float& stress : frame) stress += noise(random);
    for (std::size_t k = 0; k < 12; ++k) scaled[k] = 1e5f * frame[k];
    constexpr std::size_t from[] = {2, 0, 3, 1};  // x of the turned pad is -y
    for (std::size_t t = 0; t < 4; ++t) {
      other[t] = frame[from[t]];
      other[4 + t] = -frame[8 + from[t]], other[8 + t] = frame[4 + from[t]];
    }
    const AlarmAnswer said = alarm.next(frame), same = in_counts.next(scaled), there = turned.next(other);
    EXPECT_EQ(said.rest, i >= 19) << i;
    if (said.rest != true) continue;
    EXPECT_NEAR(said.left, same.left, 1e-4 * (1 + said.left)) << i;
    EXPECT_NEAR(said.left, there.left, 1e-4 * (1 + said.left)) << i;
    EXPECT_TRUE(said.on == same.on && said.on == there.on) << i;
    on |= said.on;
  }
  EXPECT_TRUE(on);
}

// A slow creep of the grip is a new rest; a quick change is an alarm, which ends where the grip rests anew.
TEST(Left, TheRestFollows) {
  Alarm alarm(4, 3, left());
  Hand hand;
  hand.rest(alarm);
  for (int i = 0; i < 1200; ++i)
    EXPECT_FALSE(hand.next(alarm, static_cast<float>(i) / 1200).on) << i << ": 20 s of creep";
  int first = -1;
  for (int i = 0; i < 12; ++i)
    if (hand.next(alarm, 1 + 0.15f * static_cast<float>(i)).on && first < 0) first = i;
  EXPECT_GE(first, 1);
  EXPECT_LE(first, 8);
  for (int i = 0; i < 60; ++i) hand.last = hand.next(alarm, 2.65f);
  EXPECT_FALSE(hand.last.on) << "it holds again";
  EXPECT_EQ(hand.last.rest, true);
}

// At any rate of frames the window is a third of a second, and the same turn is heard within 0.1 s of one place.
TEST(Left, AnyRate) {
  double first_at[4];
  for (std::size_t r = 0; r < 4; ++r) {
    const double rate = std::array{30.0, 60.0, 250.0, 1000.0}[r];
    Alarm alarm(4, 3, left(60));
    alarm.rate(rate);
    Hand hand;
    const int second = static_cast<int>(rate);
    hand.rest(alarm, 2 * second);
    int i = 0;
    while (i < second && !hand.next(alarm, 2 * static_cast<float>(i) / static_cast<float>(second)).on) ++i;
    first_at[r] = i / rate;
  }
  for (const double at : first_at) EXPECT_NEAR(at, first_at[1], 0.1);
}

// A third of the frames lost, a tenth repeated, spikes of one frame, a tactel that reads 0.
TEST(Left, LostRepeatedAndWildFrames) {
  Alarm alarm(4, 3, left());
  Hand hand;
  std::mt19937 random(9);
  std::uniform_real_distribution<float> share(0, 1);
  Frame last = with(0);
  int spikes = 0;
  for (int i = 0; i < 400; ++i) {
    if (share(random) < 0.3f) continue;
    Frame frame = share(random) < 0.1f ? last : with(0);
    last = frame;
    if (share(random) < 0.05f) frame[static_cast<std::size_t>(i) % 12] += 0.1f, ++spikes;
    frame[3] = frame[7] = frame[11] = 0;
    EXPECT_FALSE(alarm.next(frame).on) << i;
  }
  EXPECT_GT(spikes, 5);
  AlarmAnswer said;
  for (int i = 0; i < 20; ++i) {
    Frame frame = with(0.1f * static_cast<float>(i));
    frame[3] = frame[7] = frame[11] = 0;
    said = alarm.next(frame);
  }
  EXPECT_TRUE(said.on);
}

// The hand opens within 0.3 s, all tactels one after the other. Then a lighter grip rests anew.
TEST(Left, AHandThatOpensIsReleased) {
  Alarm alarm(4, 3, left());
  Hand hand;
  hand.rest(alarm);
  bool released = false;
  for (int i = 0; i < 24; ++i) {
    const AlarmAnswer said = alarm.next(with(0, std::max(0.0f, 1 - static_cast<float>(i) / 18)));
    EXPECT_FALSE(said.on) << i;
    released |= said.released;
    EXPECT_TRUE(i < 8 || i >= 18 || said.released) << i << ": 0.61 of P, 0.69 of that a twelfth of a second ago";
    if (i < 18) continue;
    EXPECT_EQ(said.contact, false);
    EXPECT_TRUE(i < 21 || (said.released && said.rest == false)) << i;
    EXPECT_FALSE(said.cannot_tell);
  }
  EXPECT_TRUE(released);
  for (int i = 0; i < 60; ++i) {
    const AlarmAnswer said = hand.next(alarm, 0, 0.3f * std::min(1.0f, static_cast<float>(i) / 12));
    EXPECT_FALSE(said.on) << i;
    EXPECT_TRUE(i < 5 || !said.released) << i;
    EXPECT_TRUE(i < 50 || said.rest == true) << i;
  }
}

// What the rubber remembers after a release, 3 % of P, is no rest of the next grip.
TEST(Left, MemoryOfTheRubberIsNoGrip) {
  Alarm alarm(4, 3, left());
  Hand hand;
  hand.rest(alarm);
  for (int i = 0; i < 60; ++i) {
    const AlarmAnswer said = alarm.next(with(-3, 0.03f + 1e-5f * static_cast<float>(i % 3)));
    EXPECT_EQ(said.released, i > 0) << i << ": the median of three";
    EXPECT_FALSE(said.on || said.cannot_tell) << i;
    EXPECT_EQ(said.contact, true);
  }
  for (int i = 0; i < 60; ++i)
    EXPECT_FALSE(hand.next(alarm, 0, std::min(1.0f, 0.03f + static_cast<float>(i) / 10)).on) << i;
}

// D of a turn by a covariance of 1e-4 each, by hand; at is three quarters of it.
TEST(Left, AHoldLowersTheThreshold) {
  const Frame a = with(0), b = with(0.3f);
  const infer::Change change = infer::PadMoments({4, 3, 2, 1}).change(b, a);
  double square = 0;
  for (const double m : change.moments) square += m * m;
  AlarmOptions options = left();
  for (std::size_t i = 0; i < 8; ++i) options.held.covariance[i * (i + 3) / 2] = 1e-4f;
  options.held.at = static_cast<float>(0.75 * std::sqrt(square) / 0.01);
  Alarm with_hold(4, 3, options), without(4, 3, left());
  AlarmAnswer said, plain;
  for (int i = 0; i < 40; ++i) with_hold.next(a), without.next(a);
  for (int i = 0; i < 3; ++i) said = with_hold.next(b), plain = without.next(b);
  EXPECT_NEAR(said.left, 0.95 / 0.75, 1e-3) << "one of the twenty frames of the rest is the new one";
  EXPECT_TRUE(said.on);
  EXPECT_LT(plain.left, 1);
  EXPECT_FALSE(plain.on);
}

// Q / P is 0.2; it slides at 0.5, told or read. Full from 0.75 of it on: left is share squared of what it was, or the
// share.
TEST(Left, ARememberedSlide) {
  AlarmOptions options = left();
  options.slide = 0.4f;
  Alarm told(4, 3, options), without(4, 3, left());
  const double q = infer::PadMoments({4, 3, 2, 1}).friction(held);
  AlarmAnswer said = told.next(held);
  EXPECT_EQ(said.rest, false);
  EXPECT_NEAR(said.index, q / 0.4, 1e-5);
  EXPECT_NEAR(said.left, q / 0.4 / 0.6, 1e-5) << "before there is a rest the index alone";
  EXPECT_FALSE(said.cannot_tell);
  AlarmAnswer plain;
  for (int i = 0; i < 43; ++i) said = told.next(with(i < 40 ? 0 : 0.5f)), plain = without.next(with(i < 40 ? 0 : 0.5f));
  EXPECT_NEAR(said.left, plain.left * std::pow(said.index / 0.6, 3), 1e-5);
  EXPECT_TRUE(std::isnan(plain.index));
  EXPECT_NEAR(without.slides(), plain.answer.status == AnswerStatus::ok ? 0.4 * said.index : 0, 0.02);
  EXPECT_NEAR(without.next(with(0.5f)).index, 1, 0.1);
}

// NaN in one of twelve numbers: it cannot tell, and the others are still heard.
TEST(Left, ADeadChannelCannotTell) {
  Alarm alarm(4, 3, left());
  Hand hand;
  hand.rest(alarm);
  AlarmAnswer said;
  const auto dead = [&](float turned) {
    Frame frame = with(turned);
    frame[5] = NAN;
    return alarm.next(frame);
  };
  for (int i = 0; i < 60; ++i) {
    said = dead(0);
    EXPECT_TRUE(said.cannot_tell && !said.on) << i;
    EXPECT_EQ(said.why, CannotTell::not_a_number);
    EXPECT_EQ(said.contact, true);
  }
  for (int i = 0; i < 6; ++i) said = dead(2);
  EXPECT_TRUE(said.on && said.cannot_tell);
}

// After noise, twelve equal frames say that the cable is out, of every signal; the first that differs ends it.
TEST(Left, AFrozenSensorCannotTell) {
  AlarmOptions moved{.at = 0.1f, .touch = 0.002};
  moved.signal = AlarmSignal::moved;
  for (const AlarmOptions& options : {left(), moved}) {
    Alarm alarm(4, 3, options);
    Hand hand;
    hand.rest(alarm, 100);
    const Frame last = with(0.01f);
    for (int i = 0; i < 40; ++i) {
      const AlarmAnswer said = alarm.next(last);
      EXPECT_EQ(said.why == CannotTell::frozen, i > 10) << i;
      EXPECT_EQ(said.cannot_tell, i > 10) << i;
    }
    EXPECT_FALSE(hand.next(alarm, 0).cannot_tell);
  }
}

// z counts downwards under pressure: said in every frame that touches, of every signal.
TEST(Left, AWrongSignCannotTell) {
  const SlipEstimator network = SlipEstimator::load("uskin-4x4");
  Alarm by_left(4, 3, left()), by_network(network, {.touch = 0.002});
  std::mt19937 random(2);
  std::normal_distribution<float> noise(0, 0.0002f);
  for (int i = 0; i < 60; ++i) {
    Frame frame = with(0, -1);
    std::vector<float> large(48, 0.02f);
    for (float& stress : large) stress += noise(random);
    for (float& stress : frame) stress += noise(random);
    const AlarmAnswer said[] = {by_left.next(frame), by_network.next(large)};
    for (const AlarmAnswer& one : said) {
      EXPECT_TRUE(one.cannot_tell) << i;
      EXPECT_EQ(one.why, CannotTell::wrong_sign) << name(one.why);
    }
    EXPECT_FALSE(said[0].on);
  }
}

// Pads of normal stresses alone, and of 2 x 4 to 8 x 8 tactels.
TEST(Left, OtherPads) {
  const std::array<std::size_t, 3> pads[] = {{2, 4, 3}, {8, 8, 3}, {4, 4, 1}, {6, 4, 1}, {1, 10, 2}};
  for (const auto& [rows, columns, axes] : pads) {
    AlarmOptions options = left();
    options.columns = columns;
    Alarm alarm(rows * columns, axes, options);
    std::mt19937 random(1);
    std::normal_distribution<float> noise(0, 2e-5f);
    const auto next = [&](float shift) {
      std::vector<float> frame(alarm.inputs());
      const std::size_t n = rows * columns;
      for (std::size_t k = 0; k < frame.size(); ++k) {
        const float x = static_cast<float>(k % columns) / static_cast<float>(columns) - 0.5f;
        frame[k] = (k < n ? -0.02f * (1 + shift * x) : 0.01f * shift * (1 + x)) + noise(random);
      }
      return alarm.next(frame);
    };
    AlarmAnswer said;
    for (int i = 0; i < 60; ++i) said = next(0);
    EXPECT_TRUE(said.rest == true && !said.on && !said.cannot_tell) << rows << ' ' << columns << ' ' << axes;
    for (int i = 0; i < 12; ++i) said = next(0.08f * static_cast<float>(i));
    EXPECT_TRUE(said.on) << rows << ' ' << columns << ' ' << axes << ' ' << said.left;
  }
}

// Of scores 2 and 1, 0.35 of the larger and 0.65 of the smaller: 1.35. A pad that does not touch says nothing.
TEST(Left, PadsOfAnObjectAreJoined) {
  AlarmAnswer pads[3];
  pads[0].score = 2, pads[0].of_hold = 0.5f, pads[0].index = 0.9f;
  pads[1].score = 1, pads[1].of_hold = 0.7f, pads[1].index = 0.6f;
  join(pads);
  for (const AlarmAnswer& pad : pads) {
    EXPECT_NEAR(pad.left, 1.35, 1e-6);
    EXPECT_EQ(pad.of_hold, 0.7f);
    EXPECT_EQ(pad.index, 0.6f);
  }
  pads[0].score = 1.25f, pads[1].score = NAN;
  pads[2].score = NAN;
  join(pads);
  EXPECT_NEAR(pads[1].left, 1.25, 1e-6);
}

TEST(Left, RefusesWhatItCannotMean) {
  const auto message = [](auto&& change) {
    AlarmOptions options = left();
    change(options);
    return thrown_message<InputError>([&] { Alarm(4, 3, options); });
  };
  EXPECT_THAT(message([](AlarmOptions& o) { o.at = 0; }), HasSubstr("at: 0"));
  EXPECT_THAT(message([](AlarmOptions& o) { o.rate = NAN; }), HasSubstr("rate: nan"));
  EXPECT_THAT(message([](AlarmOptions& o) { o.columns = 3; }), HasSubstr("columns: 3"));
  EXPECT_THAT(message([](AlarmOptions& o) { o.aspect = 0; }), HasSubstr("aspect: 0"));
  EXPECT_THAT(message([](AlarmOptions& o) { o.held.at = 3; }), HasSubstr("held.covariance"));
  EXPECT_THAT(message([](AlarmOptions& o) { o.slide = -1; }), HasSubstr("slide: -1"));
  EXPECT_THAT(message([](AlarmOptions& o) { o.touch = 0; }), HasSubstr("touch: 0"));
}

}  // namespace tactel::left_test
