// SPDX-License-Identifier: Apache-2.0

// The plain transducer chain against closed forms and hand calculation.
#include "nn/transducer_chain.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>

#include "fem/numbers/value_error.h"

namespace tactel::nn::transducer_chain_test {

RowMatrix<double> signal(int steps, const std::function<double(int)>& stress) {
  RowMatrix<double> out(steps, 2);
  for (int k = 0; k < steps; ++k) out.row(k) << stress(k), -3 * stress(k);
  return out;
}

TEST(Transducer, NothingMeansNothing) {
  const Transducer none;
  EXPECT_FALSE(none.present());
  EXPECT_EQ(description(none), "none");
  const auto stress = signal(5, [](int k) { return 0.1 * k - 0.2; });
  EXPECT_EQ(transducer_chain(none, 1, 2, stress), stress);
}

// Steps at t = h, 2 h, ...; a ramp of slope s charges the amplifier to s tau (1 - e^(-t / tau)).
TEST(Transducer, ARampSettlesAtItsSlopeTimesTau) {
  for (const double h : {0.01, 0.3, 2.0}) {
    const Transducer t{.time_constant = 1.7, .step_time = h};
    const auto reading = transducer_chain(t, 0, 0, signal(50, [&](int k) { return 0.4 * h * (k + 1); }));
    for (int k = 0; k < 50; ++k) {
      const double expected = 0.4 * 1.7 * (1 - std::exp(-h * (k + 1) / 1.7));
      EXPECT_NEAR(reading(k, 0), expected, 1e-14);  // values below 1, 50 roundings
      EXPECT_NEAR(reading(k, 1), -3 * expected, 3e-14);
    }
  }
}

// A stress that comes within the first step of h and stays leaks away as e^(-t / tau); for h << tau the reading begins
// at the stress itself.
TEST(Transducer, AHeldStressLeaksAway) {
  const Transducer t{.time_constant = 1, .step_time = 0.05};
  const auto reading = transducer_chain(t, 0, 0, signal(100, [](int) { return 0.5; }));
  for (int k = 0; k < 100; ++k)
    EXPECT_NEAR(reading(k, 0), 0.5 * (1 - std::exp(-0.05)) / 0.05 * std::exp(-0.05 * k), 1e-14);
  const Transducer quick{.time_constant = 1, .step_time = 1e-5};
  EXPECT_NEAR(transducer_chain(quick, 0, 0, signal(1, [](int) { return 0.5; }))(0, 0), 0.5, 0.5 * 1e-5);
}

// Three bits over -1 ... 1: readings -1, -0.75, ... 0.75.
TEST(Transducer, ConvertsByHand) {
  const Transducer t{.range = 1, .bits = 3};
  const double in[] = {0, 0.12, 0.13, -0.13, 0.374, 0.376, 0.8, 0.9, 5, -0.9, -5},
               out[] = {0, 0, 0.25, -0.25, 0.25, 0.5, 0.75, 0.75, 0.75, -1, -1};
  for (int k = 0; k < 11; ++k)
    EXPECT_EQ(transducer_chain(t, 0, 0, signal(1, [&](int) { return in[k]; }))(0, 0), out[k]) << in[k];
  const Transducer cut{.range = 1};
  EXPECT_EQ(transducer_chain(cut, 0, 0, signal(1, [](int) { return 0.4; })),
            signal(1, [](int) { return 0.4; }).cwiseMax(-1));
  const auto nothing =
      transducer_chain(t, 0, 0, signal(1, [](int) { return std::numeric_limits<double>::quiet_NaN(); }));
  EXPECT_TRUE(std::isnan(nothing(0, 0)));
}

struct Moments {
  double mean = 0, deviation = 0, fourth = 0;
};
Moments moments(const std::vector<double>& x) {
  Moments m;
  for (const double v : x) m.mean += v / x.size();
  for (const double v : x) m.deviation += std::pow(v - m.mean, 2) / x.size();
  for (const double v : x) m.fourth += std::pow(v - m.mean, 4) / x.size() / (m.deviation * m.deviation);
  m.deviation = std::sqrt(m.deviation);
  return m;
}
/// n normal numbers: mean and deviation within five of their own deviations, and the kurtosis 3 within five times
/// sqrt(24 / n).
void expect_normal(const std::vector<double>& x, double mean, double deviation) {
  const double n = x.size();
  const Moments m = moments(x);
  EXPECT_NEAR(m.mean, mean, 5 * deviation / std::sqrt(n));
  EXPECT_NEAR(m.deviation, deviation, 5 * deviation / std::sqrt(2 * n));
  EXPECT_NEAR(m.fourth, 3, 5 * std::sqrt(24 / n));
}

TEST(Transducer, NoiseIsNormalAndNeverTheSameTwice) {
  const Transducer t{.noise = 0.02};
  std::vector<double> all, products;
  double before = 0;
  for (std::uint64_t contact = 0; contact < 500; ++contact) {
    const RowMatrix<double> reading = transducer_chain(t, 3, contact, RowMatrix<double>::Zero(9, 16));
    for (const double v : reading.reshaped()) {
      products.push_back(v * before);
      all.push_back(before = v);
    }
  }
  expect_normal(all, 0, 0.02);
  // Neighbours in time: the mean of n products of independent numbers spreads by 0.02^2 / sqrt(n).
  EXPECT_NEAR(moments(products).mean, 0, 5 * 4e-4 / std::sqrt(72000.0));
  std::ranges::sort(all);
  // 23 bits of each of two words: 72000 numbers share one by chance far less than once; a counter used twice would
  // double thousands.
  EXPECT_LT(all.end() - std::unique(all.begin(), all.end()), 3);
}

TEST(Transducer, GainsAndOffsetsBelongToTheSensor) {
  const Transducer own{.gain_spread = 0.1, .offset_spread = 0.03, .seed = 9};
  std::vector<double> gains, offsets;
  for (std::uint64_t contact = 0; contact < 2000; ++contact) {
    RowMatrix<double> stress = RowMatrix<double>::Zero(3, 8);
    stress.row(1).setOnes();
    const RowMatrix<double> reading = transducer_chain(own, 3, contact, stress);
    EXPECT_EQ(reading.row(0), reading.row(2)) << "an offset stays";
    for (int c = 0; c < 8; ++c) {
      offsets.push_back(reading(0, c));
      gains.push_back(reading(1, c) - reading(0, c));
    }
  }
  expect_normal(gains, 1, 0.1);
  expect_normal(offsets, 0, 0.03);
}

TEST(Transducer, AContactMeetsOneOfTheInstances) {
  Transducer t{.gain_spread = 0.1, .instances = 3, .seed = 9};
  std::map<double, int> met;
  const RowMatrix<double> stress = RowMatrix<double>::Ones(1, 4);
  for (std::uint64_t contact = 0; contact < 3000; ++contact) ++met[transducer_chain(t, 3, contact, stress)(0, 2)];
  ASSERT_EQ(met.size(), 3u);
  for (const auto& [gain, times] : met) EXPECT_NEAR(times, 1000, 5 * std::sqrt(3000 * 2 / 9.0));
  // The same sensors in another set; other sensors by another seed.
  EXPECT_TRUE(met.contains(transducer_chain(t, 4, 77, stress)(0, 2)));
  t.seed = 10;
  EXPECT_FALSE(met.contains(transducer_chain(t, 3, 77, stress)(0, 2)));
}

/// Four tactels: stresses 1, 2, 4, 8 (normal) and 10, 20, 40, 80 (shear).
RowMatrix<double> four_tactels() { return RowMatrix<double>{{1, 2, 4, 8, 10, 20, 40, 80}}; }

// By hand: with shares c of the neighbours, tactel 1 reads 2 + c (1 + 4), the first 1 + 2 c; the normal and the shear
// transducer of a tactel have shares of their own. E |n| of a normal number is sqrt(2 / pi).
TEST(Transducer, CrosstalkAddsNeighboursOfTheSameKind) {
  const Transducer t{.seed = 3, .crosstalk = 0.01};
  double sum = 0;
  for (std::uint64_t contact = 0; contact < 4000; ++contact) {
    const RowMatrix<double> reading = transducer_chain(t, 0, contact, four_tactels());
    const double c = (reading(0, 1) - 2) / 5, d = (reading(0, 4) - 10) / 20;
    EXPECT_GE(c, 0);
    EXPECT_GE(d, 0);  // the first shear transducer has no neighbour among the normal ones
    EXPECT_NE(c, d);
    sum += c;
  }
  EXPECT_NEAR(sum / 4000, 0.01 * std::sqrt(2 / 3.14159265358979), 5 * 0.01 / std::sqrt(4000.0));
}

// A tactel that sits d of the distance to the right reads (1 - d) of its stress and d of the right one's; both its
// transducers shift alike, and those at the ends do not leave the row.
TEST(Transducer, AShiftedTactelReadsBetweenTwo) {
  const Transducer t{.seed = 3, .shift_spread = 0.1};
  std::vector<double> shifts;
  for (std::uint64_t contact = 0; contact < 4000; ++contact) {
    const RowMatrix<double> reading = transducer_chain(t, 0, contact, four_tactels());
    const double by = reading(0, 1) - 2, shift = by > 0 ? by / 2 : by;
    EXPECT_NEAR(reading(0, 5), 10 * reading(0, 1), 1e-12);
    EXPECT_GE(reading(0, 0), 1);  // only to the right
    EXPECT_LE(reading(0, 3), 8);  // only to the left
    shifts.push_back(shift);
  }
  expect_normal(shifts, 0, 0.1);
}

TEST(Transducer, DeadTransducersFeelNothing) {
  const Transducer t{.offset_spread = 0.5, .dead = 0.2};
  int dead = 0;
  for (std::uint64_t contact = 0; contact < 1000; ++contact) {
    RowMatrix<double> stress = RowMatrix<double>::Zero(2, 8);
    stress.row(1).setOnes();
    const RowMatrix<double> reading = transducer_chain(t, 0, contact, stress);
    for (int c = 0; c < 8; ++c) {
      const double felt = reading(1, c) - reading(0, c);
      EXPECT_TRUE(std::abs(felt) < 1e-12 || std::abs(felt - 1) < 1e-12);
      dead += felt < 0.5;
    }
  }
  EXPECT_NEAR(dead, 1600, 5 * std::sqrt(8000 * 0.2 * 0.8));
}

// A stress held from the first step on: (1 - lag) of it at once, all of it in the end. The first step is a ramp of h.
TEST(Transducer, TheLateShareArrivesWithItsTimeConstant) {
  const Transducer t{.step_time = 0.05, .lag = 0.1, .lag_time = 1};
  const auto reading = transducer_chain(t, 0, 0, signal(200, [](int) { return 0.5; }));
  for (int k = 0; k < 200; ++k)
    EXPECT_NEAR(reading(k, 0), 0.5 * (1 - 0.1 * (1 - std::exp(-0.05)) / 0.05 * std::exp(-0.05 * k)), 1e-14);
}

/// Of a stress of 1 held from step 0 on and gone from step `end` on, each step a ramp of h: what of the late share with
/// the time constant T has not arrived at step k.
double not_arrived(double T, double h, int k, int end) {
  const double first = T / h * (1 - std::exp(-h / T));
  return first * (std::exp(-h * k / T) - (k < end ? 0 : std::exp(-h * (k - end) / T)));
}

// The rubber's memory: two shares arrive, and are left after the unloading, as a sum of two exponentials.
TEST(Transducer, MemoryIsASumOfTwoExponentials) {
  const Transducer t{.step_time = 0.02, .lag = 0.03, .lag_time = 0.3, .memory = 0.02, .memory_time = 0.6};
  constexpr int end = 300;
  const auto reading = transducer_chain(t, 0, 0, signal(400, [](int k) { return k < end ? 1 : 0; }));
  for (int k = 0; k < 400; ++k)
    EXPECT_NEAR(reading(k, 0),
                (k < end) - 0.03 * not_arrived(0.3, 0.02, k, end) - 0.02 * not_arrived(0.6, 0.02, k, end), 1e-13)
        << k;  // 400 roundings of at most 1
  EXPECT_NEAR(reading(end + 49, 0), 0.03 * std::exp(-1 / 0.3) + 0.02 * std::exp(-1 / 0.6), 2e-4);  // after 1 s of 6 s
}

// A share of 1 or all but none of it, times far below and far above the steps: within the bounds the filter is exact.
TEST(Transducer, MemoryOfExtremeSharesAndTimes) {
  for (const double share : {1e-12, 0.5, 1.0})
    for (const double T : {0.02, 1.0, 1e6}) {
      const Transducer t{.step_time = 1, .memory = share, .memory_time = T};
      EXPECT_NO_THROW(t.validate());
      const auto reading = transducer_chain(t, 0, 0, signal(20, [](int k) { return k < 10 ? 1 : 0; }));
      for (int k = 0; k < 20; ++k)
        EXPECT_NEAR(reading(k, 0), (k < 10) - share * not_arrived(T, 1, k, 10),
                    1e-9);  // T / h (1 - e) of 1e6 roundings
    }
}

// From the first two readings of a held stress of 1: e = (1 - r_1) / (1 - r_0) = exp(-h / T), and the share is
// (1 - r_0) h / (T (1 - e)). Shares evenly in 0.02 ... 0.04, times in 0.3 ... 0.6 s, each sensor's own.
TEST(Transducer, ARangeGivesEachSensorItsOwnMemory) {
  Transducer lag{.step_time = 0.1, .lag = 0.04, .lag_time = 0.6};
  lag.lag_from = 0.02, lag.lag_time_from = 0.3;
  Transducer memory{.step_time = 0.1, .memory = 0.04, .memory_time = 0.6};
  memory.memory_from = 0.02, memory.memory_time_from = 0.3;
  for (const Transducer& t : {lag, memory}) {
    constexpr int sensors = 3000;
    double share_mean = 0, time_mean = 0, product = 0;
    for (std::uint64_t contact = 0; contact < sensors; ++contact) {
      const auto reading = transducer_chain(t, 3, contact, RowMatrix<double>::Ones(2, 2));
      EXPECT_EQ(transducer_chain(t, 99, contact, RowMatrix<double>::Ones(2, 2)), reading) << "the sensor's own";
      const double e = (1 - reading(1, 0)) / (1 - reading(0, 0)), time = -0.1 / std::log(e);
      const double share = (1 - reading(0, 0)) * 0.1 / (time * (1 - e));
      EXPECT_TRUE(share > 0.02 && share < 0.04 && time > 0.3 && time < 0.6) << share << ' ' << time;
      share_mean += share / sensors, time_mean += time / sensors, product += (share - 0.03) * (time - 0.45) / sensors;
    }
    const double five = 5 / std::sqrt(12.0 * sensors);  // deviations of the mean of numbers even in a range of 1
    EXPECT_NEAR(share_mean, 0.03, 0.02 * five);
    EXPECT_NEAR(time_mean, 0.45, 0.3 * five);
    EXPECT_NEAR(product, 0, 0.02 * 0.3 * five / std::sqrt(12.0)) << "independent";
  }
}

// The zero stands still along a contact, and elsewhere in the next: normal, 5 % of the largest normal stress, however
// large the shear.
TEST(Transducer, DriftMovesTheZeroOfAContact) {
  const Transducer t{.instances = 1, .drift = 0.05};
  std::vector<double> zeros;
  for (std::uint64_t contact = 0; contact < 2000; ++contact) {
    RowMatrix<double> stress = RowMatrix<double>::Zero(3, 8);
    const double largest = 1 + static_cast<double>(contact % 5);
    stress(1, 2) = -largest, stress(1, 6) = 100;
    const RowMatrix<double> reading = transducer_chain(t, 3, contact, stress) - stress;
    for (int c = 0; c < 8; ++c) {
      EXPECT_NEAR(reading(0, c), reading(1, c), 1e-13);  // roundings of 100
      EXPECT_EQ(reading(0, c), reading(2, c));
      zeros.push_back(reading(0, c) / largest);
    }
  }
  expect_normal(zeros, 0, 0.05);
}

TEST(Transducer, ARangeGivesEachSensorItsOwnDrift) {
  Transducer t{.drift = 0.1};
  t.drift_from = 0;
  double squares = 0, within = 0;
  for (std::uint64_t contact = 0; contact < 3000; ++contact) {
    const double own = (transducer_chain(t, 3, contact, RowMatrix<double>::Ones(1, 40)).array() - 1).square().mean();
    squares += own / 3000, within += own * own / 3000;
  }
  EXPECT_NEAR(squares, 0.01 / 3, 5 * 0.0031 / std::sqrt(3000.0));  // squares of even numbers spread by 0.298 of 0.01
  EXPECT_GT(within, 1.5 * squares * squares);                      // one drift for all: 1 + 2 / 40; here 9 / 5 of it
}

// n frames of which each but the first repeats the one before with the probability p: whole rows, as often as a
// binomial number; the others are what they were without repeats, memory and amplifier included.
TEST(Transducer, RepeatedRowsAreBinomial) {
  Transducer without{.time_constant = 1, .step_time = 0.1, .noise = 0.1, .lag = 0.1, .lag_time = 1};
  Transducer t = without;
  t.repeats = 0.08;
  int repeated = 0, twice = 0;
  constexpr int contacts = 400, steps = 101;
  for (std::uint64_t contact = 0; contact < contacts; ++contact) {
    const auto stress = RowMatrix<double>::Random(steps, 6);
    const RowMatrix<double> all = stress, reading = transducer_chain(t, 5, contact, all),
                            bare = transducer_chain(without, 5, contact, all);
    EXPECT_EQ(reading.row(0), bare.row(0));
    for (int k = 1; k < steps; ++k) {
      const bool again = reading.row(k) == reading.row(k - 1);
      EXPECT_TRUE(again || reading.row(k) == bare.row(k)) << k;
      repeated += again;
      twice += again && k > 1 && reading.row(k - 1) == reading.row(k - 2);
    }
  }
  constexpr double n = contacts * (steps - 1);
  EXPECT_NEAR(repeated, 0.08 * n, 5 * std::sqrt(n * 0.08 * 0.92));
  EXPECT_NEAR(twice, 0.08 * 0.08 * n, 5 * std::sqrt(n * 0.0064 * 1.2));  // independent of the frame before
  t.repeats = 1;
  const auto frozen = transducer_chain(t, 5, 1, RowMatrix<double>::Random(9, 6));
  for (int k = 1; k < 9; ++k) EXPECT_EQ(frozen.row(k), frozen.row(0));
}

// Each sensor's own share of repeats, evenly in 0 ... 0.1: the numbers of repeats among 100 have the mean 5 and the
// variance 10000 0.01 / 12 + 100 (0.05 - 0.01 / 3) = 13.
TEST(Transducer, ARangeGivesEachSensorItsOwnRepeats) {
  Transducer t{.repeats = 0.1};
  t.repeats_from = 0;
  std::vector<double> counts;
  const auto stress = signal(101, [](int k) { return k; });
  for (std::uint64_t contact = 0; contact < 3000; ++contact) {
    const auto reading = transducer_chain(t, 3, contact, stress);
    int count = 0;
    for (int k = 1; k < 101; ++k) count += reading(k, 0) == reading(k - 1, 0);
    counts.push_back(count);
  }
  const Moments m = moments(counts);
  EXPECT_NEAR(m.mean, 5, 5 * std::sqrt(13 / 3000.0));
  EXPECT_NEAR(m.deviation * m.deviation, 13, 5 * 13 * std::sqrt(2 / 3000.0));  // kurtosis below 3
}

// By hand: tactel 1 of a line reads 2 + m 20 and 20 + m' 2; of a pad with one axis pressed, each other axis reads its
// own share of it, and shares add.
TEST(Transducer, MixingAddsTheOtherAxesOfTheTactel) {
  const Transducer t{.seed = 3, .mixing = 0.03};
  std::vector<double> shares;
  for (std::uint64_t contact = 0; contact < 2000; ++contact) {
    const RowMatrix<double> reading = transducer_chain(t, 0, contact, four_tactels());
    const double normal = (reading(0, 1) - 2) / 20, shear = (reading(0, 5) - 20) / 2;
    EXPECT_NE(normal, shear);
    shares.push_back(normal), shares.push_back(shear);
  }
  expect_normal(shares, 0, 0.03);
  shares.clear();
  double product = 0;  // of the two shares of a transducer, on average
  for (std::uint64_t contact = 0; contact < 500; ++contact) {
    RowMatrix<double> pressed[3], sum = RowMatrix<double>::Zero(1, 12);  // 2 x 2 tactels with z, x, y
    for (int axis = 0; axis < 3; ++axis) {
      RowMatrix<double> stress = RowMatrix<double>::Zero(1, 12);
      stress.middleCols(4 * axis, 4) << 1, 10, 100, 1000;
      pressed[axis] = transducer_chain(t, 0, contact, stress, 3, 2);
      EXPECT_EQ(pressed[axis].middleCols(4 * axis, 4), stress.middleCols(4 * axis, 4));
      for (int other = 1; other < 3; ++other)
        for (int tactel = 0; tactel < 4; ++tactel)
          shares.push_back(pressed[axis](0, (axis + other) % 3 * 4 + tactel) / stress(0, 4 * axis + tactel));
      sum += 2 * (axis + 1) * pressed[axis];
    }
    product += pressed[1](0, 0) * pressed[2](0, 0) / 500;
    RowMatrix<double> all(1, 12);
    all << 2, 20, 200, 2000, 4, 40, 400, 4000, 6, 60, 600, 6000;
    EXPECT_LT((transducer_chain(t, 0, contact, all, 3, 2) - sum).cwiseAbs().maxCoeff(), 1e-11);  // roundings of 6000
  }
  expect_normal(shares, 0, 0.03);
  EXPECT_NEAR(product, 0, 5 * 0.03 * 0.03 / std::sqrt(500.0)) << "independent";
}

// A dead transducer feels the other axes no more than its own; a range of mixing is the sensor's.
TEST(Transducer, MixingOfDeadTransducersAndRanges) {
  EXPECT_TRUE(transducer_chain({.dead = 1, .mixing = 0.5}, 0, 1, four_tactels()).isZero(0));
  Transducer t{.mixing = 0.1};
  t.mixing_from = 0;
  double squares = 0, within = 0;
  for (std::uint64_t contact = 0; contact < 3000; ++contact) {
    const double own = (transducer_chain(t, 3, contact, RowMatrix<double>::Ones(1, 40)).array() - 1).square().mean();
    squares += own / 3000, within += own * own / 3000;
  }
  EXPECT_NEAR(squares, 0.01 / 3, 5 * 0.0031 / std::sqrt(3000.0));  // as drift's
  EXPECT_GT(within, 1.5 * squares * squares);
}

/// Stresses of 3 x 4 tactels with three axes: planes over row and column.
RowMatrix<double> planes() {
  RowMatrix<double> stress(1, 36);
  for (int axis = 0; axis < 3; ++axis)
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 4; ++column)
        stress(0, 12 * axis + 4 * row + column) = 1 + (2 + axis) * column + (7 - axis) * row;
  return stress;
}

