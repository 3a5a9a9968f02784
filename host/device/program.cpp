// SPDX-License-Identifier: Apache-2.0
#include "host/device/program.h"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <future>
#include <set>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <utility>

#include "host/device/built_programs.h"
#include "host/device/compile_cache.h"
#include "host/device/opencl.h"
#include "host/support/errors.h"
#include "host/support/stop_scope.h"
#include "kernels/embedded.h"

namespace tactel::host {
namespace {

const kernels::Source& embedded(std::string_view name) {
  for (const kernels::Source& source : kernels::sources())
    if (source.name == name) return source;
  throw std::out_of_range("no embedded kernel source named " + std::string(name));
}

// The name between the quotes of an #include line, or nothing.
std::string_view included_name(std::string_view line) {
  const std::size_t hash = line.find_first_not_of(" \t");
  if (hash == line.npos || line[hash] != '#') return {};
  const std::size_t word = line.find_first_not_of(" \t", hash + 1);
  if (word == line.npos || !line.substr(word).starts_with("include")) return {};
  const std::size_t open = line.find('"', word);
  const std::size_t close = line.find('"', open == line.npos ? open : open + 1);
  return close == line.npos ? std::string_view{} : line.substr(open + 1, close - open - 1);
}

std::string line_directive(int line, std::string_view name) {
  return "#line " + std::to_string(line) + " \"" + std::string(name) + "\"\n";
}

void expand(std::string_view name, std::string_view text, std::set<std::string, std::less<>>& done, std::string& out) {
  out += line_directive(1, name);
  for (int number = 1; !text.empty(); ++number) {
    const std::size_t end = std::min(text.find('\n'), text.size() - 1);
    const std::string_view line = text.substr(0, end + 1);
    text.remove_prefix(end + 1);
    const std::string_view wanted = included_name(line);
    if (wanted.empty()) {
      out += line;
      continue;
    }
    if (done.emplace(wanted).second) expand(wanted, embedded(wanted).text, done, out);
    out += line_directive(number + 1, name);
  }
  if (!out.ends_with('\n')) out += '\n';
}

// Whether single precision's quotients and roots are rounded correctly only where the program asks for it. On PoCL's
// processors they always are.
bool rounds_on_demand(const Device& device) {
  const bool processor = (device.cl_device().getInfo<CL_DEVICE_TYPE>() & CL_DEVICE_TYPE_CPU) != 0;
  return !(is_pocl(device.info()) && processor) &&
         (device.cl_device().getInfo<CL_DEVICE_SINGLE_FP_CONFIG>() & CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT) != 0;
}

// Denormal numbers, to which the tails of frames and of momentum decay, would cost a processor ten times the time of
// others; no result is in need of them.
std::string option_text(const Device& device, const Defines& defines) {
  std::string text = "-cl-std=CL1.2 -cl-denorms-are-zero";
  if (rounds_on_demand(device)) text += " -cl-fp32-correctly-rounded-divide-sqrt";
  if (device.short_code()) text += " -DSHORT_CODE=1";
  for (const auto& [key, value] : defines) text.append(" -D").append(key).append("=").append(value);
  return text;
}

std::atomic<int> under_way = 0;  ///< builds in threads of their own

/// Lets a build that a stop has left come to its end, and ends the process without what the driver and its compiler do
/// at an exit: they do not bear a build beside it.
void end_after_what_is_left(int status, void*) {
  while (const int left = under_way) under_way.wait(left);
  if (const CompileCache* const cache = compile_cache()) cache->leave();
  std::fflush(nullptr);
  ::_exit(status);
}

/// Returns build(). Where this thread may be asked to stop, another one builds, and a stop leaves it to its work: the
/// cache keeps the program for the next who asks.
cl::Program stoppable(const std::function<cl::Program()>& build) {
  using namespace std::chrono_literals;
  if (!StopScope::current()) return build();
  std::packaged_task<cl::Program()> task(build);
  std::future<cl::Program> built = task.get_future();
  ++under_way;
  try {
    std::thread([task = std::move(task)]() mutable {
      std::exchange(task, {})();  // its objects of the driver end here, too
      --under_way;
      under_way.notify_all();
    }).detach();
  } catch (const std::system_error&) {
    --under_way;
    return build();
  }
  while (built.wait_for(20ms) != std::future_status::ready)
    if (StopScope::asked()) {
      static const int at_exit = ::on_exit(end_after_what_is_left, nullptr);  // before what the driver has for it
      (void)at_exit;
      throw Stopped("stopped while kernels were compiled");
    }
  return built.get();
}

}  // namespace

std::string expand_includes(const std::string& name, const std::string& text) {
  std::set<std::string, std::less<>> done;
  std::string out;
  expand(name, text, done, out);
  return out;
}

struct Program::State {
  Device device;
  std::string source, options;
  std::string text;  ///< as written, without what it includes
  cl::Program built{};

  /// Takes the program that an earlier Program of the same context has built, or builds it.
  void find_or_build() {
    BuiltPrograms& programs = device.built_programs();
    const std::lock_guard lock(programs.mutex);
    cl::Program& known = programs.all[options + "\n" + source + "\n" + text];
    if (!known()) {
      const ProgramText all{source, options, expand_includes(source, text)};
      known = stoppable([on = device, all] { return built_program(on, all); });
      device.log(LogLevel::debug, source + " built, " + options);
    }
    built = known;
  }
};

Program::Program(const Device& device, const std::string& source, const Defines& defines)
    : Program(from_text(device, source, std::string(embedded(source).text), defines)) {}

Program Program::from_text(const Device& device, const std::string& name, const std::string& text,
                           const Defines& defines) {
  const auto state = std::make_shared<State>(State{device, name, option_text(device, defines), text});
  translated(device.info().name, [&] { state->find_or_build(); });
  return Program(state);
}

cl::Kernel Program::kernel(const std::string& name) const {
  return translated(device().info().name, [&] { return cl::Kernel(state_->built, name.c_str()); });
}

const Device& Program::device() const { return state_->device; }
const std::string& Program::source() const { return state_->source; }
const std::string& Program::options() const { return state_->options; }
std::vector<KernelParameter> Program::parameters(const std::string& kernel) const {
  const bool twice = options().find("-DREAL=double") != std::string::npos;
  return kernel_parameters(state_->text, kernel, twice ? "double" : "float");
}
bool Program::takes_group(const std::string& kernel) const { return host::takes_group(state_->text, kernel); }

}  // namespace tactel::host
