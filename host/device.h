#pragma once
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "host/log.h"
#include "host/opencl.h"

namespace tactel::host {

enum class Precision { fp32, fp64 };
enum class DeviceType { cpu, gpu, other };

/// "fp32", "fp64".
const char* name(Precision precision);
/// "cpu", "gpu", "other".
const char* name(DeviceType type);
/// The OpenCL C type, for -DREAL=: "float", "double".
const char* real_type(Precision precision);

struct DeviceInfo {
  int index = 0;         ///< place in list_devices()
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
};

/// Every OpenCL device, in the order that --device counts. Empty when there is none. Before the first OpenCL call of
/// the process sets, unless the user has, POCL_DEVICES to "basic pthread" and POCL_CACHE_DIR to "pocl" in
/// fem::default_cache_directory(): there PoCL keeps compiled kernels. (It does not check them: delete a damaged cache.)
std::vector<DeviceInfo> list_devices();
/// Index of the device that is taken when nobody chooses: $TACTEL_DEVICE, else the best: PoCL's `basic` first (what
/// answers are tested on), then another CPU, then a GPU. -1 when there is none.
int default_device(std::span<const DeviceInfo> devices);
/// What a user without a device can do.
extern const char* const no_device_advice;

/// A device with its context: what programs, buffers and executors are made on. Cheap to copy; copies share the
/// context.
class Device {
 public:
  /// `choice`: an index of list_devices(), or (part of) a name, any case. Empty: $TACTEL_DEVICE, else the best: PoCL's
  /// `basic` first, then another CPU, then a GPU. Throws ConfigError for a choice that names no device or several
  /// different ones (it lists what there is), DeviceError when there is no device at all.
  explicit Device(std::string_view choice = {}, LogSink log = {});

  const DeviceInfo& info() const;
  /// Lanes of explicit vectors in this precision. Throws DeviceError when the device lacks fp64.
  int lanes(Precision precision) const;
  const cl::Device& cl_device() const;
  const cl::Context& context() const;
  /// A queue of its own, in order.
  cl::CommandQueue make_queue() const;
  void log(LogLevel level, std::string_view message) const;

 private:
  struct State;
  std::shared_ptr<const State> state_;
};

}  // namespace tactel::host
