// SPDX-License-Identifier: Apache-2.0

// The tables of quantities, beside the manual that users read.
#include "host/answers/quantities.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>
#include <string>

#include "host/answers/step_quantities.h"
#include "test_paths.h"

namespace tactel::host::quantities_test {

/// The text of docs/answers.md from `begin` to `end`.
std::string manual(const std::string& begin, const std::string& end) {
  std::ifstream file(std::string(TACTEL_SOURCE_DIR) + "/docs/answers.md");
  std::stringstream text;
  text << file.rdbuf();
  const std::size_t from = text.str().find(begin), to = text.str().find(end, from);
  EXPECT_NE(to, std::string::npos) << begin;
  return text.str().substr(from, to - from);
}

/// The line of a key, which stands in backquotes.
std::string line_of(const std::string& text, const std::string& key) {
  const std::size_t at = text.find('`' + key + '`');
  if (at == std::string::npos) return "";
  const std::size_t begin = text.rfind('\n', at), end = text.find('\n', at);
  return text.substr(begin, end - begin);
}

void expect_documented(const auto& step, const std::string& text) {
  each(quantities<false>(step), [&](const auto& quantity) {
    const std::string line = line_of(text, quantity.key);
    EXPECT_NE(line, "") << quantity.key;
    if (line.find("as above") == std::string::npos) {
      EXPECT_NE(line.find(quantity.unit), std::string::npos) << quantity.key << " in" << line;
    }
  });
  each(residuals(step.residual), [&](const auto& law) { EXPECT_NE(line_of(text, law.key), "") << law.key; });
}

TEST(Quantities, OfALineStandInTheManualWithTheirUnits) {
  expect_documented(fem::ContactStep{}, manual("Each of `steps`:", "## A pad as JSON"));
}

TEST(Quantities, OfAPadStandInTheManualWithTheirUnits) {
  const std::string pads = manual("## A pad as JSON", "S = 1 / lambda");
  expect_documented(fem::PadStep{}, pads.substr(pads.find("Each of `steps`:")));
}

TEST(Quantities, ManyAnswersKeepThoseOfThePathInTheirOrder) {
  const fem::ContactStep line{};
  const fem::PadStep pad{};
  std::string keys, of_pads;
  each(quantities<true>(line), [&](const auto& quantity) { keys += std::string(quantity.key) + ' '; });
  each(quantities<true>(pad), [&](const auto& quantity) { of_pads += std::string(quantity.key) + ' '; });
  EXPECT_EQ(keys, "indentation tangential P Q slip_index slip_distance sigma_y tau_xy converged ");
  EXPECT_EQ(
      of_pads,
      "indentation tangential twist P Q M slip_index force_ratio stick_fraction slip_distance sigma_z tau_x tau_y "
      "converged ");
}

}  // namespace tactel::host::quantities_test
