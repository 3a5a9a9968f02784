// SPDX-License-Identifier: Apache-2.0

// Malformed scenes through the program itself: exit 2, a message with file, key, value and what is allowed, and no
// output file.
#include <gmock/gmock.h>

#include "tests/host/support/run_tactel.h"

namespace tactel::host::bad_scene_test {

using testing::HasSubstr;

const std::string good_scene = R"([sensor]
length = 20.0
thickness = 1.5
poisson = 0.45
columns = 41
rows = 11

[indenter]
shape = "parabola"
radius = 10.0

[contact]
friction = 0.5

[load]
indentation = 0.15
tangential_step = 0.05
tangential_steps = 4
)";

struct BadScene {
  std::string name;                ///< of the test
  std::string from, to;            ///< what is replaced in the good scene; an empty `from` replaces all of it
  std::string key, value;          ///< as the message must name them
  std::string allowed;             ///< a part of what the message must allow
  std::string csv{};               ///< measured.csv beside the scene
  std::string file{"scene.toml"};  ///< that the message must blame
};

void PrintTo(const BadScene& scene, std::ostream* out) { *out << scene.name; }

std::string text_of(const BadScene& bad) {
  if (bad.from.empty()) return bad.to;
  std::string text = good_scene;
  const std::size_t at = text.find(bad.from);
  if (at == std::string::npos) throw std::logic_error("the good scene has no " + bad.from);
  return text.replace(at, bad.from.size(), bad.to);
}

class BadSceneTest : public testing::TestWithParam<BadScene> {};

TEST_P(BadSceneTest, EndsWithTwoAndSaysWhy) {
  const BadScene& bad = GetParam();
  const ScratchFolder folder;
  const std::string scene = folder.write("scene.toml", text_of(bad)), answer = (folder / "answer.json").string();
  if (!bad.csv.empty()) folder.write("measured.csv", bad.csv);
  const ChildResult result = run_tactel({"solve", scene, "--json", answer, "--solver", "reference"});
  EXPECT_EQ(result.exit_code, 2) << result.out;
  EXPECT_THAT(result.err, HasSubstr((folder / bad.file).string()));
  EXPECT_THAT(result.err, HasSubstr(bad.key + " = " + bad.value));
  EXPECT_THAT(result.err, HasSubstr(": must be "));
  EXPECT_THAT(result.err, HasSubstr(bad.allowed));
  EXPECT_EQ(result.out, "");
  EXPECT_FALSE(std::filesystem::exists(answer));
}

/// Expects that the last of `lines`, "key = value", is refused; they stand in `table` in place of `from`.
BadScene line(const std::string& name, const std::string& from, const std::string& lines, const std::string& table,
              const std::string& allowed) {
  const std::string last = lines.substr(lines.rfind('\n') + 1);
  const std::size_t equals = last.find(" = ");
  return {name, from, lines, table + "." + last.substr(0, equals), last.substr(equals + 3), allowed};
}

const std::string its_shape = "shape = \"parabola\"\nradius = 10.0",
                  its_load = "indentation = 0.15\ntangential_step = 0.05\ntangential_steps = 4";

/// The good scene's indenter with other lines; `load` does the same for the load.
BadScene indenter(const std::string& name, const std::string& lines, const std::string& key, const std::string& value,
                  const std::string& allowed, const std::string& csv = "", const std::string& file = "scene.toml") {
  return {name, its_shape, lines, key, value, allowed, csv, file};
}
BadScene indenter(const std::string& name, const std::string& lines, const std::string& allowed) {
  return line(name, its_shape, lines, "indenter", allowed);
}
BadScene load(const std::string& name, const std::string& lines, const std::string& allowed) {
  return line(name, its_load, lines, "load", allowed);
}

BadScene profile(const std::string& name, const std::string& csv, const std::string& key, const std::string& value,
                 const std::string& allowed, const std::string& file = "measured.csv") {
  return indenter(name, "shape = \"profile\"\nfile = \"measured.csv\"", key, value, allowed, csv, file);
}

