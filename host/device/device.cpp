// SPDX-License-Identifier: Apache-2.0
#include "host/device/device.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <latch>
#include <mutex>
#include <optional>
#include <system_error>
#include <thread>
#include <utility>

#include "fem/numbers/cache_directory.h"
#include "host/device/built_programs.h"
#include "host/device/compile_cache.h"
#include "host/device/opencl.h"
#include "host/support/host_limits.h"
#include "host/support/interrupt.h"
#include "kernels/shared/interleaved.h"

namespace tactel::host {
namespace {

constexpr const char* our_pocl_devices = "basic pthread";

struct FoundDevice {
  DeviceInfo info;
  cl::Device device;
};

/// A device as OpenCL gives it.
struct DriverDevice {
  cl::Platform platform;
  cl::Device device;
};

bool contains(std::string_view text, std::string_view part) {
  const auto same = [](unsigned char a, unsigned char b) { return std::tolower(a) == std::tolower(b); };
  return std::search(text.begin(), text.end(), part.begin(), part.end(), same) != text.end();
}

/// What is set up once a process.
struct Process {
  std::mutex first_use;  ///< of the next three: PoCL and OpenCL's loader set themselves up in their first calls
  bool set_up = false;
  std::vector<DriverDevice> devices;    ///< empty: none found yet
  std::atomic<pid_t> user{0};           ///< the process that has found them; 0: none
  std::unique_ptr<CompileCache> cache;  ///< none where the user says where kernels are kept
  std::string trouble;                  ///< with places for the cache
  LogSink log;
  std::atomic<bool> reported{false};
};

Process& process() {
  static Process* const all = new Process;  // never destroyed: devices may outlive static objects
  return *all;
}

void set_up_cache() {
  namespace fs = std::filesystem;
  if (std::getenv("POCL_CACHE_DIR")) return;
  std::error_code error;
  const std::array<fs::path, 2> shared = {fs::temp_directory_path(error), "/dev/shm"};
  const fs::path named = fem::named_cache_directory();
  const CachePlace place = choose_cache(named.empty() ? named : named / "pocl", shared);
  process().trouble = place.trouble;
  if (place.folder.empty()) return;
  try {
    process().cache = std::make_unique<CompileCache>(place.folder);
  } catch (const fs::filesystem_error& failed) {
    process().trouble += place.folder.string() + " (" + failed.code().message() + ")";
    return;
  }
  std::atexit([] { process().cache->leave(); });  // before the driver is loaded: it ends first
}

// By default PoCL offers only its `pthread` device; its `basic` device launches in under a microsecond.
// What the user has set stays.
void set_up_pocl() {
  if (std::exchange(process().set_up, true)) return;
  setenv("POCL_DEVICES", our_pocl_devices, 0);
  if (!shows_processors()) {  // hwloc, with which PoCL looks for them, takes this for the machine
    const std::size_t memory = static_cast<std::size_t>(::sysconf(_SC_PHYS_PAGES)) * ::sysconf(_SC_PAGESIZE);
    const std::string seen =
        "numa:1(memory=" + std::to_string(memory) + ") pu:" + std::to_string(::sysconf(_SC_NPROCESSORS_ONLN));
    setenv("HWLOC_SYNTHETIC", seen.c_str(), 0);
    setenv("HWLOC_THISSYSTEM", "1", 0);
  }
  if (!process().cache) set_up_cache();
}

/// While it lives, PoCL is told where this process keeps what it compiles. PoCL reads that once; the programs that this
/// one starts must not.
class ToldFolder {
 public:
  ToldFolder() {
    if (process().cache) setenv("POCL_CACHE_DIR", process().cache->own().c_str(), 1);
  }
  ~ToldFolder() {
    if (process().cache) unsetenv("POCL_CACHE_DIR");
  }
  ToldFolder(const ToldFolder&) = delete;
  ToldFolder& operator=(const ToldFolder&) = delete;
};

std::string no_cache() {
  return "compiled kernels need a folder, and none can be used: " + process().trouble +
         "; set TACTEL_CACHE_DIR to a folder that can be written";
}

// Reports the state of the cache to the log of the first device that is opened.
void report_cache(const LogSink& log) {
  const Process& all = process();
  if (!log || process().reported.exchange(true)) return;
  if (!all.cache) {
    if (!all.trouble.empty()) log(LogLevel::warning, no_cache());
    return;
  }
  if (!all.trouble.empty())
    log(LogLevel::warning,
        "compiled kernels are kept in " + all.cache->folder().string() + ", because of " + all.trouble);
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

/// Whether this processor takes each AVX-512 operation in two halves of 256 bits: AMD's family 19h has it as Zen 4.
bool in_halves() {
#ifdef __x86_64__
  return __builtin_cpu_is("amdfam19h") && __builtin_cpu_supports("avx512f");
#else
  return false;
#endif
}

/// What $TACTEL_LANES asks for, in both precisions: the layout of another device, for tests. None where it is not set.
std::optional<int> asked_lanes() {
  const char* text = std::getenv("TACTEL_LANES");
  if (!text || !*text) return std::nullopt;
  for (const int lanes : {1, 2, 4, 8, 16})
    if (std::to_string(lanes) == text) return lanes;
  throw ConfigError("", "TACTEL_LANES", text, "1, 2, 4, 8 or 16");
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
  if (const std::optional<int> lanes = asked_lanes()) {
    info.lanes_fp32 = *lanes;
    if (info.fp64) info.lanes_fp64 = *lanes;
  }
  info.halves = info.type == DeviceType::cpu && in_halves();
  const bool pocl_cpu = is_pocl(info) && info.type == DeviceType::cpu;
  info.zero_copy = pocl_cpu;
  info.low_latency = pocl_cpu && (info.name.starts_with("basic") || info.name.starts_with("cpu-minimal"));
  return info;
}

/// A driver or its compiler that cannot open or write a file does not say so, and PoCL aborts.
void expect_files() {
  constexpr rlim_t largest = 1 << 20;  // bytes; five times a kernel
  rlimit limit{};
  if (::getrlimit(RLIMIT_FSIZE, &limit) == 0 && limit.rlim_cur < largest)
    throw DeviceError("write", std::strerror(EFBIG), "",
                      "OpenCL and its compiler write files of up to 1 MB: allow larger ones (ulimit -f unlimited)");
  std::array<int, 40> files{};
  for (int& file : files) file = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
  const int error = files.back() < 0 ? errno : 0;
  for (const int file : files)
    if (file >= 0) ::close(file);
  if (error == EMFILE || error == ENFILE)
    throw DeviceError("open", std::strerror(error), "",
                      "OpenCL and its compiler open up to " + std::to_string(files.size()) +
                          ": allow more (ulimit -n 1024), or close some");
}

/// PoCL starts a thread a core, and aborts where there is none.
void expect_threads() {
  std::latch all(1);
  std::vector<std::jthread> threads;
  try {
    for (long k = ::sysconf(_SC_NPROCESSORS_ONLN); k > 0; --k) threads.emplace_back([&] { all.wait(); });
    all.count_down();
  } catch (const std::system_error& error) {
    all.count_down();
    throw DeviceError("pthread_create", error.code().message(), "", thread_advice);
  }
}

std::vector<DriverDevice> ask_drivers() {
  const HeldSignals held(HeldSignals::always);  // PoCL's threads are made here, and compile later: they keep it
  const ToldFolder told;
  std::vector<cl::Platform> platforms;
  try {
    cl::Platform::get(&platforms);
  } catch (const cl::Error&) {
    return {};  // the loader reports "no platform" as an error
  }
  std::vector<DriverDevice> found;
  for (const cl::Platform& platform : platforms) {
    std::vector<cl::Device> devices;
    try {
      platform.getDevices(CL_DEVICE_TYPE_ALL, &devices);
    } catch (const cl::Error&) {
      continue;  // a platform without devices reports that as an error, too
    }
    for (const cl::Device& device : devices) found.push_back({platform, device});
  }
  return found;
}

/// OpenCL's first use in a process, and the environment of that alone, are one thread's at a time.
std::vector<FoundDevice> find_devices() {
  Process& all = process();
  if (const pid_t user = all.user; user != 0 && user != ::getpid())
    throw DeviceError("fork", "the threads of OpenCL stay in the process that was forked", "",
                      "start processes anew (spawn), or before the first use of a device");
  const std::lock_guard lock(all.first_use);
  expect_files();
  set_up_pocl();
  if (address_space_left() < opencl_space + std::thread::hardware_concurrency() * stack_size()) return {};
  if (all.devices.empty()) {
    expect_threads();
    all.devices = ask_drivers();
    if (!all.devices.empty()) all.user = ::getpid();
  }
  std::vector<FoundDevice> found;
  for (const auto& [platform, device] : all.devices)
    found.push_back({describe(platform, device, static_cast<int>(found.size())), device});
  return found;
}

// Default device: the devices on which answers are tested come first.
int rank(const DeviceInfo& info) {
  if (info.low_latency) return 0;
  if (info.type == DeviceType::cpu) return 1;
  return info.type == DeviceType::gpu ? 2 : 3;
}

// The best device that `is_meant` accepts, -1 without one.
template <class IsMeant>
int best_match(std::span<const DeviceInfo> devices, const IsMeant& is_meant) {
  const DeviceInfo* best = nullptr;
  for (const DeviceInfo& info : devices)
    if (is_meant(info) && (!best || rank(info) < rank(*best))) best = &info;
  return best ? best->index : -1;
}

// By type ("gpu", "cpu"), else by a part of the name or the platform's. An empty part is in every name.
int best_match(std::span<const DeviceInfo> devices, std::string_view part) {
  const int of_type = best_match(devices, [&](const DeviceInfo& info) { return name(info.type) == part; });
  if (of_type >= 0) return of_type;
  return best_match(devices,
                    [&](const DeviceInfo& info) { return contains(info.name, part) || contains(info.platform, part); });
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
  infos.reserve(found.size());
  for (const FoundDevice& each : found) infos.push_back(each.info);
  return infos;
}

FoundDevice choose(std::string_view choice) {
  const std::vector<FoundDevice> found = find_devices();
  if (found.empty()) throw DeviceError("clGetPlatformIDs", "no OpenCL device", "", no_device_advice());
  const int index = chosen_index(infos_of(found), choice);
  if (index >= 0) return found[index];
  std::string names;
  for (const FoundDevice& each : found) names += "\n  " + std::to_string(each.info.index) + "  " + each.info.name;
  const std::string hidden = hidden_gpu_advice(infos_of(found));
  throw ConfigError(
      "", "device", std::string(choice),
      "gpu, cpu, an index or a part of the name of one of" + names + (hidden.empty() ? "" : "\n" + hidden));
}

}  // namespace

std::string no_device_advice() {
  if (!process().cache) {
    const char* cache = std::getenv("POCL_CACHE_DIR");
    if (cache && access(cache, W_OK) != 0)
      return "POCL_CACHE_DIR = " + std::string(cache) + " must be a folder that can be written";
    if (!process().trouble.empty()) return no_cache();
  }
  if (std::string advice = address_space_advice(); !advice.empty()) return advice;
  for (const char* name : {"OCL_ICD_VENDORS", "OCL_ICD_FILENAMES", "POCL_DEVICES", "POCL_BUILDING"})
    if (const char* value = std::getenv(name); value && value != std::string_view(our_pocl_devices))
      return name + (" = " + std::string(value)) +
             " is set and may hide the devices: unset it, or name one that is there";
  return "install one, for the processor: apt install pocl-opencl-icd, or for the Python package pip install "
         "intel-opencl-rt intel-cmplr-lib-rt; `clinfo -l` lists the devices";
}

std::string hidden_gpu_advice(std::span<const DeviceInfo> devices, const std::string& root) {
  namespace fs = std::filesystem;
  if (std::ranges::any_of(devices, [](const DeviceInfo& info) { return info.type == DeviceType::gpu; })) return "";
  struct Maker {
    const char *file, *of, *icd, *library;
  };
  constexpr Maker makers[] = {{"dev/nvidia0", "NVIDIA", "nvidia.icd", "libnvidia-opencl.so.1"},
                              {"dev/kfd", "AMD", "amdocl64.icd", "libamdocl64.so"},
                              {"dev/dri/renderD128", "its maker", "intel.icd, for Intel", "libigdrcl.so"}};
  std::error_code error;
  for (const Maker& maker : makers)
    if (fs::exists(fs::path(root) / maker.file, error))
      return std::string("there is a GPU (/") + maker.file + "), and no OpenCL platform for it: install the driver's " +
             "OpenCL part of " + maker.of + "; in a container the file /etc/OpenCL/vendors/" + maker.icd +
             " may be missing, with the line " + maker.library;
  return "";
}

void set_default_log(LogSink log) { process().log = std::move(log); }

bool is_pocl(const DeviceInfo& device) { return device.platform == "Portable Computing Language"; }

const char* name(DeviceType type) {
  if (type == DeviceType::cpu) return "cpu";
  return type == DeviceType::gpu ? "gpu" : "other";
}

std::vector<DeviceInfo> list_devices() {
  return translated("", [] { return infos_of(find_devices()); });
}

std::uint64_t memory_of(const DeviceInfo& device) {
  return translated(device.name, [&] {
    return find_devices().at(static_cast<std::size_t>(device.index)).device.getInfo<CL_DEVICE_GLOBAL_MEM_SIZE>();
  });
}

int default_device(std::span<const DeviceInfo> devices) { return chosen_index(devices, default_choice()); }

struct Device::State {
  DeviceInfo info;
  cl::Device device;
  cl::Context context;
  LogSink log;
  std::shared_ptr<BuiltPrograms> programs = std::make_shared<BuiltPrograms>();
  bool short_code = false, poisons = false;
};

Device::Device(std::string_view choice, LogSink log) {
  const FoundDevice found = translated("", [&] { return choose(choice.empty() ? default_choice() : choice); });
  if (!log) log = process().log;
  report_cache(log);
  const HeldSignals held(HeldSignals::always);
  const cl::Context context = translated(found.info.name, [&] { return cl::Context(found.device); });
  state_ = std::make_shared<State>(State{found.info, found.device, context, std::move(log)});
}

const DeviceInfo& Device::info() const { return state_->info; }

int Device::lanes(Precision precision) const {
  if (precision == Precision::fp32) return info().lanes_fp32;
  if (info().fp64) return info().lanes_fp64;
  throw DeviceError("fp64", "not supported", info().name, "choose --precision fp32 or another --device");
}

int Device::interleaved(Precision precision) const { return lanes(precision) == 1 ? INTERLEAVED_SCALARS : 1; }

const cl::Device& Device::cl_device() const { return state_->device; }
const cl::Context& Device::context() const { return state_->context; }
BuiltPrograms& Device::built_programs() const { return *state_->programs; }

cl::CommandQueue Device::make_queue() const {
  return translated(info().name, [&] { return cl::CommandQueue(state_->context, state_->device); });
}

void Device::log(LogLevel level, std::string_view message) const {
  if (state_->log) state_->log(level, message);
}

template <class Change>
Device Device::changed(const Change& change) const {
  State state = *state_;
  change(state);
  Device other = *this;
  other.state_ = std::make_shared<State>(std::move(state));
  return other;
}

Device Device::with_lanes(int lanes) const {
  return changed([&](State& state) {
    state.info.lanes_fp32 = lanes;
    if (state.info.fp64) state.info.lanes_fp64 = lanes;
  });
}

Device Device::with_halves(bool halves) const {
  return changed([&](State& state) { state.info.halves = halves; });
}

Device Device::with_copies() const {
  return changed([](State& state) { state.info.zero_copy = false; });
}

Device Device::as_gpu() const {
  return with_lanes(1).changed([](State& state) {
    state.info.compute_units = 132;
    state.info.type = DeviceType::gpu;
    state.info.zero_copy = state.info.low_latency = false;
    state.poisons = true;
  });
}
bool Device::poisons() const { return state_->poisons; }

Device Device::for_one_contact() const {
  if (info().type != DeviceType::cpu) return *this;
  return with_lanes(1).changed([](State& state) { state.short_code = true; });
}

Device Device::for_training() const {
  if (info().type == DeviceType::cpu) return *this;
  const int processor =
      best_match(list_devices(), [](const DeviceInfo& other) { return other.type == DeviceType::cpu; });
  if (processor >= 0) return Device(std::to_string(processor), state_->log);
  log(LogLevel::warning, info().name +
                             " trains each network on one work-item, as this machine has no OpenCL device of " +
                             "its processor: install one (apt install pocl-opencl-icd)");
  return *this;
}

bool Device::short_code() const { return state_->short_code; }

const CompileCache* compile_cache() { return process().cache.get(); }

void compile_in(const std::filesystem::path& folder, const std::filesystem::path& own) {
  process().cache = std::make_unique<CompileCache>(folder, own);
}

}  // namespace tactel::host
