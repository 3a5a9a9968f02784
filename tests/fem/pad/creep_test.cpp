// SPDX-License-Identifier: Apache-2.0

// Retardation from relaxation: by the numbers of an independent program, by the convolution that ties both, at
// extremes.
#include "fem/pad/creep.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tactel::fem::creep_test {

using Terms = std::vector<std::array<double, 2>>;

TEST(Creep, HasTheTermsOfAnIndependentProgram) {
  const Creep creep(Terms{{0.15, 0.3}, {0.10, 3.0}});
  ASSERT_EQ(creep.terms().size(), 2u);
  EXPECT_NEAR(creep.terms()[0].c, 0.17103003, 1e-8);
  EXPECT_NEAR(creep.terms()[0].theta, 0.35212566, 1e-8);
  EXPECT_NEAR(creep.terms()[1].c, 0.16230331, 1e-8);
  EXPECT_NEAR(creep.terms()[1].theta, 3.40787434, 1e-8);
}

// One term: E relaxes to 1 - g, so J grows to 1 / (1 - g) in tau / (1 - g).
TEST(Creep, OfOneTermIsInClosedForm) {
  for (const double g : {1e-6, 0.3, 0.9, 0.998}) {
    const Creep creep(Terms{{g, 2}});
    EXPECT_NEAR(creep.terms()[0].c, g / (1 - g), 1e-12 / (1 - g));
    EXPECT_NEAR(creep.terms()[0].theta, 2 / (1 - g), 1e-12 / (1 - g));
  }
}

// The stress of a strain that grows as J is constant: int E(t - s) dJ(s) = 1.
TEST(Creep, AndRelaxationUndoEachOther) {
  for (const Terms& terms : {Terms{{0.15, 0.3}, {0.1, 3}}, Terms{{0.2, 1}, {0.2, 1.001}, {0.2, 50}},
                             Terms{{0.3, 1e-3}, {0.3, 1}, {0.2, 1e3}, {0.19, 1.5}}}) {
    const Creep creep(terms);
    for (const double t : {1e-4, 0.01, 0.5, 3.0, 40.0, 5e3}) {
      // E(t) J(0) and the integral of E(t - s) J'(s), J' = c / theta exp(-s / theta), in closed form.
      double E = 1, sum = 0;
      for (const auto& [g, tau] : terms) E -= g * (1 - std::exp(-t / tau));
      for (const auto& [c, theta] : creep.terms()) {
        sum += c * -std::expm1(-t / theta);
        for (const auto& [g, tau] : terms) {
          const double mixed = tau * (std::exp(-t / theta) - std::exp(-t / tau)) / (theta - tau) * theta;
          sum -= g * c * (-std::expm1(-t / theta) - mixed / theta);
        }
      }
      EXPECT_NEAR(E + sum, 1, 1e-11) << t;
    }
  }
}

TEST(Creep, OfAStepIsBoundedAtAnyTime) {
  const Creep creep(Terms{{0.15, 0.3}, {0.10, 3.0}});
  EXPECT_EQ(creep.step(0).softer, 1);
  EXPECT_EQ(creep.step(0).terms[1].e, 1);
  EXPECT_EQ(creep.step(0).terms[1].b, 1);
  double last = 1;
  for (int power = -12; power <= 12; ++power) {
    const CreepStep step = creep.step(std::pow(10, power));
    EXPECT_GE(step.softer, last);
    last = step.softer;
    for (const auto& [c, e, b] : step.terms) {
      EXPECT_GE(b, e - 1e-15);
      EXPECT_LE(b, 1);
    }
  }
  EXPECT_NEAR(last, 1 / 0.75, 1e-12);
}

}  // namespace tactel::fem::creep_test
