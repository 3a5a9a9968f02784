#include "host/device.h"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstdlib>
#include <filesystem>
#include <mutex>

#include "fem/condensation.h"

namespace tactel::host {
namespace {

struct FoundDevice {
  DeviceInfo info;
  cl::Device device;
};

bool contains(std::string_view text, std::string_view part) {
  const auto same = [](unsigned char a, unsigned char b) { return std::tolower(a) == std::tolower(b); };
  return std::search(text.begin(), text.end(), part.begin(), part.end(), same) != text.end();
}

// Where PoCL keeps what it compiled, and loads it from: beside our other caches, or else in a temporary directory that
// nobody but this user can write. Empty: neither.
std::filesystem::path pocl_cache_directory() {
  namespace fs = std::filesystem;
  std::error_code error;
  const fs::path own = fem::default_cache_directory() / "pocl";
  fs::create_directories(own, error);
  if (!error && access(own.c_str(), W_OK) == 0) return own;
  const fs::path temporary = fs::temp_directory_path(error) / ("tactel-" + std::to_string(getuid()));
  mkdir(temporary.c_str(), S_IRWXU);
  struct stat status {};
  const bool ours = lstat(temporary.c_str(), &status) == 0 && S_ISDIR(status.st_mode) && status.st_uid == getuid();
  return ours && (status.st_mode & (S_IRWXG | S_IRWXO)) == 0 ? temporary : fs::path();
}

// PoCL offers only its `pthread` device unless told otherwise; `basic` is the one that launches in under a microsecond.
// What the user has set stays.
void set_up_pocl() {
  static std::once_flag once;
  std::call_once(once, [] {
    setenv("POCL_DEVICES", "basic pthread", 0);
    if (std::getenv("POCL_CACHE_DIR")) return;
    const std::filesystem::path cache = pocl_cache_directory();  // PoCL offers no device where it cannot write
    if (!cache.empty()) setenv("POCL_CACHE_DIR", cache.c_str(), 0);
  });
}

DeviceType type_of(cl_device_type type) {
  if (type & CL_DEVICE_TYPE_CPU) return DeviceType::cpu;
  return type & CL_DEVICE_TYPE_GPU ? DeviceType::gpu : DeviceType::other;
}

// The device's own vector width, as a width that OpenCL C has. GPUs run a lane in each work-item.
int explicit_lanes(DeviceType type, cl_uint native_width) {
  if (type != DeviceType::cpu) return 1;
  int lanes = 1;
  while (2 * lanes <= static_cast<int>(std::min<cl_uint>(native_width, 16))) lanes *= 2;
  return lanes;
}

DeviceInfo describe(const cl::Platform& platform, const cl::Device& device, int index) {
  DeviceInfo info;
  info.index = index;
  info.name = device.getInfo<CL_DEVICE_NAME>();
  info.platform = platform.getInfo<CL_PLATFORM_NAME>();
  info.driver = device.getInfo<CL_DRIVER_VERSION>();
  info.type = type_of(device.getInfo<CL_DEVICE_TYPE>());
  info.compute_units = static_cast<int>(device.getInfo<CL_DEVICE_MAX_COMPUTE_UNITS>());
  info.fp64 = device.getInfo<CL_DEVICE_DOUBLE_FP_CONFIG>() != 0;
  info.lanes_fp32 = explicit_lanes(info.type, device.getInfo<CL_DEVICE_NATIVE_VECTOR_WIDTH_FLOAT>());
  info.lanes_fp64 = info.fp64 ? explicit_lanes(info.type, device.getInfo<CL_DEVICE_NATIVE_VECTOR_WIDTH_DOUBLE>()) : 0;
  const bool pocl_cpu = contains(info.platform, "Portable Computing Language") && info.type == DeviceType::cpu;
  info.zero_copy = pocl_cpu;
  info.low_latency = pocl_cpu && (info.name.starts_with("basic") || info.name.starts_with("cpu-minimal"));
  return info;
}

std::vector<FoundDevice> find_devices() {
  set_up_pocl();
  std::vector<cl::Platform> platforms;
  try {
    cl::Platform::get(&platforms);
  } catch (const cl::Error&) {
    return {};  // the loader reports "no platform" as an error
  }
  std::vector<FoundDevice> found;
  for (const cl::Platform& platform : platforms) {
    std::vector<cl::Device> devices;
    try {
      platform.getDevices(CL_DEVICE_TYPE_ALL, &devices);
    } catch (const cl::Error&) {
      continue;  // a platform without devices reports that as an error, too
    }
    for (const cl::Device& device : devices)
      found.push_back({describe(platform, device, static_cast<int>(found.size())), device});
  }
  return found;
}

// What is taken without being asked for: the devices that the answers were tested on come first.
int rank(const DeviceInfo& info) {
  if (info.low_latency) return 0;
  if (info.type == DeviceType::cpu) return 1;
  return info.type == DeviceType::gpu ? 2 : 3;
}

// The best device with `part` in its name or its platform's, -1 without one. An empty part is in every name.
int best_match(std::span<const DeviceInfo> devices, std::string_view part) {
  const DeviceInfo* best = nullptr;
  for (const DeviceInfo& info : devices) {
    if (!contains(info.name, part) && !contains(info.platform, part)) continue;
    if (!best || rank(info) < rank(*best)) best = &info;
  }
  return best ? best->index : -1;
}

// Index of the device that `choice` means, -1 without one.
int chosen_index(std::span<const DeviceInfo> devices, std::string_view choice) {
  std::size_t index = 0;
  const char* end = choice.data() + choice.size();
  const auto [stop, error] = std::from_chars(choice.data(), end, index);
  if (choice.empty() || error != std::errc{} || stop != end) return best_match(devices, choice);
  return index < devices.size() ? static_cast<int>(index) : -1;
}

std::string_view default_choice() {
  const char* choice = std::getenv("TACTEL_DEVICE");
  return choice ? choice : "";
}

std::vector<DeviceInfo> infos_of(const std::vector<FoundDevice>& found) {
  std::vector<DeviceInfo> infos;
  for (const FoundDevice& each : found) infos.push_back(each.info);
  return infos;
}

FoundDevice choose(std::string_view choice) {
  const std::vector<FoundDevice> found = find_devices();
  if (found.empty()) throw DeviceError("clGetPlatformIDs", "no OpenCL device", "", no_device_advice);
  const int index = chosen_index(infos_of(found), choice);
  if (index >= 0) return found[index];
  std::string names;
  for (const FoundDevice& each : found) names += "\n  " + std::to_string(each.info.index) + "  " + each.info.name;
  throw ConfigError("", "device", std::string(choice), "an index or a part of the name of one of" + names);
}

}  // namespace

const char* const no_device_advice =
    "install one, for the processor: apt install pocl-opencl-icd; `clinfo -l` lists what OpenCL finds";

const char* name(Precision precision) { return precision == Precision::fp32 ? "fp32" : "fp64"; }

const char* name(DeviceType type) {
  if (type == DeviceType::cpu) return "cpu";
  return type == DeviceType::gpu ? "gpu" : "other";
}

const char* real_type(Precision precision) { return precision == Precision::fp32 ? "float" : "double"; }

std::vector<DeviceInfo> list_devices() {
  return translated("", [] { return infos_of(find_devices()); });
}

int default_device(std::span<const DeviceInfo> devices) { return chosen_index(devices, default_choice()); }

struct Device::State {
  DeviceInfo info;
  cl::Device device;
  cl::Context context;
  LogSink log;
};

Device::Device(std::string_view choice, LogSink log) {
  const FoundDevice found = translated("", [&] { return choose(choice.empty() ? default_choice() : choice); });
  const cl::Context context = translated(found.info.name, [&] { return cl::Context(found.device); });
  state_ = std::make_shared<State>(State{found.info, found.device, context, std::move(log)});
}

const DeviceInfo& Device::info() const { return state_->info; }

int Device::lanes(Precision precision) const {
  if (precision == Precision::fp32) return info().lanes_fp32;
  if (info().fp64) return info().lanes_fp64;
  throw DeviceError("fp64", "not supported", info().name, "choose --precision fp32 or another --device");
}

const cl::Device& Device::cl_device() const { return state_->device; }
const cl::Context& Device::context() const { return state_->context; }

cl::CommandQueue Device::make_queue() const {
  return translated(info().name, [&] { return cl::CommandQueue(state_->context, state_->device); });
}

void Device::log(LogLevel level, std::string_view message) const {
  if (state_->log) state_->log(level, message);
}

}  // namespace tactel::host
