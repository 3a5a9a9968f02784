// SPDX-License-Identifier: Apache-2.0
#include "host/figures/figure_layout.h"

#include <algorithm>
#include <cmath>

namespace tactel::host {
namespace {

constexpr int right_margin = 24, title_margin = 36;

std::pair<double, double> data_range(const std::vector<Series>& series, std::vector<double> Series::*member) {
  double low = INFINITY, high = -INFINITY;
  for (const Series& s : series) {
    for (const double value : s.*member) {
      low = std::fmin(low, value);  // fmin and fmax pass over NaN
      high = std::fmax(high, value);
    }
  }
  return {low, high};
}

}  // namespace

int figure_height(const Figure& figure) {
  const int columns = std::max(1, figure.columns),
            rows = (static_cast<int>(figure.panels.size()) + columns - 1) / columns;
  return rows * figure.panel_height + (figure.title.empty() ? 0 : figure_title_height);
}

int legend_rows(const Figure& f, const Panel& p) {
  constexpr int sample = 70, letter = 7;  // pixels
  int entries = 0, longest = 0;
  for (const Series& s : p.series) {
    entries += s.label.empty() ? 0 : 1;
    longest = std::max(longest, static_cast<int>(s.label.size()));
  }
  const int beside = p.mosaic ? 1 : std::max(1, axes_width(f, p) / (sample + letter * longest));
  return (entries + beside - 1) / beside;
}

int top_margin(const Figure& f, const Panel& p) { return title_margin + legend_row_height * legend_rows(f, p); }

int axes_width(const Figure& f, const Panel& p) {
  constexpr int colour_scale = 56;
  return f.width / std::max(1, f.columns) - left_margin - right_margin - (p.mosaic ? colour_scale : 0);
}

int axes_height(const Figure& f, const Panel& p) { return f.panel_height - bottom_margin - top_margin(f, p); }

std::pair<double, double> shown_x(const Panel& p) { return p.x_range ? *p.x_range : data_range(p.series, &Series::x); }

std::pair<double, double> shown_y(const Panel& p) { return p.y_range ? *p.y_range : data_range(p.series, &Series::y); }

double tick_distance(std::pair<double, double> range, int most) {
  const double least = (range.second - range.first) / std::max(2, most);
  if (!(least > 0) || !std::isfinite(least)) return 0;
  const double power = std::pow(10.0, std::floor(std::log10(least)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= least * (1 - 1e-9)) return factor * power;
  }
  return 10 * power;
}

}  // namespace tactel::host
