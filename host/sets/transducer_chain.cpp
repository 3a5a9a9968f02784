// SPDX-License-Identifier: Apache-2.0
#include "host/sets/transducer_chain.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "kernels/shared/chain_settings.h"
#include "kernels/shared/random_streams.h"
#include "nn/philox.h"

namespace tactel::host {
namespace {

static_assert(int(nn::RandomStream::fault) == FAULT_STREAM && int(nn::RandomStream::frame) == FRAME_STREAM);

/// The factors of a filter with this time constant; 1, 1 without one.
struct Filter {
  float decay, pass;
  Filter(double time_constant, double step_time) {
    const double ratio = time_constant > 0 ? step_time / time_constant : 0;
    decay = static_cast<float>(std::exp(-ratio));
    pass = ratio > 0 ? static_cast<float>(-std::expm1(-ratio) / ratio) : 1;
  }
};

float least_of(const std::optional<double>& from, double to) { return static_cast<float>(from.value_or(to)); }

LateShare late_share(const std::optional<double>& share_from, double share, const std::optional<double>& time_from,
                     double time, double step_time) {
  const Filter filter(time, step_time);
  return {.share = {least_of(share_from, share), float(share)},
          .time = {least_of(time_from, time), float(time)},
          .decay = filter.decay,
          .pass = filter.pass};
}

/// Of a gain; 0 is none, 1.
float log_of(double gain) { return gain > 0 ? static_cast<float>(std::log(gain)) : 0.0f; }

ChainSettings settings(const nn::Transducer& t, std::uint64_t seed) {
  t.validate();
  constexpr float infinity = std::numeric_limits<float>::infinity();
  const bool converts = t.bits > 0;
  const float codes = converts ? std::ldexp(1.0f, t.bits - 1) : 0;
  const float limit = t.range > 0 ? static_cast<float>(t.range) : infinity;
  const Filter amplifier(t.time_constant, t.step_time);
  return {.reading_seed = seed,
          .instance_seed = t.seed,
          .instances = t.instances,
          .decay = amplifier.decay,
          .pass = amplifier.pass,
          .step_time = static_cast<float>(t.step_time),
          .time_constant = {least_of(t.time_constant_from, t.time_constant), float(t.time_constant)},
          .gain_spread = {least_of(t.gain_spread_from, t.gain_spread), float(t.gain_spread)},
          .shear_gain = {log_of(t.shear_gain_from.value_or(t.shear_gain)), log_of(t.shear_gain)},
          .offset_spread = {least_of(t.offset_spread_from, t.offset_spread), float(t.offset_spread)},
          .noise = {least_of(t.noise_from, t.noise), float(t.noise)},
          .noise_of_largest = static_cast<float>(t.noise_of_largest),
          .drift = {least_of(t.drift_from, t.drift), float(t.drift)},
          .repeats = {least_of(t.repeats_from, t.repeats), float(t.repeats)},
          .mixing = {least_of(t.mixing_from, t.mixing), float(t.mixing)},
          .shift_spread = static_cast<float>(t.shift_spread),
          .crosstalk = static_cast<float>(t.crosstalk),
          .dead = static_cast<float>(t.dead),
          .late = {late_share(t.lag_from, t.lag, t.lag_time_from, t.lag_time, t.step_time),
                   late_share(t.memory_from, t.memory, t.memory_time_from, t.memory_time, t.step_time)},
          .low = converts ? -codes : -limit,
          .high = converts ? codes - 1 : limit,
          .quantum = static_cast<float>(t.quantum()),
          .bits = {t.bits_from.value_or(t.bits), t.bits},
          .range = static_cast<float>(t.range)};
}

void raise_to_largest(float& most, std::span<const float> stresses) {
  for (const float s : stresses)
    if (std::isfinite(s)) most = std::max(most, std::abs(s));
}

}  // namespace

TransducerChain::TransducerChain(Executor& executor, const nn::Transducer& transducer, std::uint64_t seed, int channels,
                                 int axes, int rows)
    : executor_(&executor),
      channels_(static_cast<std::uint32_t>(channels)),
      tactels_(channels_ / static_cast<std::uint32_t>(axes)),
      others_(transducer.reaches_others()),
      relative_(transducer.noise_of_largest > 0 || transducer.drift > 0) {
  if (axes > 3 || channels % (axes * rows) != 0)
    throw std::invalid_argument("channels that are no whole axes and rows");
  const Device& device = executor.device();
  const int lanes = device.lanes(Precision::fp32);
  vectors_ = static_cast<std::uint32_t>((channels + lanes - 1) / lanes);
  signal_ = Buffer<float>(device, 1);
  const ChainSettings chain = settings(transducer, seed);
  const Buffer<std::uint64_t> no_contacts(device, 1);
  const Buffer<std::uint32_t> no_rows(device, 1);
  const Buffer<float> no_stress(device, 1);
  const Program program(device, "transducer_chain.cl",
                        {{"LANES", std::to_string(lanes)}, {"REAL", real_type(Precision::fp32)}});
  launch_ = executor.prepare(program, "transducer_chain", [&](KernelArguments& kernel) {
    kernel.set("contact", no_contacts);
    kernel.set("first_row", no_rows);
    kernel.set("largest", no_stress);
    kernel.set("stress", signal_);
    kernel.set("signal", signal_);
    kernel.set("vectors", std::uint32_t{vectors_});
    kernel.set("channels", std::uint32_t{channels_});
    kernel.set("tactels", std::uint32_t{tactels_});
    kernel.set("columns", std::uint32_t{tactels_ / static_cast<std::uint32_t>(rows)});
    kernel.set("chain", chain);
  });
}

void TransducerChain::run(std::span<const Contact> contacts, std::span<float> signal) {
  std::vector<std::uint64_t> number;
  std::vector<std::uint32_t> first_row = {0};
  for (const Contact& contact : contacts) {
    number.push_back(contact.number);
    first_row.push_back(first_row.back() + contact.steps);
  }
  const std::size_t rows = first_row.back();
  if (signal.size() != rows * channels_) throw std::invalid_argument("signal of another size than the contacts' steps");
  if (rows == 0) return;
  const Device& device = executor_->device();
  const std::size_t row_size = std::size_t{vectors_} * device.lanes(Precision::fp32);
  if (signal_.size() < rows * row_size) {
    signal_ = Buffer<float>(device, rows * row_size);
    stress_ = others_ ? Buffer<float>(device, rows * row_size) : signal_;  // what others read must stay
  }
  {
    const auto view = stress_.map(MapFor::writing);
    for (std::size_t row = 0; row < rows; ++row) {
      const auto end = std::ranges::copy(signal.subspan(row * channels_, channels_), &view[row * row_size]).out;
      std::fill(end, &view[row * row_size] + row_size, 0.0f);
    }
  }
  const Buffer<std::uint64_t> numbers(device, std::span<const std::uint64_t>(number));
  const Buffer<std::uint32_t> first_rows(device, std::span<const std::uint32_t>(first_row));
  std::vector<float> most(2 * contacts.size(), 0.0f);  // [contacts][all axes, the normal one]
  for (std::size_t c = 0; relative_ && c < contacts.size(); ++c)
    for (std::size_t row = first_row[c]; row < first_row[c + 1]; ++row) {
      raise_to_largest(most[2 * c], signal.subspan(row * channels_, channels_));
      raise_to_largest(most[2 * c + 1], signal.subspan(row * channels_, tactels_));
    }
  const Buffer<float> largest(device, std::span<const float>(most));
  launch_.bind([&](KernelArguments& kernel) {
    kernel.set("contact", numbers);
    kernel.set("first_row", first_rows);
    kernel.set("largest", largest);
    kernel.set("stress", stress_);
    kernel.set("signal", signal_);
  });
  executor_->run(launch_, contacts.size() * vectors_);
  const auto view = signal_.map(MapFor::reading);
  for (std::size_t row = 0; row < rows; ++row) std::copy_n(&view[row * row_size], channels_, &signal[row * channels_]);
}

}  // namespace tactel::host
