// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "host/support/log.h"
#include "host/support/precision.h"

namespace cl {
class Buffer;
class CommandQueue;
class Context;
class Device;
class Kernel;
}  // namespace cl

namespace tactel::host {

struct BuiltPrograms;

enum class DeviceType { cpu, gpu, other };

/// Returns "cpu", "gpu" or "other".
const char* name(DeviceType type);

struct DeviceInfo {
  int index = 0;         ///< index in list_devices()
  std::string name;      ///< CL_DEVICE_NAME
  std::string platform;  ///< CL_PLATFORM_NAME
  std::string driver;    ///< CL_DRIVER_VERSION
  DeviceType type = DeviceType::other;
  int compute_units = 0;
  bool fp64 = false;   ///< double precision in kernels
  int lanes_fp32 = 1;  ///< scenes (frames, networks) that one work-item carries in an explicit vector; 1 on a GPU
  int lanes_fp64 = 1;  ///< the same for double; 0 without fp64
  bool low_latency =
      false;               ///< runs kernels in the calling thread (PoCL's `basic`): a launch costs under a microsecond
  bool zero_copy = false;  ///< kernels work on host memory in place
  bool halves = false;     ///< works at its widest vectors in two halves: AVX-512 on Zen 4
};

/// Whether the device is PoCL's.
bool is_pocl(const DeviceInfo& device);

/// Default log of devices without a log of their own; none at first. Set it before other threads exist.
void set_default_log(LogSink log);

/// Returns every OpenCL device, in the order of --device; empty where there is none. $TACTEL_LANES (1, 2, 4, 8 or 16)
/// replaces the lanes of each; throws ConfigError for another number. Before the first OpenCL call
/// of the process it sets POCL_DEVICES to "basic pthread", and POCL_CACHE_DIR to "pocl" in
/// fem::named_cache_directory(), unless the user has set them. PoCL keeps compiled kernels there; they are
/// checked first (compile_cache.h). The content of a user's own POCL_CACHE_DIR is not checked.
std::vector<DeviceInfo> list_devices();
/// Returns the bytes of a device's memory.
std::uint64_t memory_of(const DeviceInfo& device);
/// Returns the index of the default device: $TACTEL_DEVICE, else PoCL's `basic` (on which answers are tested),
/// another CPU, a GPU. Returns -1 where there is none.
int default_device(std::span<const DeviceInfo> devices);
/// Returns the remedy for a missing device; it concerns the folder of compiled kernels where that is the cause.
std::string no_device_advice();
/// Returns why OpenCL does not show a GPU that this machine has: its device files (of `root`) are there, and no
/// platform has a GPU. Empty where all is well, or there is none.
std::string hidden_gpu_advice(std::span<const DeviceInfo> devices, const std::string& root = "/");

/// A device with its context, for programs, buffers and executors. Cheap to copy; copies share the context.
class Device {
 public:
  /// `choice`: an index of list_devices(), "gpu" or "cpu", or (part of) a name, any case. Empty: $TACTEL_DEVICE, else
  /// the best: PoCL's `basic` first, then another CPU, then a GPU. Throws ConfigError, with a list of the devices, for
  /// a choice that names none or several different ones. Throws DeviceError where there is no device. `log` defaults to
  /// the default log.
  explicit Device(std::string_view choice = {}, LogSink log = {});

  const DeviceInfo& info() const;
  /// Returns the lanes of explicit vectors in this precision. Throws DeviceError where the device lacks fp64.
  int lanes(Precision precision) const;
  /// Returns how many work-items have their numbers side by side in arrays of contacts: 1 where each has a vector
  /// (kernels/shared/group.h).
  int interleaved(Precision precision) const;
  const cl::Device& cl_device() const;
  const cl::Context& context() const;
  /// Returns the programs that were built for the context, for Program.
  BuiltPrograms& built_programs() const;
  /// Returns a new queue, in order.
  cl::CommandQueue make_queue() const;
  void log(LogLevel level, std::string_view message) const;
  /// Returns the same device with this number of lanes in both precisions, 1, 2, 4, 8 or 16: for tests. Shares
  /// the context.
  Device with_lanes(int lanes) const;
  /// Returns the same device as one that works at its widest vectors in two halves, or not: for tests. Shares the
  /// context.
  Device with_halves(bool halves) const;
  /// Returns the same device with buffers in memory of its own, as a GPU has: for tests. Shares the context.
  Device with_copies() const;
  /// Returns the same device as a GPU is: of this type, with the 132 compute units of an H100, one lane, work-groups of
  /// 64, launches as a whole, and buffers in memory of its own, which hold NaN at first: for tests. Shares the context.
  Device as_gpu() const;
  bool poisons() const;  ///< whether new buffers hold NaN
  /// Returns the same device for single contacts: kernels give the same bits, and a processor compiles them in half the
  /// time, with one lane and rolled loops. Shares the context.
  Device for_one_contact() const;
  /// Returns the device that trains any networks for this one: of a GPU, where one network may be one work-item, the
  /// best processor. The same device where there is none, with a warning.
  Device for_training() const;
  bool short_code() const;  ///< whether kernels keep their loops rolled (kernels/shared/unroll.h)

 private:
  struct State;
  template <class Change>
  Device changed(const Change& change) const;  ///< change(State&)
  std::shared_ptr<const State> state_;
};

/// Sends `what` to a device's log as LogLevel::busy, and ends that announcement at destruction.
class BusyMessage {
 public:
  BusyMessage(const Device& device, std::string_view what) : device_(device) { device_.log(LogLevel::busy, what); }
  ~BusyMessage() { device_.log(LogLevel::busy, ""); }
  BusyMessage(const BusyMessage&) = delete;
  BusyMessage& operator=(const BusyMessage&) = delete;

 private:
  const Device device_;
};

/// Words that start a process of this program that calls compile_for_parent() with the two words behind them: kernels
/// are then compiled in that process. It may die there, for want of memory: an error says so, and this process never
/// calls a compiler. A library has no program of its own and compiles in its process. Call it before the first device.
void set_compiler(std::vector<std::string> words);

/// Compiles kernels for the process that started this one, until that ends or asks for nothing for some seconds. The
/// folders: CompileCache's. Returns the exit code.
int compile_for_parent(const std::filesystem::path& folder, const std::filesystem::path& own);

}  // namespace tactel::host
