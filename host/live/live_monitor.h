// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <tactel/infer.h>

#include <deque>
#include <functional>
#include <limits>

#include "host/live/drift_watch.h"
#include "host/live/frame_reader.h"
#include "host/live/live_estimator.h"
#include "host/live/live_frames.h"
#include "host/live/mounting_watch.h"
#include "host/live/sensor_profile.h"
#include "hw/decoder.h"
#include "hw/frame_source.h"
#include "nn/model.h"

namespace tactel::host {

struct MonitorOptions {
  double late = 0.1;  ///< s: a live frame older than this is dropped and counted
  /// MPa: a frame whose normal stresses all stay below is no contact; none: ChannelMap::touch() of the profile, and at
  /// least the smallest peak that the network learnt; 0: all frames are contacts
  std::optional<double> touch{};
  /// As of AlarmOptions, up to signal.
  float at = std::numeric_limits<float>::infinity(), widest = std::numeric_limits<float>::infinity();
  int hold = 1;
  bool ignore_unlike = false, rest = false;
  AlarmSignal signal = AlarmSignal::slip;
  double friction = 0, friction_spread = 0.1;  ///< as of Alarm::friction; 0: not known
  /// Relative standard deviation by which mu drifts in the minute after it was read from a slide, and with the root of
  /// time.
  double friction_drift = 0.1;
  std::function<float(std::uint64_t frame)> true_slip_index{};  ///< of OpenSource, for a network of S or slid
  double silence = 1.0;  ///< s of listening to a live source without a frame until it is told, and told again
  double drift = 2.0;    ///< s of rest that are compared with the calibration at once (DriftWatch); 0: no watch
};

/// The answer to a frame.
struct MonitorLine {
  LiveFrame frame;
  std::span<const float> stresses;          ///< [places of the channel map] MPa
  Answer answer{};                          ///< of several pads: of the one with the largest number to act on
  bool has_bound = false;                   ///< the network has a bound
  std::optional<bool> contact{};            ///< as of AlarmAnswer; of several pads whether one touches
  float acted_on = 0;                       ///< as of AlarmAnswer, and the next two
  bool alarm = false, cannot_tell = false;  ///< of several pads those of one
  bool no_answer = false;                   ///< a pad touches and has none
  CannotTell why = CannotTell::none;        ///< of the first pad that cannot tell
  std::optional<bool> rest{};               ///< as of AlarmAnswer; of several pads whether one has it
  /// As of AlarmAnswer; the largest of several pads, the smallest index.
  float moved = std::numeric_limits<float>::quiet_NaN(), left = moved, calm = moved, index = moved;
  bool has_left = false, has_index = false, released = false;  ///< they are asked for; of several pads that of one
  std::optional<float> true_slip_index{};                      ///< of a simulation; NaN without contact
  std::vector<AlarmAnswer> pads{};                             ///< of several pads; none: `answer` is all
  std::vector<Drift> drift{};                                  ///< what this frame showed to have moved; mostly nothing
  double latency = 0;                                          ///< us from the frame's last byte to S
  double answer_time = 0;                                      ///< us of the latency, from the decoded frame to S
};

struct MonitorSummary {
  hw::DecoderCounts decoder;
  hw::TransportCounts transport;
  std::uint64_t late = 0;
  std::uint64_t silences = 0;  ///< each counts once, regardless of its length
  std::uint64_t drifts = 0;    ///< each counts once
  std::uint64_t contacts = 0;  ///< frames in contact
  std::uint64_t faint = 0;     ///< frames that touch by the profile's threshold, but by no peak that was learnt
  /// Of a simulation: sum of |S - true S|, and its frames.
  double error_sum = 0;
  std::uint64_t judged = 0;
  LatencyHistogram latency;
  std::string device;  ///< that evaluated the networks; empty: host code
};

/// What its user asks of a LiveMonitor between packets.
struct MonitorCalls {
  bool rest = false;    ///< Alarm::rest of all pads
  bool slides = false;  ///< Alarm::slides of all pads
};

/// Callbacks of LiveMonitor. Empty functions are allowed.
struct MonitorEvents {
  std::function<void(const MonitorLine&)> line{};
  std::function<void(const MonitorSummary&)> second{};  ///< about once a second
  /// Seconds without a frame, and the time of the source's clock; each MonitorOptions::silence again.
  std::function<void(double seconds, double now)> silence{};
  std::function<bool()> stop{};           ///< true ends it
  std::function<MonitorCalls()> calls{};  ///< asked between packets
  /// mu of each pad after `slides`, or of AlarmSignal::left Q / P; NaN: none was read.
  std::function<void(std::span<const float>)> friction{};
};

/// Returns the rate of frames, Hz, of the recorded hold, else a usual one.
double usual_rate(const SensorProfile& profile);
/// Returns whether the calibration gives every pad a threshold of touch.
bool knows_touch(const SensorProfile& profile);

/// Returns the tactels of each pad, or of the line.
std::vector<std::size_t> tactels_of(const SensorProfile& profile);
/// Takes the stresses of `tactels` tactels from `first` on, axis by axis, from those of all tactels of a profile's map.
void take_pad(std::span<const float> all, std::size_t all_tactels, std::size_t first, std::size_t tactels, float* to);
/// Throws ConfigError where a network's inputs do not match a pad, or a line, of so many tactels.
void check_width(const nn::Model& model, const SensorProfile& profile, std::size_t tactels);

/// Turns frames of a source into slippage indices and an alarm, in the calling thread, by tactel::Alarm.
class LiveMonitor {
 public:
  /// `networks`: one, or one for each pad of the profile, all with a bound or none; there may be none but of
  /// AlarmSignal::slip. Throws ConfigError where their number is another, or the inputs of one do not match the
  /// tactels. `device`: evaluates them; none: host code, with the same bits.
  LiveMonitor(std::span<const nn::Model> networks, const SensorProfile& profile, const MonitorOptions& options,
              const std::optional<Device>& device = {});
  LiveMonitor(const nn::Model& network, const SensorProfile& profile, const MonitorOptions& options)
      : LiveMonitor(std::span(&network, 1), profile, options) {}
  /// Runs until the source ends or `stop` returns true.
  MonitorSummary run(hw::FrameSource& source, const MonitorEvents& events);

