// SPDX-License-Identifier: Apache-2.0
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/timerfd.h>
#include <tactel/live.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <memory>
#include <utility>

#include "host/api/conversion.h"
#include "host/api/states.h"
#include "host/live/live_estimator.h"
#include "host/live/live_frames.h"
#include "host/live/open_source.h"
#include "hw/decoder.h"
#include "hw/descriptor.h"

namespace tactel {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t most_waiting = 4096;  ///< frames
constexpr long tick = 1'000'000;            ///< ns between looks at a source that runs by the clock, without descriptor

/// A format of the user's as hw has it.
class OwnFormat final : public hw::WireFormat {
 public:
  explicit OwnFormat(const tactel::WireFormat& format) : format_(format) {}
  hw::Verdict inspect(hw::Bytes bytes) const override {
    const Verdict verdict = format_.inspect(bytes);
    return {static_cast<hw::Verdict::Kind>(verdict.kind), verdict.length};
  }
  hw::FrameHeader read(hw::Bytes frame, std::span<double> values) const override {
    const FrameHeader header = format_.read(frame, values);
    return {header.counter, header.clock};
  }
  std::size_t channels() const override { return format_.channels(); }
  std::size_t longest_frame() const override { return format_.longest_frame(); }
  int confirmations() const override { return format_.confirmations(); }
  int counter_bits() const override { return format_.counter_bits(); }
  int clock_bits() const override { return format_.clock_bits(); }
  double clock_tick() const override { return format_.clock_tick(); }

 private:
  const tactel::WireFormat& format_;
};
static_assert(int(Verdict::incomplete) == int(hw::Verdict::incomplete) &&
              int(Verdict::whole) == int(hw::Verdict::whole));
static_assert(int(Verdict::nothing) == int(hw::Verdict::nothing) && int(Verdict::damaged) == int(hw::Verdict::damaged));

bool readable_within(int fd, double seconds) {
  pollfd wanted{fd, POLLIN, 0};
  const int most = static_cast<int>(std::clamp(seconds, 0.0, 3600.0) * 1e3 + 0.999);
  return ::poll(&wanted, 1, most) > 0;
}

/// A byte source of the user's as hw has it.
class OwnBytes final : public hw::FrameSource {
 public:
  explicit OwnBytes(ByteSource& bytes) : bytes_(bytes) {}
  std::optional<hw::Packet> wait(double timeout) override {
    if (finished_ || (timeout > 0 && !readable_within(bytes_.fd(), timeout))) return std::nullopt;
    const std::ptrdiff_t size = bytes_.read(buffer_);
    finished_ = size < 0;
    if (size <= 0) return std::nullopt;
    ++counts_.packets, counts_.bytes += static_cast<std::uint64_t>(size);
    return hw::Packet{hw::Bytes(buffer_).first(static_cast<std::size_t>(size)), now(), false};
  }
  bool finished() const override { return finished_; }
  bool live() const override { return true; }
  double now() const override { return std::chrono::duration<double>(Clock::now() - zero_).count(); }
  hw::TransportCounts counts() const override { return counts_; }
  int fd() const override { return bytes_.fd(); }

 private:
  ByteSource& bytes_;
  std::vector<std::uint8_t> buffer_ = std::vector<std::uint8_t>(1 << 14);
  hw::TransportCounts counts_;
  bool finished_ = false;
  Clock::time_point zero_ = Clock::now();
};

/// A descriptor of our own for sources without one: always readable, or readable each tick.
class Wakeup {
 public:
  explicit Wakeup(bool by_clock)
      : file_(by_clock ? ::timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK | TFD_CLOEXEC)
                       : ::eventfd(1, EFD_NONBLOCK | EFD_CLOEXEC)),
        by_clock_(by_clock) {
    if (file_ < 0) throw HardwareError(std::string("frame source: no descriptor: ") + std::strerror(errno));
    const itimerspec each{.it_interval = {0, tick}, .it_value = {0, tick}};
    if (by_clock) ::timerfd_settime(file_, 0, &each, nullptr);
  }
  int fd() const { return file_; }
  void clear() const {
    std::uint64_t ticks = 0;
    if (by_clock_ && ::read(file_, &ticks, sizeof ticks) < 0) return;  // no tick since
  }

 private:
  hw::Descriptor file_;
  bool by_clock_;
};

hw::ChannelMap map_of(const Channels& channels, std::size_t count) {
  hw::ChannelMap map{channels.normal, channels.shear, {channels.offset, channels.gain}};
  if (map.shear.empty()) map.shear.assign(map.normal.size(), -1);
  if (map.calibration.offset.empty()) map.calibration.offset.assign(count, 0.0);
  if (map.calibration.gain.empty()) map.calibration.gain.assign(count, 1.0);
  map.validate(count);
  return map;
}

}  // namespace

