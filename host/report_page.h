#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "host/plot.h"

namespace tactel::host {

/// A table of texts; columns that hold numbers in every row are set right.
struct ReportTable {
  std::string caption;
  std::vector<std::string> head{};
  std::vector<std::vector<std::string>> rows{};  ///< each as long as head
};

/// One figure of ours beside the paper's.
struct Comparison {
  std::string name;
  double measured = 0, paper = 0;
};
/// name | measured | paper | difference (percent of the paper's figure).
ReportTable comparison_table(const std::string& caption, const std::string& name_head,
                             const std::vector<Comparison>& rows, int digits);

/// A report as one HTML file that needs nothing beside it: inline style, inline SVG. All text is escaped.
class ReportPage {
 public:
  ReportPage(std::string title, std::string subtitle);
  /// Sections are listed at the top of the page.
  void section(const std::string& title);
  void paragraph(const std::string& text);
  /// A remark set apart: a limit, a caveat.
  void note(const std::string& text);
  void table(const ReportTable& table);
  void figure(const Figure& figure, const std::string& caption);
  std::string html() const;

 private:
  std::string title_, subtitle_, body_;
  std::vector<std::string> sections_;
  int figures_ = 0, tables_ = 0;
};

/// Text with & < > " ' written as HTML entities.
std::string escaped(const std::string& text);

}  // namespace tactel::host
