// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <numeric>
#include <vector>

#include "host/networks/training_checkpoint.h"

namespace tactel::fuzz {

inline const std::string checkpoint_plan = "a training of two networks";

/// Returns what the checkpoints of the corpus hold: two networks after two cycles.
inline std::vector<host::NetworkRecord<float>> checkpoint_records() {
  std::vector<host::NetworkRecord<float>> records;
  for (const auto& widths : {std::vector{4, 3, 1}, std::vector{2, 2, 2, 1}}) {
    const nn::Topology topology(widths);
    host::NetworkRecord<float> record{.network = {.topology = topology},
                                      .state = nn::BatchState<float>(nn::Weights<float>(topology))};
    record.network.cycles = 2;
    record.network.rows = 12;
    record.network.sse = 0.5f;
    record.network.largest = 0.25f;
    record.network.curve = {{1, 6, 0.75f, 0.125f, 0.5f}, {2, 12, 0.5f, 0.08f, 0.25f}};
    std::iota(record.state.weights.values.begin(), record.state.weights.values.end(), -4.0f);
    std::ranges::fill(record.state.first.values, 0.125f);
    record.state.updates = 6;
    record.state.epoch = 2;
    records.push_back(std::move(record));
  }
  return records;
}

}  // namespace tactel::fuzz