WireFormat::~WireFormat() = default;
int WireFormat::confirmations() const { return 1; }
int WireFormat::counter_bits() const { return 0; }
int WireFormat::clock_bits() const { return 0; }
double WireFormat::clock_tick() const { return 0; }

ByteSource::~ByteSource() = default;
std::ptrdiff_t ByteSource::read(std::span<std::uint8_t> into) {
  if (!readable_within(fd(), 0)) return 0;
  const ssize_t size = ::read(fd(), into.data(), into.size());
  if (size < 0 && (errno == EAGAIN || errno == EINTR)) return 0;
  return size > 0 ? size : -1;
}

struct FrameSource::State {
  State(std::unique_ptr<hw::FrameSource> source, std::unique_ptr<const hw::WireFormat> format, hw::ChannelMap map,
        std::string note)
      : source(std::move(source)),
        map(std::move(map)),
        decoder(std::move(format)),
        waiting(most_waiting, this->map.places()),
        note(std::move(note)) {
    if (!this->map.calibration.has_zero)
      this->note += (this->note.empty() ? "" : "; ") +
                    std::string(
                        "stresses have no zero: the profile has gains without offsets; give a calibration of "
                        "tactel tare");
    if (this->source->fd() < 0) own.emplace(this->source->live());
    sink = [this](const hw::DecodedFrame& frame) {
      const std::span<float> stress =
          waiting.push({.number = number++, .device_time = frame.device_time, .arrival = arrival});
      this->map.apply(frame.values, stress);
    };
  }

  int fd() const { return own ? own->fd() : source->fd(); }

  /// Frees the frame that was handed out, and reads packets until a frame waits or none comes. Returns whether one
  /// waits.
  bool advance(double seconds) {
    if (std::exchange(handed_out, false)) waiting.pop();
    if (own) own->clear();
    const auto end = Clock::now() + std::chrono::duration<double>(std::clamp(seconds, 0.0, 1e6));
    while (waiting.size() == 0 && !source->finished()) {
      const double left = std::max(0.0, std::chrono::duration<double>(end - Clock::now()).count());
      const auto packet = source->wait(seconds > 0 ? left : 0);
      if (packet) {
        if (packet->after_gap) decoder.interrupt();
        arrival = packet->arrival;
        decoder.feed(packet->bytes, sink);
        if (waiting.size() > 0) source->answered();
      } else if (!(seconds > 0) || left <= 0) {
        break;
      }
    }
    return waiting.size() > 0;
  }

  bool take(Frame& frame, double seconds) {
    if (!advance(seconds)) return false;
    const host::LiveFrame& next = waiting.frame(0);
    frame = {waiting.inputs(0), next.number, next.device_time, next.arrival};
    handed_out = true;
    return true;
  }

  std::unique_ptr<hw::FrameSource> source;
  hw::ChannelMap map;
  hw::Decoder decoder;
  host::FrameQueue waiting;
  std::string note;
  std::optional<Wakeup> own;
  hw::FrameSink sink;
  double arrival = 0;
  std::uint64_t number = 0;
  bool handed_out = false;  ///< the oldest frame is the user's
};

DeviceProfile read_profile(const std::string& name) {
  return api::with_public_errors([&] {
    const host::SensorProfile read = host::read_profile(name);
    const hw::Calibration& calibration = read.map.calibration;
    DeviceProfile profile{.text = read.text,
                          .channel = {},
                          .offset = calibration.offset,
                          .gain = calibration.gain,
                          .noise = calibration.noise,
                          .pads = {}};
    for (std::size_t i = 0; i < read.map.places(); ++i) profile.channel.push_back(read.map.channel(i));
    for (const host::PadLayout& pad : read.pads) profile.pads.push_back(pad.tactels);
    return profile;
  });
}

FrameSource FrameSource::open(const std::string& source, const std::string& profile, const std::string& calibration) {
  return api::with_public_errors([&] {
    host::OpenSource opened = host::open_source(source, profile, calibration);
    return FrameSource(new State(std::move(opened.source), opened.profile.format(), std::move(opened.profile.map),
                                 std::move(opened.note)));
  });
}

FrameSource::FrameSource(ByteSource& bytes, const WireFormat& format, const Channels& channels)
    : state_(api::with_public_errors([&] {
        return new State(std::make_unique<OwnBytes>(bytes), std::make_unique<OwnFormat>(format),
                         map_of(channels, format.channels()), "");
      })) {}

