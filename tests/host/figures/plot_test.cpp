// Pictures and the report page: what can be told without looking. (How they look was looked at.)
#include "host/figures/plot.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <regex>
#include <set>

#include "host/figures/contact_figure.h"
#include "host/figures/contour.h"
#include "host/figures/field_figure.h"
#include "host/figures/figure_layout.h"
#include "host/figures/gnuplot_script.h"
#include "host/figures/report_page.h"
#include "host/support/errors.h"
#include "tests/host/support/run_tactel.h"

namespace tactel::host {
namespace {

using testing::HasSubstr;
using testing::Not;

Figure line_figure() {
  Figure figure{.title = plain("a_title & {more}")};
  figure.panels = {{.title = "lines", .x_label = "x (mm)", .y_label = "y (MPa)"}};
  figure.panels[0].series = {{.label = "one", .x = {0, 1, 2}, .y = {0, 1, 4}},
                             {.label = "gap", .x = {0, 1, 2}, .y = {1, NAN, 1}, .mark = Mark::circles}};
  return figure;
}

Figure every_mark() {
  Figure figure;
  Panel panel{.title = "marks", .x_ticks = {{1, "net \"1\""}, {2, "net 2"}}, .log_y = true};
  for (int mark = 0; mark <= static_cast<int>(Mark::whiskers); ++mark) {
    const double y = 1.0 + mark;
    panel.series.push_back({.label = "m",
                            .x = {1, 2},
                            .y = {y, y},
                            .mark = static_cast<Mark>(mark),
                            .ink = static_cast<Ink>(mark % 8),
                            .low = {y - 0.5, y - 0.5},
                            .high = {y + 0.5, y + 0.5}});
  }
  Panel raster{.title = "raster"};
  raster.raster = Raster{.rows = 2,
                         .columns = 2,
                         .values = {-1, 0, 1, NAN},
                         .x_range = {0, 2},
                         .y_range = {0, 2},
                         .unit = "MPa",
                         .palette = Palette::diverging};
  figure.panels = {panel, raster};
  figure.columns = 2;
  return figure;
}

TEST(Plot, SvgHoldsTitleAndLabels) {
  const std::string svg = render_svg(line_figure());
  EXPECT_THAT(svg, HasSubstr("<svg"));
  EXPECT_THAT(svg, HasSubstr("a_title &amp; {more}"));
  EXPECT_THAT(svg, HasSubstr("x (mm)"));
  EXPECT_THAT(svg, HasSubstr("y (MPa)"));
}

TEST(Plot, EveryMarkPaletteAndTickIsDrawnWithoutComplaint) {
  EXPECT_THAT(render_svg(every_mark()), HasSubstr("net \"1\""));  // gnuplot's own complaints are a PlotError
}

TEST(Plot, NothingToDrawIsNoCrash) {
  Figure empty;
  empty.panels = {{.title = "empty", .x_range = {{0, 1}}, .y_range = {{0, 1}}}};
  EXPECT_THAT(render_svg(empty), HasSubstr("empty"));
}

TEST(Plot, FileNamesMustEndAsPictures) {
  const ScratchFolder folder;
  EXPECT_THROW(write_figure("--plot", folder / "a.gif", line_figure()), ConfigError);
  write_figure("--plot", folder / "a.svg", line_figure());
  EXPECT_EQ(folder.files(), 1u);
}

TEST(FigureLayout, TicksAreRoundAndFit) {
  EXPECT_DOUBLE_EQ(tick_distance({-10, 10}, 12), 2.0);
  EXPECT_DOUBLE_EQ(tick_distance({0, 0.5}, 6), 0.1);
  EXPECT_DOUBLE_EQ(tick_distance({0.2, 1}, 5), 0.2);
  EXPECT_DOUBLE_EQ(tick_distance({0, 100}, 10), 10.0);  // exactly as many as fit
  EXPECT_EQ(tick_distance({1, 1}, 5), 0.0);
  EXPECT_EQ(tick_distance({INFINITY, -INFINITY}, 5), 0.0);  // nothing drawn
}

TEST(FigureLayout, LegendTakesTheRowsItNeeds) {
  Figure figure = line_figure();
  EXPECT_EQ(legend_rows(figure, figure.panels[0]), 1);
  for (int k = 0; k < 20; ++k) figure.panels[0].series.push_back({.label = "another of many"});
  EXPECT_GT(legend_rows(figure, figure.panels[0]), 2);
  figure.panels[0].series.clear();
  EXPECT_EQ(legend_rows(figure, figure.panels[0]), 0);
}

TEST(Contour, LineOfALinearFieldIsStraight) {
  GridField field{.x = {0, 1, 3}, .y = {0, 2}, .values = {0, 1, 3, 0, 1, 3}};  // f = x
  EXPECT_DOUBLE_EQ(interpolate(field, 2.5, 1.0), 2.5);
  EXPECT_TRUE(std::isnan(interpolate(field, 3.1, 1.0)));
  const ContourLine line = contour_line(field, 2.0);
  ASSERT_EQ(line.x.size(), 3u);  // one piece: two points and a break
  EXPECT_DOUBLE_EQ(line.x[0], 2.0);
  EXPECT_DOUBLE_EQ(line.x[1], 2.0);
  EXPECT_DOUBLE_EQ(std::abs(line.y[0] - line.y[1]), 2.0);
  EXPECT_TRUE(std::isnan(line.x[2]));
}

TEST(Contour, SaddleIsCutByTheMean) {
  // corners 1, 0, 1, 0 counter-clockwise, mean 0.5: below 0.6 the high corners are apart, each cut off by itself
  const GridField field{.x = {0, 1}, .y = {0, 1}, .values = {1, 0, 0, 1}};
  const ContourLine line = contour_line(field, 0.6);
  ASSERT_EQ(line.x.size(), 6u);
  for (std::size_t piece : {0u, 3u}) {
    const double side_0 = line.x[piece] + line.y[piece], side_1 = line.x[piece + 1] + line.y[piece + 1];
    EXPECT_DOUBLE_EQ(side_0, side_1);  // parallel to the diagonal x + y = 1
    EXPECT_TRUE(std::abs(side_0 - 0.4) < 1e-12 || std::abs(side_0 - 1.6) < 1e-12) << side_0;
  }
}

TEST(ContactFigure, TractionIsForceOverTheNodesShare) {
  Eigen::VectorXd x(4), force(4);
  x << 0, 1, 2, 4;
  force << 1, 1, 3, 1;
  EXPECT_EQ(traction(force, x), (std::vector{2.0, 1.0, 2.0, 1.0}));
}

TEST(ReportPage, EscapesWhatIsNotItsOwn) {
  ReportPage page("A < B & \"C\"", "sub");
  page.section("<script>");
  page.paragraph("x > y");
  const std::string html = page.html();
  EXPECT_THAT(html, HasSubstr("<h1>A &lt; B &amp; &quot;C&quot;</h1>"));
  EXPECT_THAT(html, HasSubstr("&lt;script&gt;"));
  EXPECT_THAT(html, Not(HasSubstr("<script")));
  EXPECT_THAT(html, HasSubstr("x &gt; y"));
}

TEST(ReportPage, ComparesWithThePaper) {
  const ReportTable table = comparison_table("c", "u_x", {{"0.075", 5.0, 4.0}, {"0", 1.0, 0.0}}, 2);
  EXPECT_EQ(table.head, (std::vector<std::string>{"u_x", "measured", "paper", "difference"}));
  EXPECT_EQ(table.rows[0], (std::vector<std::string>{"0.075", "5.00", "4.00", "+25.0 %"}));
  EXPECT_EQ(table.rows[1], (std::vector<std::string>{"0", "1.00", "0.00", "+1.00"}));
}

TEST(ReportPage, FiguresShareNoIdAndNeedNothingOutside) {
  ReportPage page("t", "s");
  page.figure(line_figure(), "first");
  page.figure(every_mark(), "second");
  const std::string html = page.html();
  EXPECT_THAT(html, Not(HasSubstr("<?xml")));
  EXPECT_THAT(html, HasSubstr("Figure 2. second"));
  std::set<std::string> ids;
  const std::regex id("\\sid=['\"]([^'\"]+)['\"]"), use("href=['\"]#([^'\"]+)['\"]|url\\(#([^)]+)\\)"),
      outside("(src|href)=['\"]https?:");
  for (std::sregex_iterator at(html.begin(), html.end(), id), end; at != end; ++at)
    EXPECT_TRUE(ids.insert((*at)[1]).second) << (*at)[1];
  for (std::sregex_iterator at(html.begin(), html.end(), use), end; at != end; ++at) {
    EXPECT_TRUE(ids.contains((*at)[1].str() + (*at)[2].str())) << at->str();
  }
  EXPECT_FALSE(std::regex_search(html, outside));
}

}  // namespace
}  // namespace tactel::host
