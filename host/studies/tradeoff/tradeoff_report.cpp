// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "host/figures/page.h"
#include "host/studies/tradeoff/tradeoff.h"

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

Json rung_json(const PadRung& rung) {
  return {{"name", rung.name}, {"cells", rung.cells}, {"increments", rung.increments}};
}

const std::string& name_of(const MeasuredModel& model) {
  return std::visit([](const auto& rung) -> const std::string& { return rung.name; }, model.rung);
}

std::string words_of(const MeasuredModel& model) {
  return std::visit([](const auto& rung) { return description(rung); }, model.rung);
}

Json model_json(const MeasuredModel& model) {
  Json error;
  for (std::size_t k = 0; k < error_members.size(); ++k)
    error[error_names[k]] = {{"median", model.error.median.*error_members[k]},
                             {"most95", model.error.most95.*error_members[k]},
                             {"largest", model.error.largest.*error_members[k]}};
  Json out = {{"model", std::visit([](const auto& rung) { return rung_json(rung); }, model.rung)},
              {"error", std::move(error)},
              {"unsolved", model.unsolved}};
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

std::string short_name(const MeasuredModel& model) { return name_of(model).empty() ? words_of(model) : name_of(model); }

std::string model_name(const MeasuredModel& model) {
  const std::string name = name_of(model).empty() ? "" : name_of(model) + ": ";
  return name + words_of(model) + (model.front ? " *" : "");
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
  series.names.push_back(name_of(model));
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
    return fmt::format("{} ({} load steps/s, error in S {:.2g})", short_name(m), speed_text(m.steps_per_second),
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
    if (name_of(m) == "paper") page.finding(Tone::fact, "the paper", "Its mesh: " + text(m) + ".");
  page.verdict(fastest
                   ? fmt::format("An error in S below 0.05 for 95 % of the contacts is had at {} load steps a second, "
                                 "on {}.",
                                 speed_text(fastest->steps_per_second), short_name(*fastest))
                   : std::string("No timed model has an error in S below 0.05 for 95 % of the contacts."));
}

}  // namespace

Json to_json(const Tradeoff& tradeoff) {
  Json models = Json::array();
  for (const MeasuredModel& model : tradeoff.models) models.push_back(model_json(model));
  return {{"tactel", TACTEL_VERSION},   {"device", tradeoff.device}, {"scenes", tradeoff.scenes},
          {"seed", tradeoff.seed},      {"mix", tradeoff.mix},       {"definitions", tradeoff.definitions},
          {"models", std::move(models)}};
}

Figure tradeoff_figure(const Tradeoff& tradeoff) {
  Series patches{.label = "patches", .mark = Mark::line_dots, .ink = Ink::blue};
  Series meshes{.label = "meshes", .mark = Mark::line_dots, .ink = Ink::orange};
  Series paper{.label = "the paper's mesh", .mark = Mark::diamonds, .ink = Ink::red};
  Series others{.label = "other meshes", .mark = Mark::circles, .ink = Ink::grey};
  Series pads{.label = "pads", .mark = Mark::line_dots, .ink = Ink::blue};
  for (const MeasuredModel& model : by_speed(tradeoff.models)) {
    const Rung* rung = std::get_if<Rung>(&model.rung);
    if (std::visit([](const auto& of) { return of.exact; }, model.rung)) continue;
    add_point(!rung                   ? pads
              : rung->patch()         ? patches
              : rung->name == "paper" ? paper
              : rung->name.empty()    ? others
                                      : meshes,
              model);
  }
  Panel panel{.x_label = "load steps per second",
              .y_label = "error in S, 95 % of the scenes",
              .series = {others, meshes, paper, patches, pads},
              .log_x = true,
              .log_y = true};
  std::erase_if(panel.series, [](const Series& series) { return series.x.empty(); });
  return {.title = "Cost of accuracy", .panels = {panel}, .width = 820, .panel_height = 420};
}

std::string tradeoff_page(const Tradeoff& tradeoff) {
  Page page("tactel: speed against accuracy", "tactel " TACTEL_VERSION " on " + tradeoff.device);
  report_tradeoff_verdict(page, tradeoff);
  page.section("The ladder");
  page.paragraph(tradeoff.mix + ". " + tradeoff.definitions);
  page.figure(tradeoff_figure(tradeoff), "95 % of the scenes have an error in S below the mark.");
  PageTable table{.caption = "Models, named rungs first; * nothing faster is better", .head = head};
  for (const MeasuredModel& model : tradeoff.models) table.add(model_row(model));
  page.table(table);
  page.note(fmt::format(
      "The judge is the rung `reference`. Its own error in S, by extrapolation from a coarser one, is below "
      "{:.2g} for 95 % of such scenes: smaller errors in the table mean little.",
      tradeoff.judge_error));
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
  return out + fmt::format("\nreference: own error in S below {:.2g} (95 %)\n", tradeoff.judge_error);
}

}  // namespace tactel::host
