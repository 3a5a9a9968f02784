#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "fem/contact_solution.h"
#include "host/executor.h"
#include "nn/transducer_chain.h"

namespace tactel::host {

/// A record of a sensor while an indenter is pressed on it by hand (the paper, sections III and VII.B).
struct Record {
  double seconds = 10, rate = 100;  ///< s, Hz
  std::uint32_t samples() const;
};

/// When the load begins, and how long it grows, stays and falls; evenly. s
struct HandPress {
  double start = 3, rise = 1, hold = 1.5, release = 0.5;
  double load(double t) const;  ///< at time t, over the full load: 0 ... 1
};
/// A press as a hand makes it: starts after 2 to 5 s, grows within 0.5 to 1.5 s, stays for 1 to 2 s, falls within 0.3
/// to 0.7 s, each evenly distributed; words 0 ... 3 of random_words(seed, contact, number).
HandPress hand_press(std::uint64_t seed, std::uint32_t number);

/// What the transducers feel, [samples, 2 tactels] MPa, normal stresses first. The steps of `solution` are equal parts
/// of the load, between which stress changes evenly. Lifting retraces pressing: without the slip on the way back, but a
/// sample that is taken before cannot know.
std::vector<float> pressed_record(const fem::ContactSolution& solution, const HandPress& press, const Record& record);

/// The sample of a record [samples, channels], normal stresses first, with the strongest compression that any one
/// transducer reads.
std::size_t highest_normal_sample(std::span<const float> record, std::size_t channels);

}  // namespace tactel::host
