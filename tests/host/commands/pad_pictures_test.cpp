// SPDX-License-Identifier: Apache-2.0

// Page, plot and VTU file that `tactel solve` writes of a pad hold the numbers of its JSON.
#include <gmock/gmock.h>

#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/host/support/run_tactel.h"

namespace tactel::host::pad_pictures_test {

using nlohmann::json;
using testing::HasSubstr;

const std::string twisted = source_file("examples/pad_twist.toml");

/// The data of the pad on a page.
json pad_of(const std::string& page) {
  const std::string mark = "<script type=\"application/json\">";
  const std::size_t from = page.find(mark, page.find("data-kind=\"pad\"")) + mark.size();
  return json::parse(page.substr(from, page.find("</script>", from) - from));
}

/// Numbers of a DataArray of a VTU file.
std::vector<double> array_of(const std::string& vtu, const std::string& name) {
  const std::size_t open = vtu.find('>', vtu.find("Name=\"" + name + "\"")) + 1;
  std::istringstream in(vtu.substr(open, vtu.find('<', open) - open));
  return {std::istream_iterator<double>(in), {}};
}

TEST(PadPictures, HoldTheAnswer) {
  const ScratchFolder folder;
  const std::string page = folder / "a.html", plot = folder / "a.svg", field = folder / "a.vtu",
                    answers = folder / "a.json";
  ASSERT_EQ(
      run_tactel({"solve", twisted, "--html", page, "--plot", plot, "--field", field, "--json", answers}).exit_code, 0);
  const json answer = json::parse(text_of(answers)), pad = pad_of(text_of(page));
  EXPECT_THAT(text_of(page), HasSubstr("The contact holds with S = "));
  EXPECT_LT(text_of(page).size(), 200'000u);
  ASSERT_EQ(pad["steps"].size(), answer["steps"].size());
  EXPECT_EQ(pad["shown"], pad["steps"].size() - 1);  // some cells stick and some slip
  const double hx = answer["cell_width"][0], hy = answer["cell_width"][1];
  for (std::size_t k = 0; k < pad["steps"].size(); ++k) {
    const json &shown = pad["steps"][k], &step = answer["steps"][k];
    for (const char* key : {"P", "M", "indentation", "twist"})
      EXPECT_NEAR(shown[key].get<double>(), step[key].get<double>(), 1e-5 + 1e-5 * step["P"].get<double>()) << key;
    EXPECT_NEAR(shown["S"].get<double>(), step["slip_index"].get<double>(), 1e-6);
    for (std::size_t cell = 0; cell < 144; ++cell)  // five digits
      EXPECT_NEAR(shown["p"][cell].get<double>() * hx * hy, step["normal_force"][cell].get<double>(), 1e-5);
    for (std::size_t tactel = 0; tactel < 16; ++tactel)
      EXPECT_NEAR(shown["tau_x"][tactel].get<double>(), step["tau_x"][tactel].get<double>(), 1e-5);
  }
  const json& last = answer["steps"].back();
  const std::vector<double> normal = array_of(text_of(field), "normal_traction"),
                            shear = array_of(text_of(field), "tangential_traction"),
                            points = array_of(text_of(field), "Points");
  ASSERT_EQ(normal.size(), 144u);
  ASSERT_EQ(points.size(), 3u * 169);
  for (std::size_t cell = 0; cell < 144; ++cell) {
    EXPECT_NEAR(normal[cell] * hx * hy, last["normal_force"][cell].get<double>(), 1e-12);
    EXPECT_NEAR(shear[3 * cell + 1] * hx * hy, last["tangential_force"][cell][1].get<double>(), 1e-12);
  }
  EXPECT_EQ(points[2], 4);  // the thickness
  EXPECT_THAT(text_of(plot), HasSubstr("Along the path"));
}

TEST(PadPictures, AreOfTheStepNamed) {
  const ScratchFolder folder;
  const std::string page = folder / "a.html", plot = folder / "a.svg", field = folder / "a.vtu";
  // Of rubber whose sides are held: beside free ones it flees outward, and slips at the rim as it is pressed.
  std::string text = text_of(twisted);
  text.insert(text.find("[indenter]"), "sides = \"held\"\n");
  const std::string held = folder.write("held.toml", text);
  ASSERT_EQ(
      run_tactel({"solve", held, "--step", "1", "--html", page, "--plot", plot, "--field", field, "--quiet"}).exit_code,
      0);
  EXPECT_EQ(pad_of(text_of(page))["shown"], 0);
  EXPECT_THAT(text_of(plot), HasSubstr("drag (0, 0) mm"));
  for (const double shear : array_of(text_of(field), "status")) EXPECT_LT(shear, 2);  // pressed alone: all stick
  EXPECT_TRUE(is_refused(run_tactel({"solve", twisted, "--step", "7", "--html", page}), {"--step", "1 to 6"}));
  EXPECT_TRUE(is_refused(run_tactel({"solve", twisted, "--plot", folder / "a.gif"}), {"--plot", ".svg, .png or .pdf"}));
}

}  // namespace tactel::host::pad_pictures_test
