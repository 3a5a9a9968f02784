// SPDX-License-Identifier: Apache-2.0
#include "host/sets/simulate_family.h"

#include <fmt/format.h>

#include "host/sets/set_simulator.h"

namespace tactel::host {

std::optional<std::string> unsolved_warning(const ContactSet& set) {
  if (set.unsolved == 0) return std::nullopt;
  return fmt::format("{} of {} contacts have a load step that did not meet its tolerance", set.unsolved, set.contacts);
}

ContactSet simulate_family(Executor& executor, const SceneFamily& family, Precision precision, double tolerance) {
  const SceneSource source = source_of(family);
  ContactSet set = SetSimulator(executor, source, {precision, tolerance}).simulate(0, source.contacts());
  if (const auto warning = unsolved_warning(set)) executor.device().log(LogLevel::warning, *warning);
  return set;
}

}  // namespace tactel::host
