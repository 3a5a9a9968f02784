// SPDX-License-Identifier: Apache-2.0

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <sstream>
#include <string_view>

#include "host/commands/program.h"

namespace tactel::host {
namespace {

constexpr std::size_t page_width = 79, name_width = 30, longest_choices = 60;

/// `text` in lines of at most `width` letters, the first of which begins at `column`; the others are indented by
/// `indent`. A word longer than a line stands alone.
std::string wrapped(const std::string& text, std::size_t indent, std::size_t column) {
  std::string out;
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    const bool first = out.empty();
    if (!first && column + 1 + word.size() > page_width) {
      out += "\n" + std::string(indent, ' ');
      column = indent;
    } else if (!first) {
      out += " ";
      ++column;
    }
    out += word;
    column += word.size();
  }
  return out;
}

std::string two_columns(const std::string& name, const std::string& text) {
  std::string out = "  " + name;
  if (out.size() + 2 > name_width)
    out += "\n" + std::string(name_width, ' ');
  else
    out.resize(name_width, ' ');
  return out + wrapped(text, name_width, name_width) + "\n";
}

/// CLI11 says "TEXT:{a,b}", "FLOAT:POSITIVE", "UINT:INT in [1 - 9]"; this "a|b", "NUMBER", "N". Choices that do not fit
/// in a line have their type's name alone: the description lists them.
std::string type_in_words(const std::string& type) {
  const auto open = type.find('{');
  if (open != std::string::npos && type.find('}') - open <= longest_choices) {
    std::string choices = type.substr(open + 1, type.find('}') - open - 1);
    std::replace(choices.begin(), choices.end(), ',', '|');
    return choices;
  }
  auto colon = type.find(':');
  if (colon != std::string::npos && colon > 0 && type[colon - 1] == '[')
    colon = type.find(':', colon + 1);  // K[:STRIDE]
  const std::string plain = type.substr(0, colon);
  if (plain == "FLOAT") return "NUMBER";
  return plain == "INT" || plain == "UINT" ? "N" : plain;
}

struct OptionGroup {
  std::string_view name, options;
};
/// Where the help of every command lists an option: groups and options that are used most come first. An option of a
/// table names its group and its place there, "Learning:7"; one that means something else in one command its group.
constexpr std::array<OptionGroup, 8> option_groups = {{
    {"Input", "--source --profile --calibration --seconds --late --drift --scenes --seed --pads --quick "},
    {"Output",
     "--output --html --json --no-floor --plot --field --step --view --serve --serve-host --stresses "
     "--every --frames --columns --compress --recall --resume --force --checkpoint-seconds "},
    {"Network", "--network --friction --friction-spread --friction-drift --level "},
    {"Learning", "--cycles --seeds --noise-cycles "},
    {"Alarm", "--alarm --signal --rest --decision --decision-csv --touch --hold --slide --unlike --widest --rate "},
    {"Accuracy", "--accuracy --rung --converge --tolerance "},
    {"Device", "--device --also-device --precision --solver --sensors "},
    {"Other", "--quiet --help --version "},
}};

std::size_t place_in(const OptionGroup& group, const CLI::Option* option) {
  const std::string& named = option->get_group();
  if (const auto colon = named.find(':'); colon != std::string::npos) return std::stoul(named.substr(colon + 1));
  return group.options.find(option->get_name() + " ");
}

std::string_view group_of(const CLI::Option* option) {
  const std::string_view named = option->get_group();
  if (named != "Options") return named.substr(0, named.find(':'));
  if (option->get_positional()) return "Input";
  const auto* found = std::ranges::find_if(
      option_groups, [&](const auto& group) { return place_in(group, option) != std::string_view::npos; });
  return found == option_groups.end() ? "Other" : found->name;
}

/// A call of every command that a user may copy. `examples/` is in the source tree, and in the packages.
constexpr std::array<std::string_view, 14> examples = {
    "solve examples/parabola.toml --html parabola.html",
    "generate examples/random_sweep.toml --output random.h5",
    "check random.h5",
    "train random.h5 --output networks --schedule batch",
    "recall networks recall.h5 --html recall.html",
    "calibrate bound networks/bound.onnx other_seed.h5",
    "monitor --source usb:glove --network slip.onnx --view",
    "record --source usb:glove --output frames.tactel --seconds 10",
    "tare --source usb:glove --output offsets.toml",
    "reproduce --output report",
    "tradeoff --output tradeoff",
    "extremes --quick",
    "devices --json",
    "demo --output tactel-demo",
};

/// The example of a command or of its first; none of the program.
std::string example_of(const CLI::App* app) {
  std::string words;
  for (; app->get_parent() != nullptr; app = app->get_parent()) words.insert(0, app->get_name() + " ");
  if (words.empty()) return "";
  const auto* found = std::ranges::find_if(examples, [&](std::string_view call) { return call.starts_with(words); });
  return found == examples.end() ? "" : fmt::format("Examples:\n  tactel {}\n\n", *found);
}

class HelpFormatter : public CLI::Formatter {
 public:
  HelpFormatter() { label("SUBCOMMAND", "COMMAND"); }
  std::string make_description(const CLI::App* app) const override { return paragraph(app->get_description()); }
  std::string make_footer(const CLI::App* app) const override { return example_of(app) + paragraph(app->get_footer()); }
  std::string make_subcommand(const CLI::App* sub) const override {
    return two_columns(sub->get_name(), sub->get_description());
  }
  std::string make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const override {
    return make_description(app) + make_usage(app, std::move(name)) + make_subcommands(app, mode) + grouped(app) +
           "\n" + make_footer(app);
  }
  std::string make_option(const CLI::Option* option, bool positional) const override {
    const std::string type = option->get_type_name();
    const bool takes_value = option->get_type_size() != 0;
    std::string name = positional ? option->get_name(true, false) : option->get_name(false, true);
    for (std::size_t comma = 0; (comma = name.find(',', comma)) != std::string::npos; comma += 2)
      name.insert(comma + 1, " ");
    if (takes_value && !type.empty()) name += " " + type_in_words(type);
    const std::string range = range_in(type);
    std::string text = option->get_description() + (range.empty() ? "" : ", " + range);
    if (takes_value && !option->get_default_str().empty())
      text += fmt::format(" (default: {})", option->get_default_str());
    if (option->get_required() && !positional) text += " (required)";
    return two_columns(name, text);
  }

 private:
  std::string grouped(const CLI::App* app) const {
    std::string out;
    for (const OptionGroup& group : option_groups) {
      auto options = app->get_options([&](const CLI::Option* option) { return group_of(option) == group.name; });
      if (options.empty()) continue;
      std::ranges::stable_sort(options, {}, [&](const CLI::Option* option) {
        return option->get_positional() ? 0 : place_in(group, option);
      });
      out += fmt::format("\n{}:\n", group.name);
      for (const CLI::Option* option : options) out += make_option(option, option->get_positional());
    }
    return out;
  }
  static std::string paragraph(const std::string& text) { return text.empty() ? "" : wrapped(text, 0, 0) + "\n"; }
};

}  // namespace

std::shared_ptr<CLI::FormatterBase> help_formatter() { return std::make_shared<HelpFormatter>(); }

}  // namespace tactel::host
