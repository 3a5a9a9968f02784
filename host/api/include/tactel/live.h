// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <tactel/train.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

// Frames of a sensor, live, recorded or simulated, for an event loop of your own; devices that answer them.

namespace tactel {

/// Classification of the beginning of some bytes.
struct Verdict {
  enum Kind : std::uint32_t {
    incomplete,  ///< more bytes are needed
    nothing,     ///< no frame begins here
    damaged,     ///< a frame begins here, but its checksum or structure is wrong
    whole        ///< a frame of `length` bytes
  };
  Kind kind = nothing;
  std::size_t length = 0;  ///< bytes; of a damaged frame where known, else 0
};

/// Counter and clock of a frame.
struct FrameHeader {
  std::optional<std::uint64_t> counter{};  ///< as sent, wraps at 2^counter_bits
  std::optional<std::uint64_t> clock{};    ///< ticks of the device's clock as sent, wraps at 2^clock_bits
};

/// A wire format of your own. Stateless: a verdict depends on the bytes alone, and never changes when more bytes
/// follow, except from `incomplete`. Nothing may throw.
class TACTEL_API WireFormat {
 public:
  WireFormat() = default;
  WireFormat(const WireFormat&) = delete;
  WireFormat& operator=(const WireFormat&) = delete;
  virtual ~WireFormat();
  virtual Verdict inspect(std::span<const std::uint8_t> bytes) const = 0;
  /// Reads a whole frame into values [channels()], in the units of the device.
  virtual FrameHeader read(std::span<const std::uint8_t> frame, std::span<double> values) const = 0;
  virtual std::size_t channels() const = 0;
  /// Returns the bytes from which on a verdict is never `incomplete`.
  virtual std::size_t longest_frame() const = 0;
  /// Returns the number of frames in a row that establish sync: above 1 where marks may also occur inside a frame.
  virtual int confirmations() const;
  virtual int counter_bits() const;   ///< 0: no counter
  virtual int clock_bits() const;     ///< 0: no clock
  virtual double clock_tick() const;  ///< s
};

/// A source of bytes of your own: a serial port, a socket, a pipe.
class TACTEL_API ByteSource {
 public:
  ByteSource() = default;
  ByteSource(const ByteSource&) = delete;
  ByteSource& operator=(const ByteSource&) = delete;
  virtual ~ByteSource();
  /// Returns the descriptor that is readable where read() has bytes.
  virtual int fd() const = 0;
  /// Reads bytes that are there, without waiting. Returns their number; 0: none now; -1: the end. Defaults to read(2)
  /// of fd(), where a pipe or socket that is closed on the other side ends it.
  virtual std::ptrdiff_t read(std::span<std::uint8_t> into);
};

/// Channels of the tactels' stresses, and their calibration.
struct Channels {
  std::vector<int> normal, shear;    ///< [tactels] channel; -1: none, the stress is 0
  std::vector<double> offset, gain;  ///< [channels] reading at rest; MPa by the device's unit. Empty: 0 and 1
};

/// What a device profile says of the channels of a frame.
struct DeviceProfile {
  std::string text;                         ///< the file
  std::vector<int> channel;                 ///< [inputs of a frame] channel; -1: none, the stress is 0
  std::vector<double> offset, gain, noise;  ///< [channels] as in the file; no noise: not known
  std::vector<std::array<int, 2>> pads;     ///< tactels along x and y of each pad; none: a line
};
/// Reads a profile file, or takes a built-in one: "glove", "uskin-4x4", "uskin-4x6". Throws InputError.
TACTEL_API DeviceProfile read_profile(const std::string& name);

/// A frame as networks take it.
struct Frame {
  /// [2 tactels] MPa, normal stresses first; of a pad [3 tactels], sigma_z, then tau_x, then tau_y; valid until the
  /// next poll or wait
  std::span<const float> stress;
  std::uint64_t number = 0;             ///< from 0, in the order of decoding
  std::optional<double> device_time{};  ///< s by the device's clock
  double arrival = 0;                   ///< s since the source was opened
};

/// Counts of a source.
struct FrameCounts {
  std::uint64_t frames = 0;                              ///< decoded
  std::uint64_t lost = 0;                                ///< missing by the device's counter
  std::uint64_t bad = 0;                                 ///< with a wrong checksum or structure
  std::uint64_t resynchronised = 0;                      ///< times that sync was found again
  std::uint64_t overruns = 0;                            ///< packets dropped because they were not polled in time
  std::uint64_t stalls = 0, errors = 0, reconnects = 0;  ///< of the transport
};

/// Frames of a sensor. One thread may use a source at a time. After the first frames poll() allocates nothing.
class TACTEL_API FrameSource {
 public:
  /// Opens "usb:glove", "usb:VID:PID" with a profile, "csv:FILE" with a profile, "replay:FILE" or
  /// "simulate:SCENE.toml?rate=100" (docs/sensors.md). Empty names mean no file. Throws InputError, HardwareError.
  static FrameSource open(const std::string& source, const std::string& profile = {},
                          const std::string& calibration = {});
  /// Reads `bytes` by a format of your own. Both must outlive the source. Throws InputError for channels that the
  /// format has not.
  FrameSource(ByteSource& bytes, const WireFormat& format, const Channels& channels);
  /// Reads `bytes`, which must outlive the source, by the format and channels of a profile file.
  FrameSource(ByteSource& bytes, const std::string& profile);
  ~FrameSource();
  FrameSource(FrameSource&&) noexcept;
  FrameSource& operator=(FrameSource&&) noexcept;

