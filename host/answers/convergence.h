// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "host/answers/solve.h"
#include "host/figures/page.h"

namespace tactel::host {

/// Values on ever smaller cells, continued to cells of size 0: limit + slope h^order, fitted by least squares with
/// an order of 0.5 to 2 (Eca and Hoekstra, J. Comput. Phys. 262, 2014) and weights 1 / h^2.
struct Extrapolation {
  double limit = 0;        ///< without an order the value of the smallest cells
  double uncertainty = 0;  ///< of the limit
  double order = 0;        ///< 0: none, since the values scatter about the fit more than they change from rung to rung
  double slope = 0;
  double scatter = 0;              ///< standard deviation of the values about the fit
  const char* trend = "constant";  ///< "constant", "monotone", "oscillating", "noisy": the values from rung to rung
};

inline constexpr std::size_t least_rungs = 4;  ///< which a fit of three numbers takes

/// Returns the extrapolation of values on cells of sizes h, [rungs] both, the largest cells first. Values that differ
/// by `rounding` at most are constant; uncertainties include it.
Extrapolation extrapolate(std::span<const double> h, std::span<const double> values, double rounding = 0);

/// A number of a load step on all rungs.
struct ConvergedQuantity {
  std::string name, unit;
  double answer = 0;              ///< of the answer that is judged
  std::vector<double> values{};   ///< [rungs]
  std::vector<double> changes{};  ///< [rungs - 1] largest difference from one rung to the next over the load steps
  Extrapolation fit{};
  double error() const { return answer - fit.limit; }
};

/// An answer beside exact contact on ever smaller cells.
struct Convergence {
  /// Number of cells of a contact (of a pad, of a side), their mean size, and the time to solve.
  struct Rung {
    std::string name;
    double h = 0;  ///< mm
    double seconds = 0;
  };
  struct Missed {
    std::string name;
    double residual = 0, accepted = 0;  ///< of the step that is judged; NaN where the rung has no step
  };
  std::size_t step = 0;                         ///< that is judged
  double h = 0;                                 ///< mm, of the answer
  std::vector<Rung> rungs{};                    ///< the largest cells first
  std::vector<Missed> missed{};                 ///< rungs that missed their tolerance
  std::vector<ConvergedQuantity> quantities{};  ///< defined in this step on all rungs; none of fewer than least_rungs
};

/// Takes the name of each rung before it is solved.
using RungProgress = std::function<void(const std::string&)>;

/// Solves the scene of an answer on 15, 30, 60 and 120 elements, of a pad on 16 x 16 to 64 x 64 cells, as the rung
/// `reference` does, and judges a load step. The contact does not depend on a mesh that the scene may name.
Convergence converge(const SolveOutcome& outcome, std::size_t step, const RungProgress& progress = {});
Convergence converge(const PadOutcome& outcome, std::size_t step, const RungProgress& progress = {});

std::string convergence_table(const Convergence& found);
nlohmann::ordered_json to_json(const Convergence& found);
/// Adds a finding and a section with a table and a panel for each quantity.
void add_convergence(Page& page, const Convergence& found);

}  // namespace tactel::host
