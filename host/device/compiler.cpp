// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "host/device/built_programs.h"
#include "host/device/compile_cache.h"
#include "host/device/device.h"
#include "host/device/kernel_arguments.h"
#include "host/device/launcher.h"
#include "host/support/errors.h"
#include "host/support/host_limits.h"
#include "host/support/interrupt.h"
#include "kernels/shared/group.h"

extern char** environ;

namespace tactel::host {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

constexpr auto longest_turn = 60s;                // far more than a program takes
constexpr auto longest_compilation = 15min;       // a minute on a machine that is busy
constexpr auto glance = 20ms;                     // between two looks at what is waited for
constexpr int idle_milliseconds = 2000;           // after which the compiling process ends
constexpr std::size_t longest_message = 1 << 26;  // bytes
constexpr std::size_t largest_argument = 4096;    // bytes

/// Whether compiled programs of this device are kept between runs. PoCL runs the compiler's front end to find out that
/// it knows a program; Intel's driver for processors keeps nothing. Drivers of GPUs know by themselves, and oclgrind's
/// reports need the source.
bool keeps_binaries(const Device& device) {
  return is_pocl(device.info()) || device.info().platform == "Intel(R) OpenCL";
}

/// All that a binary depends on: what compiles, for which processor, and the program. Two
/// processors that Intel's driver names alike may differ in the width of their vectors.
std::string key_of(const Device& device, const ProgramText& program) {
  const cl::Platform platform(device.cl_device().getInfo<CL_DEVICE_PLATFORM>());
  std::string key = platform.getInfo<CL_PLATFORM_VERSION>();
  for (const std::string& part :
       {device.cl_device().getInfo<CL_DEVICE_VERSION>(),
        std::to_string(device.cl_device().getInfo<CL_DEVICE_NATIVE_VECTOR_WIDTH_FLOAT>()), device.info().name,
        device.info().driver, std::string(name(device.info().type)), program.options, program.text})
    key.append("\n").append(part);
  return key;
}

/// Builds from a binary, without the compiler's front end. Returns none where the device does not take it.
std::optional<cl::Program> load(const Device& device, const ProgramText& program, const std::string& binary) try {
  if (binary.empty()) return std::nullopt;
  const cl::Program::Binaries binaries = {{binary.begin(), binary.end()}};
  cl::Program built(device.context(), {device.cl_device()}, binaries);
  built.build(program.options.c_str());
  std::vector<cl::Kernel> kernels;
  built.createKernels(&kernels);
  return built;
} catch (const cl::Error&) {
  return std::nullopt;
}

/// What the cache keeps of a program of other drivers, once it was compiled in a process of its own.
constexpr const char* survived = "compiled";

/// Gives a kernel arguments of the right size that mean nothing: a launch without groups reads none.
void set_any_arguments(cl::Kernel& kernel, const std::vector<KernelParameter>& parameters) {
  const std::array<char, largest_argument> zeros{};
  for (cl_uint i = 0; i < parameters.size(); ++i) {
    std::size_t size = parameters[i].pointer ? sizeof(cl_mem) : 1;
    const void* const value = parameters[i].pointer ? nullptr : zeros.data();
    while (::clSetKernelArg(kernel(), i, size, value) == CL_INVALID_ARG_SIZE && size < zeros.size()) ++size;
  }
}

/// PoCL compiles a kernel at its first launch. So each is launched, for nothing and at its widest.
void compile_kernels(const Device& device, cl::Program& program, const std::string& text) {
  std::vector<cl::Kernel> kernels;
  program.createKernels(&kernels);
  cl::CommandQueue queue = device.make_queue();
  for (cl::Kernel& kernel : kernels) {
    const std::string name = kernel.getInfo<CL_KERNEL_FUNCTION_NAME>();
    if (!takes_group(text, name)) continue;
    set_any_arguments(kernel, kernel_parameters(text, name, "float"));
    Launcher::enqueue(queue, kernel, std::size_t{NO_GROUPS}, widest_cpu_launch,
                      Launcher::required_size(device, kernel));
  }
  queue.finish();
}

cl::Program compile(const Device& device, const ProgramText& program) {
  const CompileCache* const cache = compile_cache();
  const std::optional<AbortNotice> notice = cache ? std::optional<AbortNotice>(cache->folder()) : std::nullopt;
  const HeldSignals held(HeldSignals::handled);
  cl::Program built(device.context(), program.text);
  try {
    built.build(program.options.c_str());
  } catch (const cl::BuildError& error) {
    std::string log;
    for (const auto& [each, lines] : error.getBuildLog()) log += lines;
    throw KernelBuildError(program.name, program.options, log + (cache ? cache->advice() : ""));
  }
  if (is_pocl(device.info())) compile_kernels(device, built, program.text);
  return built;
}

/// PoCL makes a binary of kernels for any local size, and compiles each once more for it. On a processor our groups
/// have one item (Launcher::local_size): where PoCL has that kernel already, it finds it in the place of the other.
void stand_for_any_size(const fs::path& compiled) {
  std::error_code end, taken;
  for (fs::recursive_directory_iterator at(compiled, end); !end && at != fs::recursive_directory_iterator();
       at.increment(end)) {
    const fs::path of_one = at->path().parent_path(), of_any = of_one.parent_path() / "0-0-0";
    if (at->path().extension() != ".so" || of_one.filename() != "1-1-1-goffs0-smallgrid") continue;
    fs::create_directory(of_any, taken);
    fs::create_hard_link(at->path(), of_any / at->path().filename(), taken);
  }
}

/// Keeps the binary of a program where the device makes all kernels of it again.
void keep(const CompileCache& cache, const std::string& key, const Device& device, const ProgramText& program,
          const cl::Program& built) {
  if (is_pocl(device.info()) && device.info().type == DeviceType::cpu) stand_for_any_size(cache.own());
  const auto binaries = built.getInfo<CL_PROGRAM_BINARIES>();
  if (binaries.size() != 1) return;
  const std::string binary(binaries[0].begin(), binaries[0].end());
  if (load(device, program, binary)) cache.keep_program(key, binary);
}

/// For the process that asked: keeps the binary, or only that the driver compiles it and starts its kernels.
void compile_and_keep(const CompileCache& cache, const Device& device, const ProgramText& program) {
  cl::Program built = compile(device, program);
  const std::string key = key_of(device, program);
  if (keeps_binaries(device)) return keep(cache, key, device, program, built);
  compile_kernels(device, built, program.text);
  cache.keep_program(key, survived);
}

// Messages between the two processes: strings, each behind its length.

bool send_all(int socket, const void* from, std::size_t count) {
  for (const char* at = static_cast<const char*>(from); count > 0;) {
    const ssize_t sent = ::send(socket, at, count, MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) return false;
    at += sent, count -= static_cast<std::size_t>(sent);
  }
  return true;
}

bool receive_all(int socket, void* to, std::size_t count) {
  for (char* at = static_cast<char*>(to); count > 0;) {
    const ssize_t got = ::recv(socket, at, count, 0);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    at += got, count -= static_cast<std::size_t>(got);
  }
  return true;
}

bool send_text(int socket, const std::string& text) {
  const std::uint64_t size = text.size();
  return send_all(socket, &size, sizeof size) && send_all(socket, text.data(), text.size());
}

std::optional<std::string> receive_text(int socket) {
  std::uint64_t size = 0;
  if (!receive_all(socket, &size, sizeof size) || size > longest_message) return std::nullopt;
  std::string text(size, '\0');
  if (!receive_all(socket, text.data(), size)) return std::nullopt;
  return text;
}

/// Answers to a request: an empty one where it was compiled, else one of these and a text.
constexpr char build_failed = 'b', call_failed = 'c';

std::string ending_text(int status) {
  if (WIFEXITED(status)) return fmt::format("its process ended with exit code {}", WEXITSTATUS(status));
  return fmt::format("its process was ended by signal {} ({})", WTERMSIG(status), ::strsignal(WTERMSIG(status)));
}

/// The process that compiles. It ends by itself where nothing is asked for; the next request starts another.
class CompilingProcess {
 public:
  std::vector<std::string> words;  ///< that start it; none: there is no such process

