#include "host/program.h"

#include <algorithm>
#include <mutex>
#include <optional>
#include <set>
#include <stdexcept>

#include "fem/condensation.h"
#include "host/binary_cache.h"
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

std::string option_text(const Defines& defines) {
  std::string text = "-cl-std=CL1.2";
  for (const auto& [key, value] : defines) text += " -D" + key + "=" + value;
  return text;
}

// All that a binary depends on.
std::string cache_key(const Device& device, const std::string& options, const std::string& text) {
  const DeviceInfo& info = device.info();
  return info.platform + "\n" + info.name + "\n" + info.driver + "\n" + options + "\n" + text;
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
  cl::Program program;
  std::optional<BinaryCache> cache;
  bool from_cache = false;
  std::mutex launched_mutex;
  std::set<std::string> launched;  ///< kernels that the stored binary holds compiled

  State(const Device& device, std::string source, std::string options, std::string text)
      : device(device), source(std::move(source)), options(std::move(options)), text(std::move(text)) {}
  void build(const std::string& text);
  bool build_stored();
  void build_text(const std::string& text);
};

bool Program::State::build_stored() {
  const std::optional<StoredBinary> stored = cache->load();
  if (!stored) return false;
  try {
    program = cl::Program(device.context(), {device.cl_device()}, {stored->binary});
    program.build(options.c_str());
  } catch (const cl::Error& error) {
    device.log(LogLevel::warning, source + ": stored binary refused (" + cl_code_name(error.err()) + "), compiling");
    return false;
  }
  launched = stored->kernels;
  return true;
}

void Program::State::build_text(const std::string& text) {
  program = cl::Program(device.context(), text);
  try {
    program.build(options.c_str());
  } catch (const cl::BuildError& error) {
    std::string log;
    for (const auto& [each, lines] : error.getBuildLog()) log += lines;
    throw KernelBuildError(source, options, log);
  }
}

void Program::State::build(const std::string& text) {
  from_cache = cache && build_stored();
  if (!from_cache) build_text(text);
  device.log(LogLevel::debug, source + (from_cache ? ": from the cache" : ": compiled") + ", " + options);
}

Program::Program(const Device& device, const std::string& source, const Defines& defines, const ProgramOptions& options)
    : Program(from_text(device, source, std::string(embedded(source).text), defines, options)) {}

Program Program::from_text(const Device& device, const std::string& name, const std::string& text,
                           const Defines& defines, const ProgramOptions& options) {
  const std::string whole = expand_includes(name, text);
  const auto state = std::make_shared<State>(device, name, option_text(defines), text);
  if (options.cache) {
    const auto directory =
        options.cache_directory.empty() ? fem::default_cache_directory() / "programs" : options.cache_directory;
    state->cache.emplace(directory, name, cache_key(device, state->options, whole));
  }
  translated(device.info().name, [&] { state->build(whole); });
  return Program(state);
}

cl::Kernel Program::kernel(const std::string& name) const {
  return translated(device().info().name, [&] { return cl::Kernel(state_->program, name.c_str()); });
}

const Device& Program::device() const { return state_->device; }
const std::string& Program::source() const { return state_->source; }
const std::string& Program::options() const { return state_->options; }
bool Program::from_cache() const { return state_->from_cache; }

bool Program::takes_group(const std::string& kernel) const {
  const std::string& text = state_->text;
  const std::size_t start = text.find("kernel void " + kernel + "(");
  if (start == text.npos) return false;
  const std::size_t next = text.find("kernel void ", start + 1);
  return text.substr(start, next == text.npos ? next : next - start).find("TAKE_GROUP(") != text.npos;
}

void Program::note_launched(const std::string& kernel) const {
  const std::lock_guard lock(state_->launched_mutex);
  if (!state_->launched.insert(kernel).second || !state_->cache) return;
  const auto binaries =
      translated(device().info().name, [&] { return state_->program.getInfo<CL_PROGRAM_BINARIES>(); });
  const bool stored = !binaries.empty() && state_->cache->store({state_->launched, binaries.front()});
  if (!stored)
    device().log(LogLevel::warning, state_->source + ": binary not stored in " + state_->cache->path().string());
}

}  // namespace tactel::host