// On a plane, reading between tactels is exact: in the middle of the pad a reading less its own stress is the plane's
// slopes by the shift along and across the row, the same shift for all axes. At the edges tactels shift only inward.
TEST(Transducer, ATactelOfAPadShiftsAlongAndAcross) {
  const Transducer t{.seed = 3, .shift_spread = 0.1};
  const RowMatrix<double> stress = planes();
  std::vector<double> along, across;
  for (std::uint64_t contact = 0; contact < 4000; ++contact) {
    const RowMatrix<double> moved = transducer_chain(t, 0, contact, stress, 3, 3) - stress;
    const double z = moved(0, 5), x = moved(0, 17);  // 2 dx + 7 dy, 3 dx + 6 dy
    const double dx = (7 * x - 6 * z) / 9, dy = (3 * z - 2 * x) / 9;
    EXPECT_NEAR(moved(0, 29), 4 * dx + 5 * dy, 1e-12);
    EXPECT_GE(moved(0, 0), 0);
    EXPECT_LE(moved(0, 11), 0);
    along.push_back(dx), across.push_back(dy);
  }
  expect_normal(along, 0, 0.1);
  expect_normal(across, 0, 0.1);
}

// By hand: a tactel in the middle reads c times the four around it; the last of a row does not feel the first of the
// next.
TEST(Transducer, CrosstalkOfAPadReachesFourNeighbours) {
  const Transducer t{.seed = 3, .crosstalk = 0.01};
  RowMatrix<double> one = RowMatrix<double>::Zero(1, 36);
  one(0, 12 + 5) = 1;  // axis x, row 1, column 1
  for (std::uint64_t contact = 0; contact < 100; ++contact) {
    const RowMatrix<double> reading = transducer_chain(t, 0, contact, one, 3, 3);
    for (int c = 0; c < 36; ++c) {
      const bool beside = c == 12 + 1 || c == 12 + 4 || c == 12 + 6 || c == 12 + 9;
      EXPECT_EQ(reading(0, c) > 0 && reading(0, c) < 0.1, beside) << c;
    }
    const RowMatrix<double> all = transducer_chain(t, 0, contact, planes(), 3, 3);
    const double c = (all(0, 17) - 10) / (4 * 10);  // 1 + 3 + 6, as the mean of the four around it
    EXPECT_NEAR(c, (transducer_chain(t, 0, contact, RowMatrix<double>::Ones(1, 36), 3, 3)(0, 17) - 1) / 4, 1e-13);
  }
  one.setZero();
  one(0, 3) = 1;
  EXPECT_EQ(transducer_chain(t, 0, 1, one, 3, 3)(0, 4), 0);
  EXPECT_THROW(transducer_chain(t, 0, 1, one, 3, 5), std::invalid_argument);
}

