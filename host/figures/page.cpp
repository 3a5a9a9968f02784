// SPDX-License-Identifier: Apache-2.0
#include "host/figures/page.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "host/figures/contact_view.h"
#include "host/figures/page_files.h"

namespace tactel::host {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::array tone_names{"", "good", "fair", "poor", "fact"};

const char* name(Tone tone) { return tone_names[static_cast<std::size_t>(tone)]; }

/// Escaped text in which the indices of stresses and displacements stand low, and `names` between backticks
/// look like code.
std::string rich(const std::string& text) {
  std::string out = escaped(text);
  for (const auto& [plain, low] :
       {std::pair("σ_y", "σ<sub>y</sub>"), std::pair("σ_z", "σ<sub>z</sub>"), std::pair("τ_xy", "τ<sub>xy</sub>"),
        std::pair("u_x", "u<sub>x</sub>"), std::pair("u_y", "u<sub>y</sub>"), std::pair("θ_L", "θ<sub>L</sub>")}) {
    for (std::size_t at = out.find(plain); at != std::string::npos; at = out.find(plain, at))
      out.replace(at, std::string_view(plain).size(), low);
  }
  for (std::size_t from = out.find('`'); from != std::string::npos; from = out.find('`', from)) {
    const std::size_t to = out.find('`', from + 1);
    if (to == std::string::npos) break;
    out.replace(to, 1, "</code>").replace(from, 1, "<code>");
  }
  return out;
}

bool is_number(const std::string& text) {
  if (text.empty() || text == "-") return true;
  char* end = nullptr;
  std::strtod(text.c_str(), &end);
  const std::string rest = end;
  return end != text.c_str() &&
         (rest.empty() || rest == " %" || rest == "%" || rest == " k" || rest == " M" || rest.starts_with(" ["));
}

/// Most of its cells are numbers; a remark in between does not change that.
bool numeric_column(const PageTable& table, std::size_t column) {
  const auto numbers = std::ranges::count_if(
      table.rows, [&](const Row& row) { return column < row.cells.size() && is_number(row.cells[column].text); });
  return 2 * static_cast<std::size_t>(numbers) > table.rows.size();
}

/// "0.034 [0.031, 0.039]" may be parted before its range alone.
std::string kept_together(const std::string& html) {
  std::string out;
  bool range = false;
  for (const char c : html) {
    range = range ? c != ']' : c == '[';
    range&& c == ' ' ? out += "&nbsp;" : out += c;
  }
  return out;
}

std::string cell_html(const std::string& tag, const Cell& cell, bool numeric) {
  constexpr std::size_t short_cell = 24;  // letters that stay on one line
  std::string classes = numeric ? "number" : "";
  if (tag == "td" && cell.text.size() <= short_cell && cell.text.find(" [") == std::string::npos) classes += " short";
  if (cell.tone != Tone::plain) classes += std::string(" ") + name(cell.tone);
  return fmt::format("<{0} class=\"{1}\">{2}</{0}>", tag, classes, kept_together(rich(cell.text)));
}

std::string row_html(const PageTable& table, const Row& row) {
  std::string out = row.aside ? "<tr class=\"aside\">" : "<tr>";
  for (std::size_t i = 0; i < row.cells.size(); ++i) out += cell_html("td", row.cells[i], numeric_column(table, i));
  return out + "</tr>\n";
}

std::string head_html(const PageTable& table) {
  std::string out = "<tr>";
  for (std::size_t i = 0; i < table.head.size(); ++i) out += cell_html("th", table.head[i], numeric_column(table, i));
  return out + "</tr>";
}

std::string verdict_html(const std::string& headline, const std::vector<Finding>& findings) {
  if (headline.empty() && findings.empty()) return "";
  std::string out = fmt::format("<section class=\"verdict\" aria-label=\"verdict\"><p>{}</p>\n<ul>\n", rich(headline));
  for (const Finding& finding : findings)
    out += fmt::format("<li><span class=\"tone {}\">{}</span><span>{}</span></li>\n", name(finding.tone),
                       escaped(finding.label), rich(finding.text));
  return out + "</ul></section>\n";
}

// ---- figures

constexpr int page_digits = 6;  ///< more than a picture shows; they keep the page small

Json range_json(const std::optional<std::pair<double, double>>& range) {
  return range ? rounded(std::array{range->first, range->second}, page_digits) : Json();
}

const char* name(Mark mark) {
  constexpr const char* names[] = {"line",    "thin",     "dashed",    "long_dashes",    "dots", "circles", "triangles",
                                   "crosses", "diamonds", "line_dots", "dash_triangles", "bars", "band",    "whiskers"};
  return names[static_cast<std::size_t>(mark)];
}
const char* name(Ink ink) {
  constexpr const char* names[] = {"blue", "orange", "green", "purple", "red", "brown", "grey", "black"};
  return names[static_cast<std::size_t>(ink)];
}

Json to_json(const Series& series) {
  return {{"label", series.label},
          {"mark", name(series.mark)},
          {"ink", name(series.ink)},
          {"x", rounded(series.x, page_digits)},
          {"y", rounded(series.y, page_digits)},
          {"low", rounded(series.low, page_digits)},
          {"high", rounded(series.high, page_digits)},
          {"names", series.names}};
}

Json to_json(const Raster& raster) {
  return {{"rows", raster.rows},
          {"columns", raster.columns},
          {"values", rounded(raster.values, 4)},
          {"x_range", range_json(raster.x_range)},
          {"y_range", range_json(raster.y_range)},
          {"unit", raster.unit},
          {"palette", raster.palette == Palette::diverging ? "diverging" : "sequential"},
          {"limits", range_json(raster.limits)},
          {"isolines", raster.isolines}};
}

Json to_json(const Panel& panel) {
  Json series = Json::array(), ticks = Json::array();
  for (const Series& s : panel.series) series.push_back(to_json(s));
  for (const auto& [place, text] : panel.x_ticks) ticks.push_back({place, text});
  Json out = {{"title", panel.title},
              {"x_label", panel.x_label},
              {"y_label", panel.y_label},
              {"series", std::move(series)},
              {"x_range", range_json(panel.x_range)},
              {"y_range", range_json(panel.y_range)},
              {"x_ticks", panel.x_ticks.empty() ? Json() : std::move(ticks)},
              {"log_x", panel.log_x},
              {"log_y", panel.log_y},
              {"zero_line", panel.zero_line}};
  if (panel.raster) out["raster"] = to_json(*panel.raster);
  return out;
}

}  // namespace

