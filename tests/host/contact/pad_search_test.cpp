// SPDX-License-Identifier: Apache-2.0

// The search's kernel against its twin, against Hertz, against mirror images, and against itself in other batches and
// lanes.
#include "host/contact/pads/pad_search.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <random>

#include "fem/pad/pad_layers.h"
#include "fem/pad/pad_mix.h"
#include "tests/host/device/test_device.h"

namespace tactel::host::pad_search_test {

/// Sensors side by side in one batch; the last is thin and cannot be compressed.
const std::vector<fem::PadSensor>& sensors() {
  static const std::vector<fem::PadSensor> sensors{{.thickness = 2, .young = 1.5, .poisson = 0.45},
                                                   {.thickness = 4, .young = 0.3, .poisson = 0.3},
                                                   {.thickness = 0.7, .young = 2, .poisson = 0.5}};
  return sensors;
}

const fem::PadLayer& layer(double poisson) {
  static std::map<double, fem::PadLayer> layers;
  return layers.try_emplace(poisson, poisson).first->second;
}

/// A sphere as it may have been measured.
fem::HeightMap measured_sphere(double radius, double pitch, int points) {
  fem::HeightMap map{.pitch = pitch, .heights = Eigen::MatrixXd(points, points)};
  const auto along = [&](Eigen::Index i) { return pitch * (static_cast<double>(i) - (points - 1) / 2.0); };
  for (Eigen::Index i = 0; i < points; ++i)
    for (Eigen::Index j = 0; j < points; ++j)
      map.heights(i, j) = radius - std::sqrt(radius * radius - along(i) * along(i) - along(j) * along(j));
  map.heights.array() -= map.heights.minCoeff();
  return map;
}

/// Random scenes of all shapes, sensor by sensor; a tenth of them measured.
std::vector<fem::PadScene> mix(std::size_t count, unsigned seed) {
  std::vector<fem::PadMix> draw;
  for (const fem::PadSensor& sensor : sensors()) draw.emplace_back(seed, &sensor);
  std::vector<fem::PadScene> scenes;
  for (std::size_t i = 0; i < count; ++i) {
    fem::PadScene scene = draw[i % draw.size()]();
    const double H = scene.sensor.thickness;
    if (i % 10 == 9) {
      scene.indenter.shape = measured_sphere((i % 4 + 4) * H, (i % 3 + 1) * H / 20, 31 + static_cast<int>(i % 2));
      scene.indenter.tilt = 0;
    }
    scenes.push_back(scene);
  }
  return scenes;
}

/// Differences of contacts from the twin's, of all scenes, in order: the largest of the four sides over the width, and
/// that of P over P.
struct Difference {
  std::vector<double> side, P;

  Difference(std::span<const fem::PadScene> scenes, std::span<const fem::PadSearch> found) {
    for (std::size_t i = 0; i < scenes.size(); ++i) {
      const fem::PadSearch twin = fem::find_pad_contact(scenes[i], layer(scenes[i].sensor.poisson));
      double worst = 0;
      for (const auto& [a, b] : {std::pair(found[i].contact.x, twin.contact.x), {found[i].contact.y, twin.contact.y}})
        worst = std::max(
            {worst, std::abs(a.left - b.left) / (b.right - b.left), std::abs(a.right - b.right) / (b.right - b.left)});
      side.push_back(worst);
      P.push_back(std::abs(found[i].P / twin.P - 1));
      EXPECT_NEAR(found[i].depth / twin.depth, 1, 1e-3) << i;
    }
    std::ranges::sort(side);
    std::ranges::sort(P);
  }
  double of_all_but(double part, const std::vector<double>& v) const {
    return v[static_cast<std::size_t>((1 - part) * static_cast<double>(v.size() - 1))];
  }
};

/// Both stop at a change of 1e-3, in another order of sweeps: 1e-3 of P. A cell at the rim that bears less than that
/// may press in one and not in the other: one side, or with a mirror image both, then lies a cell of the last window
/// beside, at most a ninth of the width.
void expect_like_the_twin(const Difference& d, double rounding) {
  EXPECT_LE(d.of_all_but(0.03, d.side), rounding);
  EXPECT_LE(d.side.back(), 0.15);
  EXPECT_LE(d.of_all_but(0.03, d.P), 1e-3);
  EXPECT_LE(d.P.back(), 5e-3);
}

TEST(PadSearch, FindsTheTwinsContactsInFp32) {
  const auto scenes = mix(360, 21);
  expect_like_the_twin(Difference(scenes, PadSearch<float>(executor()).find(scenes)), 1e-5);
}

TEST(PadSearch, FindsTheTwinsContactsInFp64) {
  ASSERT_TRUE(executor().device().info().fp64);
  const auto scenes = mix(180, 22);
  expect_like_the_twin(Difference(scenes, PadSearch<double>(executor()).find(scenes)), 1e-13);
}

TEST(PadSearch, FindsTheTwinsContactsOfSoftObjects) {
  auto scenes = mix(90, 24);
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    scenes[i].indenter.young = scenes[i].sensor.young * std::exp2(static_cast<double>(i) / 9 - 5);
    scenes[i].indenter.poisson = 0.05 * static_cast<double>(i % 11);
  }
  const auto found = PadSearch<double>(executor()).find(scenes);
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const fem::PadSearch twin = fem::find_pad_contact(scenes[i], fem::pad_layer(scenes[i]));
    EXPECT_NEAR(found[i].P / twin.P, 1, 5e-3) << i;
    EXPECT_NEAR(found[i].contact.x.right, twin.contact.x.right, 0.15 * (twin.contact.x.right - twin.contact.x.left))
        << i;
  }
}

