#pragma once
#include <utility>

#include "host/plot.h"

namespace tactel::host {

/// Where the axes of a figure's panels stand, and how many ticks they take. All in pixels.

/// Room under the axes for tick labels, and left of them.
inline constexpr int bottom_margin = 54, left_margin = 86;
inline constexpr int figure_title_height = 34;

/// Height of the whole figure.
int figure_height(const Figure& figure);
/// Rows of the legend over the axes: gnuplot gives every entry the room of the longest.
int legend_rows(const Figure& figure, const Panel& panel);
/// Room over the axes, for title and legend.
int top_margin(const Figure& figure, const Panel& panel);
int axes_width(const Figure& figure, const Panel& panel);
int axes_height(const Figure& figure, const Panel& panel);

/// What the axes will show: the range given, the raster's, or that of the data.
std::pair<double, double> shown_x(const Panel& panel);
std::pair<double, double> shown_y(const Panel& panel);

/// Distance of ticks, 1, 2 or 5 times a power of ten, so that no more than `most` intervals fit (gnuplot alone crowds
/// small panels); 0 where the range is empty.
double tick_distance(std::pair<double, double> range, int most);

}  // namespace tactel::host