// Noise of 1 % of a contact's largest stress, wherever and whenever it is.
TEST(Transducer, NoiseMayFollowTheContactsLargestStress) {
  const Transducer t{.noise_of_largest = 0.01};
  std::vector<double> relative;
  for (std::uint64_t contact = 0; contact < 1000; ++contact) {
    RowMatrix<double> stress = RowMatrix<double>::Zero(3, 8);
    const double largest = 1 + static_cast<double>(contact % 7);
    stress(2, 5) = -largest;
    const RowMatrix<double> reading = transducer_chain(t, 3, contact, stress);
    for (const double v : reading.topRows(2).reshaped()) relative.push_back(v / largest);
  }
  expect_normal(relative, 0, 0.01);
}

// Of 3000 sensors each has a spread between 0.05 and 0.2, evenly: the mean of squared gains less 1 is
// (a^2 + a b + b^2) / 3 = 0.0175.
TEST(Transducer, ARangeGivesEachSensorItsOwnSpread) {
  Transducer t{.gain_spread = 0.2};
  t.gain_spread_from = 0.05;
  double squares = 0, within = 0;
  for (std::uint64_t contact = 0; contact < 3000; ++contact) {
    const RowMatrix<double> reading = transducer_chain(t, 3, contact, RowMatrix<double>::Ones(1, 40));
    const double own = (reading.array() - 1).square().mean();
    squares += own / 3000;
    within += own * own / 3000;
  }
  EXPECT_NEAR(squares, 0.0175, 5 * 0.012 / std::sqrt(3000.0));  // own squares spread by 0.011 between sensors
  EXPECT_GT(within, 1.3 * squares * squares);                   // one spread for all: 1 + 2 / 40
}

