// SPDX-License-Identifier: Apache-2.0
#include "host/commands/shared_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "host/support/durable_file.h"

namespace tactel::host {
namespace {

/// The words of lines, and those of pads besides.
std::vector<std::string> both(std::vector<std::string> words, const std::vector<std::string>& of_pads) {
  for (const std::string& word : of_pads)
    if (std::ranges::find(words, word) == words.end()) words.push_back(word);
  return words;
}

}  // namespace

void add_device_option(CLI::App& command, std::string& device) {
  command
      .add_option("--device", device, "OpenCL device: a part of its name, its index, gpu or cpu, see `tactel devices`")
      ->type_name("NAME|INDEX");
}

void write_report(const std::string& folder, const std::string& page, bool quiet) {
  const std::filesystem::path file = std::filesystem::absolute(folder).lexically_normal() / "index.html";
  write_file("--output", file, page);
  if (!quiet) fmt::print("report: {}\n", file.string());
}

void add_shared_options(CLI::App& command, SharedOptions& options, const char* precision) {
  SolveOptions& solve = options.solve;
  command
      .add_option("--solver", solve.solver,
                  "batched (OpenCL device); without one full-mesh (lines, slow) or twin (pads)")
      ->check(CLI::IsMember(solver_names()))
      ->transform([](const std::string& name) { return name == "reference" ? std::string("full-mesh") : name; })
      ->capture_default_str();
  command
      .add_option("--precision", solve.precision,
                  std::string("precision of the arithmetic (default: ") + precision + ")")
      ->check(CLI::IsMember({"fp32", "fp64"}));
  add_device_option(command, solve.device);
  command
      .add_option("--tolerance", solve.tolerance,
                  "largest relative residual that counts as converged, no unit (default: the solver's own)")
      ->check(CLI::PositiveNumber);
  command
      .add_option(
          "--rung", solve.rung,
          "model, from fast to exact, instead of the file's: patch-8, patch-12, patch-16, patch-24, paper, mesh-321, "
          "reference (docs/accuracy.md has others); of pads pad-8, pad-12, pad-16, pad-24, reference")
      ->check(CLI::IsMember(both(rung_names(), pad_rung_names())))
      ->type_name("NAME");
  command
      .add_option("--accuracy", solve.accuracy,
                  "largest expected error in S: selects the cheapest rung that keeps it, and reports the choice")
      ->type_name("E")
      ->check(CLI::PositiveNumber);
  command.add_flag("--quiet", options.quiet, "no progress and no warnings on stderr");
}

void add_network_options(CLI::App& command, NetworkOptions& options) {
  command.add_option("--precision", options.precision, "precision of the arithmetic; network files hold fp32")
      ->check(CLI::IsMember({"fp32", "fp64"}))
      ->capture_default_str();
  add_device_option(command, options.device);
  command.add_flag("--quiet", options.quiet, "no progress and no warnings; for train no summary either");
}

}  // namespace tactel::host
