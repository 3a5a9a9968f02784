// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <optional>

#include "fem/gap/stress_field.h"
#include "fem/pad/side_kernel.h"
#include "host/answers/planner.h"
#include "host/commands/add_option.h"
#include "host/commands/shared_options.h"
#include "host/scenes/ladder.h"
#include "host/scenes/scene_source.h"
#include "host/scenes/sweep_file.h"
#include "host/scenes/unit_warnings.h"
#include "host/sets/set_production.h"
#include "host/sets/set_recipe.h"
#include "host/support/durable_file.h"
#include "host/support/errors.h"
#include "host/support/interrupt.h"
#include "host/support/progress_line.h"
#include "host/support/ranks.h"
#include "host/support/seconds.h"
#include "host/support/terminal.h"

namespace tactel::host {
namespace {

constexpr double usual_depth = 0.1;  ///< over the thickness, of forces on pads

struct GenerateRequest {
  SharedOptions shared;
  std::string sweep, output;
  std::vector<std::string> devices;
  std::string columns;  ///< names of datasets, separated by commas; empty: all
  bool force = false, resume = false, compress = false;
};

ProductionOptions production_options(const GenerateRequest& request) {
  const SolveOptions& solve = request.shared.solve;
  if (solve.solver != "batched") throw ConfigError("command line", "--solver", solve.solver, "batched for sets");
  ProductionOptions options;
  options.set.precision = precision_named(solve.precision);
  options.set.accept = solve.tolerance.value_or(0);
  if (!solve.device.empty()) options.devices = {solve.device};
  if (!request.devices.empty())
    options.devices.insert(options.devices.end(), request.devices.begin(), request.devices.end());
  return options;
}

/// How the contacts are solved.
struct Modelling {
  std::optional<Rung> rung{};  ///< of lines; none: as the file says
  bool accurate = true;        ///< false: no rung is known to keep --accuracy
};

/// The rung of lines that --rung names, or that --accuracy takes for a sample of the contacts.
Modelling modelling(const GenerateRequest& request, const SceneSource& source, bool quiet) {
  const SolveOptions& solve = request.shared.solve;
  if (const auto rung = named_rung_for_many(solve)) return {rung};
  if (!solve.accuracy) {
    if (source.model() == fem::SurfaceModel::patch) return {usual_patch()};
    return {};
  }
  const std::uint64_t count = std::min(source.contacts(), most_tried);
  const StageLine stage(fmt::format("trying rungs on {} contacts", count), quiet);
  Executor executor{Device(solve.device)};
  const RungChoice chosen = plan_for_many(
      executor, *solve.accuracy,
      {source.contacts(), [&](std::uint64_t k) { return source.contact(k).scene; }, source.own_sensors()});
  if (!quiet) {
    fmt::print(stderr, "{}, in 95 % of {} contacts tried\n", chosen.why(), count);
    if (!chosen.kept || chosen.rung.exact)
      print_warning("no rung is known to keep this accuracy on these contacts: the finest was taken");
  }
  return {chosen.rung_for_many(), chosen.kept && !chosen.rung.exact};
}

/// The rung of pads that --rung names, or the cheapest whose class of errors keeps --accuracy.
PadRung pad_rung(const SolveOptions& solve, const PadSource& source) {
  if (const auto rung = named_rung_for_many<PadRung>(solve)) return *rung;
  if (!solve.accuracy) return usual_pad_rung();
  const auto tried = tried_of(source.contacts(), [&](std::uint64_t k) { return source.contact(k).scene; });
  const PadRung& cheapest = cheapest_pad_rung(tried, *solve.accuracy, [&](std::size_t k) {
    return by_force(tried[k]) ? usual_depth * tried[k].sensor.thickness : largest_normal(tried[k].load);
  });
  if (cheapest.exact)
    throw ConfigError("command line", "--accuracy", fmt::format("{:g}", *solve.accuracy),
                      "an error in S that a rung of pads keeps on these contacts (docs/pads.md); pad-24 is the finest");
  return cheapest;
}

/// Returns true where a complete set exists and may stay.
bool already_there(const GenerateRequest& request, const SetRecipe& recipe) {
  std::error_code error;
  if (request.force || !std::filesystem::exists(request.output, error)) return false;
  if (!request.resume)
    throw ConfigError("command line", "--output", request.output, "a new file, or --force to overwrite it");
  expect_made_by(recipe, request.output);
  SetSpool::discard(request.output);  // of a run that was killed after the set was complete
  return true;
}

/// The number of rows is known to a tenth before a run that may take days. At its end chunks and set are there, half as
/// large at least where it is compressed.
void check_room(const GenerateRequest& request, double bytes) {
  namespace fs = std::filesystem;
  std::error_code error;
  const fs::space_info disk = fs::space(fs::absolute(request.output, error).parent_path(), error);
  const double both = bytes * (request.compress ? 1.5 : 2), there = SetSpool::bytes_left(request.output);
  if (error || 0.9 * both <= static_cast<double>(disk.available) + there) return;
  throw ConfigError("command line", "--output", request.output,
                    fmt::format("on a disk with room for it: the set and its chunks take about {}B together, and {}B "
                                "are free; take fewer contacts, fewer --columns or another disk",
                                with_prefix(both), with_prefix(static_cast<double>(disk.available))));
}

/// What the processes did together.
struct Work {
  double contacts = 0, steps = 0, kernel = 0, bytes = 0;
  StageSeconds stages;
  double write_seconds = 0;
  double unfinished = 0;  ///< processes
};

/// "draw 8 %, lay-out 20 %, ...": shares of the time of all threads.
std::string shares(const StageSeconds& s) {
  std::string text;
  for (const auto& [name, seconds] : {std::pair("draw", s.draw),
                                      {"lay-out", s.lay_out},
                                      {"solve", s.solve},
                                      {"solve again", s.solve_again},
                                      {"gather", s.gather},
                                      {"write", s.write}})
    text += fmt::format("{}{} {:.0f} %", text.empty() ? "" : ", ", name, 100 * seconds / s.all());
  return text;
}

std::string report_text(const GenerateRequest& request, const ContactSet& set, const Work& work, std::uint64_t rows,
                        double seconds, double assemble_seconds) {
  std::string text = fmt::format("{}: {} rows; {} contacts by the exact fallback, {} unsolved\n", request.output, rows,
                                 set.fell_back, set.unsolved);
  const auto of_contacts = [&](std::uint64_t count, const std::string& what) {
    if (count > 0) text += fmt::format("{} of {} contacts {}\n", count, set.contacts, what);
  };
  of_contacts(set.without_rows, "have no row: mu P = 0 in all their load steps, and S = Q / (mu P) is not defined");
  of_contacts(set.never_slid,
              fmt::format("do not slide as a whole within {} steps of their drag", fem::most_tangential_steps));
  of_contacts(set.far_slip,
              fmt::format("slide further than {}a tenth of their width: displacements are taken as small (docs/{}.md)",
                          set.pad ? "" : "an element and ", set.pad ? "pads" : "scenes"));
  of_contacts(set.near_edge,
              "come nearer than the thickness to an edge of the pad, whose sides are held: sensor.sides = \"free\" is "
              "right there; `tactel solve` refuses them; 1 in the column outside (docs/pads.md)");
  of_contacts(set.unseen,
              "stay farther than the thickness from every tactel, which hardly see them: the pitch exceeds two "
              "thicknesses; 2 in the column outside");
  of_contacts(set.wide_cells,
              "have cells wider than the thickness, which put P of sharp and tilted shapes off: `tactel solve` states "
              "by how much; 4 in the column outside");
  if (set.coarse > 0)
    text += fmt::format(
        "in {} of {} rows the contact covers few of the {} that are laid for its deepest step: status 3 "
        "(docs/sets.md)\n",
        set.coarse, rows, set.pad ? "cells" : "elements");
  if (work.contacts > 0)
    text += fmt::format(
        "{:.0f} contacts, {} load steps in {:.2f} s: {} steps/s{}; chunks written at {}B/s, set assembled in {:.2f} s\n"
        "time of the threads before that: {}\n",
        work.contacts, with_prefix(work.steps), seconds, with_prefix(work.steps / seconds),
        work.kernel > 0 ? fmt::format(", in kernels {} steps/s", with_prefix(work.steps / work.kernel))
                        : "",  // free sides
        with_prefix(work.bytes / work.write_seconds), assemble_seconds, shares(work.stages));
  return text + fmt::format("device: {}\n", set.device);
}

void warn_of_depth(std::uint64_t too_deep, std::uint64_t contacts) {
  if (too_deep == 0) return;
  const double limit = 100 * fem::linear_strain_limit;
  print_warning(fmt::format(
      "in {} of {} contacts the indenter is deeper than {:.0f} % of the thickness; rubber was measured to be linear up "
      "to {:.0f} %",
      too_deep, contacts, limit, limit));
}

/// Chooses the model of the contacts. `quiet`: says nothing.
Modelling modelling(const GenerateRequest& request, Sweep& sweep, SetOptions& options, bool quiet) {
  if (const auto* pads = std::get_if<PadSource>(&sweep.source)) {
    options.pad = pad_rung(request.shared.solve, *pads);
    return {};
  }
  auto& lines = std::get<SceneSource>(sweep.source);
  Modelling chosen = modelling(request, lines, quiet);
  if (chosen.rung) {  // what --precision and --tolerance do not say
    const SetOptions asked = options;
    model_on(*chosen.rung, lines, options);
    if (!request.shared.solve.precision.empty()) options.precision = asked.precision;
    if (request.shared.solve.tolerance) options.tolerance = asked.tolerance;
  }
  if (options.patch && tactels_at_ends(lines) && !quiet) fmt::print(stderr, "note: {}\n", tactels_at_ends_text);
  return chosen;
}

/// "tables of free sides take about 3 min, for 200 sensors" where they take a second or more.
std::string tables_of_sides(const PadSource& source) {
  double seconds = 0;
  for (const fem::PadSensor& sensor : source.sensors())
    seconds += fem::seconds_for_sides(sensor, fem::SideBricks::usual);
  return seconds < 1 ? ""
                     : fmt::format("tables of free sides take about {}, for {} sensors", duration_text(seconds),
                                   source.sensors().size());
}

int run_generate(const GenerateRequest& request) {
  Sweep sweep = read_sweep(request.sweep);
  const ContactSource& contacts = sweep.contacts();
  ProductionOptions options = production_options(request);
  std::optional<Interrupt> interrupt;  // outlives ranks: a process that is done waits in MPI_Finalize for the others
  Ranks ranks;
  const auto [rung, accurate] = modelling(request, sweep, options.set, request.shared.quiet || !ranks.first());
  if (ranks.first() && !request.shared.quiet)
    for (const std::string& warning : unit_warnings(sweep.source)) print_warning(warning);
  SetColumns columns = columns_of(sweep.source);
  if (!request.columns.empty()) columns = only_columns(columns, request.columns);
  const SetRecipe recipe = recipe_of(sweep, rung, options.set, request.columns, request.compress);
  const bool complete = ranks.first() && already_there(request, recipe);
  if (ranks.sum({complete ? 1.0 : 0.0})[0] > 0) {  // all processes must agree
    if (complete && !request.shared.quiet) fmt::print("{}: complete already\n", request.output);
    return done;
  }
  if (ranks.first()) check_writable("--output", request.output);
  for (const std::string& device : options.devices) Device{device};  // without one nothing is begun
  interrupt.emplace();                                               // before there is anything to keep
  const std::uint64_t chunks = chunk_count(sweep.source);
  std::optional<SetSpool> spool;
  if (ranks.first()) {
    if (request.force) SetSpool::discard(request.output);
    check_room(request, expected_bytes(sweep.source, columns));
    spool.emplace(request.output, recipe.text(), columns, chunks,
                  request.resume ? SetSpool::Open::resume : SetSpool::Open::fresh);
  }
  const std::vector<double> found = ranks.sum(spool ? spool->found() : std::vector<double>(chunks));
  if (!ranks.first()) spool.emplace(request.output, recipe.text(), columns, chunks, SetSpool::Open::join, ranks.rank());
  if (ranks.first() && !request.shared.quiet && request.resume)
    fmt::print("{} of {} chunks exist{}\n", chunks - missing_chunks(found).size(), chunks,
               spool->torn() ? "; torn ones are generated again" : "");

  if (const auto* pads = std::get_if<PadSource>(&sweep.source); pads && ranks.first() && !request.shared.quiet)
    if (const std::string text = tables_of_sides(*pads); !text.empty()) fmt::print(stderr, "note: {}\n", text);
  ProgressLine line("contacts", "contacts", request.shared.quiet || !ranks.first());
  options.progress = [&](std::size_t answered, std::size_t all) {
    line.show(answered, all);
    const bool asked = interrupt->requested();
    if (asked) spool->stop();
    return !asked && !spool->stopped();
  };
  const ProductionReport report =
      produce_set(sweep.source, *spool, missing_chunks(found, ranks.rank(), ranks.count()), options);
  line.clear();
  if (!ranks.first()) spool->flush();  // the first process reads the chunks of all
  const auto work = ranks.sum(Work{.contacts = static_cast<double>(report.contacts),
                                   .steps = static_cast<double>(report.steps),
                                   .kernel = report.kernel_seconds,
                                   .bytes = static_cast<double>(spool->bytes()),
                                   .stages = report.stages,
                                   .write_seconds = report.write_seconds,
                                   .unfinished = report.finished ? 0.0 : 1.0});
  if (work.unfinished > 0) {
    if (ranks.first())
      fmt::print(stderr, "stopped; complete chunks are kept in {}: the same command with --resume continues\n",
                 SetSpool::folder(request.output).string());
    return interrupted;
  }
  if (!ranks.first()) return done;
  const auto start = Clock::now();
  ContactSet set(columns);
  set.sweep = sweep.text;
  set.plan = recipe.conditions;
  set.contacts = contacts.contacts();
  set.seed = contacts.seed();
  set.press_rows = contacts.press_rows();
  set.indenter_names = contacts.kind_names();
  set.transducer = nn::description(contacts.transducer());
  set.device = fmt::format("{}", fmt::join(report.devices, ", "));
  set.rung = model_text(sweep.source, rung, options.set, request.shared.solve.accuracy);
  {
    const StageLine stage("assembling " + request.output, request.shared.quiet);
    spool->assemble(set, request.compress);
  }
  const double seconds = seconds_since(start);
  if (!request.shared.quiet) {
    warn_of_depth(set.too_deep, contacts.contacts());
    fmt::print("{}", report_text(request, set, work, spool->rows(), report.seconds, seconds));
  }
  return set.unsolved == 0 && accurate ? done : not_converged;
}

}  // namespace

void add_generate_command(CLI::App& app, Action& action) {
  const auto [command, request] =
      add_command(app, action, "Simulate", "generate", "simulate a set of many contacts, as HDF5", run_generate);
  add_option(command, "sweep", request.sweep, "sweep file (TOML; mm, MPa)", {.type = "SWEEP.toml"})->required();
  add_option(command, "--output", request.output, "the set to write", {.type = "SET.h5"})->required();
  add_option(command, "--force", request.force, "overwrite an existing file, discard an interrupted run");
  add_option(command, "--resume", request.resume, "resume an interrupted run")->excludes("--force");
  add_option(command, "--columns", request.columns, "datasets of the set; all by default (docs/sets.md)",
             {.type = "NAME,NAME,..."});
  add_option(command, "--compress", request.compress, "compress the set with gzip: smaller, slower");
  add_option(command, "--also-device", request.devices, "one more device to share the work (repeatable)",
             {.type = "NAME|INDEX"})
      ->allow_extra_args();
  add_shared_options(command, request.shared, "fp32, or the rung's with --rung or --accuracy");
}

}  // namespace tactel::host
