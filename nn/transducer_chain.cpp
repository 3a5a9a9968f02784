// SPDX-License-Identifier: Apache-2.0
#include "nn/transducer_chain.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "fem/numbers/value_error.h"
#include "nn/charge_amplifier.h"
#include "nn/philox.h"

namespace tactel::nn {
namespace {

constexpr double most_shear_gain = 1e3;
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
std::array<double, 2> coarse_normal_pair(std::uint32_t a, std::uint32_t b) {
  const auto unit = [](std::uint32_t word) { return ((word >> 9) + 0.5) * 0x1p-23; };
  const double radius = std::sqrt(-2 * std::log(unit(a))), angle = 2 * std::numbers::pi * unit(b);
  return {radius * std::cos(angle), radius * std::sin(angle)};
}

/// Which sensor a contact meets.
std::uint64_t instance_of(const Transducer& t, std::uint64_t contact) {
  if (t.instances == 0) return contact;
  return std::uint64_t{words(t.seed, RandomStream::instance, contact, 0)[0]} * t.instances >> 32;
}

/// Readings of a charge amplifier, or what of x has not yet arrived of a late share.
std::vector<double> high_pass(double tau, double h, std::vector<double> x) {
  ChargeAmplifier amplifier(tau, h);
  for (double& each : x) each = amplifier(each);
  return x;
}

double unit(std::uint32_t word) { return ((word >> 9) + 0.5) * 0x1p-23; }

/// A sensor's own spread: evenly between the two, by a word.
double spread_of(const std::optional<double>& from, double to, std::uint32_t word) {
  const double least = from.value_or(to);
  return least + (to - least) * unit(word);
}

/// The numbers of a sensor, in place of their ranges.
Transducer of_sensor(Transducer t, std::uint64_t instance) {
  const auto drawn = [&](std::uint32_t which) { return words(t.seed, RandomStream::spread, instance, which); };
  const auto choose = [](const std::optional<double>& from, double& to, std::uint32_t word) {
    to = spread_of(from, to, word);
  };
  const PhiloxCounter electric = drawn(0), skin = drawn(2), late = drawn(3);
  choose(t.gain_spread_from, t.gain_spread, electric[0]);
  choose(t.offset_spread_from, t.offset_spread, electric[1]);
  choose(t.noise_from, t.noise, electric[2]);
  choose(t.time_constant_from, t.time_constant, electric[3]);
  choose(t.mixing_from, t.mixing, skin[0]);
  choose(t.drift_from, t.drift, skin[1]);
  choose(t.repeats_from, t.repeats, skin[2]);
  if (t.shear_gain_from) t.shear_gain = *t.shear_gain_from * std::pow(t.shear_gain / *t.shear_gain_from, unit(skin[3]));
  choose(t.lag_from, t.lag, late[0]);
  choose(t.lag_time_from, t.lag_time, late[1]);
  choose(t.memory_from, t.memory, late[2]);
  choose(t.memory_time_from, t.memory_time, late[3]);
  if (t.bits_from) {
    const auto count = static_cast<std::uint64_t>(t.bits) - static_cast<std::uint64_t>(*t.bits_from) + 1;
    t.bits = *t.bits_from + static_cast<int>(drawn(1)[0] * count >> 32);
  }
  return t;
}

/// Axes, rows and tactels of a row, as the channels lie.
struct Layout {
  std::uint32_t axes, rows, columns;
  std::uint32_t tactels() const { return rows * columns; }
  std::uint32_t channels() const { return axes * tactels(); }
};

/// The stress that a transducer feels: at its shifted place, linear between tactels, with shares of its neighbours' and
/// of the other axes of its tactel. A neighbour beyond an edge has no share, and the place does not shift beyond it.
std::vector<double> felt_stress(const Transducer& t, std::uint64_t instance, const RowMatrix<double>& stress,
                                const Layout& layout, std::uint32_t channel) {
  const std::uint32_t channels = layout.channels(), tactels = layout.tactels(), columns = layout.columns;
  const std::uint32_t tactel = channel % tactels, axis = channel / tactels;
  const PhiloxCounter fault = words(t.seed, RandomStream::fault, instance, channel);
  const PhiloxCounter place = words(t.seed, RandomStream::fault, instance, channels + tactel);
  const PhiloxCounter mixed = words(t.seed, RandomStream::fault, instance, 2 * channels + channel);
  const bool left = tactel % columns > 0, right = tactel % columns + 1 < columns;
  const bool below = tactel >= columns, above = tactel + columns < tactels;
  const double share = t.crosstalk * std::abs(coarse_normal_pair(fault[2], fault[3])[0]);
  const auto [along, across] = coarse_normal_pair(place[0], place[1]);
  const double x = std::clamp(t.shift_spread * along, left ? -1.0 : 0.0, right ? 1.0 : 0.0);
  const double rest = 1 - std::abs(x);  // of a triangle between three tactels
  const double y = std::clamp(t.shift_spread * across, below ? -rest : 0.0, above ? rest : 0.0);
  const auto mixing = coarse_normal_pair(mixed[0], mixed[1]);
  std::vector<double> felt(stress.rows());
  for (std::size_t k = 0; k < felt.size(); ++k) {
    felt[k] = (1 - std::abs(x) - std::abs(y)) * stress(k, channel);
    if (left) felt[k] += (std::max(-x, 0.0) + share) * stress(k, channel - 1);
    if (right) felt[k] += (std::max(x, 0.0) + share) * stress(k, channel + 1);
    if (below) felt[k] += (std::max(-y, 0.0) + share) * stress(k, channel - columns);
    if (above) felt[k] += (std::max(y, 0.0) + share) * stress(k, channel + columns);
    if (t.mixing > 0)
      for (std::uint32_t other = 1; other < layout.axes; ++other)
        felt[k] += t.mixing * mixing[other - 1] * stress(k, (axis + other) % layout.axes * tactels + tactel);
    if (unit(fault[0]) < t.dead) felt[k] = 0;
  }
  return felt;
}

/// Less the shares that arrive late, as far as they have not.
void delay(const Transducer& t, std::vector<double>& x) {
  const std::vector<double> felt = x;
  for (const auto& [share, time] : {std::pair{t.lag, t.lag_time}, {t.memory, t.memory_time}}) {
    if (share == 0) continue;
    const std::vector<double> late = high_pass(time, t.step_time, felt);
    for (std::size_t k = 0; k < x.size(); ++k) x[k] -= share * late[k];
  }
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
         reaches_others() || dead > 0 || lag > 0 || memory > 0 || drift > 0 || repeats > 0 || shear_gain > 0;
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
  check(memory >= 0 && lag + memory <= 1, "memory", memory,
        "a share of the stress, 0 to 1 with that of transducer.lag");
  check(at_least_0(memory_time) && (memory > 0) == (memory_time > 0), "memory_time", memory_time,
        "a time in s, given with transducer.memory");
  check(mixing >= 0 && mixing <= 1, "mixing", mixing, "a share of each other axis of the tactel, 0 to 1");
  check(at_least_0(drift), "drift", drift,
        "a standard deviation over the contact's largest normal stress, finite, 0 or more");
  check(repeats >= 0 && repeats <= 1, "repeats", repeats, "a probability, 0 to 1");
  check_from("gain_spread", gain_spread_from, gain_spread);
  check_from("offset_spread", offset_spread_from, offset_spread);
  check_from("noise", noise_from, noise);
  check_from("time_constant", time_constant_from, time_constant);
  check_from("mixing", mixing_from, mixing);
  check_from("drift", drift_from, drift);
  check_from("repeats", repeats_from, repeats);
  check(at_least_0(shear_gain) && shear_gain <= most_shear_gain &&
            (!shear_gain_from || (*shear_gain_from >= 1 / most_shear_gain && *shear_gain_from <= shear_gain)) &&
            (shear_gain == 0 || shear_gain >= 1 / most_shear_gain),
        "shear_gain", shear_gain_from.value_or(shear_gain), "a gain, or a range of it upward, 1e-3 to 1e3");
  check_from("lag", lag_from, lag);
  check_from("lag_time", lag_time_from, lag_time);
  check_from("memory", memory_from, memory);
  check_from("memory_time", memory_time_from, memory_time);
  check(!bits_from || (*bits_from >= 2 && *bits_from <= bits), "bits", bits_from.value_or(0),
        "a range of whole numbers from 2 upward");
  check((time_constant == 0 && lag_time == 0 && memory_time == 0) == (step_time == 0), "step_time", step_time,
        "given with transducer.time_constant, in s");
  // Beyond these bounds exp(-h / T) is 0 or 1, and the filter is not what it says.
  const auto check_step = [&](double longest, double shortest, const char* allowed) {
    check(longest == 0 || (step_time >= 1e-6 * longest && step_time <= 50 * shortest), "step_time", step_time, allowed);
  };
  check_step(time_constant, time_constant_from.value_or(time_constant),
             "between 1e-6 and 50 of transducer.time_constant, in s");
  check_step(lag_time, lag_time_from.value_or(lag_time), "between 1e-6 and 50 of transducer.lag_time, in s");
  check_step(memory_time, memory_time_from.value_or(memory_time),
             "between 1e-6 and 50 of transducer.memory_time, in s");
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
  say_range("mixing", t.mixing_from, t.mixing, "");
  say("dead", t.dead, "");
  say_range("lag", t.lag_from, t.lag, "");
  say_range("lag_time", t.lag_time_from, t.lag_time, " s");
  say_range("memory", t.memory_from, t.memory, "");
  say_range("memory_time", t.memory_time_from, t.memory_time, " s");
  say_range("gain_spread", t.gain_spread_from, t.gain_spread, "");
  say_range("shear_gain", t.shear_gain_from, t.shear_gain, "");
  say_range("time_constant", t.time_constant_from, t.time_constant, " s");
  say("step_time", t.step_time, " s");
  say_range("offset_spread", t.offset_spread_from, t.offset_spread, " MPa");
  say_range("drift", t.drift_from, t.drift, "");
  say_range("noise", t.noise_from, t.noise, " MPa");
  say("noise_of_largest", t.noise_of_largest, "");
  say("range", t.range, " MPa");
  say_range("bits", t.bits_from, t.bits, "");
  say_range("repeats", t.repeats_from, t.repeats, "");
  say("instances", t.instances, "");
  const bool ranges = t.noise_from || t.time_constant_from || t.bits_from || t.lag_from || t.lag_time_from ||
                      t.memory_from || t.memory_time_from || t.drift_from || t.repeats_from || t.shear_gain_from;
  if (t.gain_spread > 0 || t.offset_spread > 0 || ranges || t.reaches_others() || t.dead > 0)
    text << ", seed " << t.seed;
  return t.present() ? text.str() : "none";
}

RowMatrix<double> transducer_chain(const Transducer& of_all, std::uint64_t seed, std::uint64_t contact,
                                   const RowMatrix<double>& stress, int axes, int rows) {
  const auto channels = static_cast<std::uint32_t>(stress.cols());
  const Layout layout{static_cast<std::uint32_t>(axes), static_cast<std::uint32_t>(rows), channels / (axes * rows)};
  if (axes > 3 || layout.channels() != channels)
    throw std::invalid_argument("channels that are no whole axes and rows");
  const std::uint64_t instance = instance_of(of_all, contact);
  const Transducer t = of_sensor(of_all, instance);
  const auto largest = [&](Eigen::Index first) {
    double most = 0;
    for (const double s : stress.leftCols(first).reshaped())
      if (std::isfinite(s)) most = std::max(most, std::abs(s));
    return most;
  };
  const double deviation = t.noise + t.noise_of_largest * largest(channels);
  const double drift = t.drift * largest(layout.tactels());
  RowMatrix<double> reading(stress.rows(), stress.cols());
  for (std::uint32_t channel = 0; channel < channels; ++channel) {
    const PhiloxCounter drawn = words(t.seed, RandomStream::gain, instance, channel);
    const PhiloxCounter drifted = words(seed, RandomStream::frame, contact, channel);
    const auto [gain, offset] = coarse_normal_pair(drawn[0], drawn[1]);
    const double zero = t.offset_spread * offset + drift * coarse_normal_pair(drifted[0], drifted[1])[0];
    std::vector<double> x = felt_stress(t, instance, stress, layout, channel);
    delay(t, x);
    const double of_axis = t.shear_gain > 0 && channel >= layout.tactels() ? t.shear_gain : 1;
    for (double& s : x) s *= (1 + t.gain_spread * gain) * of_axis;
    const std::vector<double> y = t.time_constant == 0 ? x : high_pass(t.time_constant, t.step_time, x);
    for (std::uint32_t k = 0; k < y.size(); ++k) {
      const PhiloxCounter noise = words(seed, RandomStream::reading, contact, k / 4 * channels + channel);
      const double normal = coarse_normal_pair(noise[k % 4 / 2 * 2], noise[k % 4 / 2 * 2 + 1])[k % 2];
      reading(k, channel) = converted(t, y[k] + zero + deviation * normal);
    }
  }
  for (std::uint32_t k = 1; k < reading.rows(); ++k)
    if (unit(words(seed, RandomStream::frame, contact, channels + k / 4)[k % 4]) < t.repeats)
      reading.row(k) = reading.row(k - 1);
  return reading;
}

}  // namespace tactel::nn
