// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace tactel::hw {

/// Statistics of the readings of a channel over some time, in the device's units.
struct ChannelRest {
  std::size_t readings = 0;  ///< number of finite readings
  double mean = 0;           ///< 0 without readings
  double noise = 0;          ///< standard deviation between neighbouring readings, which a slow drift does not raise
  double step = 0;           ///< smallest difference of neighbours above 0: a step of the converter
  double lowest = 0, highest = 0;  ///< means over 8 to 16 equal parts of the time
  double allowed = 0;              ///< largest difference of these means in a sensor at rest
  bool at_rest() const { return highest - lowest <= allowed; }
};

/// Readings of a sensor that should be at rest: their means, and a check of rest. Memory does not grow with time.
class Tare {
 public:
  explicit Tare(std::size_t channels) : channels_(channels) {}
  /// Adds values [channels]. Non-finite ones are ignored.
  void add(std::span<const double> values);
  std::size_t frames() const { return frames_; }
  std::vector<double> offset() const;  ///< [channels] mean
  std::vector<double> noise() const;   ///< [channels] noise, but half a step at least: it may be hidden below the step
  ChannelRest channel(std::size_t i) const;

 private:
  static constexpr std::size_t most_parts = 16;
  struct Part {
    double sum = 0;
    std::size_t readings = 0;
    double mean() const { return sum / static_cast<double>(readings); }
  };
  struct Channel {
    std::array<Part, most_parts> parts{};
    double last = 0, steps = 0, smallest_step = 0;  ///< between neighbours: their sum, and the smallest above 0
    std::size_t readings = 0;
    void add(double value, std::size_t part);
    void halve();
  };
  std::vector<Channel> channels_;
  std::size_t frames_ = 0, frames_a_part_ = 1;
};

}  // namespace tactel::hw