  /// Compiles a program into the cache. `asked_before`: a stop was requested before, and goes on being disregarded.
  void compile(const Device& device, const ProgramText& program, const CompileCache& cache, bool asked_before) {
    for (bool again : {true, false}) {
      if (!asked_before && Interrupt::seen()) throw Stopped("stopped before kernels were compiled");
      if (child_ < 0) start(cache);
      const bool sent = send_text(socket_, std::to_string(device.info().index)) && send_text(socket_, program.name) &&
                        send_text(socket_, program.options) && send_text(socket_, program.text);
      const std::optional<std::string> answer = sent ? await_answer(asked_before) : std::nullopt;
      if (answer) return check(*answer, device, program);
      const int status = end();
      if (late_)
        throw DeviceError("compiling " + program.name, "no end after 15 minutes", device.info().name,
                          "update the driver, or choose another --device");
      if (again && WIFEXITED(status) && WEXITSTATUS(status) == 0) continue;  // it had nothing to do for long
      const std::string advice = cache.advice();
      const char* const other = keeps_binaries(device) ? "close other programs: memory may be short"
                                                       : "the driver's compiler fails: update the driver, or choose "
                                                         "another --device";
      throw DeviceError("compiling " + program.name, ending_text(status), device.info().name,
                        advice.empty() ? other : advice);
    }
  }

