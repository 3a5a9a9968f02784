// SPDX-License-Identifier: Apache-2.0
#include "host/contact/pads/pad_rung.h"

#include <fmt/format.h>

#include <algorithm>

#include "host/support/errors.h"
#include "host/support/nearest_word.h"

namespace tactel::host {
const std::vector<PadRung>& pad_rungs() {
  static const std::vector<PadRung> rungs = {
      {"pad-8", 8, 2}, {"pad-12", 12, 4}, {"pad-16", 16, 6}, {"pad-24", 24, 8}, {"reference", 64, 16, true}};
  return rungs;
}

const PadRung& usual_pad_rung() { return pad_rung_named("pad-12"); }

const PadRung& pad_rung_named(const std::string& name) {
  const auto found = std::ranges::find(pad_rungs(), name, &PadRung::name);
  if (found == pad_rungs().end())
    throw ConfigError("command line", "--rung", name,
                      "a rung of pads, one of " + listed(pad_rung_names()) + did_you_mean(name, pad_rung_names()));
  return *found;
}

std::vector<std::string> pad_rung_names() {
  std::vector<std::string> names;
  for (const PadRung& rung : pad_rungs()) names.push_back(rung.name);
  return names;
}

std::string description(const PadRung& rung) {
  return fmt::format("{0} x {0} cells, {1} increments", rung.cells, rung.increments);
}

}  // namespace tactel::host
