// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <CLI/CLI.hpp>
#include <chrono>
#include <string>
#include <vector>

#include "host/live/open_source.h"
#include "host/support/interrupt.h"
#include "hw/decoder.h"

namespace tactel::host {

/// Options of the commands that read a sensor.
struct SensorRequest {
  std::string source;
  std::vector<std::string> profiles, calibrations;
  double seconds = 0;  ///< 0: until the source ends
  bool quiet = false;
};
void add_sensor_options(CLI::App& command, SensorRequest& request);
/// Returns the check for a finite number above 0.
const CLI::Validator& positive_number();

/// Returns the check for a finite number of 0 or more.
const CLI::Validator& not_negative_number();

/// Opens the source. Prints its note on stderr, unless quiet.
OpenSource open_for(const SensorRequest& request);
/// Prints a warning about a truncated source, unless quiet.
void say_if_cut_short(const SensorRequest& request, const hw::FrameSource& source);
/// Prints a warning about a reading that decoded no frame, unless quiet.
void say_if_nothing_decoded(const SensorRequest& request, const hw::FrameSource& source,
                            const hw::DecoderCounts& counts);
/// Prints a line on stderr. A closed or full stderr does not end a reading.
void say(const std::string& text);

/// Ends a reading after some s, or on Ctrl-C. A source with a time of its own ends by that.
class Until {
 public:
  Until(hw::FrameSource& source, double seconds)  ///< 0: no such limit
      : seconds_(seconds > 0 && source.end_after(seconds) ? 0 : seconds) {}
  bool operator()() const { return by_signal() || (seconds_ > 0 && passed() >= seconds_); }
  bool by_signal() const { return interrupt_.requested(); }
  double passed() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

 private:
  using Clock = std::chrono::steady_clock;
  double seconds_;
  Interrupt interrupt_;
  Clock::time_point start_ = Clock::now();
};

}  // namespace tactel::host
