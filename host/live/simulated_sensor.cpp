// SPDX-License-Identifier: Apache-2.0
#include "host/live/simulated_sensor.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <thread>
#include <utility>

#include "host/live/open_source.h"
#include "host/scenes/scene_file.h"
#include "host/support/errors.h"
#include "host/support/seconds.h"

namespace tactel::host {
namespace {

constexpr std::size_t most_frames_a_packet = 64;
constexpr double most_frames = 1e12;  // 30 years at 1 kHz; a number of frames must fit its type
constexpr double headroom = 1.5;      // full scale over the largest stress: gains spread, and ramps must not clip

std::uint64_t frame_count(double duration, const SimulationOptions& options) {
  return static_cast<std::uint64_t>(std::floor(duration * options.repeat * options.rate)) + 1;
}

hw::GenericLayout layout_of(int channels) {
  hw::GenericLayout layout;
  layout.sync = {0xA5, 0x5A};
  layout.header = 14;
  layout.counter = {2, 4};
  layout.clock = {6, 8};
  layout.channels = channels;
  layout.checksum = hw::Checksum::crc16;
  layout.confirmations = 1;
  return layout;
}

/// The channels of an axis whose tactels follow each other.
std::vector<int> axis_channels(int axis, Eigen::Index tactels) {
  std::vector<int> all(static_cast<std::size_t>(tactels));
  std::iota(all.begin(), all.end(), axis * static_cast<int>(tactels));
  return all;
}

void require_at_least(const std::string& key, double value, double least, const std::string& what) {
  if (!(value >= least && std::isfinite(value))) throw ValueError(key, fmt::format("{}", value), what);
}

}  // namespace

void SimulationOptions::validate() const {
  if (!(rate > 0 && rate <= 1e6))
    throw ValueError("rate", fmt::format("{}", rate), "a number of Hz, above 0, at most 1e6");
  const std::pair<const char*, double> times[] = {
      {"rest", rest}, {"press", press}, {"hold", hold}, {"drag", drag}, {"slip", slip}};
  for (const auto& [key, value] : times) require_at_least(key, value, 0, "a number of s, not below 0");
  for (const auto& [key, value] : {std::pair<const char*, double>{"gain_spread", gain_spread}, {"noise", noise}})
    if (!(value >= 0 && value <= 1)) throw ValueError(key, fmt::format("{}", value), "a number from 0 to 1");
  require_at_least("time_constant", time_constant, 0, "a number of s, not below 0 (0: no charge amplifier)");
  require_at_least("bits", bits, 2, "a whole number from 2 to 16");
  if (bits > 16) throw ValueError("bits", std::to_string(bits), "a whole number from 2 to 16");
  require_at_least("repeat", repeat, 1, "a whole number, at least 1");
  if (const double frames = (rest + press + hold + drag + slip) * repeat * rate; !(frames <= most_frames))
    throw ValueError(
        "repeat", std::to_string(repeat),
        fmt::format("so small that at most {:.0e} frames are played, and not {:.0e}", most_frames, frames));
}

ScenePlay::ScenePlay(const fem::ContactSolution& solution, int indentation_steps, const SimulationOptions& options)
    : map_{axis_channels(0, solution.tactel_x.size()), axis_channels(1, solution.tactel_x.size()), {}} {
  stress_ = Eigen::MatrixXd::Zero(2 * solution.tactel_x.size(), static_cast<Eigen::Index>(solution.steps.size()));
  load_.resize(2, stress_.cols());
  for (std::size_t i = 0; i < solution.steps.size(); ++i) {
    const fem::ContactStep& step = solution.steps[i];
    stress_.col(static_cast<Eigen::Index>(i)) << step.sigma_y, step.tau_xy;
    load_.col(static_cast<Eigen::Index>(i)) << step.slip_index.value_or(0) * step.P, step.P;
  }
  set_times(indentation_steps, options);
}

ScenePlay::ScenePlay(const fem::PadSolution& solution, const fem::PadScene& scene, const SimulationOptions& options)
    : pads_{{scene.sensor.tactels, scene.sensor.pitch}} {
  const auto tactels = static_cast<Eigen::Index>(pads_[0].count());
  map_.normal = axis_channels(0, tactels);
  if (scene.sensor.axes == 3) map_.shear = axis_channels(1, tactels), map_.shear_y = axis_channels(2, tactels);
  stress_ = Eigen::MatrixXd::Zero(scene.sensor.axes * tactels, static_cast<Eigen::Index>(solution.steps.size()));
  load_.resize(2, stress_.cols());
  for (std::size_t i = 0; i < solution.steps.size(); ++i) {
    const fem::PadStep& step = solution.steps[i];
    stress_.col(static_cast<Eigen::Index>(i)) = step.stress.leftCols(scene.sensor.axes).reshaped();
    load_.col(static_cast<Eigen::Index>(i)) << step.slip_index.value_or(0) * step.P, step.P;
  }
  set_times(static_cast<int>(fem::pressing_targets(scene.load)), options);
}

/// Knots: rest, its end where it lasts, each load step, and after the last step of pressing and of all it is held.
void ScenePlay::set_times(int pressing_steps, const SimulationOptions& options) {
  const Eigen::MatrixXd steps = std::exchange(stress_, Eigen::MatrixXd::Zero(stress_.rows(), stress_.cols() + 4));
  const Eigen::Matrix2Xd loads = std::exchange(load_, Eigen::Matrix2Xd::Zero(2, stress_.cols()));
  time_ = {0.0};
  if (options.rest > 0) time_.push_back(options.rest);
  const double dragged = options.rest + options.press + options.hold;
  const auto add = [&](double time, Eigen::Index step) {
    stress_.col(static_cast<Eigen::Index>(time_.size())) = steps.col(step);
    load_.col(static_cast<Eigen::Index>(time_.size())) = loads.col(step);
    time_.push_back(time);
  };
  for (int i = 0; i < pressing_steps; ++i) add(options.rest + options.press * (i + 1) / pressing_steps, i);
  add(dragged, pressing_steps - 1);
  const Eigen::Index tangential = steps.cols() - pressing_steps;
  for (Eigen::Index i = 0; i < tangential; ++i)
    add(dragged + options.drag * static_cast<double>(i + 1) / static_cast<double>(tangential), pressing_steps + i);
  add(time_.back() + options.slip, steps.cols() - 1);
}

ScenePlay::Place ScenePlay::place(double t) const {
  const auto after = std::ranges::upper_bound(time_, t);
  const auto next = std::clamp<std::ptrdiff_t>(after - time_.begin(), 1, static_cast<std::ptrdiff_t>(time_.size()) - 1);
  const double from = time_[static_cast<std::size_t>(next - 1)], to = time_[static_cast<std::size_t>(next)];
  return {next, to > from ? std::clamp((t - from) / (to - from), 0.0, 1.0) : 1.0};
}

void ScenePlay::at(double t, Eigen::VectorXd& stress) const {
  const auto [next, share] = place(t);
  stress = (1 - share) * stress_.col(next - 1) + share * stress_.col(next);
}

float ScenePlay::slip_index(double t) const {
  const auto [next, share] = place(t);
  const Eigen::Vector2d load = (1 - share) * load_.col(next - 1) + share * load_.col(next);
  return load[1] > 0 ? static_cast<float>(load[0] / load[1]) : std::nanf("");
}

SimulatedSensor::SimulatedSensor(ScenePlay play, const SimulationOptions& options)
    : play_(std::move(play)),
      options_(options),
      converter_{.bits = options.bits, .full_scale = headroom * std::max(play_.largest(), 1e-9)},
      layout_(layout_of(play_.channels())),
      random_(static_cast<std::uint64_t>(options.seed)),
      stress_(play_.channels()),
      codes_(static_cast<std::size_t>(play_.channels())),
      frames_(frame_count(play_.duration(), options)),
      zero_(Clock::now()) {
  const double decay = options.time_constant > 0 ? options.time_constant : std::numeric_limits<double>::infinity();
  std::normal_distribution<double> spread(1.0, 1.0);
  for (std::size_t i = 0; i < codes_.size(); ++i) {
    gain_.push_back(1 + options.gain_spread * (spread(random_) - 1));
    amplifiers_.emplace_back(decay, 1 / options.rate);
  }
  packet_.reserve(most_frames_a_packet * hw::generic_frame_length(layout_));
}

std::string SimulatedSensor::profile_text() const {
  // Codes: before the converter and by its rounding; half a step at least, as tare has it.
  const double noise =
      std::max(0.5, std::sqrt(std::pow(options_.noise * converter_.full_scale / converter_.step(), 2) + 1.0 / 12));
  return fmt::format(
      "[device]\nname = \"simulated sensor\"\n"
      "[format]\nkind = \"generic\"\nsync = [0xA5, 0x5A]\nheader = {}\ncounter_offset = {}\ncounter_width = {}\n"
      "clock_offset = {}\nclock_width = {}\nclock_tick = {}\nchannels = {}\nsample = \"u16\"\nchecksum = \"crc16\"\n"
      "confirmations = {}\n"
      "{}[calibration]\noffset = {}\ngain = {}\nnoise = {}\n",
      layout_.header, layout_.counter.offset, layout_.counter.width, layout_.clock.offset, layout_.clock.width,
      layout_.clock_tick, layout_.channels, layout_.confirmations, play_.channels_text(), converter_.zero(),
      converter_.step(), noise);
}

// Without pace the clock begins anew at each frame's own time, when it is handed out.
double SimulatedSensor::now() const { return zero_time_ + seconds_since(zero_); }

// What is overdue comes at once in one packet, as from a device whose bytes were not fetched in time.
std::optional<hw::Packet> SimulatedSensor::wait(double timeout) {
  if (finished()) return std::nullopt;
  packet_.clear();
  if (!options_.paced) {
    append_frame();
    zero_time_ = due(frame_ - 1);
    zero_ = Clock::now();
    return hw::Packet{packet_, zero_time_};
  }
  const double asked = now();
  if (due(frame_) > asked + timeout) {
    std::this_thread::sleep_for(std::chrono::duration<double>(timeout));
    return std::nullopt;
  }
  if (due(frame_) > asked) std::this_thread::sleep_for(std::chrono::duration<double>(due(frame_) - asked));
  const bool overdue = due(frame_) <= asked;
  const double time = now();
  for (std::size_t i = 0; i < most_frames_a_packet && !finished() && due(frame_) <= time; ++i) append_frame();
  if (packet_.empty()) return std::nullopt;
  return hw::Packet{packet_, overdue ? due(frame_ - 1) : now()};
}

bool SimulatedSensor::end_after(double seconds) {
  frames_ = static_cast<std::uint64_t>(
      std::clamp(std::ceil(seconds * options_.rate * (1 - 1e-12)), 1.0, static_cast<double>(frames_)));
  return true;
}

double SimulatedSensor::time_of(std::uint64_t frame) const {
  const double played =
      std::min(std::floor(due(frame) / play_.duration()), options_.repeat - 1.0);  // the end is not a new start
  return due(frame) - played * play_.duration();
}

void SimulatedSensor::append_frame() {
  std::normal_distribution<double> noise(0.0, 1.0);
  const double t = due(frame_);
  play_.at(time_of(frame_), stress_);
  for (std::size_t i = 0; i < codes_.size(); ++i) {
    const double measured = amplifiers_[i](gain_[i] * stress_[static_cast<Eigen::Index>(i)]);
    codes_[i] = converter_(measured + options_.noise * converter_.full_scale * noise(random_));
  }
  const std::size_t at = packet_.size();
  packet_.resize(at + hw::generic_frame_length(layout_));
  const auto clock = static_cast<std::uint64_t>(std::llround(t / layout_.clock_tick));
  hw::write_generic_frame(layout_, frame_, clock, codes_, std::span(packet_).subspan(at));
  ++frame_;
  ++counts_.packets;
  counts_.bytes += packet_.size() - at;
}

std::unique_ptr<SimulatedSensor> open_simulation(const std::string& scene_and_options) {
  SourceOptions given(scene_and_options);
  SimulationOptions options;
  for (const auto& [key, value] : {std::pair<const char*, double*>{"rate", &options.rate},
                                   {"rest", &options.rest},
                                   {"press", &options.press},
                                   {"hold", &options.hold},
                                   {"drag", &options.drag},
                                   {"slip", &options.slip},
                                   {"gain_spread", &options.gain_spread},
                                   {"noise", &options.noise},
                                   {"time_constant", &options.time_constant}})
    given.read(key, *value);
  for (const auto& [key, value] : {std::pair<const char*, int*>{"tactels", &options.tactels},
                                   {"bits", &options.bits},
                                   {"seed", &options.seed},
                                   {"repeat", &options.repeat}})
    given.read(key, *value);
  int paced = 1;
  given.read("paced", paced);
  options.paced = paced != 0;
  given.finish();
  try {
    options.validate();
    AnyScene any = read_any_scene(given.path());
    if (const auto* pad = std::get_if<fem::PadScene>(&any)) {
      if (options.tactels != 0) throw ValueError("tactels", std::to_string(options.tactels), "left out of a pad");
      return std::make_unique<SimulatedSensor>(ScenePlay(solve(*pad, {}).solution, *pad, options), options);
    }
    auto& scene = std::get<fem::Scene>(any);
    if (options.tactels != 0) scene.sensor.tactels = options.tactels;
    scene.validate();
    const fem::ContactSolution solution = solve(scene, {}).solution;
    return std::make_unique<SimulatedSensor>(ScenePlay(solution, fem::load_path(scene.load).indentation_steps, options),
                                             options);
  } catch (const ValueError& error) {
    throw ConfigError("--source simulate:", error);
  }
}

}  // namespace tactel::host
