// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

namespace tactel::host {

/// Model of a contact on a pad: cells along a side, and the least number of increments to each pressing target.
struct PadRung {
  std::string name;
  int cells = 12;
  int increments = 4;
  bool exact = false;  ///< fem::PadReference, which states its own error
};

/// Returns all rungs of pads, cheapest first. The last is the reference.
const std::vector<PadRung>& pad_rungs();
/// Returns the rung where none is asked for.
const PadRung& usual_pad_rung();
/// Returns the rung of a name. Throws ConfigError naming --rung.
const PadRung& pad_rung_named(const std::string& name);
std::vector<std::string> pad_rung_names();
/// Returns "12 x 12 cells, 4 increments".
std::string description(const PadRung& rung);

}  // namespace tactel::host
