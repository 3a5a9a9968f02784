// SPDX-License-Identifier: Apache-2.0

// The command line: outputs, exit codes, and messages about options.
#include <gmock/gmock.h>
#include <stdlib.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "fem/gap/gap_reference.h"
#include "host/scenes/scene_file.h"
#include "host/support/checksum.h"
#include "tests/host/support/run_tactel.h"

namespace tactel::host::solve_command_test {

using nlohmann::json;
using testing::HasSubstr;
using testing::Not;

const std::string parabola = source_file("examples/parabola.toml");

std::vector<std::string> keys(const json& object) {
  std::vector<std::string> names;
  for (const auto& [key, value] : object.items()) names.push_back(key);
  return names;
}

TEST(SolveCommand, DerivativesAreOfPython) {
  EXPECT_TRUE(is_refused(run_tactel({"solve", parabola, "--json", "-", "--derivatives"}),
                         {"--derivatives", "differences of two answers"}));
}

TEST(SolveCommand, ConvergeJudgesTheStepBesideSmallerCells) {
  const ScratchFolder folder;
  const std::string page = folder / "page.html", file = folder / "answer.json";
  const std::vector<std::string> call = {"solve", source_file("examples/cylinder.toml"), "--converge"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), call.begin(), call.end());
    return run_tactel(more);
  };
  const ChildResult result = with({"--html", page, "--json", file});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  std::istringstream lines(result.out);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 79u) << line;
  const json answer = json::parse(text_of(file)), &found = answer["converge"];
  const std::size_t step = found["step"].get<std::size_t>() - 1;
  EXPECT_LT(answer["steps"][step]["slip_index"], 1);  // one that tells more than full sliding does
  EXPECT_EQ(found["rungs"].size(), 4u);
  for (const json& q : found["quantities"]) {
    EXPECT_EQ(q["values"].size(), 4u) << q;
    EXPECT_NEAR(q["error"].get<double>(), q["answer"].get<double>() - q["limit"].get<double>(), 1e-12) << q;
  }
  EXPECT_EQ(found["quantities"][0]["answer"], answer["steps"][step]["P"]);
  EXPECT_THAT(text_of(page), HasSubstr("Convergence"));

  EXPECT_EQ(json::parse(with({"--json", "-", "--step", "2"}).out)["converge"]["step"], 2);
  EXPECT_TRUE(is_refused(with({"--step", "99"}), {"--step", "99"}));
  // Steps are the same as without the option.
  EXPECT_EQ(json::parse(run_tactel({call[0], call[1], "--json", "-"}).out)["steps"], answer["steps"]);
}

TEST(SolveCommand, TableHasALineAStep) {
  const ChildResult result = run_tactel({"solve", parabola});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("parabola on the paper's mesh B\n"));
  EXPECT_THAT(result.out, HasSubstr("\n   9  0.1500  0.4000 "));
  std::istringstream lines(result.out);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 79u) << line;
  EXPECT_THAT(result.out, HasSubstr("the whole contact slides"));
}

TEST(SolveCommand, JsonHasTheDocumentedKeys) {
  const json answer = json::parse(run_tactel({"solve", parabola, "--json", "-"}).out);
  EXPECT_THAT(keys(answer),
              testing::UnorderedElementsAre("tactel", "scene", "solver", "precision", "device", "fallback", "surface_x",
                                            "surface_width", "base_x", "tactel_x", "steps", "warnings", "model",
                                            "model_reason", "discretisation_error"));
  EXPECT_THAT(keys(answer["discretisation_error"]),
              testing::UnorderedElementsAre("slip_index", "P", "Q", "sigma_y", "tau_xy", "from"));
  ASSERT_EQ(answer["steps"].size(), 9u);
  const json& step = answer["steps"][4];
  EXPECT_THAT(keys(step), testing::UnorderedElementsAre("indentation", "tangential", "P", "Q", "slip_index",
                                                        "slip_distance", "status", "normal_force", "tangential_force",
                                                        "base_force_x", "base_force_y", "sigma_y", "tau_xy",
                                                        "converged", "iterations", "residual"));
  EXPECT_THAT(keys(step["residual"]),
              testing::UnorderedElementsAre("penetration", "cone", "complementarity", "drift", "balance"));
  for (const char* key : {"status", "normal_force", "tangential_force"}) EXPECT_EQ(step[key].size(), 41u) << key;
  for (const char* key : {"base_force_x", "base_force_y"}) EXPECT_EQ(step[key].size(), answer["base_x"].size()) << key;
  for (const char* key : {"sigma_y", "tau_xy"}) EXPECT_EQ(step[key].size(), 21u) << key;
  EXPECT_EQ(answer["scene"]["sensor"]["element"], "bbar");
}

