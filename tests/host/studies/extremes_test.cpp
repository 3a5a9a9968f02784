// The table of extremes, as `tactel extremes --quick` prints it, and what must hold on each of its lines.
#include "host/studies/extremes/extremes.h"

#include <gtest/gtest.h>

#include <cstdio>

namespace {

using namespace tactel;

TEST(Extremes, EverySceneIsSolvedOrSaysSo) {
  host::Executor executor{host::Device()};
  const auto extremes = host::scene_extremes(executor, {.quick = true});
  std::printf("%s\n", host::extremes_table(extremes).c_str());
  for (const host::Extreme& e : extremes) {
    SCOPED_TRACE(e.group + " " + e.name);
    EXPECT_TRUE(e.reference.solved);
    EXPECT_TRUE(e.fp64.solved);
    EXPECT_TRUE(e.fp32.solved);
    // The bounds at which a step counts as solved; the reference's are its rounding.
    EXPECT_LE(e.fp32.residual, 1e-3);
    EXPECT_LE(e.fp64.residual, 1e-9);
    EXPECT_LE(e.reference.residual, 1e-10);
    // Sweeps end with a last change of 1e-5 (fp32) and 1e-11 (fp64), of which slow scenes leave some 100 times.
    EXPECT_LE(e.fp32.off, 1e-3);
    EXPECT_LE(e.fp64.off, 1e-8);
  }
}

TEST(Extremes, PathsUniquenessAndWrongInput) {
  host::Executor executor{host::Device()};
  const auto findings = host::extreme_findings(executor, {.quick = true});
  std::printf("%s\n", host::findings_table(findings).c_str());
  for (const host::ExtremeFinding& f : findings) EXPECT_TRUE(f.good) << f.question << " " << f.found;
}

}  // namespace
