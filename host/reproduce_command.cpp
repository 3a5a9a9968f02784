#include <fmt/format.h>

#include <filesystem>

#include "host/atomic_file.h"
#include "host/command.h"
#include "host/direct_problem_report.h"
#include "host/errors.h"
#include "host/json_text.h"

namespace tactel::host {
namespace {

struct ReproduceRequest {
  std::string output = "report", device;
  bool quiet = false;
};

void make_directory(const std::filesystem::path& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (error)
    throw ConfigError("command line", "--output", path.string(),
                      "a directory that can be made (" + error.message() + ")");
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
  write_file("--output", directory / "index.html", page.html());
  if (!request.quiet)
    fmt::print("report: {}\n", std::filesystem::absolute(directory / "index.html").lexically_normal().string());
  return done;
}

}  // namespace

void add_reproduce_command(CLI::App& app, Action& action) {
  auto request = std::make_shared<ReproduceRequest>();
  CLI::App* command =
      app.add_subcommand("reproduce", "the paper: Table I and Figures 3 to 5, as an HTML page and JSON");
  command->add_option("--output", request->output, "directory of the report")->type_name("DIR")->capture_default_str();
  command->add_option("--device", request->device, "OpenCL device, its index or a part of its name")
      ->type_name("NAME|INDEX");
  command->add_flag("--quiet", request->quiet, "say nothing but errors");
  command->callback([request, &action] { action = [request] { return run_reproduce(*request); }; });
}

}  // namespace tactel::host
