// SPDX-License-Identifier: Apache-2.0

// A simulated pad behind profiles that name its tactels or its axes in every turned and mirrored order.
#include "host/live/mounting_watch.h"

#include <gmock/gmock.h>

#include "host/live/frame_reader.h"
#include "host/live/open_source.h"
#include "tests/host/support/run_tactel.h"

namespace tactel::host::mounting_watch_test {

using Frames = std::vector<std::vector<float>>;
constexpr std::size_t n = 4, tactels = n * n;  // examples/pad.toml
constexpr double touch = 1e-3;                 // MPa, 0.02 of the largest stress

/// A sphere beside the middle, pressed and then dragged obliquely; gains off by 5 %, a noise of 0.1 % of full scale.
const Frames& pressed() {
  static const Frames frames = [] {
    OpenSource opened =
        open_source("simulate:" + source_file("examples/pad.toml") + "?rate=50&paced=0&time_constant=0", "", "");
    Frames all;
    hw::Decoder decoder(opened.profile.format());
    read_frames(*opened.source, decoder, {.frame = [&](const hw::DecodedFrame& frame, double) {
      opened.profile.map.apply(frame.values, all.emplace_back(3 * tactels));
    }});
    return all;
  }();
  return frames;
}

/// The frame whose place (x, y) is read from another place, and whose shear from other axes.
using Place = std::array<std::size_t, 2> (*)(std::size_t x, std::size_t y);
struct Axes {
  bool exchanged = false;
  float x = 1, y = 1;
};
std::vector<float> image(const std::vector<float>& frame, Place place, Axes axes = {}) {
  std::vector<float> seen(frame.size());
  for (std::size_t k = 0; k < tactels; ++k) {
    const auto [x, y] = place(k % n, k / n);
    const std::size_t from = y * n + x;
    seen[k] = frame[from];
    seen[tactels + k] = axes.x * frame[(axes.exchanged ? 2 : 1) * tactels + from];
    seen[2 * tactels + k] = axes.y * frame[(axes.exchanged ? 1 : 2) * tactels + from];
  }
  return seen;
}
constexpr Place as_it_is = [](std::size_t x, std::size_t y) { return std::array{x, y}; };

std::vector<Drift> told(Place place, Axes axes = {}) {
  MountingWatch watch({{n, n}, {4.7, 4.7}}, touch, true);
  std::vector<Drift> all;
  for (const std::vector<float>& frame : pressed())
    if (auto drift = watch.next(image(frame, place, axes))) all.push_back(*drift);
  return all;
}

TEST(MountingWatch, ARightPadIsNotTold) { EXPECT_TRUE(told(as_it_is).empty()); }

// Four turns, each with and without a mirror, of the places alone: with shear turned along with them all is right.
TEST(MountingWatch, EveryOtherOrderOfTheTactelsIsToldOnce) {
  constexpr std::pair<Place, Axes> orders[] = {{[](std::size_t x, std::size_t y) {
                                                  return std::array{n - 1 - y, x};
                                                },
                                                {true, 1, -1}},
                                               {[](std::size_t x, std::size_t y) {
                                                  return std::array{n - 1 - x, n - 1 - y};
                                                },
                                                {false, -1, -1}},
                                               {[](std::size_t x, std::size_t y) {
                                                  return std::array{y, n - 1 - x};
                                                },
                                                {true, -1, 1}},
                                               {[](std::size_t x, std::size_t y) {
                                                  return std::array{n - 1 - x, y};
                                                },
                                                {false, -1, 1}},
                                               {[](std::size_t x, std::size_t y) {
                                                  return std::array{x, n - 1 - y};
                                                },
                                                {false, 1, -1}},
                                               {[](std::size_t x, std::size_t y) {
                                                  return std::array{y, x};
                                                },
                                                {true, 1, 1}},
                                               {[](std::size_t x, std::size_t y) {
                                                  return std::array{n - 1 - y, n - 1 - x};
                                                },
                                                {true, -1, -1}}};
  for (const auto& [place, axes] : orders) {
    const std::vector<Drift> found = told(place);
    ASSERT_EQ(found.size(), 1u) << axes.exchanged << axes.x << axes.y;
    EXPECT_EQ(found[0].kind, Drift::Kind::mounting);
    EXPECT_LT(found[0].size, 0.1);
    EXPECT_EQ(found[0].text.find("shear_x and shear_y exchanged") != std::string::npos, axes.exchanged);
    EXPECT_EQ(found[0].text.find("gains of shear_x") != std::string::npos, axes.x < 0);
    EXPECT_EQ(found[0].text.find("gains of shear_y") != std::string::npos, axes.y < 0);
    EXPECT_TRUE(told(place, axes).empty()) << "the remedy";
  }
}

TEST(MountingWatch, WithoutShearOrTouchThereIsNothingToWatch) {
  for (const auto& [threshold, shear, size] : {std::tuple{0.0, true, 4}, {touch, false, 4}, {touch, true, 2}}) {
    MountingWatch watch({{size, size}, {0, 0}}, threshold, shear);
    for (const std::vector<float>& frame : pressed())
      EXPECT_FALSE(watch.next(image(frame, as_it_is, {false, -1, -1})).has_value());
  }
}

}  // namespace tactel::host::mounting_watch_test
