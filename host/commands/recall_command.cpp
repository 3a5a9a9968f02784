// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "host/commands/add_option.h"
#include "host/commands/network_parts.h"
#include "host/commands/shared_options.h"
#include "host/support/durable_file.h"
#include "host/support/errors.h"
#include "host/support/interrupt.h"
#include "host/support/json_text.h"
#include "host/support/progress_line.h"
#include "host/support/terminal.h"
#include "host/training/decision.h"
#include "host/training/network_report.h"

namespace tactel::host {
namespace {

using Json = nlohmann::ordered_json;

struct RecallRequest {
  const CLI::App* command = nullptr;
  NetworkOptions shared;
  std::string networks, set, json, rows, html, decision_csv;
  bool decision = false;
  DecisionOptions alarms;
  double spread = told_nothing;

  bool decides() const { return decision || !decision_csv.empty(); }
};

using Decisions = std::vector<std::vector<DecisionCurve>>;  ///< [networks]; empty where none were asked for

void check_recall_outputs(const RecallRequest& request) {
  if (!request.json.empty() && request.json != "-") check_writable("--json", request.json);
  if (!request.rows.empty()) check_writable("--rows", request.rows);
  if (!request.html.empty()) check_writable("--html", request.html);
  if (!request.decision_csv.empty()) check_writable("--decision-csv", request.decision_csv);
}

/// The target of all networks. Throws ConfigError for networks of several, and for an option that needs another one.
nn::Target target_of(const RecallRequest& request, std::span<const NamedNetwork> networks) {
  const nn::Target target = networks.front().model.target;
  const auto refuse = [&](const std::string& what, const std::string& value, const std::string& allowed) {
    throw ConfigError("command line", what, value, allowed);
  };
  for (const NamedNetwork& network : networks)
    if (network.model.target != target)
      refuse("networks", fmt::format("of {} and {}", nn::name(target), nn::name(network.model.target)),
             "networks of one target: name one file");
  if (target != nn::Target::slip_index && !request.html.empty())
    refuse("--html", request.html, fmt::format("left out for networks of {}: the page is about S", nn::name(target)));
  if (target == nn::Target::stick_fraction && request.decides())
    refuse("--decision", nn::name(target), "networks of slip_index or force_ratio, which rise toward sliding");
  return target;
}

/// Warns of stresses that are far from all that the network learnt, as of another unit.
void warn_of_unit(const RecallRequest& request, const NamedNetwork& network, const nn::FrameSet& set) {
  const nn::Learnt &learnt = network.model.learnt, here = nn::learnt_ranges(set);
  if (request.shared.quiet || learnt.largest_peak == 0 || here.largest_peak == 0) return;
  constexpr float times = nn::Learnt::beyond_times;
  if (here.largest_peak <= times * learnt.largest_peak && here.largest_peak >= learnt.smallest_peak / times) return;
  print_warning(
      fmt::format("{}: its normal stresses reach {:.3g} MPa, where {} learnt peaks of {:.3g} to {:.3g} MPa; "
                  "are they MPa?",
                  request.set, here.largest_peak, network.file, learnt.smallest_peak, learnt.largest_peak));
}

/// All networks on all rows; nothing after Ctrl-C.
std::optional<std::vector<NetworkResult>> recall(const RecallRequest& request, const Device& device,
                                                 std::span<const NamedNetwork> networks, const nn::FrameSet& set) {
  Executor executor{device};
  const Interrupt interrupt;
  ProgressLine line("recall", "frames", request.shared.quiet);
  const auto progress = [&](std::size_t done, std::size_t all) {
    line.show(done, all);
    return !interrupt.requested();
  };
  const bool keep_rows = !request.rows.empty() || !request.html.empty() || request.decides();
  return recall_networks(executor, precision_named(request.shared.precision), networks, set, keep_rows, progress,
                         request.spread);
}

Json report_json(const RecallRequest& request, std::span<const NamedNetwork> networks,
                 std::span<const NetworkResult> results, const ContactSet& set, const AnsweredRows& rows,
                 const Decisions& decisions, const std::string& device) {
  Json list = Json::array();
  for (std::size_t i = 0; i < networks.size(); ++i) {
    list.push_back(to_json(networks[i]));
    list.back().update(to_json(results[i], set.indenter_names));
    if (!decisions.empty()) list.back()["decision"] = to_json(decisions[i], request.alarms);
  }
  return {{"tactel", TACTEL_VERSION},
          {"set", request.set},
          {"rows", rows.frames.rows()},
          {"rows_left_out", rows.left_out},
          {"device", device},
          {"precision", request.shared.precision},
          {"networks", list}};
}

// An empty field where a network gave no answer.
std::string rows_csv(std::span<const NamedNetwork> networks, std::span<const NetworkResult> results,
                     const AnsweredRows& rows) {
  std::string text = fmt::format("row,{}", nn::name(rows.target));
  for (const NamedNetwork& network : networks) {
    text += "," + network.file;
    if (network.model.bound) text += fmt::format(",{0} slip_upper,{0} lower,{0} upper,{0} unlike", network.file);
  }
  text += '\n';
  for (std::size_t k = 0; k < rows.row.size(); ++k) {
    text += fmt::format("{},{:.9g}", rows.row[k], results.front().truth[k]);
    for (const NetworkResult& result : results) {
      const bool none = std::isnan(result.slip_index[k]);
      text += none ? "," : fmt::format(",{:.9g}", result.slip_index[k]);
      if (result.bounds.empty()) continue;
      const nn::BoundAnswer& bound = result.bounds[k];
      text += none ? fmt::format(",,,,{}", int{bound.unlike})
                   : fmt::format(",{:.9g},{:.9g},{:.9g},{}", bound.upper, bound.interval[0], bound.interval[1],
                                 int{bound.unlike});
    }
    text += '\n';
  }
  return text;
}

std::string tables(const RecallRequest& request, std::span<const NamedNetwork> networks,
                   std::span<const NetworkResult> results, const ContactSet& set, const AnsweredRows& rows,
                   const Decisions& decisions, const std::string& device) {
  std::string text = fmt::format("{} of {} networks on {} rows of {}\n", errors_of(rows.target), networks.size(),
                                 rows.frames.rows(), request.set);
  if (rows.left_out > 0)
    text +=
        fmt::format("{} rows of the set were left out: over tolerance, or without a slippage index\n", rows.left_out);
  text += "\n" + error_table(networks, results) + "\n" + error_table_by_kind(networks, results, set.indenter_names);
  for (std::size_t i = 0; i < networks.size(); ++i)
    if (results[i].bound) {
      const std::string doubt = doubt_text(networks[i].model, *results[i].bound, rows.frames);
      text += fmt::format("\n{}, {}\n{}{}{}", networks[i].file, bound_line(*networks[i].model.bound), doubt,
                          doubt.empty() ? "" : "\n", coverage_table(*results[i].bound, set.indenter_names));
    }
  for (std::size_t i = 0; i < decisions.size(); ++i)
    text += fmt::format("\n{}\n{}", networks[i].file, decision_table(decisions[i], request.alarms));
  if (rows.target == nn::Target::slip_index && !rows.frames.markers)
    text += "\nhow well S can be read at all: python -m tactel.floor SWEEP.toml (docs/judging.md)\n";
  return text + "\ndevice: " + device + "\n";
}

std::string all_curves(std::span<const NamedNetwork> networks, const Decisions& decisions,
                       const DecisionOptions& options) {
  std::string text;
  for (std::size_t i = 0; i < decisions.size(); ++i)
    text += decision_csv(decisions[i], networks[i].file, options, i == 0);
  return text;
}

int run_recall(const RecallRequest& request) {
  for (const char* option : {"--rate", "--touch", "--widest"})
    if (request.command->count(option) > 0 && !request.decides())
      throw ConfigError("command line", option, "", "left out, or with --decision");
  check_recall_outputs(request);
  const std::vector<NamedNetwork> networks = read_networks(request.networks);
  const nn::Target target = target_of(request, networks);
  if (is_recording(request.set)) {
    for (const auto& [option, given] :
         {std::pair("--html", !request.html.empty()), std::pair("--decision", request.decides())})
      if (given) throw ConfigError("command line", option, request.set, "left out for a recording: it has no true S");
    return recall_recording(networks, request.set, request.shared, request.json, request.rows);
  }
  const bool markers = networks.front().model.scaling.markers;
  if (markers && request.decides())
    throw ConfigError("command line", "--decision", "markers",
                      "left out for networks of markers: alarms go by stresses");
  const ContactSet set = [&] {
    const StageLine stage("reading " + request.set, request.shared.quiet);
    return read_contact_set(request.set, unread(markers));
  }();
  const AnsweredRows rows = answered_rows(set, request.set, target, markers);
  const Device device(request.shared.device);
  warn_of_unit(request, networks.front(), rows.frames);
  const auto results = recall(request, device, networks, rows.frames);
  if (!results) return interrupted;
  Decisions decisions;
  if (request.decides()) {
    const std::vector<double> positions = tangential_positions(set, request.set);
    for (const NetworkResult& result : *results)
      decisions.push_back(decide(result, set, rows, positions, request.set, request.alarms));
  }
  if (!request.decision_csv.empty())
    write_file("--decision-csv", request.decision_csv, all_curves(networks, decisions, request.alarms));
  if (!request.rows.empty()) write_file("--rows", request.rows, rows_csv(networks, *results, rows));
  if (!request.html.empty())
    write_file("--html", request.html,
               recall_page(networks, *results, rows, set.indenter_names, request.set, decisions).html());
  const Json report = report_json(request, networks, *results, set, rows, decisions, device.info().name);
  if (request.json == "-") {
    fmt::print("{}", json_text(report));
    return done;
  }
  if (!request.json.empty()) write_file("--json", request.json, json_text(report));
  fmt::print("{}", tables(request, networks, *results, set, rows, decisions, device.info().name));
  return done;
}

}  // namespace

void add_recall_command(CLI::App& app, Action& action) {
  const auto [command, request] =
      add_command(app, action, "Learn", "recall", "report the errors of trained networks on a set", run_recall);
  add_option(command, "networks", request.networks, "directory of tactel train, or one network (*.onnx)",
             {.type = "DIR|FILE.onnx"})
      ->required();
  add_option(command, "set", request.set,
             "set to judge by (HDF5), see tactel generate; or a recording, whose frames have no true S",
             {.type = "SET.h5|RECORDING"})
      ->required();
  add_option(command, "--json", request.json, "write all errors as JSON; - for standard output, instead of the tables",
             {.type = "FILE"});
  add_option(command, "--rows", request.rows, "write S of the set and of every network, row by row, as CSV",
             {.type = "FILE.csv"})
      ->group("Output");
  add_option(command, "--html", request.html,
             "write a page: predicted over true S, the distribution of errors, and errors by indenter and by S",
             {.type = "FILE.html"});
  add_option(command, "--decision", request.decision,
             "judge alarms on drags until sliding: detection, false alarms and lead over thresholds");
  add_option(command, "--decision-csv", request.decision_csv,
             "write the curves of --decision as CSV: a line a threshold, by signal and indenter", {.type = "FILE.csv"});
  add_option(command, "--rate", request.alarms.rate,
             "with --decision: frames a second, for the false alarms a minute, 1/s", {.positive = true});
  add_option(command, "--touch", request.alarms.touch,
             "with --decision: a frame whose normal stresses all stay below this is no contact and ends an alarm, MPa")
      ->check(CLI::NonNegativeNumber);
  add_option(
      command, "--widest", request.alarms.widest,
      "with --decision: no alarm begins at a frame with a wider interval of S; it cannot tell, no unit (default: none)")
      ->check(CLI::NonNegativeNumber);
  add_option(command, "--friction-spread", request.spread,
             "tell networks of train --friction the mu of each row within this relative standard deviation (default: "
             "they are told nothing)",
             {.type = "FLOAT", .most = 1e3});
  command.add_flag("--no-floor")->description("without effect, kept for scripts: no floor is printed");
  add_network_options(command, request.shared.device, request.shared.precision, request.shared.quiet);
  request.command = &command;
}

}  // namespace tactel::host
