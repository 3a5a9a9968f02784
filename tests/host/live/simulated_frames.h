// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "host/live/open_source.h"
#include "nn/model.h"
#include "tests/host/support/run_tactel.h"

namespace tactel::host {

/// An untrained network: any S will do to follow frames through.
inline nn::Model network(int tactels) {
  const nn::Topology topology({2 * tactels, 2 * tactels, 1});
  return {nn::initial_weights(topology, 7), {nn::ScalingKind::frame, 1.0f}, 7, 0, "", 0, {}};
}

inline const std::string scene = source_file("examples/parabola.toml");
/// As fast as it is taken: 1 + 320 frames.
inline const std::string simulation = "simulate:" + scene + "?rate=100&paced=0";

/// The bytes of the simulation and the profile that reads them.
inline std::pair<std::vector<std::uint8_t>, SensorProfile> simulated_bytes() {
  OpenSource opened = open_source(simulation, "", "");
  std::vector<std::uint8_t> bytes;
  while (const auto packet = opened.source->wait(0))
    bytes.insert(bytes.end(), packet->bytes.begin(), packet->bytes.end());
  return {bytes, opened.profile};
}

}  // namespace tactel::host
