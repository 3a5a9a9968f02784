// SPDX-License-Identifier: Apache-2.0

// The plain transducer chain against closed forms and hand calculation.
#include "nn/transducer_chain.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>

#include "fem/value_error.h"

namespace tactel::nn {
namespace {

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
}

}  // namespace
}  // namespace tactel::nn
