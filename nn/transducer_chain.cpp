// SPDX-License-Identifier: Apache-2.0
#include "nn/transducer_chain.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <sstream>
#include <vector>

#include "fem/value_error.h"
#include "nn/philox.h"

namespace tactel::nn {
namespace {

constexpr int most_bits = 24;  // readings in single precision are whole multiples of the quantum

void check(bool good, const char* member, double value, const char* allowed) {
  std::ostringstream text;
  text << value;
  if (!good) throw ValueError(std::string("transducer.") + member, text.str(), allowed);
}

bool at_least_0(double value) { return std::isfinite(value) && value >= 0; }

void check_from(const char* member, const std::optional<double>& from, double to) {
  check(!from || (at_least_0(*from) && *from <= to), member, from.value_or(0), "a range from 0 or more upward");
}

PhiloxCounter words(std::uint64_t seed, RandomStream stream, std::uint64_t item, std::uint32_t which) {
  return philox4x32({static_cast<std::uint32_t>(item), static_cast<std::uint32_t>(item >> 32),
                     static_cast<std::uint32_t>(stream), which},
                    {static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)});
}

/// Box and Muller (1958). A word's upper 23 bits make the middle of a cell of (0, 1) that single precision holds
/// exactly.
std::array<double, 2> normal_pair(std::uint32_t a, std::uint32_t b) {
  const auto unit = [](std::uint32_t word) { return ((word >> 9) + 0.5) * 0x1p-23; };
  const double radius = std::sqrt(-2 * std::log(unit(a))), angle = 2 * std::numbers::pi * unit(b);
  return {radius * std::cos(angle), radius * std::sin(angle)};
}

/// Which sensor a contact meets.
std::uint64_t instance_of(const Transducer& t, std::uint64_t contact) {
  if (t.instances == 0) return contact;
  return std::uint64_t{words(t.seed, RandomStream::instance, contact, 0)[0]} * t.instances >> 32;
}

/// tau y' + y = tau x' for x that grows evenly between samples, exactly: y_k = e y_{k-1} + (tau / h)(1 - e)(x_k -
/// x_{k-1}), e = exp(-h / tau), x and y zero before the first.
std::vector<double> high_pass(double tau, double h, const std::vector<double>& x) {
  const double decay = std::exp(-h / tau), pass = tau / h * (1 - decay);
  std::vector<double> y(x.size());
  for (std::size_t k = 0; k < x.size(); ++k) y[k] = (k ? decay * y[k - 1] : 0) + pass * (x[k] - (k ? x[k - 1] : 0));
  return y;
}

double unit(std::uint32_t word) { return ((word >> 9) + 0.5) * 0x1p-23; }

/// A sensor's own spread: evenly between the two, by a word.
double spread_of(const std::optional<double>& from, double to, std::uint32_t word) {
  const double least = from.value_or(to);
  return least + (to - least) * unit(word);
}

/// The time constant and the bits of a sensor, in place of their ranges.
Transducer of_sensor(Transducer t, std::uint64_t instance, std::uint32_t word) {
  t.time_constant = spread_of(t.time_constant_from, t.time_constant, word);
  if (t.bits_from) {
    const auto count = static_cast<std::uint64_t>(t.bits - *t.bits_from + 1);
    t.bits = *t.bits_from + static_cast<int>(words(t.seed, RandomStream::spread, instance, 1)[0] * count >> 32);
  }
  return t;
}

/// The stress that a transducer feels: at its shifted place, linear between tactels, with shares of its neighbours'. At
/// an end of the row the neighbour that is not there has no share, and the place does not shift beyond the row.
std::vector<double> felt_stress(const Transducer& t, std::uint64_t instance, const RowMatrix<double>& stress,
                                std::uint32_t channel) {
  const auto channels = static_cast<std::uint32_t>(stress.cols()), tactels = channels / 2;
  const std::uint32_t tactel = channel % tactels;
  const PhiloxCounter fault = words(t.seed, RandomStream::fault, instance, channel);
  const PhiloxCounter place = words(t.seed, RandomStream::fault, instance, channels + tactel);
  const bool left = tactel > 0, right = tactel + 1 < tactels;
  const double share = t.crosstalk * std::abs(normal_pair(fault[2], fault[3])[0]);
  const double shift =
      std::clamp(t.shift_spread * normal_pair(place[0], place[1])[0], left ? -1.0 : 0.0, right ? 1.0 : 0.0);
  const double of_left = left ? std::max(-shift, 0.0) + share : 0, of_right = right ? std::max(shift, 0.0) + share : 0;
  std::vector<double> x(stress.rows());
  for (std::size_t k = 0; k < x.size(); ++k) {
    x[k] = (1 - std::abs(shift)) * stress(k, channel);
    if (left) x[k] += of_left * stress(k, channel - 1);
    if (right) x[k] += of_right * stress(k, channel + 1);
    if (unit(fault[0]) < t.dead) x[k] = 0;
  }
  return x;
}

/// Less the share that arrives late, as far as it has not.
void delay(const Transducer& t, std::vector<double>& x) {
  if (t.lag == 0) return;
  const std::vector<double> late = high_pass(t.lag_time, t.step_time, x);
  for (std::size_t k = 0; k < x.size(); ++k) x[k] -= t.lag * late[k];
}

double converted(const Transducer& t, double reading) {
  if (t.range == 0) return reading;
  if (t.bits == 0) return std::isnan(reading) ? reading : std::clamp(reading, -t.range, t.range);
  const double half = std::ldexp(1.0, t.bits - 1), code = std::rint(reading / t.quantum());
  return std::isnan(code) ? code : std::clamp(code, -half, half - 1) * t.quantum();
}

}  // namespace

