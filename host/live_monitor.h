#pragma once
#include <functional>

#include "host/forward.h"
#include "host/live_frames.h"
#include "host/sensor_profile.h"
#include "hw/decoder.h"
#include "hw/frame_source.h"

namespace tactel::host {

struct MonitorOptions {
  double late = 0.1;            ///< s: a live frame older than this when its turn comes is dropped and counted
  std::size_t queue = 4096;     ///< frames that may wait
  std::size_t batch_from = 16;  ///< from so many waiting frames on, one launch answers all
  double silence = 1.0;         ///< s without a frame from a live source before that is said
};

/// A frame's answer.
struct MonitorLine {
  LiveFrame frame;
  std::span<const float> stresses;  ///< [2 tactels] MPa
  FrameAnswer<float> answer;
  double latency = 0;      ///< us from the frame's last byte to S
  double answer_time = 0;  ///< us of it, from the decoded frame to S
};

struct MonitorSummary {
  hw::DecoderCounts decoder;
  hw::TransportCounts transport;
  std::uint64_t late = 0, batched = 0, silences = 0;
  LatencyHistogram latency;
};

/// What happens besides frames. Empty functions are allowed.
struct MonitorEvents {
  std::function<void(const MonitorLine&)> line{};
  std::function<void(const MonitorSummary&)> second{};  ///< about once a second
  std::function<void(double seconds)> silence{};        ///< nothing came for so long
  std::function<bool()> stop{};                         ///< true ends it
};

/// Frames from a source to slippage indices, in the calling thread: single frames the shortest way, many waiting ones
/// as a batch, with the same bits.
class LiveMonitor {
 public:
  /// Compiles and runs the network once. Throws ConfigError when its inputs are not the profile's tactels.
  LiveMonitor(Executor& executor, const nn::Model& model, const SensorProfile& profile, const MonitorOptions& options);
  /// Until the source ends or `stop` says so.
  MonitorSummary run(hw::FrameSource& source, const MonitorEvents& events);

 private:
  void decode(const hw::Packet& packet);
  void answer_waiting(const MonitorEvents& events);
  void drop_late();
  void answer_one(const MonitorEvents& events);
  void answer_batch(const MonitorEvents& events);
  void tell(std::size_t i, const FrameAnswer<float>& answer, double now, const MonitorEvents& events);
  void refresh();
  void watch(const MonitorEvents& events);

  MonitorOptions options_;
  hw::ChannelMap map_;
  hw::Decoder decoder_;
  FrameQueue queue_;
  ForwardOne<float> one_;
  Forward<float> batch_;
  const Device* device_;
  const hw::FrameSource* source_ = nullptr;  ///< of the run, for its clock
  double arrival_ = 0, last_frame_ = 0, next_second_ = 1;
  std::size_t dropped_before_ = 0;
  bool silent_ = false;
  hw::FrameSink sink_;
  MonitorSummary summary_;
};

}  // namespace tactel::host