 private:
  static void check(const std::string& answer, const Device& device, const ProgramText& program) {
    if (answer.empty()) return;
    if (answer[0] == build_failed) throw KernelBuildError(program.name, program.options, answer.substr(1));
    throw DeviceError("compiling " + program.name, answer.substr(1), device.info().name, address_space_advice());
  }

  /// Empty where the process ended.
  std::optional<std::string> await_answer(bool asked_before) {
    const auto latest = Clock::now() + longest_compilation;
    for (pollfd wait{socket_, POLLIN, 0};;) {
      if (::poll(&wait, 1, static_cast<int>(glance.count())) > 0) return receive_text(socket_);
      late_ = Clock::now() > latest;
      if (!late_ && (asked_before || !Interrupt::seen())) continue;
      ::kill(-child_, SIGKILL);
      if (late_) return std::nullopt;
      end();
      throw Stopped("stopped while kernels were compiled");
    }
  }

  void start(const CompileCache& cache) {
    int ends[2];
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
      throw DeviceError("socketpair", std::strerror(errno), "");
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDIN_FILENO);
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_addclosefrom_np(&actions, STDERR_FILENO + 1);  // files and locks of this process
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    posix_spawnattr_setflags(&attributes,
                             POSIX_SPAWN_SETPGROUP);  // Ctrl-C is for this process, and the linker's end a failure
    std::vector<std::string> all = words;
    all.push_back(cache.folder()), all.push_back(cache.own() / "compiler");
    std::vector<char*> arguments;
    arguments.reserve(all.size() + 1);
    for (std::string& word : all) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    const int error = ::posix_spawn(&child_, arguments[0], &actions, &attributes, arguments.data(), environ);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&actions);
    ::close(ends[1]);
    socket_ = ends[0];
    if (error == 0) return;
    child_ = -1;
    ::close(socket_);
    throw DeviceError("starting " + words[0], std::strerror(error), "",
                      error == EAGAIN ? thread_advice : address_space_advice());
  }

  /// Returns how the process ended.
  int end() {
    ::close(socket_);
    int status = 0;
    while (::waitpid(child_, &status, 0) < 0 && errno == EINTR) {
    }
    child_ = -1;
    return status;
  }

  pid_t child_ = -1;
  int socket_ = -1;
  bool late_ = false;
};

CompilingProcess& compiling_process() {
  static CompilingProcess* const process = new CompilingProcess;  // never destroyed: it ends when this process does
  return *process;
}

/// Whether a process was stopped, as by Ctrl-Z: it may never go on.
bool is_stopped(int process) {
  std::ifstream status(fmt::format("/proc/{}/status", process));
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("State:")) return line.find("T (stopped)") != line.npos;
  return false;
}

