// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <tactel/step_options.h>

#include "fem/pad/pad_cells.h"
#include "fem/pad/pad_scene.h"

namespace tactel::host {

/// Returns the cells of steps on a pad; the options get those that the pad asks for where none are given. Throws
/// ValueError for a pad or an option that is not served.
fem::PadCells step_grid(const fem::PadSensor& pad, StepOptions& options);

/// Throws ValueError, key `key`, for another size than the allowed one.
void check_size(const char* key, std::size_t size, std::size_t allowed);
/// Throws ValueError for an option that no pad serves.
void check_step_options(const StepOptions& options);
/// Throws it for a grid that leaves a pad with free sides.
void check_within_pad(const fem::PadSensor& pad, const StepOptions& options);

}  // namespace tactel::host