bool Transducer::present() const {
  return gain_spread > 0 || offset_spread > 0 || noise > 0 || time_constant > 0 || range > 0 || noise_of_largest > 0 ||
         reaches_neighbours() || dead > 0 || lag > 0;
}

double Transducer::quantum() const { return bits == 0 ? 0 : std::ldexp(range, 1 - bits); }

void Transducer::validate() const {
  check(at_least_0(gain_spread), "gain_spread", gain_spread,
        "a standard deviation of gains about 1, finite, 0 or more");
  check(at_least_0(offset_spread), "offset_spread", offset_spread, "a standard deviation in MPa, finite, 0 or more");
  check(at_least_0(noise), "noise", noise, "a standard deviation in MPa, finite, 0 or more");
  check(at_least_0(range), "range", range, "a stress in MPa, finite, above 0");
  check(bits == 0 || (bits >= 2 && bits <= most_bits), "bits", bits, "a whole number of bits, 2 to 24");
  check(bits == 0 || range > 0, "range", range, "given with transducer.bits: the largest stress in MPa");
  check(at_least_0(time_constant), "time_constant", time_constant, "a time in s, finite, above 0");
  check(at_least_0(step_time), "step_time", step_time, "a time in s, finite, above 0");
  check(at_least_0(noise_of_largest), "noise_of_largest", noise_of_largest,
        "a standard deviation over the contact's largest stress, finite, 0 or more");
  check(shift_spread >= 0 && shift_spread <= 1, "shift_spread", shift_spread,
        "a standard deviation over the distance of two tactels, 0 to 1");
  check(crosstalk >= 0 && crosstalk <= 1, "crosstalk", crosstalk, "a share of each neighbour's stress, 0 to 1");
  check(dead >= 0 && dead <= 1, "dead", dead, "a probability, 0 to 1");
  check(lag >= 0 && lag <= 1, "lag", lag, "a share of the stress, 0 to 1");
  check(at_least_0(lag_time) && (lag > 0) == (lag_time > 0), "lag_time", lag_time,
        "a time in s, given with transducer.lag");
  check_from("gain_spread", gain_spread_from, gain_spread);
  check_from("offset_spread", offset_spread_from, offset_spread);
  check_from("noise", noise_from, noise);
  check_from("time_constant", time_constant_from, time_constant);
  check(!bits_from || (*bits_from >= 2 && *bits_from <= bits), "bits", bits_from.value_or(0),
        "a range of whole numbers from 2 upward");
  // Beyond these bounds exp(-h / tau) is 0 or 1, and the filter is not what it says.
  check((time_constant == 0 && lag_time == 0) == (step_time == 0), "step_time", step_time,
        "given with transducer.time_constant, in s");
  const double shortest = time_constant_from.value_or(time_constant);
  check(time_constant == 0 || (step_time >= 1e-6 * time_constant && step_time <= 50 * shortest), "step_time", step_time,
        "between 1e-6 and 50 of transducer.time_constant, in s");
  check(lag_time == 0 || (step_time >= 1e-6 * lag_time && step_time <= 50 * lag_time), "step_time", step_time,
        "between 1e-6 and 50 of transducer.lag_time, in s");
}