nlohmann::ordered_json to_json(const Figure& figure) {
  Json panels = Json::array();
  for (const Panel& panel : figure.panels) panels.push_back(to_json(panel));
  return {{"columns", std::max(1, figure.columns)}, {"height", figure.panel_height}, {"panels", std::move(panels)}};
}

std::string escaped(const std::string& text) {
  constexpr std::string_view marks = "&<>\"'";
  constexpr std::array entities{"&amp;", "&lt;", "&gt;", "&quot;", "&#39;"};
  std::string out;
  for (const char c : text) {
    const std::size_t mark = marks.find(c);
    mark < marks.size() ? out += entities[mark] : out += c;
  }
  return out;
}

Cell difference_cell(double measured, double reference, bool lower_is_better) {
  constexpr double close = 10, far = 50;  // percent
  if (reference == 0 || !std::isfinite(measured)) return {"-"};
  const double percent = 100 * (measured - reference) / std::abs(reference);
  const double off = lower_is_better ? percent : std::abs(percent);
  const std::string text =
      std::abs(percent) < 1000 ? fmt::format("{:+.1f} %", percent) : fmt::format("{:.0f} times", measured / reference);
  return {text, off <= close ? Tone::good : off <= far ? Tone::fair : Tone::poor};
}

Page::Page(std::string title, std::string subtitle) : title_(std::move(title)), subtitle_(std::move(subtitle)) {}

void Page::verdict(const std::string& sentence) { headline_ += (headline_.empty() ? "" : " ") + sentence; }

void Page::finding(Tone tone, std::string label, std::string text) {
  findings_.push_back({tone, std::move(label), std::move(text)});
}

void Page::section(const std::string& title) {
  sections_.push_back(title);
  body_ += fmt::format("<h2 id=\"section-{}\">{}</h2>\n", sections_.size(), escaped(title));
}

void Page::paragraph(const std::string& text) { body_ += "<p>" + rich(text) + "</p>\n"; }

void Page::note(const std::string& text) { body_ += "<p class=\"note\">" + rich(text) + "</p>\n"; }

void Page::table(const PageTable& table) {
  constexpr std::size_t long_table = 16;  // rows that may be parted on paper
  constexpr std::size_t wide_table = 8;   // columns that stand close
  ++tables_;
  std::string classes = table.rows.size() > long_table ? "long" : "";
  if (table.head.size() > wide_table) classes += " wide";
  body_ += fmt::format(
      "<figure id=\"table-{0}\" data-kind=\"table\" class=\"{1}\">\n<figcaption><b>Table {0}.</b> "
      "{2}</figcaption>\n<div class=\"scroll\"><table>\n<thead>{3}</thead>\n<tbody>\n",
      tables_, classes, rich(table.caption), head_html(table));
  for (const Row& row : table.rows) body_ += row_html(table, row);
  body_ += "</tbody></table></div><div class=\"tools\"></div></figure>\n";
}

void Page::drawing(const char* kind, const nlohmann::ordered_json& data, const std::string& caption) {
  ++figures_;
  body_ += fmt::format(
      "<figure id=\"figure-{0}\" data-kind=\"{1}\"><div class=\"drawing\"></div>\n"
      "<noscript><p>This figure is drawn by a script, which is switched off.</p></noscript>\n"
      "<script type=\"application/json\">{2}</script>\n<figcaption><b>Figure {0}.</b> {3}</figcaption><div "
      "class=\"tools\"></div></figure>\n",
      figures_, kind, script_json(data), rich(caption));
}

