// SPDX-License-Identifier: Apache-2.0
#include "host/commands/shared_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "host/commands/add_option.h"
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
  add_option(command, "--device", device,
             "OpenCL device: a part of its name, its index, gpu or cpu, see `tactel devices`", {.type = "NAME|INDEX"});
}

void write_report(const std::string& folder, const std::string& page, bool quiet) {
  const std::filesystem::path file = std::filesystem::absolute(folder).lexically_normal() / "index.html";
  write_file("--output", file, page);
  if (!quiet) fmt::print("report: {}\n", file.string());
}

void add_shared_options(CLI::App& command, SharedOptions& options, const char* precision) {
  SolveOptions& solve = options.solve;
  add_option(command, "--solver", solve.solver,
             "batched (OpenCL device); without one full-mesh (lines, slow) or twin (pads)")
      ->check(CLI::IsMember(solver_names()))
      ->transform([](const std::string& name) { return name == "reference" ? std::string("full-mesh") : name; });
  add_option(command, "--precision", solve.precision,
             std::string("precision of the arithmetic (default: ") + precision + ")", {.words = {"fp32", "fp64"}});
  add_device_option(command, solve.device);
  add_option(command, "--tolerance", solve.tolerance,
             "largest relative residual that counts as converged, no unit (default: the solver's own)",
             {.positive = true});
  add_option(command, "--rung", solve.rung,
             "model, from fast to exact, instead of the file's: patch-8, patch-12, patch-16, patch-24, paper, "
             "mesh-321, reference (docs/accuracy.md has others); of pads pad-8, pad-12, pad-16, pad-24, reference",
             {.type = "NAME"})
      ->check(CLI::IsMember(both(rung_names(), rung_names<PadRung>())));
  add_option(command, "--accuracy", solve.accuracy,
             "largest expected error in S: selects the cheapest rung that keeps it, and reports the choice",
             {.type = "E", .positive = true});
  add_option(command, "--quiet", options.quiet, "no progress and no warnings on stderr");
}

void add_network_options(CLI::App& command, std::string& device, std::string& precision, bool& quiet) {
  add_option(command, "--precision", precision, "precision of the arithmetic; network files hold fp32",
             {.words = {"fp32", "fp64"}});
  add_device_option(command, device);
  add_option(command, "--quiet", quiet, "no progress and no warnings; for train no summary either");
}

}  // namespace tactel::host
