// SPDX-License-Identifier: Apache-2.0
#include "host/contact/pad_rung.h"

#include <fmt/format.h>

#include <algorithm>

#include "host/support/errors.h"
#include "host/support/nearest_word.h"

namespace tactel::host {
namespace {

constexpr double beyond_the_measured = 3;

}  // namespace

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

const char* name(PadClass pad_class) {
  static constexpr const char* names[pad_classes] = {"smooth", "sharp edge", "rounded edge", "tilted", "height map"};
  return names[static_cast<int>(pad_class)];
}

PadClass pad_class(const fem::PadScene& scene) {
  if (scene.indenter.tilt != 0) return PadClass::tilted;
  const auto edge_of = [](double edge) { return edge > 0 ? PadClass::rounded_edge : PadClass::sharp_edge; };
  if (const auto* punch = std::get_if<fem::Punch>(&scene.indenter.shape)) return edge_of(punch->edge);
  if (const auto* box = std::get_if<fem::Box>(&scene.indenter.shape)) return edge_of(box->edge);
  if (std::holds_alternative<fem::HeightMap>(scene.indenter.shape)) return PadClass::height_map;
  if (std::holds_alternative<fem::LyingCylinder>(scene.indenter.shape)) return PadClass::sharp_edge;
  return PadClass::smooth;
}

std::vector<std::string> outside(const MeasuredPadScenes& measured, const fem::PadScene& scene, double depth) {
  constexpr double rounding = 1e-6;  // of a depth in fp32
  std::vector<std::string> all;
  const auto check = [&](const char* what, double value, const fem::Interval& in) {
    if (value < in.left * (1 - rounding) || value > in.right * (1 + rounding))
      all.push_back(fmt::format("{} {:.3g} (measured {:g} to {:g})", what, value, in.left, in.right));
  };
  check("sensor.poisson", scene.sensor.poisson, measured.poisson);
  check("depth over thickness", depth / scene.sensor.thickness, measured.depth);
  if (scene.friction > 0) check("friction", scene.friction, measured.friction);
  return all;
}

std::string judged_by(const PadError& error) {
  if (!error.from.empty()) return "beside " + error.from;
  return error.outside.empty() ? "95 % of scenes, " + error.scenes : "three times that of measured scenes";
}

double deepest(const fem::PadSolution& solution) {
  double depth = 0;
  for (const fem::PadStep& step : solution.steps) depth = std::max(depth, step.indentation);
  return depth;
}

const PadErrors& class_errors(const PadRung& rung, const fem::PadScene& scene) {
  const auto measured = std::ranges::find(measured_pads(), rung.name, &MeasuredPadRung::name);
  return measured->of[static_cast<int>(pad_class(scene))];
}

const PadRung& first_pad_rung(const fem::PadScene& scene, double accuracy) {
  const std::vector<PadRung>& rungs = pad_rungs();
  return *std::find_if(rungs.begin(), std::prev(rungs.end(), 2),
                       [&](const PadRung& rung) { return class_errors(rung, scene).most95.slip_index <= accuracy; });
}

PadError expected_pad_error(const PadRung& rung, const fem::PadScene& scene, double depth) {
  const PadErrors& errors = class_errors(rung, scene);
  PadError error{errors.most95, errors.largest, name(pad_class(scene)), outside(measured_classes, scene, depth)};
  if (error.outside.empty()) return error;
  for (const auto member : fem::pad_error_members) error.most95.*member *= beyond_the_measured;
  double& S = error.most95.slip_index;
  S = std::min(1.0, S), error.largest = std::max(error.largest, S);
  return error;
}

}  // namespace tactel::host