/// The only file below `folder` with this extension.
std::filesystem::path file_below(const std::filesystem::path& folder, const std::string& extension) {
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    if (entry.path().extension() == extension) return entry.path();
  return {};
}

// Tables and binaries of programs are kept between runs. A device that refuses a binary gets the source.
TEST(SolveCommand, AnswersAlikeWithAndWithoutWhatIsKept) {
  const OwnCache cache;
  const std::filesystem::path folder = std::getenv("TACTEL_CACHE_DIR");
  const auto answer = [] { return run_tactel({"solve", source_file("examples/cylinder.toml"), "--json", "-"}).out; };
  const std::string cold = answer(), warm = answer();
  EXPECT_THAT(cold, HasSubstr("patch of"));
  EXPECT_EQ(warm, cold);
  EXPECT_NE(file_below(folder, ".tables"), "");
  const std::filesystem::path kept = file_below(folder, ".binary");
  ASSERT_NE(kept, "");
  std::string magic, what, key;
  std::ifstream(kept) >> magic >> what >> key;
  const std::string no_binary = "none that a device takes";
  std::ofstream(kept) << magic << ' ' << what << ' ' << key << ' ' << no_binary.size() << ' '
                      << checksum_text(no_binary) << '\n'
                      << no_binary;
  EXPECT_EQ(answer(), cold);
  EXPECT_THAT(text_of(kept), Not(HasSubstr(no_binary)));  // stored anew
}

TEST(SolveOnHost, JsonNumbersReadBackToTheSameBits) {
  const json answer =
      json::parse(run_tactel({"solve", parabola, "--json", "-", "--solver", "reference"}).out);  // the old word
  EXPECT_EQ(answer["solver"], "full-mesh");
  const fem::ContactSolution solution = fem::solve_gap_reference(read_scene(parabola));
  const fem::ContactStep& step = solution.steps.back();
  EXPECT_EQ(answer["steps"].back()["P"].get<double>(), step.P);
  for (Eigen::Index k = 0; k < step.base_force_x.size(); ++k) {
    ASSERT_EQ(answer["steps"].back()["base_force_x"][static_cast<std::size_t>(k)].get<double>(), step.base_force_x[k]);
  }
}

TEST(SolveOnHost, SlipIndexIsNullWithoutFriction) {
  const ScratchFolder folder;
  const std::string scene = folder.write(
      "scene.toml",
      "[indenter]\nshape = \"parabola\"\nradius = 10\n[contact]\nfriction = 0\n[load]\nindentation = [0.1, 0.0]\n");
  const json answer = json::parse(run_tactel({"solve", scene, "--json", "-", "--solver", "full-mesh"}).out);
  EXPECT_TRUE(answer["steps"][0]["slip_index"].is_null());
  EXPECT_GT(answer["steps"][0]["P"].get<double>(), 0.0);
  EXPECT_TRUE(answer["steps"][1]["slip_index"].is_null());
}

// Pulled at 99.9 % of the friction angle by force, the sweeps of a mesh give up, and the fallback answers.
TEST(SolveCommand, JsonSaysWhenTheFallbackAnswered) {
  const ScratchFolder folder;
  // atan 0.5 = 26.5651 degrees
  const std::string scene = folder.write("scene.toml",
                                         "[sensor]\ncolumns = 41\n[indenter]\nshape = \"parabola\"\nradius = 10\n"
                                         "[contact]\nfriction = 0.5\n[load]\nnormal_force = 0.5\nangle = 26.5385\n");
  const json answer = json::parse(run_tactel({"solve", scene, "--json", "-"}).out);
  EXPECT_EQ(answer["fallback"], true);
  EXPECT_EQ(answer["steps"].back()["converged"], true);
  EXPECT_EQ(json::parse(run_tactel({"solve", parabola, "--json", "-"}).out)["fallback"], false);
}

