// SPDX-License-Identifier: Apache-2.0
#include "host/contact/step_warnings.h"

#include <fmt/format.h>

#include <algorithm>

namespace tactel::host {

std::string steps_text(const std::vector<std::size_t>& numbers) {
  std::string text;
  for (std::size_t first = 0, end = 0; first < numbers.size(); first = end) {
    end = first + 1;
    while (end < numbers.size() && numbers[end] == numbers[end - 1] + 1) ++end;
    text += fmt::format("{}{}", text.empty() ? "" : ", ", numbers[first]);
    if (end > first + 1) text += fmt::format(" to {}", numbers[end - 1]);
  }
  return (numbers.size() > 1 ? "load steps " : "load step ") + text;
}

std::optional<FewInSteps> few_in_steps(const std::vector<int>& across, int least) {
  std::vector<std::size_t> numbers;
  int fewest = least;
  for (std::size_t k = 0; k < across.size(); ++k) {
    if (across[k] == 0 || across[k] >= least) continue;
    numbers.push_back(k + 1);
    fewest = std::min(fewest, across[k]);
  }
  if (numbers.empty()) return std::nullopt;
  return FewInSteps{steps_text(numbers), fewest};
}

std::optional<std::string> untouched_warning(const std::vector<std::size_t>& untouched,
                                             const std::vector<std::size_t>& pressed) {
  if (untouched.empty()) return std::nullopt;
  std::string text = "the indenter touches nothing in " + steps_text(untouched);
  if (!pressed.empty())
    text += fmt::format("; in {} it should: the contact is smaller than what the model resolves there",
                        pressed.size() == untouched.size() ? "all of them" : steps_text(pressed));
  return text;
}

}  // namespace tactel::host
