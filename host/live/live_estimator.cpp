// SPDX-License-Identifier: Apache-2.0
#include "host/live/live_estimator.h"

#include <algorithm>
#include <deque>
#include <limits>
#include <map>
#include <optional>

#include "host/networks/forward.h"
#include "nn/infer/network_file.h"

namespace tactel::host {
namespace {

class HostEstimator final : public LiveEstimator {
 public:
  explicit HostEstimator(std::span<const nn::Model* const> networks) {
    std::map<const nn::Model*, SlipEstimator> made;
    for (const nn::Model* network : networks) {
      if (!made.contains(network)) made.emplace(network, infer::estimator_of(*network));
      sensors_.emplace_back(made.at(network));
    }
  }
  void estimate(std::span<const float> frames, std::span<Answer> answers) override {
    for (std::size_t i = 0; i < sensors_.size(); ++i) {
      answers[i] = sensors_[i].estimate(frames.first(sensors_[i].inputs()));
      frames = frames.subspan(sensors_[i].inputs());
    }
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
  SharedLaunch(Executor& executor, std::span<const nn::Model* const> of_sensors)
      : SharedLaunch(executor, of_sensors, distinct(of_sensors)) {}

  std::size_t inputs(std::size_t row) const { return sensors_[row].history.width(); }
  void take(std::size_t row, const float* frame) {
    sensors_[row].history.push(frame);
    sensors_[row].history.write(inputs_.row(static_cast<Eigen::Index>(row)).data());
  }
  void clear() {
    for (Sensor& sensor : sensors_) sensor.history.clear();
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
               const std::vector<const nn::Model*>& networks)
      : forward_(forward_of(executor, networks)),
        inputs_(nn::RowMatrix<float>::Zero(static_cast<Eigen::Index>(of_sensors.size()), networks.front()->stresses())),
        frames_(executor.device(), inputs_),
        buffer_(frames_.buffer()),
        found_(networks.size()) {
    for (const nn::Model* network : of_sensors) {
      const auto frames = static_cast<std::size_t>(network->history.frames);
      sensors_.push_back({static_cast<std::size_t>(std::ranges::find(networks, network) - networks.begin()),
                          nn::FrameHistory(static_cast<std::size_t>(inputs_.cols()) / frames, network->history),
                          network->learnt, network->scaling.normals(static_cast<int>(inputs_.cols()))});
    }
    run();  // compiles, and has the answers' memory
  }

  struct Sensor {
    std::size_t network;  ///< among those of the launch
    nn::FrameHistory history;
    nn::Learnt learnt;
    int normals;  ///< of the newest frame
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
  DeviceEstimator(const Device& device, std::span<const nn::Model* const> networks)
      : executor_(device, {.threads = 1}), places_(networks.size()) {  // waking other threads takes longer
    for (std::size_t first = 0; first < networks.size(); ++first) {
      if (places_[first].launch) continue;
      std::vector<const nn::Model*> together;
      for (std::size_t i = first; i < networks.size(); ++i)
        if (!places_[i].launch && share_a_launch(*networks[first], *networks[i])) {
          places_[i] = {launches_.size(), together.size()};
          together.push_back(networks[i]);
        }
      launches_.emplace_back(executor_, together);
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

std::unique_ptr<LiveEstimator> host_estimator(std::span<const nn::Model* const> networks) {
  return std::make_unique<HostEstimator>(networks);
}

std::unique_ptr<LiveEstimator> device_estimator(const Device& device, std::span<const nn::Model* const> networks) {
  return std::make_unique<DeviceEstimator>(device, networks);
}

}  // namespace tactel::host
