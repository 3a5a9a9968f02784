// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <limits>
#include <string>
#include <vector>

namespace tactel::host {

/// What the page of a live sensor shows.
struct LivePage {
  struct Pad {
    std::string name;
    std::array<int, 2> tactels{};       ///< along x and y; 0: a line
    std::array<double, 2> pitch{0, 0};  ///< mm; 0: not told
  };
  std::string source;     ///< what it says of the sensor
  std::vector<Pad> pads;  ///< one or more
  std::string signal;     ///< key of the lines that the alarm judges: "slip_index", "slid" or "moved"
  float alarm = std::numeric_limits<float>::infinity();  ///< from which there is one; infinity: none is asked for
  bool bound = false;                                    ///< the alarm judges the upper bound of S
};

/// Returns a page (host/figures/page/live.js) that listens at "events", beside its own address, to server-sent events:
/// lines of `tactel monitor --stresses`, and one named "end" with a sentence.
std::string html(const LivePage& page);

}  // namespace tactel::host
