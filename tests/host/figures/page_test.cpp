// SPDX-License-Identifier: Apache-2.0

// Pages: escaping, data, size. How they are drawn is tested in a browser (check_page.py).
#include "host/figures/page.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <regex>

#include "fem/gap/gap_reference.h"
#include "host/figures/contact_figure.h"
#include "host/figures/contact_view.h"
#include "host/figures/error_panels.h"
#include "host/figures/grid_field.h"

namespace tactel::host::page_test {

using Json = nlohmann::ordered_json;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

fem::Scene dragged_parabola() {
  return {.sensor = {.columns = 21, .rows = 5}, .load = {.indentation = {0.15}, .tangential = {0.05, 0.1}}};
}

/// The page without its own style and script.
std::string content(const Page& page) {
  const std::string html = page.html(), script = page_script();
  return html.substr(html.find("<h1>"), html.find(script) - html.find("<h1>"));
}

TEST(Page, EscapesTextInEveryBlock) {
  Page page("A < B & \"C\"", "<sub>");
  page.verdict("<b>");
  page.finding(Tone::good, "<i>", "a < b");
  page.section("<script>");
  page.paragraph("x > y");
  page.note("'");
  page.table({.caption = "<c>", .head = {"<h>"}, .rows = {{{Cell("</td>")}}}});
  page.figure({.panels = {{.title = "</script><b>"}}}, "<f>");
  const std::string html = content(page);
  EXPECT_THAT(html, HasSubstr("<h1>A &lt; B &amp; &quot;C&quot;</h1>"));
  for (const char* text : {"&lt;sub&gt;", "&lt;b&gt;", "&lt;i&gt;", "a &lt; b", "&lt;script&gt;", "x &gt; y", "&#39;",
                           "&lt;c&gt;", "&lt;h&gt;", "&lt;/td&gt;", "&lt;f&gt;", "\\u003c/script>\\u003cb>"})
    EXPECT_THAT(html, HasSubstr(text));
  EXPECT_THAT(html, Not(HasSubstr("<b>.<")));
}

TEST(Page, WritesIndicesLowAndNamesAsCode) {
  Page page("t", "s");
  page.paragraph("σ_y and `--seeds` and a lone ` mark");
  EXPECT_THAT(page.html(), HasSubstr("σ<sub>y</sub> and <code>--seeds</code> and a lone ` mark"));
}

TEST(Page, PartsARangeFromItsNumberOnly) {
  Page page("t", "s");
  page.table({.caption = "c", .head = {"h"}, .rows = {{{Cell("0.034 [0.031, 0.039]")}}}});
  EXPECT_THAT(page.html(), HasSubstr("<td class=\"number\">0.034 [0.031,&nbsp;0.039]</td>"));
}

TEST(Page, NeedsNothingOutsideAndUsesEveryIdOnce) {
  Page page("t", "s");
  page.section("one"), page.section("two");
  for (int k = 0; k < 2; ++k) {
    page.figure({.panels = {{.series = {{.x = {0}, .y = {1}}}}}}, "f");
    page.table({.caption = "c", .head = {"h"}, .rows = {}});
  }
  const std::string html = page.html();
  EXPECT_FALSE(std::regex_search(html, std::regex("(src|href)=[\"']?(https?:|//)|@import|url\\(http")));
  for (const char* id : {"id=\"section-2\"", "id=\"figure-2\"", "id=\"table-2\""})
    EXPECT_EQ(html.find(id), html.rfind(id)) << id;
  EXPECT_THAT(html, HasSubstr("href=\"#section-2\""));
}

TEST(Page, DataHaveSixDigitsAndNullForWhatIsNoNumber) {
  const Figure figure{
      .panels = {{.title = "p", .series = {{.label = "s", .x = {1.23456789, 2}, .y = {NAN, INFINITY}}}}}};
  const Json series = to_json(figure)["panels"][0]["series"][0];
  EXPECT_EQ(series["x"], Json::parse("[1.23457, 2.0]"));
  EXPECT_EQ(series["y"], Json::parse("[null, null]"));
}

TEST(Page, BytesThatAreNoUtf8AreReplaced) {
  Page page("t", "s");
  page.figure({.panels = {{.title = "\xff"}}}, "f");
  EXPECT_THAT(page.html(), HasSubstr("\xEF\xBF\xBD"));
}

TEST(Page, DifferencesFromThePaper) {
  EXPECT_EQ(difference_cell(5, 4).text, "+25.0 %");
  EXPECT_EQ(difference_cell(5, 4).tone, Tone::fair);
  EXPECT_EQ(difference_cell(3.9, 4).tone, Tone::good);
  EXPECT_EQ(difference_cell(1, 4).tone, Tone::poor);
  EXPECT_EQ(difference_cell(1, 4, true).tone, Tone::good);  // less of an error
  EXPECT_EQ(difference_cell(44, 4).text, "11 times");
  EXPECT_EQ(difference_cell(1, 0).text, "-");
}

// RFC 4648, section 10.
TEST(ContactView, Base64) {
  const auto of = [](const std::string& text) { return base64({text.begin(), text.end()}); };
  EXPECT_EQ(of(""), "");
  EXPECT_EQ(of("f"), "Zg==");
  EXPECT_EQ(of("fo"), "Zm8=");
  EXPECT_EQ(of("foo"), "Zm9v");
  EXPECT_EQ(of("foob"), "Zm9vYg==");
}

// An element of 1 mm about 1 mm on nodes 1 mm apart: half of it lies in either interval, 1/4 of a half from the node.
TEST(ContactView, NodalLoadsOfAConstantTraction) {
  const Eigen::VectorXd load = nodal_loads(Eigen::VectorXd::Constant(1, 8), Eigen::VectorXd::Constant(1, 1),
                                           Eigen::VectorXd::Constant(1, 1), Eigen::Vector4d(0, 1, 2, 3));
  EXPECT_THAT(load, ElementsAre(1, 6, 1, 0));
}

TEST(ContactView, HoldsTheSolutionsNumbers) {
  const fem::Scene scene = dragged_parabola();
  const fem::ContactSolution solution = fem::solve_gap_reference(scene);
  const Json data = contact_view(scene, solution, 1).data;
  ASSERT_EQ(data["steps"].size(), 3u);
  EXPECT_EQ(data["shown"], 1);
  EXPECT_EQ(data["exaggeration"], 1.0);  // 0.15 mm of 1.5 mm can be seen
  for (std::size_t k = 0; k < 3; ++k) {
    const Json& step = data["steps"][k];
    EXPECT_NEAR(step["P"], solution.steps[k].P, 1e-5 * solution.steps[k].P);
    EXPECT_EQ(step["sigma"].size(), static_cast<std::size_t>(solution.tactel_x.size()));
    for (std::size_t i = 0; i < data["surface_x"].size(); ++i) {
      const double x = data["surface_x"][i];
      const auto node = static_cast<std::size_t>(std::lround(x + 10));  // nodes are 1 mm apart
      EXPECT_EQ(step["status"].get<std::string>()[i], "otl"[static_cast<int>(solution.steps[k].status[node])]);
      EXPECT_NEAR(step["p"][i], solution.steps[k].normal_force[static_cast<Eigen::Index>(node)], 2e-5);  // over 1 mm
      // A touching node lies on the indenter: u_y = -(depth - profile), and it moves along where it sticks.
      if (step["status"].get<std::string>()[i] == 'o') continue;
      EXPECT_NEAR(step["uy"][i], fem::profile_height(scene.indenter, x) - 0.15, 1e-4);
    }
  }
}

// What a byte stands for is at most half a 255th of the range from the value.
TEST(ContactView, FieldsAreTheBlocksStress) {
  const fem::Scene scene = dragged_parabola();
  const fem::ContactSolution solution = fem::solve_gap_reference(scene);
  const Json data = contact_view(scene, solution, 0).data;
  const auto& field = data["field"];
  EXPECT_EQ(field["quantities"].size(), 5u);
  const std::size_t points = field["rows"].get<std::size_t>() * field["columns"].get<std::size_t>();
  for (const auto& text : data["steps"][0]["fields"]) EXPECT_EQ(text.get<std::string>().size(), (points + 2) / 3 * 4);
  EXPECT_LT(field["quantities"][2]["low"], -0.1);  // compression
  EXPECT_EQ(field["quantities"][4]["low"], 0.0);
}

TEST(ContactView, LongPathsStayBelowTheLargestPage) {
  fem::Scene scene = dragged_parabola();
  scene.sensor.tactels = 200;
  scene.load.tangential.clear();
  for (int k = 0; k < 300; ++k) scene.load.tangential.push_back(0.001 * k);
  fem::ContactSolution solution = fem::solve_gap_reference(scene);
  Page page("t", "s");
  page.contact(scene, solution, 17);
  EXPECT_LT(page.html().size(), largest_page);
  EXPECT_THAT(page.html(), HasSubstr("of 301 load steps are shown"));
  const Json data = contact_view(scene, solution, 17).data;
  EXPECT_EQ(data["steps"][data["shown"].get<std::size_t>()]["number"], 18);
  EXPECT_EQ(data["steps"].back()["number"], 301);
}

TEST(ContactFigure, TellingStepIsTheLastThatPartlySlips) {
  using enum fem::GapStatus;
  fem::ContactSolution solution;
  solution.steps.resize(4);
  solution.steps[0].status = {open, stick};
  solution.steps[1].status = {slip, stick};
  solution.steps[2].status = {slip, slip};
  solution.steps[3].status = {slip, slip};
  EXPECT_EQ(telling_step(solution), 1u);
  solution.steps[1].status = {stick, stick};
  EXPECT_EQ(telling_step(solution), 3u);
  EXPECT_DOUBLE_EQ(sticking_share(solution.steps[0]), 1);
  EXPECT_TRUE(std::isnan(sticking_share(fem::ContactStep{})));
}

TEST(GridField, IsBilinear) {
  const GridField field{.x = {0, 1, 3}, .y = {0, 2}, .values = {0, 1, 3, 0, 1, 3}};  // f = x
  EXPECT_DOUBLE_EQ(interpolate(field, 2.5, 1.0), 2.5);
  EXPECT_TRUE(std::isnan(interpolate(field, 3.1, 1.0)));
  EXPECT_THAT(resampled(field, {0.5, 2.5}, 2, 3), ElementsAre(0.5, 1.5, 2.5, 0.5, 1.5, 2.5));
}

TEST(ErrorPanels, SharesOfBins) {
  const std::vector<double> errors = {0.0, 0.05, 0.1, 0.35, 2.0, NAN};
  EXPECT_THAT(shares(errors, 0.4, 4), ElementsAre(0.4, 0.2, 0.0, 0.4));
  const Panel panel = error_histogram(errors, 0.5, "e", {{"mean", 0.2, Ink::red}});
  EXPECT_EQ(panel.series.size(), 2u);
  double sum = 0;
  for (const double share : panel.series[0].y) sum += share;
  EXPECT_NEAR(sum, 100, 1e-9);
}

TEST(ErrorPanels, ManyRowsAreThinnedAndNanIsLeftOut) {
  std::vector<double> truth(5000, 0.5), predicted(5000, 0.6);
  std::fill_n(predicted.begin(), 50, NAN);  // of the first of 100 parts
  const Panel panel = predicted_panel(truth, predicted, "p", 100);
  EXPECT_EQ(panel.series[1].x.size(), 99u);
  EXPECT_EQ(panel.series[1].y[0], 0.6);
}

// 3000 contacts of nine load steps, S from 0 to 0.8: a ninth of the dots, and not all, are of undragged contacts.
TEST(ErrorPanels, DotsAreOfAllLoadSteps) {
  std::vector<double> S;
  for (int row = 0; row < 27000; ++row) S.push_back(0.1 * (row % 9));
  const Panel panel = predicted_panel(S, S, "p");
  ASSERT_EQ(panel.series[1].x.size(), 600u);
  EXPECT_NEAR(std::ranges::count(panel.series[1].x, 0.0), 67, 31);  // as ChosenRow.KeepsNoStepOfAPeriod
}

}  // namespace tactel::host::page_test
