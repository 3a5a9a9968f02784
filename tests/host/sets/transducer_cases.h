// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <random>
#include <vector>

#include "host/sets/transducer_chain.h"
#include "tests/host/networks/network_cases.h"

namespace tactel::tests {

inline const nn::Transducer all_parts{.gain_spread = 0.1,
                                      .time_constant = 1,
                                      .step_time = 0.05,
                                      .offset_spread = 0.02,
                                      .noise = 0.03,
                                      .range = 0.8,
                                      .instances = 3,
                                      .seed = 5};

/// Nuisances of real skins, each sensor its own.
inline const nn::Transducer skin_parts{.step_time = 0.05,
                                       .seed = 5,
                                       .shift_spread = 0.1,
                                       .crosstalk = 0.05,
                                       .dead = 0.05,
                                       .lag = 0.04,
                                       .lag_time = 0.3,
                                       .memory = 0.04,
                                       .memory_time = 0.6,
                                       .mixing = 0.05,
                                       .drift = 0.1,
                                       .repeats = 0.5,
                                       .shear_gain = 3,
                                       .mixing_from = 0,
                                       .drift_from = 0,
                                       .repeats_from = 0,
                                       .shear_gain_from = 0.3,
                                       .lag_from = 0.02,
                                       .lag_time_from = 0.1,
                                       .memory_from = 0,
                                       .memory_time_from = 0.3};

/// Contacts of ragged lengths with stresses up to 1 MPa, some contacts beyond 2^32.
struct TransducerCase {
  std::vector<host::TransducerChain::Contact> contacts;
  std::vector<float> stress;

  TransducerCase(int count, int channels) {
    std::mt19937 random(7);
    std::uniform_real_distribution<float> uniform(-1, 1);
    for (int c = 0; c < count; ++c)
      contacts.push_back({c * 3000000001ull, static_cast<std::uint32_t>((c * 7 + 3) % 11)});
    std::uint32_t steps = 0;
    for (const auto& contact : contacts) steps += contact.steps;
    stress.resize(std::size_t{steps} * channels);
    for (float& s : stress) s = uniform(random);
  }
  std::vector<float> on_device(const nn::Transducer& t, int channels, int axes = 2, int rows = 1) const {
    std::vector<float> signal = stress;
    host::TransducerChain(executor(), t, 11, channels, axes, rows).run(contacts, signal);
    return signal;
  }
  std::vector<double> by_twin(const nn::Transducer& t, int channels, int axes = 2, int rows = 1) const {
    std::vector<double> all;
    std::size_t at = 0;
    for (const auto& contact : contacts) {
      const auto in = Eigen::Map<const nn::RowMatrix<float>>(&stress[at], contact.steps, channels);
      const auto out = nn::transducer_chain(t, 11, contact.number, in.cast<double>(), axes, rows);
      all.insert(all.end(), out.data(), out.data() + out.size());
      at += in.size();
    }
    return all;
  }
};

}  // namespace tactel::tests