// A held stress of 1 that all of RC takes from: after one step of h the first reading is (tau / h) (1 - exp(-h / tau)),
// from which tau follows; evenly in 0.5 to 2 s, its mean is 1.25 and its variance 1.5^2 / 12.
TEST(Transducer, ARangeGivesEachSensorItsOwnTimeConstant) {
  Transducer t{.time_constant = 2, .step_time = 1};
  t.time_constant_from = 0.5;
  double mean = 0, squares = 0, least = 9, most = 0;
  constexpr int sensors = 3000;
  for (std::uint64_t contact = 0; contact < sensors; ++contact) {
    const double reading = transducer_chain(t, 3, contact, RowMatrix<double>::Ones(1, 2))(0, 0);
    double low = 0.1, high = 10;
    for (int k = 0; k < 60; ++k) {
      const double tau = (low + high) / 2;
      (tau * (1 - std::exp(-1 / tau)) < reading ? low : high) = tau;
    }
    mean += low / sensors, squares += low * low / sensors;
    least = std::min(least, low), most = std::max(most, low);
    EXPECT_EQ(transducer_chain(t, 99, contact, RowMatrix<double>::Ones(1, 2))(0, 0), reading) << "the sensor's own";
  }
  EXPECT_NEAR(mean, 1.25, 5 * 0.433 / std::sqrt(sensors));
  EXPECT_NEAR(squares - mean * mean, 1.5 * 1.5 / 12, 0.0153);  // 5 sqrt((m4 - s^4) / sensors), m4 = 1.5^4 / 80
  EXPECT_TRUE(least >= 0.5 && most <= 2) << least << ' ' << most;
}