TEST(SolveCommand, WritesTheRubberOfAPad) {
  const ScratchFolder folder;
  const std::string rubber = folder / "rubber.vts", scene = text_of(source_file("examples/pad.toml"));
  ASSERT_EQ(run_tactel({"solve", source_file("examples/pad.toml"), "--field", rubber}).exit_code, 0);
  EXPECT_THAT(text_of(rubber), HasSubstr("<VTKFile type=\"StructuredGrid\""));
  const std::string sides =
      folder.write("sides.toml", std::string(scene).insert(scene.find("[sensor]") + 8, "\nlength = 19\nwidth = 19"));
  EXPECT_TRUE(is_refused(run_tactel({"solve", sides, "--field", rubber}),
                         {"--field = ", "must be a .vtu, of cells", "held sides"}));
}

TEST(SolveCommand, WritesEveryOutput) {
  const ScratchFolder folder;
  const std::string answer = folder / "a.json", svg = folder / "a.svg", field = folder / "a.vtu";
  EXPECT_EQ(run_tactel({"solve", parabola, "--json", answer, "--plot", svg, "--field", field, "--step", "5"}).exit_code,
            0);
  EXPECT_TRUE(json::accept(text_of(answer)));
  EXPECT_THAT(text_of(svg), HasSubstr("depth 0.15 mm, drag 0.2 mm"));
  EXPECT_THAT(text_of(field), HasSubstr("<VTKFile type=\"UnstructuredGrid\""));
  EXPECT_EQ(folder.files(), 3u) << "temporary files are left";
}

/// The data of the page's contact.
json contact_of(const std::string& page) {
  const std::string mark = "<script type=\"application/json\">";
  const std::size_t from = page.find(mark, page.find("data-kind=\"contact\"")) + mark.size();
  return json::parse(page.substr(from, page.find("</script>", from) - from));
}

