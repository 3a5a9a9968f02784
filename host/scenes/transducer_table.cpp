// SPDX-License-Identifier: Apache-2.0
#include <toml++/toml.h>

#include <cmath>

#include "host/scenes/distribution.h"
#include "host/scenes/scene_tables.h"

namespace tactel::host {
namespace {

/// Reads `key` of a part that is present: above 0.
void read_positive(TomlTable& in, const char* key, double& value, const char* what) {
  if (in.read(key, value, what) && !(value > 0)) in.refuse(key, what);
}

/// A number, or { uniform = [least, most] }: each sensor its own between the two.
void read_spread(const TomlFile& file, TomlTable& in, const char* key, double& value, std::optional<double>& from,
                 const std::string& what) {
  const toml::table* table = file.root()["transducer"].as_table();
  const toml::node* node = table != nullptr ? table->get(key) : nullptr;
  if (node == nullptr || !node->is_table()) {
    in.read(key, value, what);
    return;
  }
  in.expect_table(key);
  const std::string full = std::string("transducer.") + key;
  const auto drawn = read_distribution(file, full, *node);
  const auto* uniform = std::get_if<UniformDraw>(&*drawn);
  if (uniform == nullptr) throw file.error(full, node, what + ", or { uniform = [least, most] } of it");
  from = uniform->from, value = uniform->to;
}

/// A gain of all sensors, or { log_uniform = [least, most] } of it.
void read_shear_gain(const TomlFile& file, TomlTable& in, nn::Transducer& t) {
  const char *key = "shear_gain", *what = "a number above 0, or { log_uniform = [least, most] }";
  const toml::node* node = file.root()["transducer"][key].node();
  if (node == nullptr || !node->is_table()) return read_positive(in, key, t.shear_gain, what);
  in.expect_table(key);
  const auto drawn = read_distribution(file, std::string("transducer.") + key, *node);
  const auto* range = std::get_if<LogUniformDraw>(&*drawn);
  if (range == nullptr) throw file.error(std::string("transducer.") + key, node, what);
  t.shear_gain_from = range->from, t.shear_gain = range->to;
}

/// A time of all sensors, or a range of it.
void read_time(const TomlFile& file, TomlTable& in, const char* key, double& value, std::optional<double>& from) {
  read_spread(file, in, key, value, from, "a time in s above 0");
  if (in.has(key) && !(from.value_or(value) > 0)) in.refuse(key, "a time in s above 0");
}

/// The bits of all sensors, or { uniform = [fewest, most] } of them.
void read_bits(const TomlFile& file, TomlTable& in, nn::Transducer& t) {
  const char* what = "a whole number of bits, 2 to 24";
  double bits = 0;
  std::optional<double> from;
  read_spread(file, in, "bits", bits, from, what);
  for (const double number : {from.value_or(bits), bits})
    if (in.has("bits") && !(number >= 2 && number <= 24 && number == std::floor(number))) in.refuse("bits", what);
  t.bits = static_cast<int>(bits);
  if (from) t.bits_from = static_cast<int>(*from);
}

template <class Count>
Count read_count(TomlTable& in, const char* key, Count least, const char* what) {
  Count value = 0;
  if (in.read(key, value, what) && value < least) in.refuse(key, what);
  return value;
}

}  // namespace

nn::Transducer read_transducer(const TomlFile& file, std::uint64_t seed) {
  TomlTable in(file, "transducer");
  nn::Transducer t;
  if (in.has("width")) in.refuse("width", "left out: sensor.tactel_width is the width of the transducers");
  read_spread(file, in, "gain_spread", t.gain_spread, t.gain_spread_from,
              "a standard deviation of gains about 1, 0 or more");
  read_shear_gain(file, in, t);
  read_spread(file, in, "offset_spread", t.offset_spread, t.offset_spread_from,
              "a standard deviation in MPa, 0 or more");
  read_spread(file, in, "noise", t.noise, t.noise_from, "a standard deviation in MPa, 0 or more");
  in.read("noise_of_largest", t.noise_of_largest, "a standard deviation over the contact's largest stress, 0 or more");
  in.read("shift_spread", t.shift_spread, "a standard deviation over the distance of two tactels, 0 to 1");
  in.read("crosstalk", t.crosstalk, "a share of each neighbour's stress, 0 to 1");
  in.read("dead", t.dead, "a probability, 0 to 1");
  read_spread(file, in, "lag", t.lag, t.lag_from, "a share of the stress, 0 to 1");
  read_time(file, in, "lag_time", t.lag_time, t.lag_time_from);
  read_spread(file, in, "memory", t.memory, t.memory_from, "a share of the stress, 0 to 1");
  read_time(file, in, "memory_time", t.memory_time, t.memory_time_from);
  read_spread(file, in, "mixing", t.mixing, t.mixing_from, "a share of each other axis of the tactel, 0 to 1");
  read_spread(file, in, "drift", t.drift, t.drift_from,
              "a standard deviation over the contact's largest normal stress, 0 or more");
  read_spread(file, in, "repeats", t.repeats, t.repeats_from, "a probability, 0 to 1");
  read_positive(in, "range", t.range, "a stress in MPa above 0: the largest that is read");
  if (double fraction = 0;
      in.read("noise_fraction", fraction, "a standard deviation over transducer.range, 0 or more")) {
    if (in.has("noise")) in.refuse("noise_fraction", "left out, because transducer.noise is given too");
    if (t.range == 0) in.refuse("noise_fraction", "given with transducer.range, of which it is a fraction");
    t.noise = fraction * t.range;
  }
  read_time(file, in, "time_constant", t.time_constant, t.time_constant_from);
  read_positive(in, "step_time", t.step_time, "a time in s above 0, between load steps");
  read_bits(file, in, t);
  t.instances = static_cast<std::uint32_t>(read_count(in, "instances", 1, "a whole number of sensors, at least 1"));
  t.seed = in.has("seed")
               ? static_cast<std::uint64_t>(read_count<std::int64_t>(in, "seed", 0, "a whole number, at least 0"))
               : seed;
  in.finish();
  try {
    t.validate();
  } catch (const ValueError& error) {
    throw file.error(error);
  }
  return t;
}

}  // namespace tactel::host
