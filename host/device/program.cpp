// SPDX-License-Identifier: Apache-2.0
#include "host/device/program.h"

#include <algorithm>
#include <optional>
#include <set>
#include <stdexcept>

#include "host/device/built_programs.h"
#include "host/support/interrupt.h"
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

// Denormal numbers, to which the tails of frames and of momentum decay, would cost a processor ten times the time of
// others; no result is in need of them.
std::string option_text(const Device& device, const Defines& defines) {
  std::string text = "-cl-std=CL1.2 -cl-denorms-are-zero";
  if (device.short_code()) text += " -DSHORT_CODE=1";
  for (const auto& [key, value] : defines) text.append(" -D").append(key).append("=").append(value);
  return text;
}

/// PoCL runs the compiler's front end to find out that it knows a program. Other drivers know by themselves, and
/// oclgrind's reports need the source.
bool keeps_binaries(const Device& device) { return device.info().platform == "Portable Computing Language"; }

/// What compiles for a device, and for which processor.
std::string compiler(const Device& device) {
  const cl::Platform platform(device.cl_device().getInfo<CL_DEVICE_PLATFORM>());
  std::string text = platform.getInfo<CL_PLATFORM_VERSION>();
  for (const std::string& part :
       {device.cl_device().getInfo<CL_DEVICE_VERSION>(), device.info().name, device.info().driver})
    text.append("\n").append(part);
  return text;
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
  std::shared_ptr<BuiltProgram> built;

  /// Builds from a binary, without the compiler's front end. Returns none where the device does not take it.
  std::optional<cl::Program> load(const std::string& binary) const try {
    if (binary.empty()) return std::nullopt;
    const cl::Program::Binaries binaries = {{binary.begin(), binary.end()}};
    cl::Program program(device.context(), {device.cl_device()}, binaries);
    program.build(options.c_str());
    return program;
  } catch (const cl::Error&) {
    return std::nullopt;
  }

  cl::Program compile(const std::string& expanded, const Compilation& compilation) const {
    cl::Program program(device.context(), expanded);
    try {
      program.build(options.c_str());
    } catch (const cl::BuildError& error) {
      std::string log;
      for (const auto& [each, lines] : error.getBuildLog()) log += lines;
      throw KernelBuildError(source, options, log + compilation.advice());
    }
    return program;
  }

  static void keep_binary(const cl::Program& program, const Compilation& compilation, const std::string& key) {
    const auto binaries = program.getInfo<CL_PROGRAM_BINARIES>();
    if (binaries.size() != 1) return;
    compilation.keep_program(key, {reinterpret_cast<const char*>(binaries[0].data()), binaries[0].size()});
  }

  cl::Program build() const {
    const BusyMessage busy(device, "compiling " + source + " for this device (once)");
    const HeldSignals held(HeldSignals::handled);
    const Compilation compilation;
    const std::string expanded = expand_includes(source, text);
    std::string key;
    if (keeps_binaries(device)) key.append(compiler(device)).append("\n").append(options).append("\n").append(expanded);
    std::optional<cl::Program> program;
    if (!key.empty()) program = load(compilation.program(key));
    if (!program) {
      program = compile(expanded, compilation);
      if (!key.empty()) keep_binary(*program, compilation, key);
    }
    compilation.keep();
    device.log(LogLevel::debug, source + " built, " + options);
    return *program;
  }

  /// Takes the program that an earlier Program of the same context has built, or builds it.
  void find_or_build() {
    BuiltPrograms& programs = device.built_programs();
    const std::lock_guard lock(programs.mutex);
    std::shared_ptr<BuiltProgram>& known = programs.all[options + "\n" + source + "\n" + text];
    if (!known) known = std::make_shared<BuiltProgram>(BuiltProgram{build(), {}});
    built = known;
  }
};

Program::Program(const Device& device, const std::string& source, const Defines& defines)
    : Program(from_text(device, source, std::string(embedded(source).text), defines)) {}

Program Program::from_text(const Device& device, const std::string& name, const std::string& text,
                           const Defines& defines) {
  const auto state = std::make_shared<State>(State{device, name, option_text(device, defines), text, {}});
  translated(device.info().name, [&] { state->find_or_build(); });
  return Program(state);
}

cl::Kernel Program::kernel(const std::string& name) const {
  return translated(device().info().name, [&] { return cl::Kernel(state_->built->program, name.c_str()); });
}

const Device& Program::device() const { return state_->device; }
const std::string& Program::source() const { return state_->source; }
const std::string& Program::options() const { return state_->options; }
std::vector<KernelParameter> Program::parameters(const std::string& kernel) const {
  const bool twice = options().find("-DREAL=double") != std::string::npos;
  return kernel_parameters(state_->text, kernel, twice ? "double" : "float");
}
bool Program::first_use(const std::string& kernel) const { return state_->built->used.insert(kernel).second; }
bool Program::takes_group(const std::string& kernel) const {
  const std::string& text = state_->text;
  const std::size_t start = text.find("kernel void " + kernel + "(");
  if (start == text.npos) return false;
  const std::size_t next = text.find("kernel void ", start + 1);
  return text.substr(start, next == text.npos ? next : next - start).find("TAKE_GROUP(") != text.npos;
}

}  // namespace tactel::host