// The step with stick and slip is shown first; --step names another.
TEST(SolveCommand, PageHoldsTheAnswer) {
  const ScratchFolder folder;
  const std::string page = folder / "contact.html";
  ASSERT_EQ(run_tactel({"solve", parabola, "--html", page, "--json", folder / "contact.json"}).exit_code, 0);
  const json answer = json::parse(text_of(folder / "contact.json")), contact = contact_of(text_of(page));
  EXPECT_THAT(text_of(page), HasSubstr("The whole contact slides from load step 7 on"));
  EXPECT_LT(text_of(page).size(), 300'000u);
  ASSERT_EQ(contact["steps"].size(), 9u);
  EXPECT_EQ(contact["shown"], 5);
  for (std::size_t k = 0; k < 9; ++k)
    EXPECT_NEAR(contact["steps"][k]["Q"].get<double>(), answer["steps"][k]["Q"].get<double>(), 1e-5);
  ASSERT_EQ(run_tactel({"solve", parabola, "--html", page, "--step", "2"}).exit_code, 0);
  EXPECT_EQ(contact_of(text_of(page))["shown"], 1);
}

// All cells slip while S is still below what the page shows as 1.
TEST(SolveCommand, APageSaysSWhereAllOfItSlides) {
  const ScratchFolder folder;
  const std::string
      scene = folder.write(
          "pad.toml",
          "[sensor]\nkind = \"pad\"\npitch = 4.7\nthickness = 4.0\nyoung = 0.5\npoisson = 0.48\n[indenter]\n"
          "shape = \"sphere\"\nradius = 10\n[contact]\nfriction = 0.5\n[load]\nindentation = "
          "0.5\ntangential_step = [0.04, 0.0]\ntangential_steps = 40\n"),
      page = folder / "pad.html";
  ASSERT_EQ(run_tactel({"solve", scene, "--rung", "pad-8", "--html", page}).exit_code, 0);
  EXPECT_THAT(text_of(page), ::testing::ContainsRegex("on: S = 0\\.99[0-9] there and 1\\.000 at the end"));
}

// Of a patch: the elements' widths, and the stress of a mesh under its tractions, whose surface lies on the indenter to
// within the two models' difference of a few percent of the depth.
TEST(SolveCommand, PageOfAPatchHasTheFieldOfAMesh) {
  const ScratchFolder folder;
  const std::string page = folder / "contact.html";
  ASSERT_EQ(run_tactel({"solve", parabola, "--rung", "patch-24", "--html", page}).exit_code, 0);
  EXPECT_THAT(text_of(page), HasSubstr("under the patch&#39;s tractions"));
  const json contact = contact_of(text_of(page));
  EXPECT_EQ(contact["surface_width"].size(), contact["surface_x"].size());
  const json& step = contact["steps"][0];
  const std::string status = step["status"];
  int touching = 0;
  for (std::size_t i = 0; i < status.size(); ++i) {
    if (status[i] == 'o') continue;
    const double x = contact["surface_x"][i];
    EXPECT_NEAR(step["uy"][i].get<double>(), x * x / 20 - 0.15, 0.008) << x;  // the example's radius is 10 mm
    ++touching;
  }
  EXPECT_GT(touching, 10);
}

TEST(SolveCommand, PngIsAPng) {
  const ScratchFolder folder;
  const std::string png = folder / "a.png";
  EXPECT_EQ(run_tactel({"solve", parabola, "--plot", png}).exit_code, 0);
  EXPECT_EQ(text_of(png).substr(0, 8), "\x89PNG\r\n\x1a\n");
}

TEST(SolveCommand, WarnsOfDeepIndenters) {
  const ScratchFolder folder;
  const std::string scene =
      folder.write("scene.toml", "[indenter]\nshape = \"parabola\"\nradius = 10\n[load]\nindentation = 0.31\n");
  EXPECT_THAT(run_tactel({"solve", scene}).err,
              HasSubstr("warning: the indenter is 0.31 mm deep, 21 % of the thickness"));
  EXPECT_EQ(run_tactel({"solve", scene, "--quiet"}).err, "");
}

TEST(SolveCommand, WarnsOfOtherUnits) {
  const ScratchFolder folder;
  const std::string scene =
      folder.write("scene.toml",
                   "[sensor]\nyoung = 2e6\n[indenter]\nshape = \"parabola\"\nradius = 10\n[load]\nindentation = 0.1\n");
  const ChildResult result = run_tactel({"solve", scene, "--json", "-"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.err, HasSubstr("warning: sensor.young = 2e+06 MPa: usual are 0.01 to 100 MPa; check the unit"));
  EXPECT_THAT(json::parse(result.out)["warnings"].dump(), HasSubstr("sensor.young"));
}

// The title of a scene is written into plots and pages.
TEST(SolveCommand, ATitleIsNeverRun) {
  const ScratchFolder folder;
  const std::string scene = folder.write("scene.toml", "title = \"`touch " + (folder / "made").string() +
                                                           "`</script><b>''\"\n[indenter]\nshape = "
                                                           "\"parabola\"\nradius = 10\n[load]\nindentation = 0.1\n"),
                    plot = folder / "a.svg", page = folder / "a.html";
  EXPECT_EQ(run_tactel({"solve", scene, "--plot", plot, "--html", page}).exit_code, 0);
  EXPECT_EQ(folder.files(), 3u);
  EXPECT_THAT(text_of(plot), HasSubstr("`touch "));
  EXPECT_THAT(text_of(page), testing::Not(HasSubstr("</script><b>")));
}

TEST(SolveOnHost, MissedToleranceEndsWithFour) {
  const ChildResult result = run_tactel({"solve", parabola, "--solver", "full-mesh", "--tolerance", "1e-30"});
  EXPECT_EQ(result.exit_code, 4);
  EXPECT_THAT(result.out, HasSubstr(" NO "));
  EXPECT_THAT(result.err, HasSubstr("some steps missed their tolerance"));
}

// At depth 0 nothing touches, and so nothing slides, however far it is dragged.
TEST(SolveCommand, ADragThatNeverSlidesEndsWithFour) {
  const std::string scene = source_file("tests/host/contact/scenes/flat_released_and_dragged.toml");
  const ChildResult result = run_tactel({"solve", scene});
  EXPECT_EQ(result.exit_code, 4);
  EXPECT_THAT(result.err, HasSubstr("warning: the drag until sliding touches nothing: it ends with its first step"));
  EXPECT_THAT(result.out, HasSubstr("the contact does not slide as a whole"));
}

// 1000 steps of 1e-6 mm do not make mu = 0.5 slide: the rubber follows by more than that.
TEST(SolveCommand, ADragThatTouchesAndNeverSlidesEndsWithFour) {
  const ScratchFolder folder;
  const std::string scene = folder.write("scene.toml",
                                         "[sensor]\ncolumns = 11\nrows = 4\n[indenter]\nshape = \"parabola\"\n"
                                         "radius = 10\n[contact]\nfriction = 0.5\n"
                                         "[load]\nindentation = 0.1\ntangential_step = 1e-6\n");
  const ChildResult result = run_tactel({"solve", scene});
  EXPECT_EQ(result.exit_code, 4);
  EXPECT_THAT(result.err, HasSubstr("warning: the contact does not slide as a whole within 1000 steps of 1e-06 mm"));
  EXPECT_THAT(result.out, HasSubstr("the contact does not slide as a whole"));
}

// A wide flat driven by force, nearly incompressible rubber and mu = 1.9: sweeps and exact solver certify answers whose
// Q differ by more than a percent, and that is said.
TEST(SolveCommand, TwoSolutionsOfAWideFlatAreNamed) {
  const std::string scene = source_file("tests/host/contact/scenes/wide_flat_with_two_solutions.toml");
  const ChildResult sweeps = run_tactel({"solve", scene, "--json", "-"}),
                    exact = run_tactel({"solve", scene, "--solver", "full-mesh", "--json", "-"});
  ASSERT_EQ(sweeps.exit_code, 0) << sweeps.err;
  ASSERT_EQ(exact.exit_code, 0) << exact.err;
  const double one = json::parse(sweeps.out)["steps"].back()["Q"], other = json::parse(exact.out)["steps"].back()["Q"];
  EXPECT_GT(std::abs(one - other), 0.01 * std::abs(other));
  EXPECT_THAT(sweeps.err, HasSubstr("warning: this contact has several solutions: with friction 1.9"));
}

// P of the example is 2.7 % off; the whole answer says so, on the device and on the host, and every other key stays.
TEST(SolveCommand, SaysWhatTheMeshLeavesUndetermined) {
  for (const char* solver : {"batched", "full-mesh"}) {
    const ChildResult table = run_tactel({"solve", parabola, "--solver", solver});
    EXPECT_THAT(table.out, HasSubstr("error of the mesh to expect (from 81 x 21): S 0.0"));
    const auto json = nlohmann::json::parse(run_tactel({"solve", parabola, "--solver", solver, "--json", "-"}).out);
    EXPECT_GT(json["discretisation_error"]["P"], 0.027);
    EXPECT_LT(json["discretisation_error"]["P"], 0.08);
  }
}

TEST(SolveCommand, WarnsOfSlidingFar) {
  const std::string scene = source_file("tests/host/contact/scenes/dragged_far.toml");
  const ChildResult result = run_tactel({"solve", scene});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.err, HasSubstr("mm over the rubber, more than 0.5 mm"));
  EXPECT_EQ(run_tactel({"solve", scene, "--quiet"}).err, "");
}

TEST(SolveCommand, SinglePrecisionSaysSo) {
  const json answer = json::parse(run_tactel({"solve", parabola, "--json", "-", "--precision", "fp32"}).out);
  EXPECT_EQ(answer["precision"], "fp32");
  const json exact = json::parse(run_tactel({"solve", parabola, "--json", "-", "--solver", "full-mesh"}).out);
  // fp32 carries 6e-8, the condensed compliance amplifies it by its condition of up to 300
  EXPECT_NEAR(answer["steps"][8]["P"].get<double>(), exact["steps"][8]["P"].get<double>(), 1e-4);
}

TEST(CommandLine, HelpAndVersionEndWithZero) {
  EXPECT_EQ(run_tactel({"--version"}).out, "tactel 1.0.0-rc1\n");
  const ChildResult all = run_tactel({"--help"});
  EXPECT_EQ(all.exit_code, 0);
  EXPECT_THAT(all.out, testing::AllOf(HasSubstr("devices"), HasSubstr("solve")));
  const ChildResult solve = run_tactel({"solve", "--help"});
  EXPECT_EQ(solve.exit_code, 0);
  EXPECT_THAT(solve.out, testing::AllOf(HasSubstr("--json"), HasSubstr("--plot"), HasSubstr("--field"),
                                        HasSubstr("MPa"), HasSubstr("default")));
}

TEST(CommandLineOnDevice, DevicesAreListed) {
  const ChildResult result = run_tactel({"devices"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("cpu"));
  EXPECT_GE(json::parse(run_tactel({"devices", "--json"}).out).size(), 1u);
}

class WrongCallTest : public testing::TestWithParam<WrongCall> {};

TEST_P(WrongCallTest, EndsWithTwoAndSaysWhy) {
  const ChildResult result = run_tactel(words(GetParam().arguments));
  EXPECT_EQ(result.exit_code, 2) << result.out;
  EXPECT_THAT(result.err, HasSubstr(GetParam().says));
  EXPECT_EQ(result.out, "");
}

const WrongCall wrong_calls[] = {
    {"Nothing", "", "Usage: tactel "},
    {"UnknownCommand", "solv " + parabola, "; did you mean solve?"},
    {"BeginningOfACommand", "calib plan", "; did you mean calibrate?"},
    {"NestedCommandAlone", "bound a.onnx b.h5", "; did you mean calibrate bound?"},
    {"OptionBeforeTheCommand", "--quiet solve a.toml", "; options and files stand behind it"},
    {"FileBeforeTheCommand", "a.toml solve", "; options and files stand behind it"},
    {"OptionOfTheProgram", "--hlep", "; did you mean --help?"},
    {"TwoScenes", "solve " + parabola + " " + parabola, parabola},
    {"NegativeTolerance", "solve " + parabola + " --tolerance -1", "--tolerance"},
    {"AccuracyIsNoNumber", "solve " + parabola + " --accuracy nan", "--accuracy = nan: must be a finite number"},
    {"AccuracyIsInfinite", "solve " + parabola + " --accuracy inf", "--accuracy = inf: must be a number above 0"},
    {"ToleranceIsNoNumber", "solve " + parabola + " --tolerance nan", "--tolerance = nan: must be a finite number"},
    {"ReferenceInSingle", "solve " + parabola + " --solver full-mesh --precision fp32",
     "--precision = fp32: must be fp64 with --solver full-mesh"},
    {"ReferenceOnADevice", "solve " + parabola + " --solver full-mesh --device 0", "--device = 0: must be left out"},
    {"NoSuchFolder", "solve " + parabola + " --json /no/such/folder/a.json",
     "--json = /no/such/folder/a.json: must be a file that can be written (No such file or directory; make the folder "
     "first)"},
    {"FieldOfLayers", "solve " + source_file("examples/covered_line.toml") + " --field a.vtu",
     "--field = a.vtu: must be left out with sensor.layers"},
    {"OutputIsFolder", "solve " + parabola + " --field /tmp",
     "--field = /tmp: must be a file that can be written (it names a folder)"},
    {"PlotAsGif", "solve " + parabola + " --plot /tmp/a.gif",
     "--plot = /tmp/a.gif: must be a file name that ends in .svg, .png or .pdf"}};
INSTANTIATE_TEST_SUITE_P(All, WrongCallTest, testing::ValuesIn(wrong_calls),
                         [](const auto& info) { return info.param.name; });

const WrongCall wrong_on_device[] = {
    {"UnknownDevice", "solve " + parabola + " --device abacus", "abacus"},
    {"StepBeyondTheLast", "solve " + parabola + " --step 10", "--step = 10: must be a load step of this scene, 1 to 9"},
    {"StepZero", "solve " + parabola + " --step 0", "--step = 0: must be a load step of this scene, 1 to 9"}};
INSTANTIATE_TEST_SUITE_P(OnDevice, WrongCallTest, testing::ValuesIn(wrong_on_device),
                         [](const auto& info) { return info.param.name; });

TEST(CommandLine, SaysThatAConverterIsMissing) {
  const Environment without_converter("PATH", "/nowhere");
  const ScratchFolder folder;
  const ChildResult result = run_tactel({"solve", parabola, "--plot", folder / "a.png"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("ends in .svg, or rsvg-convert installed (apt-get install librsvg2-bin)"));
  EXPECT_EQ(folder.files(), 0u);
}

}  // namespace tactel::host::solve_command_test
