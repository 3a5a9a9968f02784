// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <span>
#include <vector>

namespace tactel::fem {

// Rubber that creeps, of one Poisson's ratio at all times. Under a strain that is held its stress falls, under a stress
// that is held its strain grows by (J. D. Ferry, Viscoelastic Properties of Polymers, 1980, chapter 3)
//
//     E(t) = E [1 - sum g (1 - exp(-t / tau))]        J(t) = [1 + sum c (1 - exp(-t / theta))] / E
//
// -1 / theta are the zeros of F(s) = 1 - sum g + sum g s / (s + 1 / tau), one right of each pole, and c = -1 / (s
// F'(s)) there. With w the elastic displacement by the tractions at each time, which runs straight through a step, and
// v what a term has crept towards, e = exp(-dt / theta), b = (1 - e) theta / dt:
//
//     u = w (1 + sum c (1 - b)) + m,    m = sum c [e v + (b - e) w_old],    v <- e v + (b - e) w_old + (1 - b) w

/// What a step of time does, by term.
struct CreepStep {
  struct Term {
    double c = 0, e = 1, b = 1;
  };
  std::vector<Term> terms{};
  double softer = 1;  ///< compliance of the step over the elastic one, 1 + sum c (1 - b)
};

/// The retardation of a rubber, by its relaxation.
class Creep {
 public:
  /// `relaxation`: shares g > 0, whose sum is below 1, and times tau > 0, which differ, s.
  explicit Creep(std::span<const std::array<double, 2>> relaxation);

  struct Term {
    double c = 0, theta = 0;  ///< over 1 / E; s
  };
  const std::vector<Term>& terms() const { return terms_; }  ///< fast ones first

  /// dt >= 0, s.
  CreepStep step(double dt) const;

 private:
  std::vector<Term> terms_;
};

}  // namespace tactel::fem
