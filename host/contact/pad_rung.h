// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <span>
#include <string>
#include <vector>

#include "fem/pad/pad_reference.h"

namespace tactel::host {

/// Model of a contact on a pad: cells along a side, and the least number of increments to each pressing target.
struct PadRung {
  std::string name;
  int cells = 12;
  int increments = 4;
  bool exact = false;  ///< fem::PadReference, which states its own error
};

/// Returns all rungs of pads, cheapest first. The last is the reference.
const std::vector<PadRung>& pad_rungs();
/// Returns the rung where none is asked for.
const PadRung& usual_pad_rung();
/// Returns the rung of a name. Throws ConfigError naming --rung.
const PadRung& pad_rung_named(const std::string& name);
std::vector<std::string> pad_rung_names();
/// Returns "12 x 12 cells, 4 increments".
std::string description(const PadRung& rung);

/// Classes of scenes on pads whose errors differ.
enum class PadClass { smooth, sharp_edge, rounded_edge, tilted, height_map };
inline constexpr int pad_classes = 5;
const char* name(PadClass pad_class);  ///< "smooth", "sharp edge", "rounded edge", "tilted", "height map"
PadClass pad_class(const fem::PadScene& scene);

/// Errors of a rung on scenes of a class: what 95 % of them stay below, and the largest of S.
struct PadErrors {
  fem::PadReferenceSolution::Errors most95;
  double largest;
};
/// By class, [pad_classes]; host/contact/measured_pads.cpp holds them.
struct MeasuredPadRung {
  const char* name;
  std::array<PadErrors, pad_classes> of;
};
std::span<const MeasuredPadRung> measured_pads();

/// Errors to expect of an answer on a pad.
struct PadError {
  fem::PadReferenceSolution::Errors most95;  ///< what 95 % of answers stay below
  double largest = 0;                        ///< of S: what almost all stay below
  std::string scenes;                        ///< "this scene"; "smooth": by the class of the scene
  std::vector<std::string>
      outside{};       ///< what lies outside the scenes measured, "friction 0.01 (measured 0.05 to 1.5)"
  std::string from{};  ///< the second solution of this scene: "24 x 24 cells"; empty: by the class
};

/// Scenes on which errors were measured, by Poisson's ratio, depth over the thickness and friction above 0: the table,
/// and what a second solution of a scene states (host/contact/pad_judge.h).
struct MeasuredPadScenes {
  fem::Interval poisson, depth, friction;
};
inline constexpr MeasuredPadScenes measured_classes{{0.3, 0.5}, {0.02, 0.2}, {0.1, 1.5}},
    measured_judge{{0, 0.5}, {0.01, 0.2}, {0.05, 1.5}};
/// Returns what of a scene that was pressed to this depth, mm, lies outside.
std::vector<std::string> outside(const MeasuredPadScenes& measured, const fem::PadScene& scene, double depth);

/// Returns what errors rest on: "beside 24 x 24 cells", "95 % of scenes, smooth".
std::string judged_by(const PadError& error);

double deepest(const fem::PadSolution& solution);  ///< mm, of all steps

/// Returns the errors of a rung below the reference on the class of a scene.
const PadErrors& class_errors(const PadRung& rung, const fem::PadScene& scene);
/// Returns an element of pad_rungs(): the cheapest whose errors of the class keep an accuracy of S, else the finest
/// below the reference.
const PadRung& first_pad_rung(const fem::PadScene& scene, double accuracy);
/// Returns the errors to expect by them on a scene that was pressed to this depth, mm: for a scene outside the measured
/// ones three times those, as on lines (host/contact/planner.h).
PadError expected_pad_error(const PadRung& rung, const fem::PadScene& scene, double depth);

}  // namespace tactel::host
