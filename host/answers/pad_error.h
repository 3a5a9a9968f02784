// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "fem/pad/pad_solver.h"
#include "host/answers/line_error.h"
#include "host/scenes/ladder.h"

namespace tactel::host {

/// Classes of scenes on pads whose errors differ.
enum class PadClass { smooth, sharp_edge, rounded_edge, tilted, height_map };
inline constexpr int pad_classes = 5;
const char* name(PadClass pad_class);  ///< "smooth", "sharp edge", "rounded edge", "tilted", "height map"
PadClass pad_class(const fem::PadScene& scene);

/// Errors of a rung on scenes of a class: what 95 % of them stay below, and the largest of S.
struct PadErrors {
  AnswerError most95;
  double largest;
};
/// By class, [pad_classes]; host/answers/measured_pads.cpp holds them.
struct MeasuredPadRung {
  const char* name;
  std::array<PadErrors, pad_classes> of;
};
std::span<const MeasuredPadRung> measured_pads();

/// Scenes on which errors were measured, by Poisson's ratio, depth over the thickness and friction above 0: the table,
/// and what a second solution of a scene states (PadJudge).
struct MeasuredPadScenes {
  fem::Interval poisson, depth, friction;
};
inline constexpr MeasuredPadScenes measured_classes{{0.3, 0.5}, {0.02, 0.2}, {0.1, 1.5}},
    measured_judge{{0, 0.5}, {0.01, 0.2}, {0.05, 1.5}};
/// Returns what of a scene that was pressed to this depth, mm, lies outside.
std::vector<std::string> outside(const MeasuredPadScenes& measured, const fem::PadScene& scene, double depth);

/// Returns what errors rest on: "beside 24 x 24 cells", "95 % of scenes, smooth".
std::string judged_by(const ExpectedError& error);

/// Returns how deep the rubber is pressed in any step, mm; a soft object takes its part, of which this is the least.
double deepest(const fem::PadScene& scene, const fem::PadSolution& solution);

/// Returns true for punches, boxes and height maps.
bool has_flat_face(const fem::PadScene& scene);
inline constexpr double deep_face = 0.05;  ///< depth over thickness from which faces are warned of
/// Returns what large strain adds to P at most, over it: rubber is linear here. Of neo-Hookean rubber, under faces 1.6
/// depth over thickness, under balls 1.3 %, half the depth where they touch 1.5 thicknesses to a side or more
/// (docs/notebook/2026-11-29-answers.md).
double strain_error(const fem::PadScene& scene, const fem::PadSolution& solution);
/// Returns by how much a curved skin bears less than the flat layer that stands for it, at most, over P: 0.7 H /
/// radius, of nu 0.48 and depths to 0.15 H.
double curvature_error(const fem::PadSensor& sensor);
/// Completes the errors of an answer, whose Q and M may be 0, by those of large strain and of curved skins.
void complete(ExpectedError& error, const fem::PadScene& scene, const fem::PadSolution& solution);

/// Returns the errors of a rung below the reference on the class of a scene.
const PadErrors& class_errors(const PadRung& rung, const fem::PadScene& scene);
/// Returns an element of all_rungs<PadRung>(): the cheapest whose errors of the class keep an accuracy of S, else the
/// finest below the reference.
const PadRung& first_pad_rung(const fem::PadScene& scene, double accuracy);
/// Returns the errors to expect by them on a scene that was pressed to this depth, mm: for a scene outside the measured
/// ones three times those, as on lines (host/answers/planner.h).
ExpectedError expected_pad_error(const PadRung& rung, const fem::PadScene& scene, double depth);

/// Returns the cheapest rung that is expected to keep an accuracy of S on all of these scenes; the reference where none
/// below it is. `depth(k)`: to which scene k was pressed, mm.
const PadRung& cheapest_pad_rung(std::span<const fem::PadScene> scenes, double accuracy,
                                 const std::function<double(std::size_t k)>& depth);

/// Solves a scene a second time to state the errors of its answers: by the twin, on more cells with twice as many
/// increments of pressing and drags. Keeps a reference to the scene.
class PadJudge {
 public:
  explicit PadJudge(const fem::PadScene& scene) : scene_(scene) {}

  /// Returns the cells along a side of second solutions that an accuracy tries for a rung, cheapest first.
  static std::vector<int> cells(const PadRung& rung);
  static int usual_cells(const PadRung& rung) { return std::max(24, 4 * rung.cells / 3); }
  /// Returns false for more load steps than 100, which would take seconds.
  static bool serves(std::size_t steps);

  /// Returns the errors to expect of an answer: its differences from a second solution on so many cells, times factors,
  /// and a little. They cover 95 % of scenes (bench/pad_study.cpp). None where it does not serve, and where the second
  /// solution misses its tolerance.
  std::optional<ExpectedError> error(const PadRung& rung, const fem::PadSolution& answer, int cells);
  std::optional<ExpectedError> error(const PadRung& rung, const fem::PadSolution& answer) {
    return error(rung, answer, usual_cells(rung));
  }

 private:
  const fem::PadSolution& finer(int cells);

  const fem::PadScene& scene_;
  std::map<int, fem::PadSolution> finer_;  ///< by their cells
};

}  // namespace tactel::host
