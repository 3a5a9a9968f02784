// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <utility>

#include "host/figures/plot.h"

namespace tactel::host {

/// Positions of the axes of a figure's panels, and the number of their ticks. All in pixels.

/// Space under the axes for tick labels, and left of them.
inline constexpr int bottom_margin = 54, left_margin = 86;
inline constexpr int figure_title_height = 34, legend_row_height = 20;

/// Returns the height of the whole figure.
int figure_height(const Figure& figure);
/// Returns the rows of the legend over the axes. gnuplot gives every entry the width of the longest, and over a mosaic
/// a row.
int legend_rows(const Figure& figure, const Panel& panel);
/// Returns the space over the axes, for title and legend.
int top_margin(const Figure& figure, const Panel& panel);
int axes_width(const Figure& figure, const Panel& panel);
int axes_height(const Figure& figure, const Panel& panel);

/// Return the range of the axes: the given one, or that of the data.
std::pair<double, double> shown_x(const Panel& panel);
std::pair<double, double> shown_y(const Panel& panel);

/// Returns the distance of ticks, 1, 2 or 5 times a power of ten, at which at most `most` intervals fit. (gnuplot
/// alone crowds small panels.) Returns 0 for an empty range.
double tick_distance(std::pair<double, double> range, int most);

}  // namespace tactel::host
