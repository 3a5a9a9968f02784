// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <span>
#include <string>
#include <vector>

#include "fem/pad/pad_solver.h"

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
enum class PadClass { smooth, sharp_edge, rounded_edge, tilted };
inline constexpr int pad_classes = 4;
const char* name(PadClass pad_class);  ///< "smooth", "sharp edge", "rounded edge", "tilted"
PadClass pad_class(const fem::PadScene& scene);

/// Errors in S of many scenes, measured.
struct PadErrors {
  double median, most95, largest;
};
/// Errors of a rung by class, [pad_classes]; host/contact/measured_pads.cpp holds them.
struct MeasuredPadRung {
  const char* name;
  std::array<PadErrors, pad_classes> of;
};
std::span<const MeasuredPadRung> measured_pads();

/// Error in S to expect of an answer on a pad.
struct PadError {
  double S = 0;                        ///< what 95 % of such scenes stay below
  double largest = 0;                  ///< largest of the scenes measured
  std::string scenes;                  ///< "smooth": the class; "this scene" where the reference measured it
  std::vector<std::string> outside{};  ///< what lies outside the measured scenes, "friction 0.05 (measured 0.1 to 1.5)"
};

/// Returns the error in S to expect of a rung below the reference on a scene that was pressed to this depth, mm. For a
/// scene outside the mix it is three times that of its class, as on lines (host/contact/planner.h).
PadError expected_pad_error(const PadRung& rung, const fem::PadScene& scene, double depth);

}  // namespace tactel::host
