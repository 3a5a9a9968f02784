// SPDX-License-Identifier: Apache-2.0
#include "host/live/live_estimator.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <limits>
#include <map>
#include <optional>

#include "host/networks/forward.h"
#include "nn/infer/friction_reading.h"
#include "nn/infer/network_file.h"
#include "nn/infer/sensor_frames.h"

namespace tactel::host {
namespace {

std::optional<double> touch_of(std::span<const double> touch, std::size_t sensor) {
  return touch.empty() ? std::nullopt : std::optional(touch[sensor]);
}

class HostEstimator final : public LiveEstimator {
 public:
  HostEstimator(std::span<const nn::Model* const> networks, std::span<const double> touch) {
    std::map<const nn::Model*, SlipEstimator> made;
    for (const nn::Model* network : networks) {
      if (!made.contains(network)) made.emplace(network, infer::estimator_of(*network));
      sensors_.emplace_back(made.at(network), touch_of(touch, sensors_.size()));
    }
  }
  void estimate(std::span<const float> frames, std::span<Answer> answers) override {
    for (std::size_t i = 0; i < sensors_.size(); ++i) {
      answers[i] = sensors_[i].estimate(frames.first(sensors_[i].inputs()));
      frames = frames.subspan(sensors_[i].inputs());
    }
  }
  void friction(std::size_t sensor, float mu, float spread) override { sensors_[sensor].friction(mu, spread); }
  float slides(std::size_t sensor) override { return sensors_[sensor].slides(); }
  void rest() override {
    for (SlipHistory& sensor : sensors_) sensor.rest();
  }
  void clear() override {
    for (SlipHistory& sensor : sensors_) sensor.clear();
  }

 private:
  std::deque<SlipHistory> sensors_;
};

bool share_a_launch(const nn::Model& a, const nn::Model& b) {
  return a.weights.topology == b.weights.topology && a.scaling == b.scaling &&
         a.bound.has_value() == b.bound.has_value();
}

/// The distinct ones, in order.
std::vector<const nn::Model*> distinct(std::span<const nn::Model* const> networks) {
  std::vector<const nn::Model*> all;
  for (const nn::Model* network : networks)
    if (std::ranges::find(all, network) == all.end()) all.push_back(network);
  return all;
}

Forward<float> forward_of(Executor& executor, std::span<const nn::Model* const> networks) {
  std::vector<nn::Weights<float>> weights;
  std::vector<const nn::Bound*> bounds;
  for (const nn::Model* network : networks) {
    weights.push_back(network->weights);
    if (network->bound) bounds.push_back(&*network->bound);
  }
  return Forward<float>(executor, weights, networks.front()->scaling, bounds);
}

/// Sensors of one launch: a row of frames each, which every network of them evaluates.
class SharedLaunch {
 public:
  /// touch: of each sensor.
  SharedLaunch(Executor& executor, std::span<const nn::Model* const> of_sensors,
               std::span<const std::optional<double>> touch)
      : SharedLaunch(executor, of_sensors, touch, distinct(of_sensors)) {}

  std::size_t inputs(std::size_t row) const { return sensors_[row].frames.width(); }
  void take(std::size_t row, const float* frame) {
    sensors_[row].frames.push(frame);
    sensors_[row].frames.write(inputs_.row(static_cast<Eigen::Index>(row)).data());
  }
  void friction(std::size_t row, float mu, float spread) {
    sensors_[row].frames.friction(mu, spread);
    sensors_[row].friction.forget();
  }
  float slides(std::size_t row) {
    Sensor& sensor = sensors_[row];
    if (!sensor.on_host) return std::numeric_limits<float>::quiet_NaN();
    const float* const input = inputs_.row(static_cast<Eigen::Index>(row)).data();
    std::vector<float> told(input, input + inputs_.cols());
    const float mu = sensor.friction.next(*sensor.on_host, sensor.learnt, told);
    if (!std::isnan(mu)) sensor.frames.friction(mu, infer::FrictionReading::spread);
    return mu;
  }
  void rest() {
    for (Sensor& sensor : sensors_) sensor.frames.rest();
  }
  void clear() {
    for (Sensor& sensor : sensors_) sensor.frames.clear();
  }
  void run() {
    buffer_.write({inputs_.data(), static_cast<std::size_t>(inputs_.size())});
    forward_.run(frames_);
    for (std::size_t i = 0; i < found_.size(); ++i) forward_.read(i, found_[i]);
  }
  Answer answer(std::size_t row) const {
    constexpr float none = std::numeric_limits<float>::quiet_NaN();
    const nn::Recall<float>& found = found_[sensors_[row].network];
    Answer answer{
        found.slip_index[static_cast<Eigen::Index>(row)],
        none,
        static_cast<AnswerStatus>(found.status[row]),
        {none, none},
        0,
        sensors_[row].learnt.beyond(inputs_.row(static_cast<Eigen::Index>(row)).data(), sensors_[row].normals),
        {}};
    if (found.bounds.empty()) return answer;
    const nn::BoundAnswer& bound = found.bounds[row];
    answer.slip_upper = bound.upper;
    std::ranges::copy(bound.interval, answer.slip_interval);
    answer.unlike = bound.unlike;
    return answer;
  }

