// SPDX-License-Identifier: Apache-2.0
#include "host/sets/set_recipe.h"

#include <fmt/format.h>

#include <map>
#include <sstream>

#include "host/sets/contact_set.h"
#include "host/sets/set_production.h"
#include "host/support/errors.h"

namespace tactel::host {
namespace {

/// "name value" lines; a line of a file also has the file's name in its key.
std::map<std::string, std::string> by_name(const std::string& conditions) {
  std::map<std::string, std::string> values;
  std::istringstream lines(conditions);
  for (std::string line; std::getline(lines, line);) {
    auto blank = line.find(' ');
    if (line.starts_with("file ")) blank = line.rfind(' ');
    values[line.substr(0, blank)] = blank == std::string::npos ? "" : line.substr(blank + 1);
  }
  return values;
}

std::string value_of(const std::map<std::string, std::string>& values, const std::string& name) {
  const auto value = values.find(name);
  return value == values.end() ? "unknown" : value->second;
}

/// "precision fp64 (requested: fp32), ..."; empty where nothing differs.
std::string differences(const std::map<std::string, std::string>& asked,
                        const std::map<std::string, std::string>& made) {
  std::string text;
  const auto note = [&](const std::string& name) {
    const std::string is = value_of(made, name), wanted = value_of(asked, name);
    if (is != wanted) text += fmt::format("{}{} {} (requested: {})", text.empty() ? "" : ", ", name, is, wanted);
  };
  for (const auto& [name, value] : asked) note(name);
  for (const auto& [name, value] : made)
    if (!asked.contains(name)) note(name);
  return text;
}

[[noreturn]] void refuse(const std::string& path, const std::string& allowed) {
  throw ConfigError("command line", "--resume", path, allowed + "; --force overwrites it");
}

}  // namespace

SetRecipe recipe_of(const Sweep& sweep, const std::optional<Rung>& rung, const SetOptions& options,
                    const std::string& columns, bool compress) {
  const std::string tolerance =
      options.accept > 0 ? fmt::format("accepting {:a}", options.accept) : fmt::format("{:a}", options.tolerance);
  std::string conditions =
      fmt::format("tactel " TACTEL_VERSION "\nspool 5\nrung {}\nprecision {}\ntolerance {}\nchunk {}\n",
                  std::holds_alternative<PadSource>(sweep.source) ? options.pad.name
                  : rung                                          ? rung->name
                                                                  : "as the file says",
                  name(options.precision), tolerance, contacts_of_chunk(sweep.source));
  if (!columns.empty()) conditions += "columns " + columns + "\n";
  if (compress) conditions += "compress yes\n";
  int number = 0;
  for (const auto& [file, sum] : common(sweep.source).files())
    conditions += fmt::format("file {} {} {}\n", number++, file, sum);
  return {conditions, sweep.text};
}

std::string model_text(const AnySource& source, const std::optional<Rung>& rung, const SetOptions& options,
                       std::optional<double> accuracy) {
  std::string text = name(options.precision);
  if (std::holds_alternative<PadSource>(source))
    text = fmt::format("{}: {}, {}", options.pad.name, description(options.pad), text);
  else if (rung)
    text = fmt::format("{}: {}", rung->name, description(*rung));
  if (accuracy) text += fmt::format("; the accuracy of {:g} holds for S alone, not for stresses", *accuracy);
  return text;
}

void expect_made_by(const SetRecipe& recipe, const std::string& path) {
  const ContactSet set = read_attributes(path);
  if (set.sweep != recipe.sweep) refuse(path, "a set of this sweep file; it has another");
  if (set.plan.empty())
    refuse(path, "a set of the requested conditions; it is a part of the sweep, or of other options");
  if (const std::string other = differences(by_name(recipe.conditions), by_name(set.plan)); !other.empty())
    refuse(path, "a set of the requested conditions; it has " + other);
}

}  // namespace tactel::host
