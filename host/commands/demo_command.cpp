// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "host/commands/add_option.h"
#include "host/commands/command.h"
#include "host/commands/shared_options.h"
#include "host/support/child_process.h"
#include "host/support/durable_file.h"
#include "host/support/errors.h"
#include "host/support/interrupt.h"
#include "host/support/terminal.h"

namespace tactel::host {
namespace {

// The tactels stay away from the ends of the glued base, where the exact stress is infinite.
constexpr const char* sensor = R"([sensor]
tactel_span = 18.0                       # mm

)";

constexpr const char* contact = R"(title = "a fingertip of 10 mm radius"

[indenter]
shape = "cylinder"
radius = 10.0                            # mm

[contact]
friction = 0.6

[load]
indentation = [0.05, 0.10, 0.15]         # mm
tangential_step = 0.02                   # mm, until the whole contact slides
)";

constexpr const char* mix = R"(
[contact]
friction = { uniform = [0.1, 1.0] }

[[indenter]]
shape = "flat"
half_width = { uniform = [1, 6] }        # mm

[[indenter]]
shape = "parabola"
radius = { log_uniform = [2, 100] }      # mm

[[indenter]]
shape = "cylinder"
radius = { log_uniform = [3, 100] }      # mm

[[indenter]]
shape = "rounded_flat"
half_width = { uniform = [0.5, 5] }      # mm
radius = { log_uniform = [2, 50] }       # mm

[load]
indentation = { uniform = [0.05, 0.25] } # mm
tangential_step = { log_uniform = [0.005, 0.08] }
tangential_steps = 9
)";

// The measuring chain of simulate:, whose noise is over 1.5 times the largest stress. A network that has not learnt
// gains and decay is off by 0.1.
constexpr const char* chain = R"(
[transducer]                             # of the simulated sensor
gain_spread = 0.05
noise_of_largest = 0.0015
time_constant = 1.0                      # s, of the charge amplifiers
step_time = 0.2                          # s between load steps
)";

std::string sweep_text(int contacts, int seed) {
  return fmt::format("[sweep]\ncontacts = {}\nseed = {}\n\n{}{}{}", contacts, seed, sensor, mix, chain);
}

struct DemoRequest {
  std::string output = "tactel-demo", device;
  bool force = false;
};

struct Step {
  std::string why;  ///< what the command does, in a line
  std::vector<std::string> words;
};

/// Shows a command and runs it as a child of this program, with its standard streams. Returns its exit code.
int run_shown(const Step& step) {
  std::string shown = "$ tactel";
  for (const std::string& word : step.words)
    shown += " " + (word.find('?') == std::string::npos ? word : "'" + word + "'");
  fmt::print("\n# {}\n{}\n", step.why, takes_colour(STDOUT_FILENO) ? painted(shown, Colour::green) : shown);
  std::fflush(stdout);
  std::vector<std::string> command = {"tactel"};
  command.insert(command.end(), step.words.begin(), step.words.end());
  const int code = run_attached("/proc/self/exe", command);
  if (code == 128 + SIGINT || code == 128 + SIGTERM || code == 128 + SIGHUP) return interrupted;
  return code > 128 ? static_cast<int>(device_failed) : code;
}

int run_demo(const DemoRequest& request) {
  const std::filesystem::path folder(request.output);
  if (!request.force && std::filesystem::exists(folder))
    throw ConfigError("command line", "--output", request.output, "a new directory (--force overwrites its files)");
  make_folder("--output", folder);
  const auto file = [&](const char* name) { return (folder / name).string(); };
  write_file("--output", file("contact.toml"), std::string(contact) + "\n" + sensor);
  write_file("--output", file("learning.toml"), sweep_text(8000, 1));
  write_file("--output", file("recall.toml"), sweep_text(1000, 2));
  const std::string network = (folder / "networks" / "42-42-21-1_noise0.001_seed1.onnx").string();
  const bool looks = is_terminal(STDOUT_FILENO);
  std::vector<std::string> live = {"monitor",   "--source", "simulate:" + file("contact.toml") + "?rate=100",
                                   "--network", network,    "--quiet"};
  for (const char* word :
       looks ? std::vector{"--view", "--seconds", "10"} : std::vector{"--every", "50", "--alarm", "0.8"})
    live.emplace_back(word);
  std::vector<Step> steps = {
      {"One contact: a fingertip is pressed into rubber and dragged until it slides.",
       {"solve", file("contact.toml"), "--html", file("contact.html")}},
      {"To learn from: 8000 random contacts, with stresses and slippage index S.",
       {"generate", file("learning.toml"), "--output", file("learning.h5"), "--force"}},
      {"To judge by: 1000 other contacts, from which no network learns.",
       {"generate", file("recall.toml"), "--output", file("recall.h5"), "--force"}},
      {"A network learns S from the 42 stresses of a frame, without the friction.",
       {"train", file("learning.h5"), "--network", "42-42-21-1", "--schedule", "batch", "--scaling", "frame", "--noise",
        "0.001", "--cycles", "300", "--output", file("networks"), "--force"}},
      {"How far off is it on the other contacts? As tables, and as a page.",
       {"recall", file("networks"), file("recall.h5"), "--html", file("networks.html")}},
      {"A simulated sensor plays the first contact; the network reads S live.", live}};
  const Interrupt interrupt;
  for (Step& step : steps) {
    if (!request.device.empty()) step.words.insert(step.words.end(), {"--device", request.device});
    if (const int code = run_shown(step); code != done) return code;
    if (interrupt.requested()) return interrupted;
  }
  fmt::print("\nOpen {} and {} in a browser; every command above can be repeated.\n",
             std::filesystem::absolute(file("contact.html")).string(), "networks.html beside it");
  return done;
}

}  // namespace

void add_demo_command(CLI::App& app, Action& action) {
  const auto [command, request] = add_command(app, action, "Set up", "demo",
                                              "show tactel in a minute: a contact, a set, a network, its page and a "
                                              "live view; each command is shown, with its reason",
                                              run_demo);
  add_option(command, "--output", request.output, "directory of all files", {.type = "DIR"});
  add_option(command, "--force", request.force, "overwrite the files in DIR");
  add_device_option(command, request.device);
}

}  // namespace tactel::host
