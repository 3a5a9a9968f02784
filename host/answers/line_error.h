// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <future>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "fem/gap/answer_error.h"
#include "fem/gap/contact_solution.h"
#include "fem/scenes/scene.h"
#include "host/scenes/ladder.h"

namespace tactel::host {

using fem::AnswerError;
/// Those of lines, which tables of errors have.
inline constexpr std::array<double AnswerError::*, 5> error_members = {
    &AnswerError::S, &AnswerError::P, &AnswerError::Q, &AnswerError::sigma, &AnswerError::tau};
inline constexpr std::array<const char*, 5> error_names = {"S", "P", "Q", "sigma", "tau"};

/// Errors to expect of an answer: on lines from its differences from a finer one (docs/accuracy.md), on pads what 95 %
/// of answers stay below.
struct ExpectedError {
  AnswerError expected;
  std::string from{};    ///< the model of comparison: "81 x 21", "24 elements", "24 x 24 cells"; empty: by class
  double largest = 0;    ///< of pads, of S: what almost all answers stay below
  double strain = 0;     ///< of pads: the part of P and sigma that large strain adds
  std::string scenes{};  ///< of pads: "this scene"; "smooth": by the class of the scene
  std::vector<std::string> outside{};  ///< of pads: "friction 0.01 (measured 0.05 to 1.5)", outside the measured scenes
};

/// Returns the error of `answer` on `rung`, beside `judge` on `judge_rung`. The tactels at the very ends are
/// excluded: there the bonded base meets the free side, and the exact stress is infinite.
AnswerError answer_error(const fem::Scene& scene, const fem::ContactSolution& answer, const Rung& rung,
                         const fem::ContactSolution& judge, const Rung& judge_rung);

/// The same at given steps of both, pair by pair.
AnswerError answer_error(const fem::ContactSolution& answer, std::span<const std::size_t> steps,
                         const fem::ContactSolution& judge, std::span<const std::size_t> judge_steps);

/// Returns true for an answer whose patch ends less than half a thickness from an end of the rubber
/// (fem/layer/end_mesh.h): only the reference resolves the corner there.
bool near_end(const fem::Sensor& sensor, const fem::ContactSolution& answer);

/// Returns the error of S to expect of a patch of up to 24 elements besides that of their number: where a contact is
/// near an end, 0.01 + 0.05 (1/2 - nu), since patches were up to 0.023 off from meshes at nu = 0; 1 (unknown) where,
/// with mu above 0.5, wide contact on thin rubber breaks loose between two steps, since the number of elements decides
/// between which.
double model_error(const fem::Scene& scene, const fem::ContactSolution& answer);

/// The answer of a scene's finer model. Begun before the scene is solved, it takes the time of another core.
using FinerAnswer = std::future<fem::ContactSolution>;

/// Begins to solve a scene on a mesh with half the element size, in a thread of its own. Returns a future without a
/// state where mesh_error would not solve it, or where the load path depends on the scene's own answer.
FinerAnswer begin_finer(const fem::Scene& scene);

/// Error over difference from half the element size: contact converges to first order at worst, and so the error
/// halves.
inline constexpr double first_order = 2;
AnswerError scaled(AnswerError error, double factor);

/// Returns the error to expect of an answer: exact contact solves the scene again with half the element size, or the
/// patch's twin with twice the elements, or the exact solver with half of more than 24. None where that would take
/// seconds (more than 81 columns, 33 rows or 100 load steps), and where it fails.
/// `finer`: of begin_finer; without a state it is made here.
std::optional<ExpectedError> mesh_error(const fem::Scene& scene, const fem::ContactSolution& answer,
                                        FinerAnswer finer = {});

/// Returns why mesh_error has no estimate of an answer: "it has more than 81 columns ..." or "24 elements ...".
std::string why_no_estimate(const fem::Scene& scene, const fem::ContactSolution& answer);

/// Quantiles over many scenes: median, 95 %, largest.
struct ErrorQuantiles {
  AnswerError median, most95, largest;
};
ErrorQuantiles quantiles(const std::vector<AnswerError>& errors);

/// Returns the smallest of the values that at least this share of them does not exceed; 0 for no values. The result
/// is always one of the values, so that a promised error is one that occurred; nn::quantile interpolates.
double covering_value(std::vector<double> values, double share);

/// A line that a share of errors stays below: error <= least + slope times the difference of two rungs.
struct ErrorLine {
  double least = 0;  ///< two rungs may agree by chance
  double slope = 0;
  double at(double difference) const { return least + slope * difference; }
};

}  // namespace tactel::host