/// Depths follow the forces: what rounding and the sweeps leave of P, 1e-3, is 1e-3 of the depth at most.
TEST(PadSearch, FindsTheTwinsContactsUnderGivenForces) {
  auto scenes = mix(240, 23);
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    if (i % 7 == 3) continue;  // by depth beside them
    const double P = fem::find_pad_contact(scenes[i], layer(scenes[i].sensor.poisson)).P;
    scenes[i].load.indentation.clear();
    scenes[i].load.normal_force = {0.3 * P, P};
  }
  expect_like_the_twin(Difference(scenes, PadSearch<float>(executor()).find(scenes)), 1e-3);
}

TEST(PadSearch, SearchesAtGivenDepths) {
  auto scenes = mix(30, 24);
  std::vector<double> depths;
  for (fem::PadScene& scene : scenes) {
    depths.push_back(0.8 * scene.load.indentation.back());
    scene.load.indentation.clear();
    scene.load.normal_force = {1};  // not looked at
  }
  const auto found = PadSearch<float>(executor()).find(scenes, depths);
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const fem::PadSearch twin = fem::find_pad_contact_at(depths[i], scenes[i], layer(scenes[i].sensor.poisson));
    EXPECT_EQ(found[i].depth, depths[i]);
    EXPECT_NEAR(found[i].P / twin.P, 1, 5e-3) << i;
  }
}

TEST(PadSearch, AnIndenterThatTouchesNothingKeepsAFewCells) {
  std::vector<fem::PadScene> scenes(3);
  scenes[0].load.indentation = {0};
  scenes[1].load = {.indentation = {}, .normal_force = {0}};
  scenes[2].indenter.shape = fem::Box{{1, 2}, 0};
  scenes[2].load.indentation = {0};
  const auto found = PadSearch<float>(executor()).find(scenes);
  for (std::size_t i = 0; i < scenes.size(); ++i) EXPECT_EQ(found[i].P, 0) << i;
  // The section of a sphere of 8 mm at 2e-6 mm, and 12 % more.
  EXPECT_NEAR(found[0].contact.x.right, 1.12 * std::sqrt(2 * 8 * 2e-6), 1e-6);
  EXPECT_EQ(found[1].contact.x.right, found[0].contact.x.right);
  EXPECT_EQ(found[2].contact.y.right, 2.0);  // its edge to the bit: cells must know that they end there
}

