// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "host/studies/floor/floor.h"

namespace tactel::host {
namespace {

using Json = nlohmann::ordered_json;

std::string error_text(const FloorError& error) {
  return error.readings == 0 ? "-" : fmt::format("{:.4f} +- {:.4f}", error.mean, error.standard_error);
}

std::string line_of(const FloorClass& one, const std::string& name) {
  std::string line = fmt::format("{:<34}{:>18}{:>18}{:>18}", name, error_text(one.lower), error_text(one.estimate),
                                 error_text(one.upper));
  for (const FloorError& network : one.networks) line += fmt::format("{:>18}", error_text(network));
  return line + '\n';
}

Json to_json(const FloorError& error) {
  if (error.readings == 0) return {{"mean", nullptr}, {"standard_error", nullptr}, {"readings", 0}};
  return {{"mean", error.mean}, {"standard_error", error.standard_error}, {"readings", error.readings}};
}

Json to_json(const FloorClass& one, const std::vector<std::string>& networks) {
  Json json = {{"lower", to_json(one.lower)},
               {"estimate", to_json(one.estimate)},
               {"upper", to_json(one.upper)},
               {"networks", Json::object()}};
  for (std::size_t i = 0; i < networks.size(); ++i) json["networks"][networks[i]] = to_json(one.networks[i]);
  return json;
}

}  // namespace

std::string floor_table(const Floor& floor, const FloorOptions& options, const std::vector<std::string>& networks) {
  std::string text = fmt::format(
      "mean |error of S| that the frames allow: noise {:g}, gains {:g}, {} frame{}; a bank of {} rows\n"
      "the floor lies between \"below\" (any estimator) and \"above\" (one estimator);\n"
      "\"estimate\" is by derivatives, and no bound\n\n",
      options.noise, options.gain, options.history.frames, options.history.frames == 1 ? "" : "s", floor.bank);
  text += fmt::format("{:<34}{:>18}{:>18}{:>18}", "contacts", "below", "estimate", "above");
  for (std::size_t i = 0; i < networks.size(); ++i) text += fmt::format("{:>18}", fmt::format("network {}", i + 1));
  text += '\n' + line_of(floor.all, "all");
  std::string family;
  for (const FloorClass& one : floor.classes) {
    if (one.family != family) text += "\n" + one.family + "\n";
    family = one.family;
    text += line_of(one, "  " + one.name);
  }
  text += "\nrows of the bank        below    above\n";
  for (const FloorStep& step : floor.convergence)
    text += fmt::format("{:<20}{:>9.4f}{:>9.4f}\n", step.bank, step.lower, step.upper);
  for (std::size_t i = 0; i < networks.size(); ++i) text += fmt::format("network {}: {}\n", i + 1, networks[i]);
  return text;
}

Json to_json(const Floor& floor, const FloorOptions& options, const std::vector<std::string>& networks) {
  Json json = {{"noise", options.noise},
               {"gain", options.gain},
               {"noise_of", options.noise_of_contact ? "contact" : "frame"},
               {"history", options.history.frames},
               {"stride", options.history.stride},
               {"history_change", options.history.change},
               {"bank_rows", floor.bank},
               {"spread", floor.spread},
               {"seed", options.seed},
               {"seconds", floor.seconds},
               {"all", to_json(floor.all, networks)},
               {"classes", Json::array()},
               {"convergence", Json::array()}};
  for (const FloorClass& one : floor.classes) {
    json["classes"].push_back({{"family", one.family}, {"class", one.name}});
    json["classes"].back().update(to_json(one, networks));
  }
  for (const FloorStep& step : floor.convergence)
    json["convergence"].push_back({{"bank_rows", step.bank}, {"lower", step.lower}, {"upper", step.upper}});
  return json;
}

std::string skin_table(std::span<const SkinFloor> skins, const std::vector<std::string>& networks) {
  std::string text = fmt::format(
      "mean |error of S| that the frames allow; a bank of {} rows or more\n"
      "the floor lies between \"below\" (any estimator) and \"above\" (one estimator);\n"
      "\"estimate\" is by derivatives, and no bound\n\n"
      "tactels  pitch   thickness  frames  noise   gains   below  estimate   above",
      std::ranges::min(skins, {}, [](const SkinFloor& skin) { return skin.floor.bank; }).floor.bank);
  for (std::size_t i = 0; i < networks.size(); ++i) text += fmt::format("{:>11}", fmt::format("network {}", i + 1));
  text += "\n            mm          mm\n";
  for (const SkinFloor& skin : skins) {
    const FloorClass& all = skin.floor.all;
    text += fmt::format("{:>7}{:>7.3g}{:>12.3g}{:>8}{:>7.3g}{:>8.3g}{:>8.4f}{:>10.4f}{:>8.4f}", skin.tactels,
                        skin.pitch, skin.thickness, skin.options.history.frames, skin.options.noise, skin.options.gain,
                        all.lower.mean, all.estimate.mean, all.upper.mean);
    for (const FloorError& network : all.networks) text += fmt::format("{:>11.4f}", network.mean);
    text += '\n';
  }
  for (std::size_t i = 0; i < networks.size(); ++i) text += fmt::format("network {}: {}\n", i + 1, networks[i]);
  return text;
}

Json to_json(std::span<const SkinFloor> skins, const std::vector<std::string>& networks) {
  Json json = Json::array();
  for (const SkinFloor& skin : skins) {
    json.push_back({{"tactels", skin.tactels}, {"pitch", skin.pitch}, {"thickness", skin.thickness}});
    json.back().update(to_json(skin.floor, skin.options, networks));
  }
  return json;
}

}  // namespace tactel::host