std::string description(const Transducer& t) {
  std::ostringstream text;
  const auto say = [&](const char* name, double value, const char* unit) {
    if (value != 0) text << (text.tellp() > 0 ? ", " : "") << name << ' ' << value << unit;
  };
  const auto say_range = [&](const char* name, const auto& from, double value, const char* unit) {
    if (from)
      text << (text.tellp() > 0 ? ", " : "") << name << ' ' << *from << " to " << value << unit;
    else
      say(name, value, unit);
  };
  say("shift_spread", t.shift_spread, "");
  say("crosstalk", t.crosstalk, "");
  say("dead", t.dead, "");
  say("lag", t.lag, "");
  say("lag_time", t.lag_time, " s");
  say_range("gain_spread", t.gain_spread_from, t.gain_spread, "");
  say_range("time_constant", t.time_constant_from, t.time_constant, " s");
  say("step_time", t.step_time, " s");
  say_range("offset_spread", t.offset_spread_from, t.offset_spread, " MPa");
  say_range("noise", t.noise_from, t.noise, " MPa");
  say("noise_of_largest", t.noise_of_largest, "");
  say("range", t.range, " MPa");
  say_range("bits", t.bits_from, t.bits, "");
  say("instances", t.instances, "");
  if (t.gain_spread > 0 || t.offset_spread > 0 || t.noise_from || t.time_constant_from || t.bits_from ||
      t.reaches_neighbours() || t.dead > 0)
    text << ", seed " << t.seed;
  return t.present() ? text.str() : "none";
}

RowMatrix<double> transducer_chain(const Transducer& of_all, std::uint64_t seed, std::uint64_t contact,
                                   const RowMatrix<double>& stress) {
  const auto channels = static_cast<std::uint32_t>(stress.cols());
  const std::uint64_t instance = instance_of(of_all, contact);
  const PhiloxCounter own = words(of_all.seed, RandomStream::spread, instance, 0);
  const Transducer t = of_sensor(of_all, instance, own[3]);
  const double gain_spread = spread_of(t.gain_spread_from, t.gain_spread, own[0]);
  const double offset_spread = spread_of(t.offset_spread_from, t.offset_spread, own[1]);
  double largest = 0;
  for (const double s : stress.reshaped())
    if (std::isfinite(s)) largest = std::max(largest, std::abs(s));
  const double deviation = spread_of(t.noise_from, t.noise, own[2]) + t.noise_of_largest * largest;
  RowMatrix<double> reading(stress.rows(), stress.cols());
  for (std::uint32_t channel = 0; channel < channels; ++channel) {
    const PhiloxCounter drawn = words(t.seed, RandomStream::gain, instance, channel);
    const auto [gain, offset] = normal_pair(drawn[0], drawn[1]);
    std::vector<double> x = felt_stress(t, instance, stress, channel);
    delay(t, x);
    for (double& s : x) s *= 1 + gain_spread * gain;
    const std::vector<double> y = t.time_constant == 0 ? x : high_pass(t.time_constant, t.step_time, x);
    for (std::uint32_t k = 0; k < y.size(); ++k) {
      const PhiloxCounter noise = words(seed, RandomStream::reading, contact, k / 4 * channels + channel);
      const double normal = normal_pair(noise[k % 4 / 2 * 2], noise[k % 4 / 2 * 2 + 1])[k % 2];
      reading(k, channel) = converted(t, y[k] + offset_spread * offset + deviation * normal);
    }
  }
  return reading;
}

}  // namespace tactel::nn
