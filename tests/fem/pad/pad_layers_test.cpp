// SPDX-License-Identifier: Apache-2.0

// Layers between Chebyshev's points of Poisson's ratio, and their file in the cache.
#include "fem/pad/pad_layers.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>

#include "tests/fem/resealed.h"
#include "tests/scratch.h"

namespace tactel::fem::pad_layers_test {

namespace fs = std::filesystem;

double apart(const PadLayer& a, const PadLayer& b) {
  double most = 0;
  for (double rho = 0; rho < PadLayer::range; rho += 0.037) {
    most = std::max(most, (a.displacements(rho) - b.displacements(rho)).abs().maxCoeff());
    most = std::max(most, (a.stresses(rho) - b.stresses(rho)).abs().maxCoeff());
  }
  return most;
}

class PadLayersCache : public testing::Test {
 protected:
  PadLayers layers() const { return PadLayers(folder_ / ""); }
  fs::path file() const { return fs::directory_iterator(folder_ / "")->path(); }
  std::string content() const { return text_of(file()); }
  void write(const std::string& bytes) const { std::ofstream(file(), std::ios::binary) << bytes; }

  const ScratchFolder folder_;
};

TEST(PadLayers, AreThoseOfEachPoissonsRatio) {
  const PadLayers layers("");
  for (const double poisson : {0.0, 0.01, 0.21, 0.3, 0.45, 0.4999, 0.5})
    EXPECT_LE(apart(layers.layer(poisson), PadLayer(poisson)), 2e-10) << poisson;
}

TEST_F(PadLayersCache, ComeFromTheirFile) {
  const PadLayer made = PadLayers("").layer(0.45);
  EXPECT_EQ(apart(layers().layer(0.45), made), 0);  // makes and writes
  const std::string good = content();
  EXPECT_EQ(apart(layers().layer(0.45), made), 0);  // reads
  std::string other = good;
  const double marker = 12345;
  std::memcpy(other.data() + other.size() - 16, &marker, 8);  // the last slope at nu = 1/2, far away
  write(resealed(other));
  EXPECT_NEAR(layers().layer(0.5).cells().back()[pad_bzx][2], -marker / PadLayer::steps_a_thickness, 0.01)
      << "was read";
}

TEST_F(PadLayersCache, BelieveNoDamagedFile) {
  const PadLayer made = layers().layer(0.45);
  const std::string good = content();
  std::string bad = good;
  bad[bad.size() / 2] ^= 1;
  write(bad);
  EXPECT_EQ(apart(layers().layer(0.45), made), 0) << "checksum";
  EXPECT_EQ(content(), good) << "mended";
  fs::resize_file(file(), good.size() - 8);
  EXPECT_EQ(apart(layers().layer(0.45), made), 0) << "truncated";
  const double none = std::numeric_limits<double>::quiet_NaN();
  std::memcpy(bad.data() + bad.size() - 16, &none, 8);
  write(resealed(bad));
  EXPECT_EQ(apart(layers().layer(0.45), made), 0) << "no number";
}

}  // namespace tactel::fem::pad_layers_test
