// SPDX-License-Identifier: Apache-2.0
#include "host/studies/tradeoff/tradeoff_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "host/contact/planner.h"
#include "host/figures/page.h"

namespace tactel::host {
namespace {

using Json = nlohmann::ordered_json;

Json rung_json(const Rung& rung) {
  if (rung.patch())
    return {{"name", rung.name},   {"elements", rung.elements},         {"increments", rung.steps},
            {"sides", rung.sides}, {"precision", name(rung.precision)}, {"tolerance", rung.tolerance}};
  return {{"name", rung.name},
          {"columns", rung.columns},
          {"rows", rung.rows},
          {"element", fem::name(rung.element)},
          {"indentation_steps", rung.steps},
          {"precision", name(rung.precision)},
          {"tolerance", rung.tolerance}};
}

Json model_json(const MeasuredModel& model) {
  Json error;
  for (std::size_t k = 0; k < error_members.size(); ++k)
    error[error_names[k]] = {{"median", model.error.median.*error_members[k]},
                             {"most95", model.error.most95.*error_members[k]},
                             {"largest", model.error.largest.*error_members[k]}};
  Json out = {{"model", rung_json(model.rung)}, {"error", std::move(error)}, {"unsolved", model.unsolved}};
  out["sweeps"] = model.sweeps;
  if (model.steps_per_second > 0) {
    out["steps_per_second"] = model.steps_per_second;
    out["front"] = model.front;
  }
  return out;
}

const std::vector<std::string> head = {"model",     "load steps/s", "S, median", "S, 95 %", "S, largest",
                                       "P, median", "P, 95 %",      "Q, median", "Q, 95 %", "σ, median",
                                       "σ, 95 %",   "τ, median",    "τ, 95 %",   "unsolved"};

std::string speed_text(double speed) {
  return speed == 0     ? ""
         : speed >= 1e6 ? fmt::format("{:.2f} M", speed / 1e6)
         : speed >= 1e3 ? fmt::format("{:.3g} k", speed / 1e3)
                        : fmt::format("{:.3g}", speed);
}

std::string model_name(const MeasuredModel& model) {
  const std::string name = model.rung.name.empty() ? "" : model.rung.name + ": ";
  return name + description(model.rung) + (model.front ? " *" : "");
}

std::vector<Cell> model_row(const MeasuredModel& model) {
  std::vector<Cell> row = {model_name(model), speed_text(model.steps_per_second)};
  for (std::size_t k = 0; k < error_members.size(); ++k) {
    row.push_back(fmt::format("{:.2g}", model.error.median.*error_members[k]));
    row.push_back(fmt::format("{:.2g}", model.error.most95.*error_members[k]));
    if (k == 0) row.push_back(fmt::format("{:.2g}", model.error.largest.S));
  }
  row.push_back(model.unsolved == 0 ? "0" : fmt::format("{:.1e}", model.unsolved));
  return row;
}

void add_point(Series& series, const MeasuredModel& model) {
  series.names.push_back(model.rung.name);
  series.x.push_back(model.steps_per_second);
  series.y.push_back(std::max(model.error.most95.S, 1e-6));
}

std::vector<MeasuredModel> by_speed(std::vector<MeasuredModel> models) {
  std::ranges::sort(models, {}, &MeasuredModel::steps_per_second);
  return models;
}

/// For each error in S, the fastest model that 95 % of the scenes keep it on; and what the paper's mesh does.
void report_tradeoff_verdict(Page& page, const Tradeoff& tradeoff) {
  const auto text = [](const MeasuredModel& m) {
    return fmt::format("{} ({} load steps/s, error in S {:.2g})",
                       m.rung.name.empty() ? description(m.rung) : m.rung.name, speed_text(m.steps_per_second),
                       m.error.most95.S);
  };
  const MeasuredModel* fastest = nullptr;
  for (const double accuracy : {0.1, 0.05, 0.02, 0.01}) {
    const MeasuredModel* best = nullptr;
    for (const MeasuredModel& m : tradeoff.models)
      if (m.error.most95.S <= accuracy && m.steps_per_second > (best ? best->steps_per_second : 0)) best = &m;
    if (accuracy == 0.05) fastest = best;
    page.finding(
        best ? Tone::fact : Tone::fair, fmt::format("S to {}", accuracy),
        best ? "Fastest: " + text(*best) + "." : std::string("No timed model keeps it for 95 % of the contacts."));
  }
  for (const MeasuredModel& m : tradeoff.models)
    if (m.rung.name == "paper") page.finding(Tone::fact, "the paper", "Its mesh: " + text(m) + ".");
  page.verdict(fastest
                   ? fmt::format("An error in S below 0.05 for 95 % of the contacts is had at {} load steps a second, "
                                 "on {}.",
                                 speed_text(fastest->steps_per_second),
                                 fastest->rung.name.empty() ? description(fastest->rung) : fastest->rung.name)
                   : std::string("No timed model has an error in S below 0.05 for 95 % of the contacts."));
}

const char* const definitions =
    "Errors are the largest over the load steps that the scene requests: of S itself; of P and Q over the path's "
    "largest; "
    "of σ_y and τ_xy at any tactel over the largest at any of them along the path. The two tactels at the very ends "
    "are excluded: there the bonded base meets the free side and the exact stress is infinite. Median and 95 % are "
    "over the "
    "scenes. Speed counts requested load steps; finer increments therefore reduce it.";

}  // namespace

Json to_json(const Tradeoff& tradeoff) {
  Json models = Json::array();
  for (const MeasuredModel& model : tradeoff.models) models.push_back(model_json(model));
  return {{"tactel", TACTEL_VERSION},   {"device", tradeoff.device}, {"scenes", tradeoff.scenes},
          {"seed", tradeoff.seed},      {"mix", tradeoff.mix},       {"definitions", definitions},
          {"models", std::move(models)}};
}

Figure tradeoff_figure(const Tradeoff& tradeoff) {
  Series patches{.label = "patches", .mark = Mark::line_dots, .ink = Ink::blue};
  Series meshes{.label = "meshes", .mark = Mark::line_dots, .ink = Ink::orange};
  Series paper{.label = "the paper's mesh", .mark = Mark::diamonds, .ink = Ink::red};
  Series others{.label = "other meshes", .mark = Mark::circles, .ink = Ink::grey};
  for (const MeasuredModel& model : by_speed(tradeoff.models)) {
    const Rung& rung = model.rung;
    if (rung.exact) continue;
    add_point(rung.patch() ? patches : rung.name == "paper" ? paper : rung.name.empty() ? others : meshes, model);
  }
  Panel panel{.x_label = "load steps per second",
              .y_label = "error in S, 95 % of the scenes",
              .series = {others, meshes, paper, patches},
              .log_x = true,
              .log_y = true};
  return {.title = "Cost of accuracy", .panels = {panel}, .width = 820, .panel_height = 420};
}

std::string tradeoff_page(const Tradeoff& tradeoff) {
  Page page("tactel: speed against accuracy", "tactel " TACTEL_VERSION " on " + tradeoff.device);
  report_tradeoff_verdict(page, tradeoff);
  page.section("The ladder");
  page.paragraph(tradeoff.mix + ". " + definitions);
  page.figure(tradeoff_figure(tradeoff), "95 % of the scenes have an error in S below the mark.");
  PageTable table{.caption = "Models, named rungs first; * nothing faster is better", .head = head};
  for (const MeasuredModel& model : tradeoff.models) table.add(model_row(model));
  page.table(table);
  page.note(fmt::format(
      "The judge is the rung `reference`. Its own error in S, by extrapolation from fewer elements, is below "
      "{:.2g} for 95 % of such scenes: smaller errors in the table mean little.",
      measured_ladder().back().most));
  return page.html();
}

std::string tradeoff_table(const Tradeoff& tradeoff) {
  std::string out = tradeoff.mix + "\n\n";
  out += fmt::format("{:<42} {:>8} | {:^23} | {:^15} | {:^15} | {:^15} | {:^15}\n", "", "steps/s",
                     "S: median, 95 %, largest", "P: median, 95 %", "Q", "sigma", "tau");
  for (const MeasuredModel& model : tradeoff.models) {
    out += fmt::format("{:<42} {:>8}", model_name(model), speed_text(model.steps_per_second));
    for (std::size_t k = 0; k < error_members.size(); ++k) {
      out +=
          fmt::format(" | {:7.2g} {:7.2g}", model.error.median.*error_members[k], model.error.most95.*error_members[k]);
      if (k == 0) out += fmt::format(" {:7.2g}", model.error.largest.S);
    }
    out += "\n";
  }
  return out + fmt::format("\nreference: own error in S below {:.2g} (95 %)\n", measured_ladder().back().most);
}

}  // namespace tactel::host