 private:
  /// A line, or a pad: some tactels of the map.
  struct Sensor {
    /// network: null without one.
    Sensor(const SlipEstimator* network, const SensorProfile& profile, std::size_t pad, std::size_t first,
           std::size_t tactels, const MonitorOptions& options);
    bool rests() const;

    std::size_t first, tactels;
    double touch;                             ///< MPa, of options or profile, without that of the network
    Alarm alarm;                              ///< has the frames answered, or dropped as late
    std::optional<MountingWatch> mounting{};  ///< of a pad
    std::span<float> stresses{};              ///< [axes tactels] MPa, of frames_
    float friction = 0;                       ///< as read from a slide; 0: none was
    double read_at = 0;                       ///< s, of that reading
  };
  void answer(const hw::DecodedFrame& frame, double arrival, const MonitorEvents& events);
  void estimate();
  void count(MonitorLine& line, bool rest);
  void refresh();
  void watch(const MonitorEvents& events);
  void judge();
  void slides(const MonitorEvents& events, double now);
  float read_friction(std::size_t sensor, double now);
  float trust(const Sensor& sensor, double now) const;
  void listen(double now, const MonitorEvents& events);

  MonitorOptions options_;
  hw::ChannelMap map_;
  std::optional<DriftWatch> drift_;
  hw::Decoder decoder_;
  bool has_bound_, magnitude_, of_slid_, has_index_;
  RateMeter rate_;
  std::deque<Sensor> sensors_;
  std::unique_ptr<LiveEstimator> estimator_;            ///< null without networks
  std::vector<float> frames_;                           ///< [sensors][axes tactels] MPa, of the newest frame
  std::vector<Answer> answers_;                         ///< [sensors]
  std::vector<AlarmAnswer> own_;                        ///< [sensors] before they are joined
  MonitorLine line_;                                    ///< the newest, for its memory
  std::vector<float> stresses_;                         ///< [places of the map] MPa, of the newest frame
  const hw::FrameSource* source_ = nullptr;             ///< of the run, for its clock
  double next_second_ = 1, last_turn_ = 0, quiet_ = 0;  ///< s; quiet_: listened since the last frame
  std::uint64_t frames_before_ = 0;                     ///< decoded until the last turn
  int told_ = 0;                                        ///< how often the silence was told
  MonitorSummary summary_;
};

}  // namespace tactel::host
