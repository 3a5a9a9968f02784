// SPDX-License-Identifier: Apache-2.0
#include "host/contact/pad_rung.h"

#include <fmt/format.h>

#include <algorithm>

#include "host/support/errors.h"
#include "host/support/nearest_word.h"

namespace tactel::host {
namespace {

constexpr double beyond_the_measured = 3;

/// A number of a scene and the range in which errors were measured.
struct MeasuredRange {
  const char* what;
  double value, low, high;
};

std::vector<std::string> outside_of(const std::vector<MeasuredRange>& ranges) {
  constexpr double rounding = 1e-6;  // of a depth in fp32
  std::vector<std::string> outside;
  for (const auto& [what, value, low, high] : ranges)
    if (value < low * (1 - rounding) || value > high * (1 + rounding))
      outside.push_back(fmt::format("{} {:.3g} (measured {:g} to {:g})", what, value, low, high));
  return outside;
}

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
  static constexpr const char* names[pad_classes] = {"smooth", "sharp edge", "rounded edge", "tilted"};
  return names[static_cast<int>(pad_class)];
}

PadClass pad_class(const fem::PadScene& scene) {
  if (scene.indenter.tilt != 0) return PadClass::tilted;
  const auto edge_of = [](double edge) { return edge > 0 ? PadClass::rounded_edge : PadClass::sharp_edge; };
  if (const auto* punch = std::get_if<fem::Punch>(&scene.indenter.shape)) return edge_of(punch->edge);
  if (const auto* box = std::get_if<fem::Box>(&scene.indenter.shape)) return edge_of(box->edge);
  if (std::holds_alternative<fem::LyingCylinder>(scene.indenter.shape)) return PadClass::sharp_edge;
  return PadClass::smooth;
}

PadError expected_pad_error(const PadRung& rung, const fem::PadScene& scene, double depth) {
  const PadClass of = pad_class(scene);
  const auto measured = std::ranges::find(measured_pads(), rung.name, &MeasuredPadRung::name);
  const PadErrors& errors = measured->of[static_cast<int>(of)];
  const double share = depth / scene.sensor.thickness;
  std::vector<MeasuredRange> ranges = {{"sensor.poisson", scene.sensor.poisson, 0.3, 0.5},
                                       {"depth over thickness", share, 0.02, 0.2}};
  if (scene.friction > 0) ranges.push_back({"friction", scene.friction, 0.1, 1.5});
  PadError error{errors.most95, errors.largest, name(of), outside_of(ranges)};
  if (!error.outside.empty()) error.S = std::min(1.0, beyond_the_measured * error.S);
  return error;
}

}  // namespace tactel::host
