#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "host/figures/plot.h"

namespace tactel::host {

inline constexpr int figure_width = 900;  ///< pixels, of a figure across a report page

/// A table of texts. Columns with numbers in every row are aligned right.
struct ReportTable {
  std::string caption;
  std::vector<std::string> head{};
  std::vector<std::vector<std::string>> rows{};  ///< each as long as head
};

/// One measured number beside the paper's.
struct Comparison {
  std::string name;
  double measured = 0, paper = 0;
};
/// Returns a table: name | measured | paper | difference (percent of the number of the paper).
ReportTable comparison_table(const std::string& caption, const std::string& name_head,
                             const std::vector<Comparison>& rows, int digits);

/// A report as one self-contained HTML file: inline style, inline SVG. All text is escaped.
class ReportPage {
 public:
  ReportPage(std::string title, std::string subtitle);
  /// Begins a section. Sections are listed at the top of the page.
  void section(const std::string& title);
  void paragraph(const std::string& text);
  /// Adds a highlighted remark: a limit, a caveat.
  void note(const std::string& text);
  void table(const ReportTable& table);
  void figure(const Figure& figure, const std::string& caption);
  std::string html() const;

 private:
  std::string title_, subtitle_, body_;
  std::vector<std::string> sections_;
  int figures_ = 0, tables_ = 0;
};

/// Returns text with & < > " ' written as HTML entities.
std::string escaped(const std::string& text);

}  // namespace tactel::host
