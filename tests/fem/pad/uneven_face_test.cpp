// SPDX-License-Identifier: Apache-2.0

// Random height fields of faces: their statistics, and that they go where the face goes.
#include "fem/pad/uneven_face.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "fem/pad/pad_surface.h"

namespace tactel::fem::uneven_face_test {

UnevenFace face_of(unsigned seed, double rms, double length, std::size_t waves = 24) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> phase(0, 2 * std::numbers::pi);
  std::vector<double> normals(2 * waves), phases(waves);
  for (double& number : normals) number = normal(random);
  for (double& number : phases) number = phase(random);
  return UnevenFace::of(rms, length, normals, phases);
}

// Over 4000 faces the mean of h(0)^2 is that of rms 0.1 mm, 0.01 mm^2, and of h(0) h(r) is exp(-1/2) = 0.607 of it at a
// distance of one length. A product of two normal numbers deviates by 1.2 of it: 4 standard errors are 0.08.
TEST(UnevenFace, HasItsRmsAndItsLength) {
  double square = 0, product = 0;
  constexpr int faces = 4000;
  for (int k = 0; k < faces; ++k) {
    const UnevenFace face = face_of(static_cast<unsigned>(k), 0.1, 5);
    square += std::pow(face.height(0, 0), 2) / faces;
    product += face.height(0, 0) * face.height(3, 4) / faces;
  }
  EXPECT_NEAR(square / 0.01, 1, 0.09);
  EXPECT_NEAR(product / 0.01, std::exp(-0.5), 0.08);
}

/// A point of the pad is at R(-angle) (p - place) of the face.
TEST(UnevenFace, GoesWhereTheFaceGoes) {
  const UnevenFace face = face_of(3, 0.02, 4);
  const PadCells cells = fixed_cells(7, 1.3);
  const double angle = 0.4;
  std::vector<double> heights(49, 1.0);
  face.add(cells, {0.7, -1.1}, angle, heights);
  for (int i = 0; i < 7; ++i)
    for (int j = 0; j < 7; ++j) {
      const double x = (i - 3) * 1.3 - 0.7, y = (j - 3) * 1.3 + 1.1;
      EXPECT_NEAR(heights[static_cast<std::size_t>(7 * i + j)],
                  1 + face.height(std::cos(angle) * x + std::sin(angle) * y, std::cos(angle) * y - std::sin(angle) * x),
                  1e-14);
    }
}

}  // namespace tactel::fem::uneven_face_test