const BadScene bad_scenes[] = {
    // files
    {"NotToml", "", "this is no scene\n", "line 1", "this is no scene", "valid TOML"},
    {"Empty", "", "", "indenter.shape", "(missing)", "given, one of flat, wedge"},
    {"OnlyComments", "", "# nothing yet\n", "indenter.shape", "(missing)", "given"},
    {"Binary", "",
     std::string("\x7f"
                 "ELF\0\1\2",
                 7),
     "line 1", "", "valid TOML"},
    {"UnclosedText", "shape = \"parabola\"", "shape = \"parabola", "shape", "\"parabola", "valid TOML"},
    {"NoValue", "friction = 0.5", "friction =", "friction", "(missing)", "valid TOML"},
    {"DecimalComma", "friction = 0.5", "friction = 0,5", "friction", "0,5", "valid TOML"},
    {"DuplicateKey", "friction = 0.5", "friction = 0.5\nfriction = 0.6", "friction", "0.6", "valid TOML"},
    {"DuplicateTable", "[load]", "[sensor]\n[load]", "line 15", "[sensor]", "valid TOML"},
    // keys
    line("MisspeltKey", "length = 20.0", "lenght = 20.0", "sensor", "did you mean length?"),
    {"UnknownKey", "friction = 0.5", "friction = 0.5\nadhesion = 0.1", "contact.adhesion", "0.1", "one of friction"},
    {"KeyInWrongTable", "friction = 0.5", "friction = 0.5\npoisson = 0.4", "contact.poisson", "0.4", "one of friction"},
    {"UnknownTable", "[contact]", "[adhesion]\nwork = 1.0\n[contact]", "adhesion", "(a table)",
     "one of contact, indenter, load"},
    {"MisspeltTable", "[sensor]", "[sensr]", "sensr", "(a table)", "did you mean sensor?"},
    {"UnknownKeyAtTheTop", "[sensor]", "mu = 0.3\n[sensor]", "mu", "0.3", "a known key"},
    {"UnknownPreset", "[sensor]", "preset = \"papper\"\n[sensor]", "preset", "\"papper\"", "did you mean paper?"},
    {"TitleIsNumber", "[sensor]", "title = 3\n[sensor]", "title", "3", "a text"},
    {"ArrayOfTables", "[indenter]", "[[indenter]]", "indenter", "", "a table, written [indenter]"},
    // sensor
    line("TextForNumber", "poisson = 0.45", "poisson = \"0.45\"", "sensor", "a number with 0 <= poisson <= 0.5"),
    line("Incompressible", "poisson = 0.45", "poisson = 0.5", "sensor", "below 0.5 on a mesh"),
    line("NegativePoisson", "poisson = 0.45", "poisson = -0.1", "sensor", "0 <= poisson <= 0.5"),
    line("NotANumber", "poisson = 0.45", "poisson = nan", "sensor", "finite, a number"),
    line("Infinite", "length = 20.0", "length = inf", "sensor", "a number of mm"),
    line("NegativeThickness", "thickness = 1.5", "thickness = -1.5", "sensor", "mm"),
    line("ZeroLength", "length = 20.0", "length = 0", "sensor", "mm"),
    line("ZeroYoung", "poisson = 0.45", "young = 0.0", "sensor", "MPa"),
    line("OneColumn", "columns = 41", "columns = 1", "sensor", "3 to 2001"),
    line("OneRow", "rows = 11", "rows = 1", "sensor", "2 to 1001"),
    line("HugeColumns", "columns = 41", "columns = 100000", "sensor", "3 to 2001"),
    line("ColumnsBeyondInt", "columns = 41", "columns = 9000000000", "sensor", "whole number"),
    line("FractionForCount", "columns = 41", "columns = 41.0", "sensor", "a whole number"),
    line("ZeroGrading", "poisson = 0.45", "grading = 0", "sensor", "0.01 to 100"),
    line("OneTactel", "poisson = 0.45", "tactels = 1", "sensor", "2 to"),
    line("UnknownElement", "poisson = 0.45", "element = \"q9\"", "sensor", "one of bbar, q4, q4i, q8"),
    line("UnknownStress", "poisson = 0.45", "stress = \"nodal\"", "sensor", "one of reaction, element"),
    line("ElementIsNumber", "poisson = 0.45", "element = 4", "sensor", "one of bbar"),
    line("BooleanForNumber", "length = 20.0", "length = true", "sensor", "a number of mm"),
    line("DateForNumber", "length = 20.0", "length = 1998-03-01", "sensor", "a number of mm"),
    // indenters
    indenter("NoShape", "radius = 10.0", "indenter.shape", "(missing)", "given, one of flat"),
    indenter("UnknownShape", "shape = \"dome\"", "one of flat, wedge, parabola, cylinder"),
    indenter("MisspeltShape", "shape = \"parabolla\"", "did you mean parabola?"),
    indenter("NoRadius", "shape = \"parabola\"", "indenter.radius", "(missing)", "given, a number of mm"),
    indenter("ZeroRadius", "shape = \"parabola\"\nradius = 0", "length in mm"),
    indenter("NegativeRadius", "shape = \"cylinder\"\nradius = -3.0", "length in mm"),
    indenter("KeyOfAnotherShape", "shape = \"parabola\"\nradius = 10.0\nedge_angle = 90.0", "belongs to shape wedge"),
    indenter("KeyOfTwoOtherShapes", "shape = \"wedge\"\nedge_angle = 90.0\nradius = 2.0",
             "belongs to shape parabola, cylinder, rounded_flat"),
    indenter("MisspeltShapeKey", "shape = \"parabola\"\nradius = 10.0\npostion = 1.0", "did you mean position?"),
    indenter("StraightEdge", "shape = \"wedge\"\nedge_angle = 180", "above 0 and below 180"),
    indenter("ZeroEdge", "shape = \"wedge\"\nedge_angle = 0", "above 0 and below 180"),
    indenter("ZeroHeight", "shape = \"exponential\"\nheight = 0.0\nrate = 1.0", "indenter.height", "0.0", "mm"),
    indenter("NegativeRate", "shape = \"exponential\"\nheight = 0.1\nrate = -1.0", "1/mm"),
    indenter("FlatFlanks", "shape = \"trapezoid\"\nhalf_width = 1.0\nslope = 0.0", "slope"),
    indenter("NoSlope", "shape = \"trapezoid\"\nhalf_width = 1.0", "indenter.slope", "(missing)", "given"),
    indenter("NegativeHalfWidth", "shape = \"flat\"\nhalf_width = -1.0", "mm"),
    indenter("ZeroPower", "shape = \"taylor\"\npowers = [0, 1]", "indenter.powers", "0", "1 to 100"),
    indenter("FractionalPower", "shape = \"taylor\"\npowers = [1.5]", "indenter.powers", "1.5", "whole numbers"),
    indenter("PowersAreNoArray", "shape = \"taylor\"\npowers = 3", "an array of whole numbers"),
    indenter("OutsideTheSensor", "shape = \"parabola\"\nradius = 10.0\nposition = 12.0", "over the sensor"),
    indenter("BetweenTwoNodes", "shape = \"flat\"\nhalf_width = 0.1\nposition = 0.25", "a surface node under"),
    // profiles
    indenter("Concave", "shape = \"profile\"\nx = [-1, 0, 1]\ny = [0, 0.5, 0]", "convex"),
    indenter("XFallsBack", "shape = \"profile\"\nx = [-1, 1, 0]\ny = [1, 0, 1]", "indenter.x", "0 after 1",
             "increasing"),
    indenter("OnePoint", "shape = \"profile\"\nx = [0]\ny = [0]", "indenter.x", "[0]", "at least two points"),
    indenter("UnequalLists", "shape = \"profile\"\nx = [-1, 0, 1]\ny = [1, 0]", "3"),
    indenter("NaNHeight", "shape = \"profile\"\nx = [-1, 0, 1]\ny = [1, nan, 1]", "indenter.y", "nan",
             "finite, an array of mm"),
    indenter("NegativeSmooth", "shape = \"profile\"\nx = [-1, 1]\ny = [0, 0]\nsmooth = -0.1", "not below 0"),
    indenter("NothingGiven", "shape = \"profile\"", "indenter.x", "(missing)", "or file"),
    indenter("NoHeights", "shape = \"profile\"\nx = [-1, 1]", "indenter.y", "(missing)", "as many as x"),
    indenter("FileAndPoints", "shape = \"profile\"\nfile = \"measured.csv\"\nx = [-1, 1]\ny = [0, 0]", "indenter.file",
             "\"measured.csv\"", "left out"),
    profile("MissingCsv", "", "indenter.file", "", "a readable CSV file"),
    profile("OtherHeader", "pos,height\n0,0\n1,1\n", "header", "(not shown)", "x,y"),
    profile("EmptyCsv", "# nothing\n", "points", "0", "x,y"),
    profile("CsvBadNumber", "x,y\n-1,1\n0,abc\n", "y", "abc", "a finite number"),
    profile("CsvNaN", "x,y\n-1,1\n0,nan\n", "y", "nan", "a finite number"),
    profile("CsvMissingColumn", "x,y\n-1,1\n0\n", "fields", "1", "x and y in mm"),
    profile("CsvThirdColumn", "x,y\n-1,1\n0,0,0\n", "fields", "3", "x and y in mm"),
    profile("CsvDecimalComma", "x,y\n-1;1\n", "fields", "1", "x and y in mm"),
    profile("CsvNotIncreasing", "x,y\n-1,1\n-1,0\n", "x", "-1", "greater than the x on the line before"),
    profile("CsvOnePoint", "x,y\n0,0\n", "points", "1", "at least 2"),
    profile("CsvConcave", "x,y\n-1,0\n0,1\n1,0\n", "indenter.file", "", "smooth = 1 (mm)", "scene.toml"),
    // loads
    line("NegativeFriction", "friction = 0.5", "friction = -0.1", "contact", "not below 0"),
    line("FrictionIsText", "friction = 0.5", "friction = \"0.5\"", "contact", "a number, mu >= 0, or \"bonded\""),
    line("FrictionIsArray", "friction = 0.5", "friction = [0.5]", "contact", "a number, mu >= 0"),
    {"NoLoad", its_load, "tangential_step = 0.05\ntangential_steps = 4", "load.indentation", "(missing)",
     "load.normal_force"},
    load("BothLoads", "indentation = 0.1\nnormal_force = 1.0", "only one of indentation, normal_force"),
    load("NegativeDepth", "indentation = -0.1", "not below 0"),
    {"NegativeDepthOfSeveral", its_load, "indentation = [0.1, -0.05]", "load.indentation", "-0.05", "not below 0"},
    load("DepthOfTheThickness", "indentation = 1.5", "sensor.thickness = 1.5"),
    {"DeeperThanTheRubber", its_load, "indentation = [0.1, 2.0]", "load.indentation", "2", "below the rubber's"},
    load("EmptyDepths", "indentation = []", "a number of mm"),
    load("NegativeForce", "normal_force = -1.0", "not below 0"),
    load("ZeroSteps", "indentation = 0.1\nindentation_steps = 0", "1 to 1000"),
    load("HugeSteps", "indentation = 0.1\nindentation_steps = 100000", "1 to 1000"),
    load("HugeDragSteps", "indentation = 0.1\ntangential_step = 0.1\ntangential_steps = 1001", "0 to 1000"),
    load("StepsWithoutStep", "indentation = 0.1\ntangential_steps = 3", "together with load.tangential_step"),
    load("StepsWithPositions", "indentation = 0.1\ntangential = [0.1]\ntangential_steps = 3",
         "together with load.tangential_step"),
    load("StepAndPositions", "indentation = 0.1\ntangential_step = 0.1\ntangential = [0.1]",
         "only one of tangential_step, tangential, angle"),
    load("StepAndAngle", "normal_force = 1.0\ntangential_step = 0.1\nangle = 5.0",
         "only one of tangential_step, tangential, angle"),
    load("NoPositions", "indentation = 0.1\ntangential = []", "at least one position"),
    load("PositionIsNumber", "indentation = 0.1\ntangential = 0.1", "an array of positions"),
    {"TextAmongPositions", its_load, "indentation = 0.1\ntangential = [0.1, \"0.2\"]", "load.tangential", "\"0.2\"",
     "an array of positions"},
    load("AngleWithoutForce", "indentation = 0.1\nangle = 10.0", "together with load.normal_force"),
    load("AngleBeyondFriction", "normal_force = 1.0\nangle = 30.0", "within the friction angle"),
    load("RightAngle", "normal_force = 1.0\nangle = 90", "within the friction angle"),
    load("MisspeltLoad", "indentation = 0.1\ntangental_step = 0.1", "did you mean tangential_step?"),
};

INSTANTIATE_TEST_SUITE_P(All, BadSceneTest, testing::ValuesIn(bad_scenes),
                         [](const auto& info) { return info.param.name; });

TEST(UnreadableScene, MissingFile) {
  const ScratchFolder folder;
  const std::string scene = (folder / "missing.toml").string();
  EXPECT_TRUE(is_refused(run_tactel({"solve", scene}),
                         {scene + ": file = " + scene + ": must be a readable TOML file (No such file or directory)"}));
}

TEST(UnreadableScene, Folder) {
  const ScratchFolder folder;
  EXPECT_TRUE(
      is_refused(run_tactel({"solve", folder.write("", "") + "."}), {"must be a readable TOML file (it is a folder)"}));
}

TEST(UnreadableScene, NamesTheLine) {
  const ScratchFolder folder;
  const std::string scene = folder.write("scene.toml", text_of({"", "rows = 11", "rows = 1", "", "", ""}));
  EXPECT_THAT(run_tactel({"solve", scene}).err, HasSubstr(scene + ":6: sensor.rows = 1: must be"));
}

}  // namespace tactel::host::bad_scene_test
