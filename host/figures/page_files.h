// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <span>
#include <string_view>

namespace tactel::host::page_files {

/// A file of host/figures/page/ at the time of the build.
struct Source {
  std::string_view name, text;
};

/// Returns the style sheet, then the files of the script in their order.
std::span<const Source> sources();

}  // namespace tactel::host::page_files
