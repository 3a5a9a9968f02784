// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <limits>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "fem/gap/contact_solution.h"
#include "fem/pad/pad_solver.h"
#include "fem/scenes/scene.h"
#include "host/figures/plot.h"

namespace tactel::host {

/// How a finding or a cell is to be taken. Colour never stands alone: a finding has a label, a cell its number.
enum class Tone { plain, good, fair, poor, fact };

/// A line of the verdict: "good" | "as close as the paper" | text.
struct Finding {
  Tone tone = Tone::fact;
  std::string label, text;
};

/// A cell of a table.
struct Cell {
  std::string text;
  Tone tone = Tone::plain;
  Cell(std::string text, Tone tone = Tone::plain) : text(std::move(text)), tone(tone) {}
  Cell(const char* text) : text(text) {}
};

/// A row of a table; `aside` rows are printed fainter, such as the numbers of the paper below the measured ones.
struct Row {
  std::vector<Cell> cells;
  bool aside = false;
};

/// A table of texts. Columns with numbers in most rows are aligned right.
struct PageTable {
  std::string caption;
  std::vector<std::string> head{};
  std::vector<Row> rows{};  ///< each as long as head
  void add(std::vector<Cell> cells, bool aside = false) { rows.push_back({std::move(cells), aside}); }
};

/// Returns "+12.3 %" of `reference`, with a tone: good within 10 %, poor beyond 50 %. Where `lower_is_better`, less
/// than the reference is good.
Cell difference_cell(double measured, double reference, bool lower_is_better = false);

/// Largest size of a page, bytes: it can be sent by mail and opens at once.
inline constexpr std::size_t largest_page = 500'000;

/// A page of findings, texts, tables, charts and contacts as one self-contained HTML file: style, script and data are
/// inside, nothing is requested. It is drawn in light and dark colours, down to 390 pixels and on paper. Text is
/// escaped. The script (host/figures/page/) draws figures from the embedded data and saves them as CSV.
class Page {
 public:
  Page(std::string title, std::string subtitle);
  /// Adds a sentence to the verdict at the top of the page.
  void verdict(const std::string& sentence);
  /// Adds a line below that sentence.
  void finding(Tone tone, std::string label, std::string text);
  /// Begins a section. Sections are listed at the top of the page.
  void section(const std::string& title);
  void paragraph(const std::string& text);
  /// Adds a highlighted remark: a limit, a caveat.
  void note(const std::string& text);
  void table(const PageTable& table);
  void figure(const Figure& figure, const std::string& caption);
  /// Adds a solved contact with a slider over its load steps, the step `shown` first. `about` is added to the caption.
  void contact(const fem::Scene& scene, const fem::ContactSolution& solution, std::size_t shown,
               const std::string& about = "");
  void contact(const fem::PadScene& scene, const fem::PadSolution& solution, std::size_t shown,
               const std::string& about = "");
  std::string html() const;

 private:
  void drawing(const char* kind, const nlohmann::ordered_json& data, const std::string& caption);

  std::string title_, subtitle_, headline_, body_;
  std::vector<Finding> findings_;
  std::vector<std::string> sections_;
  int figures_ = 0, tables_ = 0;
};

/// Returns text with & < > " ' written as HTML entities.
std::string escaped(const std::string& text);

/// Returns a figure as the script takes it; numbers have six digits, of rasters four, NaN is null.
nlohmann::ordered_json to_json(const Figure& figure);

/// Returns the style of pages, the script of reports, and that of live frames (host/figures/page/).
std::string page_style();
std::string page_script();
std::string live_script();

/// Returns a whole page around what its <main> holds. main: attributes of that, with a space in front.
std::string page_html(const std::string& title, const std::string& body, const std::string& script,
                      const std::string& main = "");

/// Returns JSON that may stand inside a <script> element: no "<" ends it. Bytes that are no UTF-8 become U+FFFD.
std::string script_json(const nlohmann::ordered_json& data);

/// What the page of a live sensor shows.
struct LivePage {
  struct Pad {
    std::string name;
    std::array<int, 2> tactels{};       ///< along x and y; 0: a line
    std::array<double, 2> pitch{0, 0};  ///< mm; 0: not told
  };
  std::string source;     ///< what it says of the sensor
  std::vector<Pad> pads;  ///< one or more
  std::string signal;     ///< key of the lines that the alarm judges: "slip_index", "slid" or "moved"
  float alarm = std::numeric_limits<float>::infinity();  ///< from which there is one; infinity: none is asked for
  bool bound = false;                                    ///< the alarm judges the upper bound of S
};

/// Returns a page (host/figures/page/live.js) that listens at "events", beside its own address, to server-sent events:
/// lines of `tactel monitor --stresses`, and one named "end" with a sentence.
std::string html(const LivePage& page);

}  // namespace tactel::host
