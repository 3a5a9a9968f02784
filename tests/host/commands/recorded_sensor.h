// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "fem/contact_solution.h"
#include "hw/generic_format.h"
#include "hw/recording.h"

namespace tactel::host {

/// A simulated sensor of eight tactels with gains, offsets and noise of its own, and recordings of it.
struct RecordedSensor {
  static constexpr int tactels = 8, channels = 2 * tactels;
  static constexpr double noise = 0.002;  ///< MPa
  /// Of a profile; the channels of the frames are those of the places.
  static constexpr const char* format =
      "[format]\nkind = \"generic\"\nsync = [0xA5, 0x5A]\nchannels = 16\nsample = \"f32\"\n";

  hw::GenericLayout layout;
  std::mt19937 random{7};
  Eigen::VectorXd gain{channels}, offset{channels};  ///< MPa by a unit; units

  RecordedSensor() {
    layout.sync = {0xA5, 0x5A};
    layout.header = 2;
    layout.channels = channels;
    layout.sample = hw::SampleType::f32;
    std::normal_distribution<double> normal;
    for (double& g : gain) g = 0.01 * (1 + 0.2 * normal(random));
    for (double& o : offset) o = 100 * normal(random);
  }

  /// Writes a frame under stresses [channels], MPa.
  void write(hw::RecordingWriter& writer, double arrival, const Eigen::VectorXd& stress) {
    std::normal_distribution<double> normal;
    std::vector<double> samples(channels);
    std::vector<std::uint8_t> bytes(hw::generic_frame_length(layout));
    for (int c = 0; c < channels; ++c)
      samples[static_cast<std::size_t>(c)] = (stress[c] + noise * normal(random)) / gain[c] + offset[c];
    hw::write_generic_frame(layout, 0, 0, samples, bytes);
    writer.write({.bytes = bytes, .arrival = arrival});
  }

  /// Records frames every 10 ms: so many at rest, then so many on each load step. Returns "P, P, ...", N/mm.
  std::string record(const std::string& path, const std::vector<fem::ContactStep>& steps, int at_rest, int on_step) {
    hw::RecordingWriter writer(path, "");
    std::string P;
    const int frames = at_rest + on_step * static_cast<int>(steps.size());
    for (int frame = 0; frame < frames; ++frame) {
      Eigen::VectorXd stress = Eigen::VectorXd::Zero(channels);
      if (frame >= at_rest) {
        const fem::ContactStep& step = steps[static_cast<std::size_t>((frame - at_rest) / on_step)];
        stress << step.sigma_y, step.tau_xy;
      }
      write(writer, 5 + 0.01 * frame, stress);
    }
    writer.finish();
    for (const fem::ContactStep& step : steps) P += (P.empty() ? "" : ", ") + std::to_string(step.P);
    return P;
  }
};

}  // namespace tactel::host
