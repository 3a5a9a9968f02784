#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <cstdio>

#include "host/command.h"
#include "host/errors.h"
#include "host/interrupt.h"
#include "host/live_monitor.h"
#include "host/live_view.h"
#include "host/onnx_file.h"
#include "host/open_source.h"

namespace tactel::host {
namespace {

struct MonitorRequest {
  std::string source, network, profile, calibration, device;
  int every = 1;
  double seconds = 0;
  MonitorOptions options;
  bool view = false, quiet = false;
};

void print_line(const MonitorLine& line) {
  const auto number = [](double value, bool known) { return known ? fmt::format("{}", value) : std::string("null"); };
  const float s = line.answer.slip_index;
  fmt::print("{{\"frame\": {}, \"device_time\": {}, \"arrival\": {}, \"slip_index\": {}, \"latency_us\": {:.1f}}}\n",
             line.frame.number, number(line.frame.device_time.value_or(0), line.frame.device_time.has_value()),
             number(line.frame.arrival, true), std::isfinite(s) ? fmt::format("{}", s) : "null", line.latency);
}

void print_summary(const MonitorSummary& all) {
  const hw::DecoderCounts& d = all.decoder;
  fmt::print(stderr,
             "{{\"frames\": {}, \"lost\": {}, \"bad\": {}, \"resynchronised\": {}, \"late\": {}, \"latency_us\": "
             "{{\"p50\": {:.1f}, "
             "\"p99\": {:.1f}, \"p99.9\": {:.1f}, \"max\": {:.1f}}}, \"duplicated\": {}, \"discarded_bytes\": {}, "
             "\"batched\": {}, \"silences\": {}, \"overruns\": {}, \"stalls\": {}, \"transfer_errors\": {}, "
             "\"reconnects\": {}}}\n",
             d.frames, d.lost, d.bad, d.resynchronised, all.late, all.latency.quantile(0.5), all.latency.quantile(0.99),
             all.latency.quantile(0.999), all.latency.largest(), d.duplicated, d.discarded, all.batched, all.silences,
             all.transport.overruns, all.transport.stalls, all.transport.errors, all.transport.reconnects);
}

/// Where the lines go, and when it ends.
MonitorEvents make_events(const MonitorRequest& request, LiveView& view, const Interrupt& interrupt) {
  using Clock = std::chrono::steady_clock;
  MonitorEvents events;
  events.line = [&](const MonitorLine& line) {
    if (line.frame.number % static_cast<std::uint64_t>(request.every) != 0) return;
    if (request.view) return view.show(line);
    print_line(line);
    std::fflush(stdout);
  };
  events.second = [&](const MonitorSummary& summary) {
    if (!request.quiet && !request.view) print_summary(summary);
  };
  events.silence = [&](double seconds) {
    if (!request.quiet) fmt::print(stderr, "warning: no frame for {:.1f} s\n", seconds);
  };
  events.stop = [&, start = Clock::now()] {
    const std::chrono::duration<double> passed = Clock::now() - start;
    return interrupt.requested() || std::ferror(stdout) != 0 ||
           (request.seconds > 0 && passed.count() >= request.seconds);
  };
  return events;
}

int run_monitor(const MonitorRequest& request) {
  const nn::Model model = read_onnx(request.network);
  Executor executor{Device(request.device)};  // sets environment variables: before there are other threads
  OpenSource opened = open_source(request.source, request.profile, request.calibration);
  LiveMonitor monitor(executor, model, opened.profile, request.options);
  LiveView view;
  const Interrupt interrupt;
  const MonitorSummary summary = monitor.run(*opened.source, make_events(request, view, interrupt));
  view.finish();
  print_summary(summary);
  return interrupt.requested() ? static_cast<int>(interrupted) : done;
}

}  // namespace

void add_monitor_command(CLI::App& app, Action& action) {
  auto request = std::make_shared<MonitorRequest>();
  CLI::App* command = app.add_subcommand("monitor", "live slippage index: one JSON line a frame");
  add_source_options(*command, request->source, request->profile, request->calibration);
  command->add_option("--network", request->network, "network that reads the frames, see tactel train")
      ->type_name("FILE.onnx")
      ->required();
  command->add_option("--every", request->every, "a line for every n-th frame only")
      ->type_name("N")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command
      ->add_option("--seconds", request->seconds, "stop after so many s (default: at the end of the source, or Ctrl-C)")
      ->check(CLI::PositiveNumber);
  command->add_option("--late", request->options.late, "drop live frames that are older than this, s; they are counted")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command->add_flag("--view", request->view,
                    "a picture in the terminal instead of lines: S as a bar, the tactels as strips");
  command
      ->add_option("--device", request->device, "OpenCL device: a part of its name or its index, see `tactel devices`")
      ->type_name("NAME|INDEX");
  command->add_flag("--quiet", request->quiet, "no summary each second, no warnings; the one at the end stays");
  command->callback([request, &action] { action = [request] { return run_monitor(*request); }; });
}

}  // namespace tactel::host
