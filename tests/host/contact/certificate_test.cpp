// SPDX-License-Identifier: Apache-2.0

// What the kernel says of its own answers, worked out again in fp64 from the forces that it wrote and C; and what
// becomes of answers that are not good enough.
#include <gtest/gtest.h>

#include <cmath>

#include "fem/gap/contact_laws.h"
#include "host/contact/lines/gap_sweep.h"
#include "host/contact/lines/solve_on_rung.h"
#include "tests/host/contact/contact_cases.h"
#include "tests/host/device/test_device.h"

namespace certificate_test {

using namespace tactel;
using fem::base_force_difference;
using host::executor;
using tactel::tests::paper_mesh;
using tactel::tests::random_force_scenes;
using tactel::tests::random_scenes;

/// Walks along a solution; residual() is that of the step just taken.
class Auditor {
 public:
  Auditor(const fem::Condensation& condensation, const fem::Scene& scene)
      : condensation_(condensation), scene_(scene), last_ux_(Eigen::VectorXd::Zero(condensation.surface_x.size())) {}

  void take(const fem::ContactStep& step) {
    Eigen::VectorXd load(2 * condensation_.surface_x.size());
    load(Eigen::seq(0, Eigen::last, 2)) = step.tangential_force;
    load(Eigen::seq(1, Eigen::last, 2)) = -step.normal_force;
    const Eigen::VectorXd u = condensation_.compliance * load / scene_.sensor.young;
    const Eigen::VectorXd ux = u(Eigen::seq(0, Eigen::last, 2)), uy = u(Eigen::seq(1, Eigen::last, 2));
    const auto or_one = [](double scale) { return scale > 0 ? scale : 1; };  // nothing touches: 0 of anything
    const double length = or_one(uy.cwiseAbs().maxCoeff()), force = or_one(step.normal_force.maxCoeff());
    residual_ = {};
    for (Eigen::Index i = 0; i < ux.size(); ++i) {
      const double gap = fem::profile_height(scene_.indenter, condensation_.surface_x[i]) - step.indentation - uy[i];
      const double slip = ux[i] - last_ux_[i] - (step.tangential - last_x_);
      const double n = step.normal_force[i], t = step.tangential_force[i];
      residual_.penetration = std::max(residual_.penetration, -gap / length);
      residual_.cone = std::max(residual_.cone, (std::abs(t) - scene_.friction * n) / force);
      if (!(n > 0)) continue;
      const double along = t > 0 ? slip : t < 0 ? -slip : 0;
      const double drift = step.status[i] == fem::GapStatus::stick ? std::abs(slip) : along;
      residual_.complementarity = std::max(residual_.complementarity, std::abs(gap) / length);
      residual_.drift = std::max(residual_.drift, drift / length);
    }
    const Eigen::Vector2d off(step.base_force_x.sum() - load(Eigen::seq(0, Eigen::last, 2)).sum(),
                              step.base_force_y.sum() - load(Eigen::seq(1, Eigen::last, 2)).sum());
    residual_.balance = off.cwiseAbs().maxCoeff() / or_one(std::max(std::abs(step.P), std::abs(step.Q)));
    // Nodes that stick are held to where they were when they began to: errors of convergence must not add up.
    for (Eigen::Index i = 0; i < ux.size(); ++i)
      last_ux_[i] = step.status[i] == fem::GapStatus::stick ? last_ux_[i] + (step.tangential - last_x_) : ux[i];
    last_x_ = step.tangential;
  }
  const fem::Residual& residual() const { return residual_; }

 private:
  const fem::Condensation& condensation_;
  const fem::Scene& scene_;
  Eigen::VectorXd last_ux_;
  double last_x_ = 0;
  fem::Residual residual_;
};

struct Case {
  const char* name;
  host::Precision precision;
  bool force;
};

class Certificate : public ::testing::TestWithParam<Case> {
 protected:
  bool fp32() const { return GetParam().precision == host::Precision::fp32; }
  std::vector<fem::Scene> scenes() const {
    return GetParam().force ? random_force_scenes(paper_mesh('B'), 200, 9) : random_scenes(paper_mesh('B'), 200, 9);
  }
  /// What fp64 adds: sums of 80 products, and cancellation of u against the indenter's position, which may be 1e3 times
  /// the last increment. fp32 the same, with C and forces stored to 6e-8.
  double rounding() const { return fp32() ? 1e-4 : 1e-12; }

  /// Steps whose residuals were compared, and how many of them were not solved.
  std::pair<int, int> audit(const host::GapSweepOptions& options) const {
    const auto scenes = this->scenes();
    const auto condensation = fem::condense(scenes.front().sensor);
    const auto solutions = host::solve_on_meshes(executor(), scenes, GetParam().precision, options);
    int steps = 0, unsolved = 0;
    for (std::size_t i = 0; i < scenes.size(); ++i) {
      Auditor auditor(condensation, scenes[i]);
      for (const fem::ContactStep& step : solutions[i].steps) {
        auditor.take(step);
        const fem::Residual &said = step.residual, &found = auditor.residual();
        for (auto member : {&fem::Residual::penetration, &fem::Residual::cone, &fem::Residual::complementarity,
                            &fem::Residual::drift, &fem::Residual::balance}) {
          EXPECT_GE(said.*member, found.*member - rounding()) << "scene " << i << ", step " << steps;
          // The kernel divides by the largest |u_y| under the indenter, which may be less than beside it.
          EXPECT_LE(said.*member, 2 * found.*member + rounding()) << "scene " << i << ", step " << steps;
        }
        ++steps;
        unsolved += !step.converged;
      }
    }
    return {steps, unsolved};
  }
};

TEST_P(Certificate, IsThatOfTheWrittenForces) {
  const auto [steps, unsolved] = audit({.fallback = false, .audit = false});
  EXPECT_GT(steps, 400);
  EXPECT_LT(unsolved, steps / 50);  // force goals near the friction angle, and flats at mu > 1.2
}

/// Three sweeps leave residuals of all sizes: the certificate tells them, it does not repeat what sweeps believe.
TEST_P(Certificate, IsThatOfTheWrittenForcesWhereSweepsWereCutShort) {
  const auto [steps, unsolved] = audit({.most_sweeps = 3, .fallback = false, .audit = false});
  EXPECT_GT(unsolved, steps / 2);
}

/// The same scenes: the fallback solves all of them, and to where the sweeps would have come.
TEST_P(Certificate, FallbackSolvesWhatSweepsGaveUp) {
  const auto scenes = this->scenes();
  const auto cut = host::solve_on_meshes(executor(), scenes, GetParam().precision, {.most_sweeps = 3});
  const auto whole = host::solve_on_meshes(executor(), scenes, host::Precision::fp64);
  std::size_t fell_back = 0;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    EXPECT_TRUE(cut[i].steps.back().converged) << i;
    if (!cut[i].fell_back) continue;
    ++fell_back;
    // Sweeps leave 100 times their last change, 1e-11.
    EXPECT_LE(base_force_difference(cut[i], whole[i]), 1e-8) << i;
  }
  EXPECT_GT(fell_back, scenes.size() / 2);
}

INSTANTIATE_TEST_SUITE_P(GapSweep, Certificate,
                         ::testing::Values(Case{"fp32_depth", host::Precision::fp32, false},
                                           Case{"fp64_depth", host::Precision::fp64, false},
                                           Case{"fp32_force", host::Precision::fp32, true},
                                           Case{"fp64_force", host::Precision::fp64, true}),
                         [](const auto& info) { return info.param.name; });

}  // namespace certificate_test