/// H. Hertz, 1882: radius sqrt(R d) and force 4/3 E / (1 - nu^2) sqrt(R d^3) on a half-space. A layer 1000 times as
/// thick as the contact is one. Half-widths are whole cells, some 4.5 a radius: half a cell is a ninth; 12 % lie
/// around.
TEST(PadSearch, HertzsRadiusAndForceOnAThickLayer) {
  std::vector<fem::PadScene> scenes(40);
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    scenes[i].sensor = {.thickness = 1000, .young = 1, .poisson = 0.3};
    scenes[i].indenter.shape = fem::Sphere{10 + 0.7 * static_cast<double>(i)};
    scenes[i].load.indentation = {0.05};
  }
  const auto found = PadSearch<float>(executor()).find(scenes);
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const double R = std::get<fem::Sphere>(scenes[i].indenter.shape).radius, a = std::sqrt(R * 0.05);
    EXPECT_NEAR(found[i].contact.x.right / a, 1.12, 0.15) << i;
    EXPECT_EQ(found[i].contact.x.right, found[i].contact.y.right) << i;
    EXPECT_NEAR(found[i].P / (4.0 / 3 / 0.91 * a * 0.05), 1, 0.02) << i;
  }
}

/// A wide flat squeezes a thin layer like a short column that cannot widen: P = E (1 - nu) / ((1 + nu) (1 - 2 nu)) d /
/// H of its area. 60 times as wide as the layer is thick, half a thickness of rim is 3 %, of which E acts on a part.
TEST(PadSearch, AWideFlatCompressesAThinLayerLikeAColumn) {
  std::vector<fem::PadScene> scenes(3);
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    scenes[i].sensor = {.thickness = 0.5, .young = 2, .poisson = 0.15 * static_cast<double>(i)};
    scenes[i].indenter.shape = fem::Box{{15, 15}, 0};
    scenes[i].load.indentation = {0.02};
  }
  const auto found = PadSearch<float>(executor()).find(scenes);
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const double nu = scenes[i].sensor.poisson;
    EXPECT_NEAR(found[i].P / (2 * (1 - nu) / ((1 + nu) * (1 - 2 * nu)) * 0.02 / 0.5 * 900), 1, 0.02) << nu;
    EXPECT_EQ(found[i].contact.x.right, 15) << nu;
  }
}

/// Unknowns of one quadrant against all cells: a tilt of 1e-9 degrees needs these.
TEST(PadSearch, AQuadrantGivesTheContactOfAllCells) {
  std::vector<fem::PadScene> upright;
  for (const fem::PadScene& scene : mix(300, 25))
    if (std::holds_alternative<fem::Punch>(scene.indenter.shape) ||
        std::holds_alternative<fem::Box>(scene.indenter.shape))
      upright.push_back(scene), upright.back().indenter.tilt = 0;
  auto tilted = upright;
  for (fem::PadScene& scene : tilted) scene.indenter.tilt = 1e-9, scene.indenter.tilt_direction = 20;
  const PadSearch<float> search(executor());
  const auto a = search.find(upright), b = search.find(tilted);
  std::size_t alike = 0;
  for (std::size_t i = 0; i < upright.size(); ++i) {
    alike += std::abs(a[i].contact.x.right - b[i].contact.x.right) <= 1e-5 * a[i].contact.x.right &&
             std::abs(a[i].contact.y.left - b[i].contact.y.left) <= -1e-5 * a[i].contact.y.left;
    EXPECT_NEAR(a[i].P / b[i].P, 1, 1e-3) << i;
  }
  EXPECT_GE(alike, upright.size() * 97 / 100);
}

/// The sweeps' order is not symmetric: P to their tolerance, sides to a cell.
TEST(PadSearch, MirrorImages) {
  std::vector<fem::PadScene> scenes, images;
  for (int k = 0; k < 20; ++k) {
    fem::PadScene scene;
    scene.indenter.shape = fem::Punch{1.0 + 0.1 * k, 0.4};
    scene.load.indentation = {0.06};
    scene.indenter.tilt = 1 + 0.2 * k, scene.indenter.tilt_direction = 10 * k;
    scenes.push_back(scene);
    scene.indenter.tilt_direction *= -1;
    images.push_back(scene);
  }
  const PadSearch<float> search(executor());
  const auto a = search.find(scenes), b = search.find(images);
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const double cell = (a[i].contact.y.right - a[i].contact.y.left) / 10;
    EXPECT_NEAR(a[i].P / b[i].P, 1, 2e-3) << i;
    EXPECT_NEAR(a[i].contact.y.left, -b[i].contact.y.right, cell) << i;
    EXPECT_NEAR(a[i].contact.y.right, -b[i].contact.y.left, cell) << i;
    EXPECT_NEAR(a[i].contact.x.left, b[i].contact.x.left, cell) << i;
  }
  EXPECT_LT(a[2].contact.x.right, 0.9 * -a[2].contact.x.left);  // tilted: pressed on one side
}

