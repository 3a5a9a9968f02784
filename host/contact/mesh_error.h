// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <string>

#include "host/contact/planner.h"
#include "host/contact/rung_error.h"

namespace tactel::host {

/// Expected discretization error of an answer: of S absolutely, of P and Q relative to their largest along the path,
/// of stresses at the tactels relative to theirs. It is made of the differences from a finer mesh (docs/accuracy.md).
struct MeshError {
  AnswerError expected;
  std::string finer;  ///< the model of comparison: "81 x 21", "24 elements"
};

/// Returns the error to expect of an answer: exact contact solves the scene again with half the element size, or the
/// patch's twin with twice the elements, or the exact solver with half of more than 24. None where that would take
/// seconds (more than 81 columns, 33 rows or 100 load steps), and where it fails.
std::optional<MeshError> mesh_error(const fem::Scene& scene, const fem::ContactSolution& answer);

/// Returns why mesh_error has no estimate of an answer: "it has more than 81 columns ..." or "24 elements ...".
std::string why_no_estimate(const fem::Scene& scene, const fem::ContactSolution& answer);

/// Returns what the planner knows of its answer's error; none where a mesh missed a contact or no rung was compared.
std::optional<MeshError> mesh_error(const RungChoice& plan);

}  // namespace tactel::host