// 0.33 MPa of a range of 1 MPa in b bits is rint(0.33 2^(b-1)) / 2^(b-1).
TEST(Transducer, ARangeGivesEachSensorItsOwnBits) {
  Transducer t{.range = 1, .bits = 7};
  t.bits_from = 4;
  std::map<double, int> seen;
  for (std::uint64_t contact = 0; contact < 4000; ++contact)
    ++seen[transducer_chain(t, 3, contact, RowMatrix<double>::Constant(1, 2, 0.33))(0, 0)];
  EXPECT_EQ(seen.size(), 4u);
  for (const double reading : {3 / 8.0, 5 / 16.0, 11 / 32.0, 21 / 64.0})
    EXPECT_NEAR(seen[reading], 1000, 5 * std::sqrt(4000 * 0.25 * 0.75)) << reading;
}

TEST(Transducer, NamesWhatItRejects) {
  const auto rejected = [](const Transducer& t) -> std::string {
    try {
      t.validate();
    } catch (const ValueError& error) {
      return error.key;
    }
    return "";
  };
  const double inf = std::numeric_limits<double>::infinity();
  EXPECT_EQ(rejected({}), "");
  EXPECT_EQ(rejected({.gain_spread = -0.1}), "transducer.gain_spread");
  EXPECT_EQ(rejected({.offset_spread = inf}), "transducer.offset_spread");
  EXPECT_EQ(rejected({.noise = std::nan("")}), "transducer.noise");
  EXPECT_EQ(rejected({.bits = 12}), "transducer.range");
  EXPECT_EQ(rejected({.range = 1, .bits = 25}), "transducer.bits");
  EXPECT_EQ(rejected({.range = 1, .bits = 8, .bits_from = 9}), "transducer.bits");
  EXPECT_EQ(rejected({.time_constant = 1, .step_time = 0.1, .time_constant_from = 2}), "transducer.time_constant");
  EXPECT_EQ(rejected({.time_constant = 1, .step_time = 0.1, .time_constant_from = 1e-3}), "transducer.step_time");
  EXPECT_EQ(rejected({.time_constant = 1}), "transducer.step_time");
  EXPECT_EQ(rejected({.step_time = 1}), "transducer.step_time");
  EXPECT_EQ(rejected({.time_constant = 1, .step_time = 1e-7}), "transducer.step_time");
  EXPECT_EQ(rejected({.time_constant = 1, .step_time = 0.05, .range = 1, .bits = 12}), "");
  for (const double wrong : {-0.1, 1.1, inf, std::nan("")}) {
    EXPECT_EQ(rejected({.mixing = wrong}), "transducer.mixing");
    EXPECT_EQ(rejected({.repeats = wrong}), "transducer.repeats");
    EXPECT_EQ(rejected({.step_time = 1, .lag = wrong, .lag_time = 1}), "transducer.lag");
    EXPECT_EQ(rejected({.step_time = 1, .memory = wrong, .memory_time = 1}), "transducer.memory");
    if (wrong != 1.1) {
      EXPECT_EQ(rejected({.drift = wrong}), "transducer.drift");
      EXPECT_EQ(rejected({.step_time = 1, .memory = 0.1, .memory_time = wrong}), "transducer.memory_time");
    }
  }
  EXPECT_EQ(rejected({.step_time = 1, .lag = 0.6, .lag_time = 1, .memory = 0.6, .memory_time = 1}),
            "transducer.memory");
  EXPECT_EQ(rejected({.step_time = 1, .memory = 0.1}), "transducer.memory_time");
  EXPECT_EQ(rejected({.step_time = 1, .memory_time = 1}), "transducer.memory_time");
  EXPECT_EQ(rejected({.memory = 0.1, .memory_time = 1}), "transducer.step_time");
  EXPECT_EQ(rejected({.step_time = 51, .memory = 0.1, .memory_time = 1}), "transducer.step_time");
  EXPECT_EQ(rejected({.step_time = 1, .memory = 0.1, .memory_time = 2e6}), "transducer.step_time");
  EXPECT_EQ(rejected({.drift = 0.1, .drift_from = 0.2}), "transducer.drift");
  EXPECT_EQ(rejected({.repeats = 0.1, .repeats_from = std::nan("")}), "transducer.repeats");
  EXPECT_EQ(rejected({.mixing = 0.1, .mixing_from = -0.1}), "transducer.mixing");
  EXPECT_EQ(rejected({.step_time = 1, .lag = 0.1, .lag_time = 1, .lag_time_from = 1e-3}), "transducer.step_time");
  EXPECT_EQ(rejected({.mixing = 1, .drift = 2, .repeats = 1}), "");
}

}  // namespace tactel::nn::transducer_chain_test
