// SPDX-License-Identifier: Apache-2.0

// The table of extremes, as `tactel extremes --quick` prints it, and what must hold on each of its lines.
#include "host/studies/extremes/extremes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <set>
#include <sstream>

namespace extremes_test {

using namespace tactel;

TEST(ExtremesNightly, EverySceneIsSolvedOrSaysSo) {
  host::Executor executor{host::Device()};
  const auto extremes = host::scene_extremes(executor, true);
  std::printf("%s\n", host::extremes_table(extremes).c_str());
  for (const host::Extreme& e : extremes) {
    SCOPED_TRACE(e.model + " " + e.group + " " + e.name);
    EXPECT_TRUE(e.reference.solved);
    EXPECT_TRUE(e.fp64.solved);
    EXPECT_TRUE(e.fp32.solved);
    // The bounds at which a step counts as solved; the reference's are its rounding, or what sweeps to 1e-9 leave.
    const bool mesh = e.model == "mesh";
    EXPECT_LE(e.fp32.residual, mesh ? 1e-3 : 0.02);
    EXPECT_LE(e.fp64.residual, mesh ? 1e-9 : 1e-6);
    EXPECT_LE(e.reference.residual, mesh ? 1e-10 : 1e-7);
    // Sweeps end with a last change of 1e-5 (fp32) and 1e-11 (fp64), on patches and pads of 1e-3 and 1e-7, of which
    // slow scenes leave some 100 times.
    EXPECT_LE(e.fp32.off, mesh ? 1e-3 : 0.1);
    EXPECT_LE(e.fp64.off, mesh ? 1e-8 : 1e-5);
  }
}

TEST(Extremes, HaveEveryShapeOfPads) {
  std::set<std::size_t> shapes;
  for (const host::ExtremeScene& extreme : host::extreme_scenes(false)) {
    std::visit([](const auto& scene) { EXPECT_NO_THROW(scene.validate()); }, extreme.scene);
    if (const auto* pad = std::get_if<fem::PadScene>(&extreme.scene)) shapes.insert(pad->indenter.shape.index());
  }
  EXPECT_EQ(shapes.size(), std::variant_size_v<fem::PadShape>);
}

TEST(Extremes, PathsUniquenessAndWrongInput) {
  host::Executor executor{host::Device()};
  const auto findings = host::extreme_findings(executor, true);
  std::printf("%s\n", host::findings_table(findings).c_str());
  int held = 0;
  for (const host::ExtremeFinding& f : findings) {
    EXPECT_TRUE(f.good) << f.question << " " << f.found;
    if (!f.question.starts_with("held")) continue;
    // Lanes at rest do not iterate, and so cannot creep: of 1000 increments hardly one may rest.
    const auto semicolon = f.found.find("; ");
    ASSERT_NE(semicolon, std::string::npos) << f.found;
    int iterated = 0;
    std::string unit;
    std::istringstream(f.found.substr(semicolon + 2)) >> iterated >> unit;
    EXPECT_EQ(unit, "increments");
    EXPECT_GT(iterated, 900) << f.question;
    ++held;
  }
  EXPECT_EQ(held, 4);
}

// Q alternates between 1 and -1, and drifts by 0.25 at one end and by 0.125 at the other; P = 2.
TEST(LoopDrift, IsTheLargestChangeAtEitherEnd) {
  const std::vector<double> P(6, 2.0);
  EXPECT_EQ(host::loop_drift({P, {9, 1, -1, 1.25, -1.125, 1}}, 1), 0.125);
  EXPECT_EQ(host::loop_drift({{9, 2, 2, 2, 2.5, 2}, {9, 1, -1, 1, -1, 1}}, 1), 0.25);
  EXPECT_EQ(host::loop_drift({P, {9, 1, -1, 1, -1, 1}}, 1), 0);
}

// Wherever it stands, and whatever numbers follow it.
TEST(LoopDrift, NaNIsNotPassedOver) {
  const std::vector<double> good(6, 2.0);
  for (std::size_t k = 1; k < good.size(); ++k) {
    std::vector<double> bad = good;
    bad[k] = NAN;
    EXPECT_TRUE(std::isnan(host::loop_drift({bad, good}, 1))) << k;
    EXPECT_TRUE(std::isnan(host::loop_drift({good, bad}, 1))) << k;
  }
}

}  // namespace extremes_test
