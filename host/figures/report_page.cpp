#include "host/figures/report_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace tactel::host {
namespace {

constexpr const char* style_sheet = R"(
:root { color-scheme: light; }
body { font: 16px/1.55 system-ui, "DejaVu Sans", Verdana, sans-serif; color: #15191e; background: #f4f5f7; margin: 0; }
main { max-width: 920px; margin: 0 auto; padding: 2.5rem 2rem 4rem; background: #fff; min-height: 100vh; }
h1 { font-size: 1.9rem; line-height: 1.2; margin: 0 0 .3rem; }
h2 { font-size: 1.3rem; margin: 2.6rem 0 .8rem; padding-top: 1rem; border-top: 1px solid #dfe3e7; }
.subtitle { color: #5b636d; margin: 0 0 1.4rem; }
nav ol { padding-left: 1.4rem; columns: 2; } a { color: #1f5fa8; }
table { border-collapse: collapse; margin: .3rem 0 0; font-variant-numeric: tabular-nums; font-size: .94rem; }
figcaption { text-align: left; color: #3a4048; font-size: .92rem; padding: .3rem 0; }
th, td { padding: .32rem .9rem .32rem 0; text-align: left; border-bottom: 1px solid #e6e9ec; vertical-align: top; }
th { border-bottom: 2px solid #7b828c; font-weight: 600; } td.number, th.number { text-align: right; padding-left: .6rem; } .short { white-space: nowrap; }
.wide { overflow-x: auto; } figure { margin: 1.2rem 0 1.8rem; } figure svg { max-width: 100%; height: auto; }
.note { border-left: 4px solid #d9660a; background: #fdf5ee; padding: .6rem 1rem; margin: 1rem 0; }
)";

bool is_number(const std::string& text) {
  if (text.empty() || text == "-") return true;
  char* end = nullptr;
  std::strtod(text.c_str(), &end);
  const std::string rest = end;
  return end != text.c_str() && (rest.empty() || rest == " %" || rest == "%");
}

/// Most of its cells are numbers; a remark in between does not change that.
bool numeric_column(const ReportTable& table, std::size_t column) {
  const auto numbers =
      std::ranges::count_if(table.rows, [&](const auto& row) { return column < row.size() && is_number(row[column]); });
  return 2 * static_cast<std::size_t>(numbers) > table.rows.size();
}

std::string row_html(const ReportTable& table, const std::vector<std::string>& cells, const std::string& tag) {
  constexpr std::size_t short_cell = 20;  // letters that stay on one line
  std::string out = "<tr>";
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const bool together = tag == "td" && cells[i].size() <= short_cell;
    const std::string classes = std::string(numeric_column(table, i) ? "number " : "") + (together ? "short" : "");
    out += fmt::format("<{} class=\"{}\">{}</{}>", tag, classes, escaped(cells[i]), tag);
  }
  return out + "</tr>\n";
}

/// The <svg> element alone, its ids made this figure's own, so that several stand in one page.
std::string inline_svg(std::string svg, int number) {
  const std::size_t start = svg.find("<svg");
  if (start == std::string::npos) throw PlotError("gnuplot's picture holds no <svg>");
  svg.erase(0, start);
  const std::string mine = fmt::format("f{}-", number);
  for (const std::string mark : {"id='", "id=\"", "xlink:href='#", "xlink:href=\"#", "url(#"}) {
    for (std::size_t at = svg.find(mark); at != std::string::npos;
         at = svg.find(mark, at + mark.size() + mine.size())) {
      svg.insert(at + mark.size(), mine);
    }
  }
  return svg;
}

}  // namespace

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

ReportTable comparison_table(const std::string& caption, const std::string& name_head,
                             const std::vector<Comparison>& rows, int digits) {
  ReportTable table{.caption = caption, .head = {name_head, "measured", "paper", "difference"}};
  for (const Comparison& row : rows) {
    const double percent = 100 * (row.measured - row.paper) / std::abs(row.paper);
    const std::string difference =
        row.paper != 0 ? fmt::format("{:+.1f} %", percent) : fmt::format("{:+.{}f}", row.measured, digits);
    table.rows.push_back({row.name, fmt::format("{:.{}f}", row.measured, digits),
                          fmt::format("{:.{}f}", row.paper, digits), difference});
  }
  return table;
}

ReportPage::ReportPage(std::string title, std::string subtitle)
    : title_(std::move(title)), subtitle_(std::move(subtitle)) {}

void ReportPage::section(const std::string& title) {
  sections_.push_back(title);
  body_ += fmt::format("<h2 id=\"section-{}\">{}</h2>\n", sections_.size(), escaped(title));
}

void ReportPage::paragraph(const std::string& text) { body_ += "<p>" + escaped(text) + "</p>\n"; }

void ReportPage::note(const std::string& text) { body_ += "<p class=\"note\">" + escaped(text) + "</p>\n"; }

void ReportPage::table(const ReportTable& table) {
  body_ +=
      fmt::format("<figure class=\"wide\"><figcaption>Table {}. {}</figcaption>\n<table>\n<thead>{}</thead>\n<tbody>\n",
                  ++tables_, escaped(table.caption), row_html(table, table.head, "th"));
  for (const auto& row : table.rows) body_ += row_html(table, row, "td");
  body_ += "</tbody></table></figure>\n";
}

void ReportPage::figure(const Figure& figure, const std::string& caption) {
  ++figures_;
  body_ += fmt::format("<figure>\n{}\n<figcaption>Figure {}. {}</figcaption>\n</figure>\n",
                       inline_svg(render_svg(figure), figures_), figures_, escaped(caption));
}

std::string ReportPage::html() const {
  std::string contents;
  for (std::size_t i = 0; i < sections_.size(); ++i) {
    contents += fmt::format("<li><a href=\"#section-{}\">{}</a></li>\n", i + 1, escaped(sections_[i]));
  }
  return fmt::format(
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" "
      "content=\"width=device-width\">\n"
      "<title>{}</title>\n<style>{}</style>\n</head>\n<body><main>\n<h1>{}</h1>\n<p "
      "class=\"subtitle\">{}</p>\n{}{}</main></body>\n</html>\n",
      escaped(title_), style_sheet, escaped(title_), escaped(subtitle_),
      contents.empty() ? "" : "<nav><ol>\n" + contents + "</ol></nav>\n", body_);
}

}  // namespace tactel::host
