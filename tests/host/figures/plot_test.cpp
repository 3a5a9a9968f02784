// SPDX-License-Identifier: Apache-2.0

// Pictures: what can be told without looking. (How they look was looked at.)
#include "host/figures/plot.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <regex>

#include "host/figures/contact_figure.h"
#include "host/figures/page_files.h"
#include "host/support/errors.h"
#include "tests/host/support/run_tactel.h"

namespace tactel::host::plot_test {

using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

Figure line_figure() {
  Figure figure{.title = plain("a_title & {more}")};
  figure.panels = {{.title = "lines", .x_label = "x (mm)", .y_label = "y (MPa)"}};
  figure.panels[0].series = {{.label = "one", .x = {0, 1, 2}, .y = {0, 1, 4}},
                             {.label = "gap", .x = {0, 1, 2}, .y = {1, NAN, 1}, .mark = Mark::circles}};
  return figure;
}

/// Every mark that a file shows, in another ink each.
Figure every_mark() {
  Panel panel{.title = "marks", .x_ticks = {{1, "net \"1\""}, {2, "net 2"}}, .log_y = true};
  int count = 0;
  for (const Mark mark : {Mark::line, Mark::line, Mark::dashed, Mark::circles, Mark::triangles, Mark::diamonds,
                          Mark::line_dots, Mark::band}) {
    const double y = 1.0 + count;
    panel.series.push_back({.label = "m",
                            .x = {1, 2},
                            .y = {y, y},
                            .mark = mark,
                            .ink = static_cast<Ink>(count++),
                            .low = {y - 0.5, y - 0.5},
                            .high = {y + 0.5, y + 0.5}});
  }
  return {.panels = {panel}};
}

TEST(Plot, SvgHoldsTitleAndLabels) {
  const std::string svg = render_svg(line_figure());
  EXPECT_THAT(svg, HasSubstr("<svg"));
  EXPECT_THAT(svg, HasSubstr("a_title &amp; {more}"));
  EXPECT_THAT(svg, HasSubstr("x (mm)"));
  EXPECT_THAT(svg, HasSubstr("y (MPa)"));
}

TEST(Plot, EveryMarkAndTickIsDrawn) {
  const std::string svg = render_svg(every_mark());
  EXPECT_THAT(svg, HasSubstr("net \"1\""));
  EXPECT_THAT(svg, HasSubstr("stroke-dasharray"));
  EXPECT_THAT(svg, Not(HasSubstr("nan")));
}

/// The colour of this name in a text of pages: that of the light scheme.
std::string page_colour(const char* file, const std::string& name) {
  for (const page_files::Source& source : page_files::sources())
    if (source.name == file) return std::string(source.text.substr(source.text.find('#', source.text.find(name)), 7));
  return "no such file";
}

TEST(Plot, ColoursAreThoseOfPages) {
  const std::string svg = render_svg(every_mark());
  for (const char* ink : {"blue", "orange", "green", "purple", "red", "brown", "grey", "black", "soft", "faint"})
    EXPECT_THAT(svg, HasSubstr(page_colour("style.css", fmt::format("--{}:", ink)))) << ink;
  for (const auto& [palette, name] :
       {std::pair(Palette::sequential, "sequential:"), {Palette::diverging, "diverging:"}}) {
    Figure figure = line_figure();
    figure.panels[0].mosaic = Mosaic{.x = {0, 1, 1, 0}, .y = {0, 0, 1, 1}, .values = {-9}, .palette = palette};
    EXPECT_THAT(render_svg(figure), HasSubstr("fill=\"" + page_colour("raster.js", name))) << name;  // the lowest
  }
}

// 2 of 0 to 4 is the middle of the axes; a panel of 400 pixels leaves room at its edges.
TEST(Plot, PointsStandAtTheirValues) {
  Figure figure{.panels = {{.series = {{.x = {0, 2, 4}, .y = {0, 2, 4}, .mark = Mark::line}},
                            .x_range = {{0, 4}},
                            .y_range = {{0, 4}}}},
                .width = 400};
  std::smatch found;
  const std::string svg = render_svg(figure);
  const std::regex three("<path d=\"M([0-9.]+),([0-9.]+)L([0-9.]+),([0-9.]+)L([0-9.]+),([0-9.]+)\" fill=\"none\"");
  ASSERT_TRUE(std::regex_search(svg, found, three));
  const auto at = [&](std::size_t k) { return std::stod(found[k].str()); };
  EXPECT_NEAR(at(3), (at(1) + at(5)) / 2, 0.1);  // digits of the file
  EXPECT_NEAR(at(4), (at(2) + at(6)) / 2, 0.1);
  const auto [width, height] = axes_size(figure, figure.panels[0]);
  EXPECT_NEAR(at(5) - at(1), width, 0.1);
  EXPECT_NEAR(at(2) - at(6), height, 0.1);  // upwards
}

TEST(Plot, ALogarithmicAxisHasDecades) {
  Figure figure = line_figure();
  figure.panels[0].series = {{.x = {0, 1, 2}, .y = {0, 1e-4, 1e3}}};  // without a place for 0
  figure.panels[0].log_y = true, figure.panels[0].y_range = {1e-4, 1e3};
  const std::string svg = render_svg(figure);
  EXPECT_THAT(svg, HasSubstr("10</tspan><tspan dy=\"-4\" font-size=\"80%\">−4</tspan>"));
  EXPECT_THAT(svg, HasSubstr(">1000</tspan>"));
  EXPECT_THAT(svg, Not(HasSubstr("nan")));
  figure.panels[0].y_range = {0, 1e3};
  EXPECT_THAT(render_svg(figure), Not(HasSubstr("nan")));
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

TEST(Plot, EveryLetterIsDrawn) {
  const std::string svg = render_svg(figure_of(plain("`a` $(b) \"c\" ''d @e {f} x^2_i \\5%g <7> & \1\n]]>")));
  const std::string letters = std::regex_replace(svg, std::regex("<[^>]*>"), "");
  for (int place = 1; place <= places; ++place)
    EXPECT_THAT(letters, HasSubstr(fmt::format("\n{}`a` $(b) \"c\" ''d @e {{f}} x^2_i \\5%g &lt;7&gt; &amp;   ]]&gt;\n",
                                               place)));
}

TEST(Plot, AFolderMayBeNamedAsACommand) {
  const ScratchFolder folder;
  const std::filesystem::path strange = folder / "a'b\"`touch made` $(touch made)";
  std::filesystem::create_directory(strange);
  const Environment temporary("TMPDIR", strange.string());
  write_figure("--plot", strange / "it's.png", line_figure());
  EXPECT_THAT(text_of(strange / "it's.png"), StartsWith("\x89PNG\r\n\x1a\n"));
  EXPECT_EQ(folder.files(), 1u);
  EXPECT_FALSE(std::filesystem::exists("made"));
}

TEST(Plot, PagesAloneDrawRastersAndBars) {
  Figure figure = line_figure();
  figure.panels[0].raster = Raster{.rows = 1, .columns = 1, .values = {1}};
  EXPECT_THROW(render_svg(figure), PlotError);
  figure = line_figure();
  figure.panels[0].series[0].mark = Mark::bars;
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
  write_figure("--plot", folder / "a.pdf", line_figure());
  EXPECT_THAT(text_of(folder / "a.pdf"), StartsWith("%PDF-"));
  EXPECT_EQ(folder.files(), 2u);
}

TEST(Plot, TicksAreRoundAndFit) {
  EXPECT_DOUBLE_EQ(tick_distance({-10, 10}, 12), 2.0);
  EXPECT_DOUBLE_EQ(tick_distance({0, 0.5}, 6), 0.1);
  EXPECT_DOUBLE_EQ(tick_distance({0.2, 1}, 5), 0.2);
  EXPECT_DOUBLE_EQ(tick_distance({0, 100}, 10), 10.0);  // exactly as many as fit
  EXPECT_EQ(tick_distance({1, 1}, 5), 0.0);
  EXPECT_EQ(tick_distance({INFINITY, -INFINITY}, 5), 0.0);  // nothing drawn
}

TEST(Plot, ALegendTakesTheRowsItNeeds) {
  Figure figure = line_figure();
  const double one_row = axes_size(figure, figure.panels[0]).second;
  for (int k = 0; k < 20; ++k) figure.panels[0].series.push_back({.label = "another of many", .x = {0}, .y = {0}});
  EXPECT_LT(axes_size(figure, figure.panels[0]).second, one_row - 30);
  figure.panels[0].series.clear();
  EXPECT_GT(axes_size(figure, figure.panels[0]).second, one_row);
}

TEST(ContactFigure, TractionIsForceOverTheNodesShare) {
  const fem::ContactSolution on_mesh{.surface_x = Eigen::Vector4d(0, 1, 2, 4)};
  EXPECT_EQ(traction_of(Eigen::Vector4d(1, 1, 3, 1), on_mesh), Eigen::VectorXd(Eigen::Vector4d(2, 1, 2, 1)));
}

}  // namespace tactel::host::plot_test
