#pragma once
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "host/device.h"

namespace tactel::host {

/// Compile-time values of a kernel, in order: {{"LANES", "16"}, {"REAL", "float"}, {"NODES", "41"}}.
using Defines = std::vector<std::pair<std::string, std::string>>;

struct ProgramOptions {
  std::filesystem::path
      cache_directory{};  ///< of program binaries; empty: "programs" in fem::default_cache_directory()
  bool cache = true;      ///< false: always compile, store nothing
};

/// An embedded kernel source (kernels/NAME.cl) built for a device: always with -cl-std=CL1.2, and without any option
/// that loosens arithmetic. Cheap to copy; copies share the program. Building takes 20 to 700 ms, from the binary cache
/// about 1 ms: make it once, before the clock starts.
class Program {
 public:
  /// Throws KernelBuildError with the compiler's log; std::out_of_range for an unknown source name (a mistake in the
  /// code).
  Program(const Device& device, const std::string& source, const Defines& defines, const ProgramOptions& options = {});
  /// The same for a source that is not embedded (tests, probes); `text` may include the embedded headers.
  static Program from_text(const Device& device, const std::string& name, const std::string& text,
                           const Defines& defines, const ProgramOptions& options = {});

  /// A new kernel object. OpenCL kernel objects hold their arguments, so every thread needs its own.
  cl::Kernel kernel(const std::string& name) const;
  const Device& device() const;
  const std::string& source() const;   ///< "gap_sweep.cl"
  const std::string& options() const;  ///< as the compiler got them
  bool from_cache() const;             ///< built from a stored binary

  /// Whether a launch of `kernel` with first_group = NO_GROUPS does nothing: its text has TAKE_GROUP
  /// (kernels/shared/group.h).
  bool takes_group(const std::string& kernel) const;

  /// Tells the cache that `kernel` has now been launched. PoCL compiles a kernel at its first launch, so a binary is
  /// worth storing only after that: the first call for a kernel that the stored binary lacks stores the program anew.
  /// Executor calls it.
  void note_launched(const std::string& kernel) const;

 private:
  struct State;
  explicit Program(std::shared_ptr<State> state) : state_(std::move(state)) {}
  std::shared_ptr<State> state_;
};

/// The text that the compiler gets for a source: every `#include "..."` of an embedded file replaced by that file
/// (once), with #line directives, so that the log names the real file and line.
std::string expand_includes(const std::string& name, const std::string& text);

}  // namespace tactel::host
