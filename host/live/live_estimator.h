// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <tactel/infer.h>

#include <memory>
#include <span>

#include "host/device/device.h"
#include "nn/model.h"

namespace tactel::host {

/// Answers to the frames of several sensors, the pads of a hand, whose histories it keeps.
class LiveEstimator {
 public:
  virtual ~LiveEstimator() = default;
  /// Takes the next frame of every sensor: [sensors][inputs of one frame] MPa, as SlipHistory::estimate. answers:
  /// [sensors]. Allocates nothing.
  virtual void estimate(std::span<const float> frames, std::span<Answer> answers) = 0;
  /// As SlipHistory::friction, of one sensor.
  virtual void friction(std::size_t sensor, float mu, float spread) = 0;
  /// As SlipHistory::slides, of the newest frame of one sensor.
  virtual float slides(std::size_t sensor) = 0;
  /// Seeks the rest of every sensor anew from the next frame on.
  virtual void rest() = 0;
  /// Forgets all frames.
  virtual void clear() = 0;
};

/// networks: that of each sensor, not null. touch: MPa, of each sensor, for the rest; none: those of the networks. In
/// the calling thread, by tactel::infer: the shortest time for a sensor or two.
std::unique_ptr<LiveEstimator> host_estimator(std::span<const nn::Model* const> networks,
                                              std::span<const double> touch = {});

/// The same bits by kernels/forward.cl on a device: one launch for all sensors whose networks have one topology and
/// scaling. It is compiled and has run once on return.
std::unique_ptr<LiveEstimator> device_estimator(const Device& device, std::span<const nn::Model* const> networks,
                                                std::span<const double> touch = {});

}  // namespace tactel::host
