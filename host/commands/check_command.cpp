// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "host/commands/add_option.h"
#include "host/commands/command.h"
#include "host/sets/check_set.h"
#include "host/support/interrupt.h"
#include "host/support/progress_line.h"

namespace tactel::host {
namespace {

struct CheckRequest {
  std::string set;
  bool quiet = false;
};

int run_check(const CheckRequest& request) {
  const Interrupt interrupt;
  ProgressLine line("checking", "chunks", request.quiet);
  const SetCheck check = check_contact_set(request.set, [&](std::size_t read, std::size_t all) {
    line.show(read, all);
    return !interrupt.requested();
  });
  line.clear();
  for (const SetDamage& damage : check.damage)
    fmt::print(
        "{}: {}{}\n", request.set,
        damage.dataset.empty() ? "" : fmt::format("{}: rows {} to {}: ", damage.dataset, damage.first, damage.last),
        damage.what);
  if (!check.finished) return interrupted;
  if (!check.damage.empty()) return not_converged;
  if (!request.quiet)
    fmt::print("{}: {} rows in {} chunks, {}B: all as written\n", request.set, check.rows, check.chunks,
               with_prefix(static_cast<double>(check.bytes)));
  return done;
}

}  // namespace

void add_check_command(CLI::App& app, Action& action) {
  const auto [command, request] = add_command(
      app, action, "Simulate", "check", "verify the checksums of a set and name what is damaged or edited", run_check);
  add_option(command, "set", request.set, "a set that tactel generate wrote", {.type = "SET.h5"})->required();
  add_option(command, "--quiet", request.quiet, "print only damage");
  command.footer("Exit codes: 0 as written, 2 not a set, 4 damaged or edited.");
}

}  // namespace tactel::host
