// SPDX-License-Identifier: Apache-2.0

// Pictures by gnuplot: what can be told without looking. (How they look was looked at.)
#include "host/figures/plot.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <regex>

#include "host/figures/contact_figure.h"
#include "host/figures/figure_layout.h"
#include "host/figures/gnuplot_script.h"
#include "host/support/errors.h"
#include "tests/host/support/run_tactel.h"

namespace tactel::host {
namespace {

using testing::HasSubstr;

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
  figure.panels = {panel};
  return figure;
}

TEST(Plot, SvgHoldsTitleAndLabels) {
  const std::string svg = render_svg(line_figure());
  EXPECT_THAT(svg, HasSubstr("<svg"));
  EXPECT_THAT(svg, HasSubstr("a_title &amp; {more}"));
  EXPECT_THAT(svg, HasSubstr("x (mm)"));
  EXPECT_THAT(svg, HasSubstr("y (MPa)"));
}

TEST(Plot, EveryMarkAndTickIsDrawnWithoutComplaint) {
  EXPECT_THAT(render_svg(every_mark()), HasSubstr("net \"1\""));  // gnuplot's own complaints are a PlotError
}

/// A text in every place that a figure has for one, numbered. [x] series names are for pages.
Figure figure_of(const std::string& text) {
  int place = 0;
  const auto next = [&] { return fmt::format("{}{}", ++place, text); };
  Figure figure{.title = next()};
  Panel panel{.title = next(), .x_label = next(), .y_label = next()};
  panel.x_ticks = {{0, next()}, {1, next()}};
  panel.series = {{.label = next(), .x = {0, 1}, .y = {0, 1}, .names = {text, text}}};
  panel.x_range = {0, 1};
  figure.panels = {panel};
  return figure;
}
constexpr int places = 7;

// gnuplot really runs, with texts that a shell or gnuplot would run if they were not quoted, as markup or escaped.
TEST(Plot, NoTextIsRunAsACommand) {
  const ScratchFolder folder;
  const std::string make = "touch " + (folder / "made").string();
  std::string text;
  for (const char* quote : {"", "'", "\"", "''", "\\'", "\\\"", "%\"", "{'}", "@'", "\n", "\r", "\\\n", "\1"})
    text +=
        fmt::format("{0}`{1}`{0}$({1}){0}; system('{1}'); system(\"{1}\") {0}\n!{1}\n{0}\nsystem '{1}'\n", quote, make);
  text += std::string("\0", 1) + "'\n!" + make + "\n\\";
  for (const std::string& shown : {plain(text), text, "'" + text, "\"" + text, "\\" + text}) {
    const Figure figure = figure_of(shown);
    EXPECT_THAT(render_svg(figure), HasSubstr("<svg"));
    EXPECT_EQ(folder.files(), 0u) << gnuplot_script(figure, "svg", "figure.svg");
  }
}

// gnuplot keeps 49 bytes of a tick's name, with its escapes.
TEST(Plot, EveryLetterIsDrawn) {
  const std::string svg = render_svg(figure_of(plain("`a` $(b) \"c\" ''d @e {f} x^2_i \\5%g \"7 %%")));
  const std::string letters = std::regex_replace(svg, std::regex("<[^>]*>"), "");
  for (int place = 1; place <= places; ++place)
    EXPECT_THAT(letters, HasSubstr(fmt::format("\t{}`a` $(b) \"c\" ''d @e {{f}} x^2_i \\5%g \"7 %%\n", place)));
}

// The name of the picture is a text of the program, too.
TEST(Plot, AFolderMayBeNamedAsACommand) {
  const ScratchFolder folder;
  const std::filesystem::path strange = folder / "a'b\"`touch made` $(touch made)";
  std::filesystem::create_directory(strange);
  const Environment temporary("TMPDIR", strange.string());
  write_figure("--plot", strange / "it's.svg", line_figure());
  EXPECT_THAT(text_of(strange / "it's.svg"), HasSubstr("<svg"));
  EXPECT_EQ(folder.files(), 1u);
  EXPECT_FALSE(std::filesystem::exists("made"));
}

TEST(Plot, ARasterIsForPages) {
  Figure figure = line_figure();
  figure.panels[0].raster = Raster{.rows = 1, .columns = 1, .values = {1}};
  EXPECT_THROW(render_svg(figure), PlotError);
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

TEST(ContactFigure, TractionIsForceOverTheNodesShare) {
  Eigen::VectorXd x(4), force(4);
  x << 0, 1, 2, 4;
  force << 1, 1, 3, 1;
  EXPECT_EQ(traction(force, x), (std::vector{2.0, 1.0, 2.0, 1.0}));
}

}  // namespace
}  // namespace tactel::host
