// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <span>
#include <string>
#include <vector>

#include "host/figures/plot.h"

namespace tactel::host {

/// Returns a panel of predicted over true slippage index with the line on which both are equal. `truth` and `predicted`
/// [rows]; of more than `most` rows, as many are drawn, chosen by a hash.
Panel predicted_panel(std::span<const double> truth, std::span<const double> predicted, const std::string& title,
                      std::size_t most = 600);

/// A vertical line in a histogram: "mean" | 0.034.
struct Landmark {
  std::string label;
  double at = 0;
  Ink ink = Ink::black;
};

/// Returns a histogram of absolute errors from 0 to `most`, in percent of all of them; larger ones count in the last
/// bar. NaN does not count.
Panel error_histogram(std::span<const double> errors, double most, const std::string& title,
                      const std::vector<Landmark>& landmarks);

/// Returns shares [bins] of the values in equal bins from 0 to `most`; larger ones in the last. NaN does not count.
std::vector<double> shares(std::span<const double> values, double most, std::size_t bins);

}  // namespace tactel::host