 private:
  SharedLaunch(Executor& executor, std::span<const nn::Model* const> of_sensors,
               std::span<const std::optional<double>> touch, const std::vector<const nn::Model*>& networks)
      : forward_(forward_of(executor, networks)),
        inputs_(nn::RowMatrix<float>::Zero(static_cast<Eigen::Index>(of_sensors.size()), networks.front()->numbers())),
        frames_(executor.device(), inputs_),
        buffer_(frames_.buffer()),
        found_(networks.size()) {
    for (const nn::Model* network : of_sensors) {
      const auto stresses = static_cast<int>(inputs_.cols());
      sensors_.push_back(
          {static_cast<std::size_t>(std::ranges::find(networks, network) - networks.begin()),
           infer::SensorFrames(network->scaling, network->history, network->learnt, stresses, touch[sensors_.size()]),
           network->learnt, network->scaling.normals(stresses),
           network->history.friction ? std::optional(infer::estimator_of(*network)) : std::nullopt});
    }
    run();  // compiles, and has the answers' memory
  }

  struct Sensor {
    std::size_t network;  ///< among those of the launch
    infer::SensorFrames frames;
    nn::Learnt learnt;
    int normals;                           ///< of the newest frame
    std::optional<SlipEstimator> on_host;  ///< a network that takes friction, with the same bits
    infer::FrictionReading friction{};
  };
  Forward<float> forward_;
  nn::RowMatrix<float> inputs_;  ///< [sensors][inputs] MPa
  DeviceFrames frames_;
  Buffer<float> buffer_;  ///< that of frames_
  std::vector<nn::Recall<float>> found_;
  std::vector<Sensor> sensors_;
};

class DeviceEstimator final : public LiveEstimator {
 public:
  DeviceEstimator(const Device& device, std::span<const nn::Model* const> networks, std::span<const double> touch)
      : executor_(device, {.threads = 1}), places_(networks.size()) {  // waking other threads takes longer
    for (std::size_t first = 0; first < networks.size(); ++first) {
      if (places_[first].launch) continue;
      std::vector<const nn::Model*> together;
      std::vector<std::optional<double>> their_touch;
      for (std::size_t i = first; i < networks.size(); ++i)
        if (!places_[i].launch && share_a_launch(*networks[first], *networks[i])) {
          places_[i] = {launches_.size(), together.size()};
          together.push_back(networks[i]);
          their_touch.push_back(touch_of(touch, i));
        }
      launches_.emplace_back(executor_, together, their_touch);
    }
  }
  void estimate(std::span<const float> frames, std::span<Answer> answers) override {
    for (const auto& [launch, row] : places_) {
      launches_[*launch].take(row, frames.data());
      frames = frames.subspan(launches_[*launch].inputs(row));
    }
    for (SharedLaunch& launch : launches_) launch.run();
    for (std::size_t i = 0; i < answers.size(); ++i) answers[i] = launches_[*places_[i].launch].answer(places_[i].row);
  }
  void friction(std::size_t sensor, float mu, float spread) override {
    launches_[*places_[sensor].launch].friction(places_[sensor].row, mu, spread);
  }
  float slides(std::size_t sensor) override { return launches_[*places_[sensor].launch].slides(places_[sensor].row); }
  void rest() override {
    for (SharedLaunch& launch : launches_) launch.rest();
  }
  void clear() override {
    for (SharedLaunch& launch : launches_) launch.clear();
  }

 private:
  struct Place {
    std::optional<std::size_t> launch{};
    std::size_t row = 0;
  };
  Executor executor_;
  std::vector<Place> places_;  ///< of the sensors
  std::deque<SharedLaunch> launches_;
};

}  // namespace

std::unique_ptr<LiveEstimator> host_estimator(std::span<const nn::Model* const> networks,
                                              std::span<const double> touch) {
  return std::make_unique<HostEstimator>(networks, touch);
}

std::unique_ptr<LiveEstimator> device_estimator(const Device& device, std::span<const nn::Model* const> networks,
                                                std::span<const double> touch) {
  return std::make_unique<DeviceEstimator>(device, networks, touch);
}

}  // namespace tactel::host