// Hertz: P = 4/3 E' sqrt(R) d^1.5, a = sqrt(R d). A millionth of the thickness once was the least depth looked at.
TEST(PadSearch, FindsContactsOfAnyDepth) {
  fem::PadScene scene;
  const double nu = scene.sensor.poisson, E = scene.sensor.young / (1 - nu * nu), R = 8;
  scene.indenter.shape = fem::Sphere{R};
  for (const double depth : {1e-4, 2e-6, 2e-9}) {
    scene.load.indentation = {depth};
    for (const fem::PadSearch& found :
         {PadSearch<float>(executor()).find(std::span(&scene, 1)).front(), fem::find_pad_contact(scene, layer(nu))}) {
      EXPECT_NEAR(found.P / (4.0 / 3 * E * std::sqrt(R) * std::pow(depth, 1.5)), 1, 0.05) << depth;
      EXPECT_NEAR(found.contact.x.right / std::sqrt(R * depth), 1.1, 0.15) << depth;
    }
  }
}

/// A pyramid whose points lie as far apart as that it is touched between them alone: height (|x| + |y|) / 2, so that
/// the bilinear profile is the pyramid itself, and its section at the depth d reaches to 2 d.
TEST(PadSearch, FindsContactsBetweenThePointsOfAMap) {
  for (const int middle : {2, 1}) {  // in the map's middle, and beside it
    fem::HeightMap map{.pitch = 1, .heights = Eigen::MatrixXd(5, 5)};
    for (int i = 0; i < 5; ++i)
      for (int j = 0; j < 5; ++j) map.heights(i, j) = 0.5 * (std::abs(i - middle) + std::abs(j - 2));
    fem::PadScene scene;
    scene.indenter.shape = map;
    scene.load.indentation = {0.01};
    const double at = middle - 2;
    for (const fem::PadSearch& found : {PadSearch<float>(executor()).find(std::span(&scene, 1)).front(),
                                        fem::find_pad_contact(scene, layer(scene.sensor.poisson))}) {
      EXPECT_GT(found.P, 0);
      EXPECT_NEAR(found.contact.x.left, at - 0.013, 0.008);
      EXPECT_NEAR(found.contact.x.right, at + 0.013, 0.008);
      EXPECT_NEAR(found.contact.y.right, 0.013, 0.008);
    }
  }
}

std::array<double, 6> numbers(const fem::PadSearch& found) {
  return {found.contact.x.left,  found.contact.x.right, found.contact.y.left,
          found.contact.y.right, found.depth,           found.P};
}

TEST(PadSearch, SameBitsInAnyBatchOrderAndNumberOfLanes) {
  auto scenes = mix(90, 26);
  for (std::size_t i = 0; i < scenes.size(); i += 4)
    scenes[i].load.normal_force = {0.1 + 0.01 * static_cast<double>(i)};
  const auto all = PadSearch<float>(executor()).find(scenes);
  std::vector<std::size_t> order(scenes.size());
  std::iota(order.begin(), order.end(), 0);
  std::shuffle(order.begin(), order.end(), std::mt19937(3));
  std::vector<fem::PadScene> shuffled;
  for (const std::size_t i : order) shuffled.push_back(scenes[i]);
  for (const Device& device : devices_of_all_lanes()) {
    Executor one(device, {.threads = 1});
    const auto found = PadSearch<float>(one).find(shuffled);
    for (std::size_t k = 0; k < order.size(); ++k)
      ASSERT_EQ(numbers(found[k]), numbers(all[order[k]])) << device.lanes(Precision::fp32) << " lanes, scene " << k;
  }
  for (const std::size_t i : {0u, 9u, 89u})
    EXPECT_EQ(numbers(PadSearch<float>(executor()).find(std::span(&scenes[i], 1))[0]), numbers(all[i])) << i;
}

}  // namespace tactel::host::pad_search_test
