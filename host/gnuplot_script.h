#pragma once
#include <string>

#include "host/plot.h"

namespace tactel::host {

/// The gnuplot program that draws a figure into `output` through `terminal` ("svg" or "pngcairo"); data are in it.
std::string gnuplot_script(const Figure& figure, const std::string& terminal, const std::string& output);

/// Text with gnuplot's markup characters ( _ ^ { } @ & ~ \ ) escaped.
std::string plain(const std::string& text);

}  // namespace tactel::host