void Page::figure(const Figure& figure, const std::string& caption) { drawing("chart", to_json(figure), caption); }

void Page::contact(const fem::Scene& scene, const fem::ContactSolution& solution, std::size_t shown,
                   const std::string& about) {
  const ContactView view = contact_view(scene, solution, shown);
  drawing("contact", view.data, view.caption + (about.empty() ? "" : " " + about));
}
void Page::contact(const fem::PadScene& scene, const fem::PadSolution& solution, std::size_t shown,
                   const std::string& about) {
  const ContactView view = contact_view(scene, solution, shown);
  drawing("pad", view.data, view.caption + (about.empty() ? "" : " " + about));
}

std::string script_json(const nlohmann::ordered_json& data) {
  const std::string text = data.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
  std::string out;
  for (const char c : text) c == '<' ? out += "\\u003c" : out += c;
  return out;
}

std::string page_style() { return std::string(page_files::sources().front().text); }

namespace {

/// The files of a script in their order, without those that `wanted` does not take.
template <class Wanted>
std::string script_of(const Wanted& wanted) {
  std::string out = "\"use strict\";\n(() => {\n";
  for (const page_files::Source& source : page_files::sources().subspan(1))
    if (wanted(source.name)) out += source.text;
  return out + "})();\n";
}

}  // namespace

std::string page_script() {
  return script_of([](std::string_view name) { return name != "live.js"; });
}

std::string live_script() {
  return script_of(
      [](std::string_view name) { return name != "contact.js" && name != "pad.js" && name != "start.js"; });
}

std::string page_html(const std::string& title, const std::string& body, const std::string& script,
                      const std::string& main) {
  return fmt::format(
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" "
      "content=\"width=device-width, initial-scale=1\">\n<meta name=\"color-scheme\" content=\"light dark\">\n"
      "<link rel=\"icon\" href=\"data:,\">\n<title>{0}</title>\n<style>\n{1}</style>\n</head>\n<body><main{2}>\n"
      "{3}</main>\n<script>\n{4}</script>\n</body>\n</html>\n",
      escaped(title), page_style(), main, body, script);
}

std::string Page::html() const {
  std::string items;
  for (std::size_t i = 0; i < sections_.size(); ++i)
    items += fmt::format("<li><a href=\"#section-{}\">{}</a></li>\n", i + 1, escaped(sections_[i]));
  const bool listed = sections_.size() > 1;
  const std::string contents = "<nav aria-label=\"sections\"><details open><summary>Contents</summary><ol>\n" + items +
                               "</ol></details></nav>\n";
  return page_html(title_,
                   fmt::format("<h1>{}</h1>\n<p class=\"subtitle\">{}</p>\n{}{}{}", escaped(title_), escaped(subtitle_),
                               listed ? contents : "", verdict_html(headline_, findings_), body_),
                   page_script(), listed ? " class=\"listed\"" : "");
}

namespace {

std::string pad_html(std::size_t k) {
  return fmt::format("<div><p class=\"pad-name\" id=\"name-{0}\"></p><div id=\"pad-{0}\"></div></div>\n", k);
}

}  // namespace

std::string html(const LivePage& page) {
  nlohmann::ordered_json setup{{"signal", page.signal}, {"bound", page.bound}, {"alarm", nullptr}};
  if (std::isfinite(page.alarm)) setup["alarm"] = page.alarm;
  std::string pads;
  for (const LivePage::Pad& pad : page.pads) {
    nlohmann::ordered_json one{{"name", pad.name}, {"tactels", nullptr}, {"pitch", pad.pitch}};
    if (pad.tactels[0] > 0) one["tactels"] = pad.tactels;
    setup["pads"].push_back(std::move(one));
    pads += pad_html(setup["pads"].size() - 1);
  }
  return page_html(
      "tactel: " + page.source,
      fmt::format(
          "<h1>tactel monitor</h1>\n<p class=\"subtitle\">{}</p>\n<p class=\"state fact\" id=\"state\"><b>waiting</b> "
          "<span>for the first frame</span></p>\n<div class=\"live\"><figure><div class=\"readout\" "
          "id=\"readout\"></div>"
          "<div class=\"legend\" id=\"key\"></div><div id=\"history\"></div><div id=\"truth\"></div></figure>\n"
          "<figure><div class=\"live-pads\">{}</div><div class=\"legend\" id=\"scale\"></div></figure></div>\n"
          "<div id=\"drift\"></div>\n<script type=\"application/json\" id=\"setup\">{}</script>\n",
          escaped(page.source), pads, script_json(setup)),
      live_script());
}

}  // namespace tactel::host
