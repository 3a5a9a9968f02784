// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "host/networks/onnx_file.h"
#include "tests/host/live/simulated_frames.h"

namespace tactel::host {

inline std::vector<nlohmann::json> lines_of(const std::string& text) {
  std::vector<nlohmann::json> lines;
  std::istringstream in(without_progress(text));
  for (std::string line; std::getline(in, line);) lines.push_back(nlohmann::json::parse(line));
  return lines;
}

/// A network that takes the simulation's frames, and a place for a recording.
class LiveCommand : public ::testing::Test {
 protected:
  ScratchFolder folder_;
  std::string network_ = (folder_ / "n.onnx").string(), recording_ = (folder_ / "r.tactel").string();
  LiveCommand() { write_onnx(network_, network(21)); }
};

}  // namespace tactel::host
