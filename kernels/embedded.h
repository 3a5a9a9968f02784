// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <span>
#include <string_view>

namespace tactel::kernels {

/// A file of this folder at the time of the build.
struct Source {
  std::string_view name;  ///< relative to kernels/: "gap_sweep.cl", "shared/lanes.h"
  std::string_view text;
};

/// Returns every kernels/*.cl and kernels/shared/*.h.
std::span<const Source> sources();

}  // namespace tactel::kernels
