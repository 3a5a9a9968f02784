// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "fem/contact_solution.h"
#include "host/device/executor.h"
#include "nn/transducer_chain.h"

namespace tactel::host {

/// A record of a sensor while an indenter is pressed on it by hand (the paper, sections III and VII.B).
struct Record {
  double seconds = 10, rate = 100;  ///< s, Hz
  std::uint32_t samples() const;
};

/// Times of a press: start, linear rise, hold and linear release. s
struct HandPress {
  double start = 3, rise = 1, hold = 1.5, release = 0.5;
  double load(double t) const;  ///< load at time t over the full load: 0 ... 1
};
/// Returns a random press: it starts after 2 to 5 s, rises within 0.5 to 1.5 s, holds for 1 to 2 s and is
/// released within 0.3 to 0.7 s, each uniformly distributed. It uses words 0 ... 3 of random_words(seed, contact,
/// number).
HandPress hand_press(std::uint64_t seed, std::uint32_t number);

/// Returns the stress at the transducers, [samples, 2 tactels] MPa, normal stresses first. The steps of
/// `solution` are equal parts of the load, with linear stress between them. The release retraces the press,
/// without the slip of a real release. A sample taken before the release is not affected.
std::vector<float> pressed_record(const fem::ContactSolution& solution, const HandPress& press, const Record& record);

/// Returns the sample of a record [samples, channels], normal stresses first, with the strongest compression at
/// any single transducer.
std::size_t highest_normal_sample(std::span<const float> record, std::size_t channels);

}  // namespace tactel::host
