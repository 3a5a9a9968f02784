// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <string>

#include "host/scenes/sweep_file.h"
#include "host/sets/set_simulator.h"

namespace tactel::host {

/// All inputs of the rows of a set.
struct SetRecipe {
  /// One line each, "name value": version, layout of the spool, rung, precision, tolerance, requested residual and
  /// contacts of a chunk.
  /// A further line per file that the sweep file names holds the checksum of its numbers.
  std::string conditions;
  std::string sweep;  ///< text of the sweep file

  std::string text() const { return conditions + sweep; }
};

/// `rung`: of lines; none: as the file says. `columns`: datasets that --columns names; empty: all.
SetRecipe recipe_of(const Sweep& sweep, const std::optional<Rung>& rung, const SetOptions& options,
                    const std::string& columns = "", bool compress = false);

/// Returns the attribute `rung` of a set. `accuracy`: asked for.
std::string model_text(const AnySource& source, const std::optional<Rung>& rung, const SetOptions& options,
                       std::optional<double> accuracy);

/// Throws ConfigError naming --resume and the difference, where the finished set `path` was made by another plan.
void expect_made_by(const SetRecipe& recipe, const std::string& path);

}  // namespace tactel::host
