// SPDX-License-Identifier: Apache-2.0
#include "fem/pad/creep.h"

#include <algorithm>
#include <cmath>

namespace tactel::fem {

Creep::Creep(std::span<const std::array<double, 2>> relaxation) {
  std::vector<std::array<double, 2>> terms(relaxation.begin(), relaxation.end());
  std::ranges::sort(terms, {}, [](const auto& term) { return term[1]; });
  double left = 1;
  for (const auto& [share, time] : terms) left -= share;
  // By x = -s: F(x) = left - sum g x / (r - x), r = 1 / tau, falls from +infinity behind each pole to -infinity at the
  // next. `offset` from the pole above keeps the digits of zeros beside it.
  const auto F = [&](double pole, double offset) {
    double sum = left;
    for (const auto& [share, time] : terms) sum -= share * (pole - offset) / (1 / time - pole + offset);
    return sum;
  };
  for (std::size_t k = 0; k < terms.size(); ++k) {
    const double pole = 1 / terms[k][1], next = k + 1 < terms.size() ? 1 / terms[k + 1][1] : 0;
    double above = 0, below = pole - next;  // offsets at which F is -infinity, and positive
    for (int halving = 0; halving < 200 && above < below; ++halving) {
      const double middle = above > 0 ? std::sqrt(above * below) : below * 1e-3;
      if (middle <= above || middle >= below) break;
      (F(pole, middle) < 0 ? above : below) = middle;
    }
    const double x = pole - below;
    double slope = 0;
    for (const auto& [share, time] : terms) {
      const double apart = 1 / time - pole + below;
      slope += share / time / (apart * apart);
    }
    terms_.push_back({1 / (x * slope), 1 / x});
  }
}

CreepStep Creep::step(double dt) const {
  CreepStep step;
  for (const auto& [c, theta] : terms_) {
    const double x = dt / theta, e = std::exp(-x), b = x > 0 ? -std::expm1(-x) / x : 1;
    step.terms.push_back({c, e, b});
    step.softer += c * (1 - b);
  }
  return step;
}

}  // namespace tactel::fem
