// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace tactel {

struct Set;

/// How networks learn; every number defaults to that of `tactel train`.
struct TrainOptions {
  std::vector<std::string> networks{"42-42-21-1"};  ///< widths, or "1" ... "6" for the paper's; of schedule
                                                    ///< "batch" also "42-96-96-1_leaky-relu"
  std::uint64_t seeds = 1, first_seed = 1;          ///< each topology and noise with each seed
  std::vector<double> noises{0.0};  ///< standard deviation of added noise over the set's largest |stress|
  std::string scaling = "set";      ///< "set", "frame" or "rest"
  std::string features = "frame";   ///< of scaling "frame" or "rest": "line" or "pad", one of all mirror images of a
                                    ///< frame and its sums before the network; "line" learns |S|
  std::string schedule = "online";  ///< "online" (the paper's rule), "batch", or "cosine": mini-batches at a rate that
                                    ///< warms up and falls to 0 as a cosine
  std::string optimizer{};          ///< of mini-batches: "adam" (default) or "delta"
  std::string loss{};               ///< of mini-batches: "squared" (default) or "absolute"
  std::string order = "permuted";   ///< or "sequential"
  std::optional<int> cycles{}, batch{};
  std::optional<double> rate{}, momentum{}, stop_error{};
  std::optional<double> warm_up{};  ///< of cosine: share of the training in which the rate rises (0.02)
  std::optional<double> average{};  ///< of mini-batches: decay of the exponential mean of the weights (0: none)
  const Set* validation = nullptr;  ///< of mini-batches: judges each cycle; the weights of the smallest error are kept
  std::optional<int> patience{};    ///< with validation: cycles without a smaller error that end a training (never)
  std::string precision = "fp32", device{};
  std::string name = "set";       ///< of the learning set, in the network's metadata
  bool bound = false;             ///< with the heads of an upper bound of S; of schedule "batch"
  std::optional<double> level{};  ///< of the bound: the probability that S is below it (default: 0.95)
  std::string history{};          ///< "k" or "k:stride": the last k kept frames as one input, of a set with press_rows
  std::optional<double> history_change{};  ///< a frame is kept that differs by more, over the largest stress (0.1)
  std::string target = "slip_index";       ///< column to learn: "slip_index", "force_ratio", "stick_fraction", "slid",
                                           ///< "slip_path", "net_slip", "slid_ahead"
  bool friction = false;                   ///< networks take mu as far as it is known, Alarm::friction
  std::string inputs = "stresses";         ///< or "markers": how each moves along x and y, mm, of a set with markers
};

}  // namespace tactel
