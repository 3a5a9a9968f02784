// SPDX-License-Identifier: Apache-2.0
#include "host/sets/transducer_chain.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "kernels/shared/chain_settings.h"

namespace tactel::host {
namespace {

ChainSettings settings(const nn::Transducer& t, std::uint64_t seed) {
  t.validate();
  constexpr float infinity = std::numeric_limits<float>::infinity();
  const bool filters = t.time_constant > 0, converts = t.bits > 0;
  const double ratio = filters ? t.step_time / t.time_constant : 0;
  const double late = t.lag > 0 ? t.step_time / t.lag_time : 0;
  const float codes = converts ? std::ldexp(1.0f, t.bits - 1) : 0;
  const float limit = t.range > 0 ? static_cast<float>(t.range) : infinity;
  return {.reading_seed = seed,
          .instance_seed = t.seed,
          .instances = t.instances,
          .high_pass = filters,
          .decay = static_cast<float>(std::exp(-ratio)),
          .pass = filters ? static_cast<float>(-std::expm1(-ratio) / ratio) : 1,
          .step_time = static_cast<float>(t.step_time),
          .time_constant = {float(t.time_constant_from.value_or(t.time_constant)), float(t.time_constant)},
          .gain_spread = {float(t.gain_spread_from.value_or(t.gain_spread)), float(t.gain_spread)},
          .offset_spread = {float(t.offset_spread_from.value_or(t.offset_spread)), float(t.offset_spread)},
          .noise = {float(t.noise_from.value_or(t.noise)), float(t.noise)},
          .noise_of_largest = static_cast<float>(t.noise_of_largest),
          .shift_spread = static_cast<float>(t.shift_spread),
          .crosstalk = static_cast<float>(t.crosstalk),
          .dead = static_cast<float>(t.dead),
          .lag = static_cast<float>(t.lag),
          .lag_decay = static_cast<float>(std::exp(-late)),
          .lag_pass = t.lag > 0 ? static_cast<float>(-std::expm1(-late) / late) : 1,
          .low = converts ? -codes : -limit,
          .high = converts ? codes - 1 : limit,
          .quantum = static_cast<float>(t.quantum()),
          .bits = {t.bits_from.value_or(t.bits), t.bits},
          .range = static_cast<float>(t.range)};
}

}  // namespace

TransducerChain::TransducerChain(Executor& executor, const nn::Transducer& transducer, std::uint64_t seed, int channels)
    : executor_(&executor),
      channels_(static_cast<std::uint32_t>(channels)),
      neighbours_(transducer.reaches_neighbours()),
      relative_(transducer.noise_of_largest > 0) {
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
    stress_ = neighbours_ ? Buffer<float>(device, rows * row_size) : signal_;  // what neighbours read must stay
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
  std::vector<float> most(contacts.size(), 0.0f);
  for (std::size_t c = 0; relative_ && c < contacts.size(); ++c)
    for (const float s : signal.subspan(first_row[c] * channels_, contacts[c].steps * channels_))
      if (std::isfinite(s)) most[c] = std::max(most[c], std::abs(s));
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
