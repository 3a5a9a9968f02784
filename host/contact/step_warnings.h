// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace tactel::host {

/// Returns "load step 2" or "load steps 1 to 3, 5" of increasing numbers, at least one, that count from 1.
std::string steps_text(const std::vector<std::size_t>& numbers);

/// Steps whose contact extends over few cells or elements.
struct FewInSteps {
  std::string steps;  ///< as steps_text
  int fewest = 0;     ///< in any of them
};
/// `across`: the cells or elements of each step, of which some but fewer than `least` are few.
std::optional<FewInSteps> few_in_steps(const std::vector<int>& across, int least);

/// Returns a warning about steps that touch nothing, and those of them that are pressed; none where there are none.
std::optional<std::string> untouched_warning(const std::vector<std::size_t>& untouched,
                                             const std::vector<std::size_t>& pressed);

/// The same of the steps of an answer, of a line or a pad.
template <class Step>
std::optional<std::string> untouched_warning(const std::vector<Step>& steps) {
  std::vector<std::size_t> untouched, pressed;
  for (std::size_t k = 0; k < steps.size(); ++k) {
    if (steps[k].P != 0) continue;
    untouched.push_back(k + 1);
    if (steps[k].indentation > 0) pressed.push_back(k + 1);
  }
  return untouched_warning(untouched, pressed);
}

}  // namespace tactel::host
