#include <fmt/format.h>

#include <filesystem>

#include "host/atomic_file.h"
#include "host/command.h"
#include "host/direct_problem_report.h"
#include "host/errors.h"
#include "host/interrupt.h"
#include "host/inverse_problem_report.h"
#include "host/json_text.h"
#include "host/progress_line.h"
#include "host/real_sensor_report.h"

namespace tactel::host {
namespace {

struct ReproduceRequest {
  std::string output = "report", device;
  std::size_t seeds = 100;
  int cycles = 0, noise_cycles = enough_noise_cycles;
  bool quiet = false;
};

void make_directory(const std::filesystem::path& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (error)
    throw ConfigError("command line", "--output", path.string(),
                      "a directory that can be made (" + error.message() + ")");
}

/// Trains at one noise level, with progress and checkpoint. False when Ctrl-C stopped it.
bool train_networks(const ReproduceRequest& request, Executor& executor, const InverseChoice& choice, double noise,
                    InverseProblem& problem) {
  const Interrupt interrupt;
  const std::string job = noise == 0 ? "networks without noise" : "networks with noise";
  ProgressLine line(job, "weight updates", request.quiet);
  const auto checkpoint = std::filesystem::path(request.output) / fmt::format("networks-{}.checkpoint", noise);
  const auto progress = [&](std::size_t done, std::size_t total) {
    line.show(done, total);
    return !interrupt.requested();
  };
  const bool finished = train_and_recall(executor, choice, noise, request.seeds,
                                         {.progress = progress, .checkpoint = checkpoint}, problem);
  line.clear();
  if (!finished) fmt::print(stderr, "stopped; the same command goes on from {}\n", checkpoint.string());
  return finished;
}

/// Section VI. False when Ctrl-C stopped it.
bool reproduce_real_sensor(const ReproduceRequest& request, Executor& executor, ReportPage& page) {
  const Interrupt interrupt;
  ProgressLine line("networks of the real sensor", "networks", request.quiet);
  RealSensorOptions options;
  options.training.cycle_limit = request.cycles;
  options.seeds = std::min(options.seeds, request.seeds);
  options.progress = [&](std::size_t done, std::size_t total) {
    line.show(done, total);
    return !interrupt.requested();
  };
  const auto study = study_real_sensor(executor, real_sensor_choice(), options);
  line.clear();
  if (!study) {
    fmt::print(stderr, "stopped; the same command goes on after the networks of section V\n");
    return false;
  }
  report_real_sensor(page, *study);
  write_file("--output", std::filesystem::path(request.output) / "section6.json", json_text(real_sensor_json(*study)));
  return true;
}

/// Section V. False when Ctrl-C stopped it.
bool reproduce_networks(const ReproduceRequest& request, Executor& executor, ReportPage& page) {
  const std::filesystem::path directory = request.output;
  InverseChoice choice = inverse_choice();
  choice.options.cycle_limit = request.cycles;
  InverseChoice noisy = choice;
  if (request.cycles == 0) noisy.options.cycle_limit = request.noise_cycles;
  InverseProblem problem;
  problem.sets = simulate_sets(executor, choice);
  if (!train_networks(request, executor, choice, 0, problem)) return false;
  if (!train_networks(request, executor, noisy, paper_noise, problem)) return false;
  const auto sensitivity = inverse_sensitivity(executor, choice, std::min<std::size_t>(request.seeds, 4),
                                               request.cycles > 0 ? std::min(request.cycles, 2000) : 2000);
  report_inverse_problem(page, problem, choice, sensitivity);
  write_file("--output", directory / "table2.json", json_text(table_two_json(problem)));
  return true;
}

int run_reproduce(const ReproduceRequest& request) {
  const std::filesystem::path directory = request.output;
  make_directory(directory);
  check_writable("--output", directory / "index.html");
  Executor executor{Device(request.device)};
  ReportPage page("tactel: the paper again",
                  "Detection of incipient object slippage by skin-like sensing and neural network processing (1998), "
                  "computed by tactel " TACTEL_VERSION " on " +
                      executor.device().info().name);
  const auto table_one = report_direct_problem(executor, page);
  write_file("--output", directory / "table1.json", json_text(table_one));
  if (!reproduce_networks(request, executor, page) || !reproduce_real_sensor(request, executor, page))
    return interrupted;
  write_file("--output", directory / "index.html", page.html());
  for (double noise : {0.0, paper_noise})
    std::filesystem::remove(directory / fmt::format("networks-{}.checkpoint", noise));
  if (!request.quiet)
    fmt::print("report: {}\n", std::filesystem::absolute(directory / "index.html").lexically_normal().string());
  return done;
}

}  // namespace

void add_reproduce_command(CLI::App& app, Action& action) {
  auto request = std::make_shared<ReproduceRequest>();
  CLI::App* command = app.add_subcommand(
      "reproduce", "the paper: Tables I and II, Figures 3 to 5 and section VI, as an HTML page and JSON");
  command->add_option("--output", request->output, "directory of the report")->type_name("DIR")->capture_default_str();
  command->add_option("--device", request->device, "OpenCL device, its index or a part of its name")
      ->type_name("NAME|INDEX");
  command->add_option("--seeds", request->seeds, "initial weights that each network of Table II is trained from")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  command->add_option("--cycles", request->cycles, "fewer learning cycles than the paper, for a quick look; 0: as many")
      ->check(CLI::Range(0, 1000000))
      ->capture_default_str();
  command->add_option("--noise-cycles", request->noise_cycles, "learning cycles with noise; 0: as many as the paper")
      ->check(CLI::Range(0, 1000000))
      ->capture_default_str();
  command->add_flag("--quiet", request->quiet, "say nothing but errors");
  command->callback([request, &action] { action = [request] { return run_reproduce(*request); }; });
}

}  // namespace tactel::host