/// Waits while another process compiles this program. Returns it where that process is done; nothing where it is this
/// process's turn, or where the other one was stopped or takes too long.
std::optional<cl::Program> await_turn(const Device& device, const ProgramText& program, const CompileCache& cache,
                                      const std::string& key, CompileCache::Turn& turn,
                                      std::unique_lock<std::mutex>& threads, bool asked_before) {
  std::optional<BusyMessage> busy;
  for (const auto end = Clock::now() + longest_turn;;) {
    threads.lock();
    const int other = turn.take();
    if (std::optional<cl::Program> built = load(device, program, cache.program(key))) return built;
    if (other == 0 || is_stopped(other) || Clock::now() > end) return std::nullopt;
    threads.unlock();
    if (!busy) busy.emplace(device, fmt::format("waiting for process {}, which compiles {}", other, program.name));
    if (!asked_before && Interrupt::seen()) throw Stopped("stopped while another process compiled kernels");
    std::this_thread::sleep_for(glance);
  }
}

/// Throws DeviceError where too little address space is left for a compiler in this process, which would not survive
/// it.
void check_space(const Device& device, const ProgramText& program) {
  if (address_space_left() < compiler_space)
    throw DeviceError("compiling " + program.name, "too little address space", device.info().name,
                      address_space_advice());
}

cl::Program compile_for_all(const Device& device, const ProgramText& program, const CompileCache& cache,
                            const std::string& key) {
  static std::mutex one_thread;
  const bool asked_before = Interrupt::seen();
  CompileCache::Turn turn(cache, key);
  std::unique_lock threads(one_thread, std::defer_lock);
  if (std::optional<cl::Program> built = await_turn(device, program, cache, key, turn, threads, asked_before))
    return *built;
  const BusyMessage busy(device, "compiling " + program.name + " for this device (once)");
  if (!compiling_process().words.empty()) {
    compiling_process().compile(device, program, cache, asked_before);
    if (std::optional<cl::Program> built = load(device, program, cache.program(key))) return *built;
  }
  check_space(device, program);
  cl::Program built = compile(device, program);
  keep(cache, key, device, program, built);
  return built;
}

/// A compiler that nobody has tried on this program may end its process, or never end. So another process tries it,
/// once.
void try_first(const Device& device, const ProgramText& program) {
  static std::mutex one_thread;
  const CompileCache* const cache = compile_cache();
  if (!cache || compiling_process().words.empty() || cache->program(key_of(device, program)) == survived) return;
  const std::lock_guard lock(one_thread);
  compiling_process().compile(device, program, *cache, Interrupt::seen());
}

/// Ends this process without what others do at an exit: the compiler may hold locks.
[[noreturn]] void give_up() { ::_exit(1); }

}  // namespace

cl::Program built_program(const Device& device, const ProgramText& program) {
  const CompileCache* const cache = keeps_binaries(device) ? compile_cache() : nullptr;
  if (!cache) {
    const BusyMessage busy(device, "compiling " + program.name + " for this device (once)");
    if (keeps_binaries(device))
      check_space(device, program);
    else
      try_first(device, program);
    return compile(device, program);
  }
  const std::string key = key_of(device, program);
  if (const std::optional<cl::Program> built = load(device, program, cache->program(key))) return *built;
  return compile_for_all(device, program, *cache, key);
}

void set_compiler(std::vector<std::string> words) { compiling_process().words = std::move(words); }

int compile_for_parent(const fs::path& folder, const fs::path& own) {
  std::set_new_handler(give_up);
  compile_in(folder, own);
  std::optional<Device> device;
  for (pollfd wait{STDIN_FILENO, POLLIN, 0}; ::poll(&wait, 1, idle_milliseconds) > 0;) {
    const auto index = receive_text(STDIN_FILENO), name = receive_text(STDIN_FILENO),
               options = receive_text(STDIN_FILENO), text = receive_text(STDIN_FILENO);
    if (!text) break;
    std::string answer;
    try {
      const ProgramText program{*name, *options, *text};
      if (!device || std::to_string(device->info().index) != *index) {
        device.emplace(*index);
        static const int at_exit = std::atexit(give_up);  // before LLVM's own
        (void)at_exit;
      }
      compile_and_keep(*compile_cache(), *device, program);
    } catch (const KernelBuildError& error) {
      answer = build_failed + error.log;
    } catch (const std::exception& error) {
      answer = call_failed + std::string(error.what());
    }
    if (!send_text(STDIN_FILENO, answer)) break;
  }
  compile_cache()->leave();
  ::_exit(0);
}

}  // namespace tactel::host
