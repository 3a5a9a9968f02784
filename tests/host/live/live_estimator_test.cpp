// SPDX-License-Identifier: Apache-2.0

// The device's answers to live frames beside those of the host's code.
#include "host/live/live_estimator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <random>

#include "tests/host/networks/bounded_model.h"

namespace tactel::host::live_estimator_test {

using nn::ScalingKind;
using tactel::tests::bounded_model;

nn::Model plain(const char* topology) {
  nn::Weights<float> weights = nn::initial_weights(nn::Topology::parse(topology), 7);
  for (float& w : weights.values) w *= 3;  // S well away from 0.5
  return {weights, {ScalingKind::set, 1.37f}, 7, 0.1, "bumps", 100, {1234, 0.31, 0.0123, 0.02}};
}

bool same(float a, float b) { return std::bit_cast<unsigned>(a) == std::bit_cast<unsigned>(b) || (a != a && b != b); }
bool same(const Answer& a, const Answer& b) {
  return same(a.slip_index, b.slip_index) && same(a.slip_upper, b.slip_upper) && a.status == b.status &&
         same(a.slip_interval[0], b.slip_interval[0]) && same(a.slip_interval[1], b.slip_interval[1]) &&
         a.unlike == b.unlike;
}

/// Presses and drags that hold still for 40 of 100 frames and end now and then, with noise, frames at rest and frames
/// with NaN; each sensor by itself.
class Frames {
 public:
  explicit Frames(std::span<const nn::Model* const> networks) : networks_(networks) {}
  std::vector<float> next() {
    std::vector<float> all;
    for (std::size_t s = 0; s < networks_.size(); ++s) {
      const auto width = static_cast<std::size_t>(networks_[s]->scaling.width(networks_[s]->numbers()));
      const std::size_t moving = number_ / 100 * 60 + std::min<std::size_t>(number_ % 100, 60);
      const auto time = static_cast<float>(moving + 13 * s);
      const bool rest = (number_ + s) % 89 == 0;
      for (std::size_t i = 0; i < width; ++i) {
        const float x = 8.0f * static_cast<float>(i) / static_cast<float>(width) - 4 - std::sin(0.05f * time);
        all.push_back(rest ? 0 : (i < width / 2 ? -1.0f : 0.4f) * std::exp(-x * x) + 1e-3f * noise_(random_));
      }
      if ((number_ + s) % 97 == 0) all.back() = std::numeric_limits<float>::quiet_NaN();
    }
    ++number_;
    return all;
  }

 private:
  std::span<const nn::Model* const> networks_;
  std::size_t number_ = 0;
  std::mt19937 random_{5};
  std::normal_distribution<float> noise_;
};

/// `sensors`: which network each has.
void expect_the_hosts_bits(const Device& device, const std::vector<nn::Model>& models,
                           const std::vector<std::size_t>& sensors) {
  std::vector<const nn::Model*> of_sensors;
  of_sensors.reserve(sensors.size());
  for (const std::size_t which : sensors) of_sensors.push_back(&models[which]);
  const auto host = host_estimator(of_sensors), kernel = device_estimator(device, of_sensors);
  std::vector<Answer> expected(sensors.size()), found(sensors.size());
  Frames frames(of_sensors);
  std::size_t different = 0, answered = 0, rested = 0;
  for (int k = 0; k < 300; ++k) {
    const std::vector<float> all = frames.next();
    if (k == 150) host->clear(), kernel->clear();
    if (k == 200) host->rest(), kernel->rest();
    for (std::size_t s = 0; s < sensors.size(); ++s) {
      if (k == 100) host->friction(s, 0.4f, 0.2f), kernel->friction(s, 0.4f, 0.2f);
      different += k == 250 && !same(host->slides(s), kernel->slides(s));
    }
    host->estimate(all, expected);
    kernel->estimate(all, found);
    for (std::size_t s = 0; s < sensors.size(); ++s) {
      different += !same(found[s], expected[s]);
      answered += expected[s].status == AnswerStatus::ok;
      rested += expected[s].status == AnswerStatus::ok && models[sensors[s]].history.rest;
    }
  }
  EXPECT_EQ(different, 0u) << sensors.size() << " sensors on " << device.info().name;
  const auto by_rest = std::ranges::count_if(sensors, [&](std::size_t which) { return models[which].history.rest; });
  EXPECT_GT(answered - rested, 290 * (sensors.size() - static_cast<std::size_t>(by_rest)) * 9 / 10);
  EXPECT_GE(rested, 60 * static_cast<std::size_t>(by_rest));
}

/// A network with a bound on a pad of four tactels.
nn::Model of_pad() {
  nn::Model model = bounded_model("12-9-3", ScalingKind::frame);
  model.scaling.axes = 3;
  model.bound->tactels = 4;
  return model;
}

/// A network with a bound on three frames of four tactels.
nn::Model with_history() {
  nn::Model model = bounded_model("24-9-3", ScalingKind::frame);
  model.history = {.frames = 3, .stride = 2, .change = 0.07};
  model.scaling.history = 3;
  model.bound->tactels = 4;
  return model;
}

/// A network with a bound by the rest of four tactels, with two frames of the path.
nn::Model by_rest() {
  nn::Model model = bounded_model("16-9-3", ScalingKind::frame);
  model.scaling.kind = ScalingKind::rest;
  model.history = {.frames = 3, .change = 0.001, .rest = true};
  model.scaling.history = 3;
  model.bound->tactels = 4;
  return model;
}

/// A network of four tactels that takes friction.
nn::Model with_friction() {
  nn::Model model = plain("10-6-1");
  model.scaling.friction = model.history.friction = true;
  model.learnt = {.least_friction = 0.1f, .most_friction = 2};
  return model;
}

TEST(LiveEstimator, DeviceGivesTheBitsOfTheHost) {
  const std::vector<nn::Model> models{with_history()};
  for (const std::size_t sensors : {1u, 2u, 17u, 33u})  // around the kernel's vectors and tiles
    expect_the_hosts_bits(device("basic"), models, std::vector<std::size_t>(sensors, 0));
  for (const Device& other : {device("basic").as_gpu(), device("pthread")})
    expect_the_hosts_bits(other, models, {0, 0, 0});
}

// Networks of one topology share a launch; one of another is between them.
TEST(LiveEstimator, EachSensorHasItsOwnNetwork) {
  std::vector<nn::Model> models{with_history(), plain("8-5-1"), with_history(), of_pad(), by_rest(), with_friction()};
  for (float& w : models[2].weights.values) w *= 0.7f;
  models[2].bound->unlike_above *= 0.5f;
  expect_the_hosts_bits(device("basic"), models, {0, 1, 3, 2, 4, 5, 0, 2, 3, 4, 5});
}

}  // namespace tactel::host::live_estimator_test
