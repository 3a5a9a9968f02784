// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "host/device/device.h"
#include "host/device/kernel_arguments.h"

namespace tactel::host {

/// Compile-time values of a kernel, in order: {{"LANES", "16"}, {"REAL", "float"}, {"NODES", "41"}}.
using Defines = std::vector<std::pair<std::string, std::string>>;

/// An embedded kernel source (kernels/NAME.cl) built for a device: always with -cl-std=CL1.2. The only option
/// that loosens arithmetic is that denormal numbers are zero. Cheap to copy; copies share the program. Building
/// takes a second or more for a new program, a few ms for one in the cache (device.h): build once, before any timing.
class Program {
 public:
  /// Throws KernelBuildError with the compiler's log; std::out_of_range for an unknown source name (a mistake in the
  /// code).
  Program(const Device& device, const std::string& source, const Defines& defines);
  /// The same for a source that is not embedded (tests, probes); `text` may include the embedded headers.
  static Program from_text(const Device& device, const std::string& name, const std::string& text,
                           const Defines& defines);

  /// Returns a new kernel object. OpenCL kernel objects hold their arguments, so every thread needs its own.
  cl::Kernel kernel(const std::string& name) const;
  const Device& device() const;
  const std::string& source() const;   ///< "gap_sweep.cl"
  const std::string& options() const;  ///< as passed to the compiler

  /// As the function of kernel_arguments.h.
  bool takes_group(const std::string& kernel) const;
  /// Returns the parameters of a kernel, from the text of the source.
  std::vector<KernelParameter> parameters(const std::string& kernel) const;

 private:
  struct State;
  explicit Program(std::shared_ptr<const State> state) : state_(std::move(state)) {}
  std::shared_ptr<const State> state_;
};

/// Returns the text for the compiler. Every `#include "..."` of an embedded file is replaced by that file (once).
/// Because of #line directives the log names the real file and line.
std::string expand_includes(const std::string& name, const std::string& text);

}  // namespace tactel::host
