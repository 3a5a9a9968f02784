// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "host/figures/plot.h"

namespace tactel::host {

/// Returns the gnuplot program that draws a figure into `output` through `terminal` ("svg" or "pngcairo"). It
/// contains the data.
std::string gnuplot_script(const Figure& figure, const std::string& terminal, const std::string& output);

/// Returns text with gnuplot's markup characters ( _ ^ { } @ & ~ \ ) escaped.
std::string plain(const std::string& text);

}  // namespace tactel::host
