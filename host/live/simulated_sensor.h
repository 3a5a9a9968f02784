// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Dense>
#include <chrono>
#include <memory>
#include <random>
#include <string>

#include "fem/gap/contact_solution.h"
#include "host/answers/solve.h"
#include "host/live/sensor_profile.h"
#include "hw/frame_source.h"
#include "hw/generic_format.h"
#include "nn/charge_amplifier.h"

namespace tactel::host {

/// Timing of a scene, and its measuring chain, that of the paper's sensor (section III).
struct SimulationOptions {
  double rate = 100;          ///< Hz
  double rest = 0;            ///< s without contact at the beginning of each play
  double press = 0.5;         ///< s for the indentation steps
  double hold = 0.2;          ///< s between press and drag
  double drag = 2;            ///< s for the tangential steps
  double slip = 0.5;          ///< s held at the end
  int tactels = 0;            ///< 0: those of the scene
  double gain_spread = 0.05;  ///< standard deviation of the transducers' gains, relative
  double noise = 0.001;       ///< standard deviation before the converter, of full scale
  double time_constant = 1;   ///< s of the charge amplifiers; 0: none, the stress itself
  int bits = 12;              ///< of the converter
  int seed = 1;               ///< of gains and noise
  int repeat = 1;             ///< number of times that the scene is played
  bool paced = true;          ///< by the clock; else as fast as it is read
  void validate() const;      ///< throws ValueError
};

/// The stresses of a solved scene over time: rest, then its load steps, each reached at a constant rate.
class ScenePlay {
 public:
  ScenePlay(const fem::ContactSolution& solution, int indentation_steps, const SimulationOptions& options);
  ScenePlay(const fem::PadSolution& solution, const fem::PadScene& scene, const SimulationOptions& options);
  double duration() const { return time_.back(); }  ///< s, of one pass
  int channels() const { return static_cast<int>(stress_.rows()); }
  double largest() const { return stress_.cwiseAbs().maxCoeff(); }  ///< MPa
  /// Computes stress [channels] MPa at time t, normal stresses first.
  void at(double t, Eigen::VectorXd& stress) const;
  /// Returns S at time t: the quotient of S P and P, each linear between load steps as the stress; NaN where P is 0.
  float slip_index(double t) const;
  /// Returns the channels of the stresses, and of a pad its layout.
  std::string channels_text() const { return host::channels_text(map_, pads_); }

 private:
  struct Place {
    Eigen::Index next;  ///< the knot at or after a time
    double share;       ///< of it, the rest of the knot before
  };
  Place place(double t) const;
  void set_times(int pressing_steps, const SimulationOptions& options);

  std::vector<double> time_;  ///< [knots] s
  Eigen::MatrixXd stress_;    ///< [channels, knots] MPa
  Eigen::Matrix2Xd load_;     ///< [2, knots] S P and P, N/mm, or N of a pad
  hw::ChannelMap map_;
  std::vector<PadLayout> pads_;
};

/// A simulated sensor: a played scene through the measuring chain, in frames of the generic format.
class SimulatedSensor final : public hw::FrameSource {
 public:
  SimulatedSensor(ScenePlay play, const SimulationOptions& options);
  /// Returns the profile of these frames, with nominal gains and the noise at rest.
  std::string profile_text() const;
  /// Returns S of frame n of the source; NaN without contact.
  float true_slip_index(std::uint64_t n) const { return play_.slip_index(time_of(n)); }

  std::optional<hw::Packet> wait(double timeout) override;
  bool finished() const override { return frame_ >= frames_; }
  bool live() const override { return options_.paced; }
  double now() const override;
  hw::TransportCounts counts() const override { return counts_; }
  bool end_after(double seconds) override;

 private:
  void append_frame();
  double due(std::uint64_t frame) const { return static_cast<double>(frame) / options_.rate; }
  double time_of(std::uint64_t frame) const;  ///< s, in its play of the scene

  ScenePlay play_;
  SimulationOptions options_;
  nn::Converter converter_;
  hw::GenericLayout layout_;
  std::mt19937_64 random_;
  std::vector<double> gain_;  ///< [channels]
  std::vector<nn::ChargeAmplifier> amplifiers_;
  Eigen::VectorXd stress_;
  std::vector<double> codes_;
  std::vector<std::uint8_t> packet_;
  std::uint64_t frame_ = 0, frames_;
  double zero_time_ = 0;  ///< s, now() at zero_
  std::chrono::steady_clock::time_point zero_;
  hw::TransportCounts counts_;
};

/// Solves the scene of "SCENE.toml?rate=1000&noise=0" and plays it. Throws ConfigError.
std::unique_ptr<SimulatedSensor> open_simulation(const std::string& scene_and_options);

}  // namespace tactel::host