FrameSource::FrameSource(ByteSource& bytes, const std::string& profile)
    : state_(api::with_public_errors([&] {
        const host::SensorProfile read = host::read_profile(profile);
        return new State(std::make_unique<OwnBytes>(bytes), read.format(), read.map, "");
      })) {}

FrameSource::~FrameSource() { delete state_; }
FrameSource::FrameSource(FrameSource&& other) noexcept : state_(std::exchange(other.state_, nullptr)) {}
FrameSource& FrameSource::operator=(FrameSource&& other) noexcept {
  std::swap(state_, other.state_);
  return *this;
}

int FrameSource::fd() const { return state_->fd(); }

bool FrameSource::poll(Frame& frame) {
  return api::with_public_errors([&] { return state_->take(frame, 0); });
}

bool FrameSource::wait(Frame& frame, double seconds) {
  return api::with_public_errors([&] { return state_->take(frame, seconds); });
}

bool FrameSource::finished() const {
  const std::size_t left = state_->waiting.size() - (state_->handed_out ? 1 : 0);
  return left == 0 && state_->source->finished();
}

std::size_t FrameSource::inputs() const { return state_->map.places(); }
std::size_t FrameSource::tactels() const { return state_->map.tactels(); }
std::string FrameSource::note() const { return state_->note; }

FrameCounts FrameSource::counts() const {
  const hw::DecoderCounts& frames = state_->decoder.counts();
  const hw::TransportCounts transport = state_->source->counts();
  return {frames.frames,      frames.lost,      frames.bad + transport.bad, frames.resynchronised,
          transport.overruns, transport.stalls, transport.errors,           transport.reconnects};
}

struct LiveEstimator::State {
  std::unique_ptr<host::LiveEstimator> estimator;
  std::string device;
  std::size_t inputs, sensors;
};

LiveEstimator::LiveEstimator(const std::vector<Network>& networks, const std::string& device,
                             std::optional<double> touch)
    : state_(api::with_public_errors([&] {
        if (networks.empty()) throw InputError("networks", "none", "one for each sensor");
        std::vector<const nn::Model*> models;
        std::size_t inputs = 0;
        for (const Network& network : networks) {
          models.push_back(network.state_->model.get());
          inputs += static_cast<std::size_t>(models.back()->scaling.width(models.back()->numbers()));
        }
        const std::vector<double> touches(touch ? models.size() : 0, touch.value_or(0));
        if (device.empty()) return new State{host::host_estimator(models, touches), "", inputs, models.size()};
        const host::Device chosen(device);
        return new State{host::device_estimator(chosen, models, touches), chosen.info().name, inputs, models.size()};
      })) {}

LiveEstimator::~LiveEstimator() { delete state_; }
std::size_t LiveEstimator::inputs() const noexcept { return state_->inputs; }
std::size_t LiveEstimator::sensors() const noexcept { return state_->sensors; }
std::string LiveEstimator::device() const { return state_->device; }
void LiveEstimator::friction(float mu, float spread) {
  for (std::size_t sensor = 0; sensor < sensors(); ++sensor) state_->estimator->friction(sensor, mu, spread);
}
float LiveEstimator::slides(std::size_t sensor) {
  if (sensor >= sensors())
    throw InputError("sensor", std::to_string(sensor), "one of 0 to " + std::to_string(sensors() - 1));
  return state_->estimator->slides(sensor);
}
void LiveEstimator::rest() { state_->estimator->rest(); }
void LiveEstimator::clear() { state_->estimator->clear(); }

void LiveEstimator::estimate(std::span<const float> frames, std::span<Answer> answers) {
  if (frames.size() != inputs())
    throw InputError("frames", std::to_string(frames.size()) + " numbers", std::to_string(inputs()));
  if (answers.size() != sensors())
    throw InputError("answers", std::to_string(answers.size()),
                     "one for each of " + std::to_string(sensors()) + " sensors");
  api::with_public_errors([&] { state_->estimator->estimate(frames, answers); });
}

std::vector<DeviceInfo> devices() {
  return api::with_public_errors([] {
    const std::vector<host::DeviceInfo> found = host::list_devices();
    const int taken = host::default_device(found);
    std::vector<DeviceInfo> all;
    all.reserve(found.size());
    for (const host::DeviceInfo& device : found)
      all.push_back({device.index, device.name, device.platform, host::name(device.type), device.compute_units,
                     host::memory_of(device), device.fp64, device.index == taken});
    return all;
  });
}

}  // namespace tactel