  /// Returns the descriptor that is readable where poll() may have a frame, for poll(2), epoll or select. Poll until
  /// poll() returns false before waiting for it again.
  int fd() const;
  /// Takes the next frame, without waiting. Returns false where there is none now. Throws HardwareError where the
  /// sensor or recording fails.
  bool poll(Frame& frame);
  /// The same, waiting up to `seconds`. Returns false also at the end.
  bool wait(Frame& frame, double seconds);
  /// Returns true at the end of the source, once all frames are taken.
  bool finished() const;

  std::size_t inputs() const;   ///< numbers of a frame
  std::size_t tactels() const;  ///< of which each has one of the frame's normal stresses
  FrameCounts counts() const;
  /// Returns a note for the user, such as which of several devices was opened; usually empty.
  std::string note() const;

  struct State;

 private:
  explicit FrameSource(State* state) noexcept : state_(state) {}
  State* state_;
};

/// Answers to the frames of several sensors, the pads of a hand, as `tactel monitor --device` gives them. It keeps
/// their histories, as SlipHistory does. Alarm::answer takes an answer. An object is for one thread at a time.
class TACTEL_API LiveEstimator {
 public:
  /// networks: that of each sensor, one or more. Networks that are copies of one share its work.
  /// device: "gpu", "cpu", an index or a part of a name of devices(): one launch for all sensors whose networks have
  /// one topology and scaling, compiled on return. Empty: host code, with the same bits, which is quicker for a sensor
  /// or two. touch: MPa, as of AlarmOptions, for the rest of a network with needs_rest(). Throws InputError without
  /// networks and for a device that is none, HardwareError without a device.
  explicit LiveEstimator(const std::vector<Network>& networks, const std::string& device = {},
                         std::optional<double> touch = {});
  ~LiveEstimator();
  LiveEstimator(const LiveEstimator&) = delete;
  LiveEstimator& operator=(const LiveEstimator&) = delete;

  std::size_t inputs() const noexcept;   ///< numbers of one frame of every sensor
  std::size_t sensors() const noexcept;  ///< answers to them
  /// Returns the name of the device; empty: host code.
  std::string device() const;
  /// Takes the next frame of every sensor: [inputs()] MPa, sensor by sensor, and writes answers [sensors()]. Allocates
  /// nothing in host code. Throws InputError for other sizes, HardwareError where the device fails.
  void estimate(std::span<const float> frames, std::span<Answer> answers);
  /// As SlipHistory::friction, of every sensor whose network takes it.
  void friction(float mu, float spread);
  /// As SlipHistory::slides, of the newest frame of one sensor. Throws InputError where there are not so many.
  float slides(std::size_t sensor);
  /// Seeks the rest of every sensor anew from the next frame on.
  void rest();
  /// Forgets all frames.
  void clear();

 private:
  struct State;
  State* state_;
};

/// An OpenCL device, as `tactel devices` lists it.
struct DeviceInfo {
  int index = 0;               ///< among devices()
  std::string name, platform;  ///< of the device; of its driver
  std::string type;            ///< "cpu", "gpu" or "other"
  int compute_units = 0;
  std::uint64_t memory = 0;  ///< bytes
  bool fp64 = false;         ///< double precision in kernels
  bool is_default = false;   ///< computes where no device is named
};

/// Returns the OpenCL devices; none is no error. Throws InputError for a wrong TACTEL_LANES.
TACTEL_API std::vector<DeviceInfo> devices();

}  // namespace tactel
