// SPDX-License-Identifier: Apache-2.0

// Sets of contacts on pads: their rows are those of `tactel solve`, and depend on the contact alone.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "fem/pad/pad_markers.h"
#include "host/answers/solve.h"
#include "host/sets/check_set.h"
#include "host/sets/set_simulator.h"
#include "tests/host/device/test_device.h"
#include "tests/host/sets/same_bytes.h"
#include "tests/host/support/run_tactel.h"

namespace tactel::host::pad_set_test {

constexpr const char* sweep_text = R"(
[sweep]
contacts = 60
seed = 26
[sensor]
kind = "pad"
tactels = [4, 3]
pitch = [2, 3]
thickness = { uniform = [1.5, 2.5] }
young = { log_uniform = [0.5, 3] }
poisson = { choice = [0.4, 0.5] }
[contact]
friction = { uniform = [0.1, 1] }
[[indenter]]
shape = "sphere"
radius = { log_uniform = [3, 20] }
position = [{ uniform = [-3, 3] }, { uniform = [-3, 3] }]
[[indenter]]
shape = "box"
half_widths = [{ uniform = [1, 2] }, 2]
edge = 0.3
yaw = { uniform = [0, 90] }
tilt = 1
tilt_direction = { uniform = [0, 360] }
[[load]]
indentation = [0.05, { uniform = [0.1, 0.25] }]
tangential = [[{ uniform = [-0.1, 0.1] }, 0.05], [0.1, { uniform = [-0.1, 0.1] }]]
twist = [{ uniform = [-3, 3] }, 2]
[[load]]
normal_force = { log_uniform = [0.5, 3] }
tangential_step = [{ uniform = [-0.05, 0.05] }, 0.03]
tangential_steps = 3
)";

class PadSet : public testing::Test {
 protected:
  PadSource source(const std::string& text = sweep_text) { return PadSource::read(folder_.write("sweep.toml", text)); }
  ScratchFolder folder_;
  Executor executor_{device()};
  SetOptions options_{.pad = rung_named<PadRung>("pad-8")};
};

std::vector<float> row_of(const std::vector<float>& all, std::size_t row, std::size_t width) {
  return {all.begin() + static_cast<std::ptrdiff_t>(row * width),
          all.begin() + static_cast<std::ptrdiff_t>((row + 1) * width)};
}

/// A set's numbers are those of the solution, to the bit: a lane's do not depend on its neighbours.
TEST_F(PadSet, RowsAreThoseOfSolve) {
  const PadSource sweep = source();
  const ContactSet set = SetSimulator(executor_, sweep, options_).simulate(0, 60);
  ASSERT_EQ(set.inputs, 36);
  SolveOptions solving;
  solving.rung = "pad-8", solving.precision = "fp32";
  std::size_t row = 0;
  for (std::uint64_t k = 0; k < 20; ++k) {
    const auto [scene, kind] = sweep.contact(k);
    const PadOutcome outcome = solve(scene, solving);
    const std::size_t pressed = pressing_targets(scene.load);
    // Over the shear of the layer under mu times the mean pressure.
    double slid = 0, before = 0, path = 0, path_before = 0;
    const auto add_slide = [&, &scene = scene](const fem::PadStep& step) {
      const double G = scene.sensor.young / (2 * (1 + scene.sensor.poisson));
      const double limit = scene.friction * step.P / step.area / G * scene.sensor.thickness;
      slid += limit > 0 ? (step.slid - before) / limit : 0, before = step.slid;
      path += limit > 0 ? (step.slip_path - path_before) / limit : 0, path_before = step.slip_path;
    };
    for (std::size_t step = 0; step + 1 < pressed; ++step) add_slide(outcome.solution.steps[step]);
    for (std::size_t step = pressed - 1; step < outcome.solution.steps.size(); ++step, ++row) {
      SCOPED_TRACE(testing::Message() << "contact " << k << ", step " << step);
      const fem::PadStep& expected = outcome.solution.steps[step];
      ASSERT_LT(row, set.rows());
      ASSERT_EQ(set.contact[row], k);
      ASSERT_EQ(set.step[row], step);
      EXPECT_EQ(set.indenter[row], kind);
      const auto f = [](double value) { return static_cast<float>(value); };
      EXPECT_EQ(set.slip_index[row], std::min(f(*expected.slip_index), 1.0f));  // rounding apart
      EXPECT_EQ(set.normal_force[row], f(expected.P));
      EXPECT_EQ(row_of(set.tangential_force, row, 2), (std::vector{f(expected.Q[0]), f(expected.Q[1])}));
      EXPECT_EQ(set.torque[row], f(expected.M));
      EXPECT_EQ(set.force_ratio[row], f(*expected.force_ratio));
      add_slide(expected);
      EXPECT_NEAR(set.slid[row], slid, 1e-6 * slid);
      // A first press on few cells has an answer of its own in both, and the ways of its cells are others.
      EXPECT_NEAR(set.slip_path[row], path, 1e-6 * path + (pressed > 1 ? 0.01 : 0));
      EXPECT_GE(set.slip_path[row], set.slid[row]);
      EXPECT_EQ(set.stick_fraction[row], f(expected.stick_fraction));
      EXPECT_EQ(set.indentation[row], f(expected.indentation));
      EXPECT_EQ(row_of(set.tangential, row, 2), (std::vector{f(expected.x), f(expected.y)}));
      EXPECT_FLOAT_EQ(set.twist[row], f(expected.twist * 180 / std::numbers::pi));
      EXPECT_EQ(set.contact_nodes[row], (expected.normal_force.array() > 0).count());
      EXPECT_EQ(set.friction[row], f(scene.friction));
      EXPECT_EQ(set.poisson[row], f(scene.sensor.poisson));
      EXPECT_EQ(set.thickness[row], f(scene.sensor.thickness));
      EXPECT_EQ(set.young[row], f(scene.sensor.young));
      EXPECT_EQ(set.residual[row], f(expected.residual.largest()));
      const Eigen::MatrixX3f stress = expected.stress.cast<float>();
      EXPECT_EQ(row_of(set.frames, row, 36), std::vector<float>(stress.data(), stress.data() + 36));
    }
  }
  EXPECT_EQ(set.contact[row], 20u);
}

TEST_F(PadSet, RowsOfAContactDependOnTheContactAlone) {
  const PadSource sweep = source();
  const ContactSet whole = SetSimulator(executor_, sweep, options_).simulate(0, 60);
  Executor one{Device("").for_one_contact()};
  const SetSimulator other(one, sweep, options_);
  expect_ranges_make(whole, other, {{0, 7}, {7, 7}, {14, 7}, {21, 7}, {28, 32}});
}

/// Contacts all over a pad with free sides, of two rubbers.
TEST_F(PadSet, FreeSidesTakeTheDevice) {
  std::string text = sweep_text;
  const auto put = [&](const std::string& from, const std::string& to) {
    text.replace(text.find(from), from.size(), to);
  };
  put("seed = 26", "seed = 26\nsensors = 2");
  put("tactels = [4, 3]", "length = 10\nwidth = 12\nsides = \"free\"\ntactels = [4, 3]");
  put("position = [{ uniform = [-3, 3] }, { uniform = [-3, 3] }]",
      "position = [{ uniform = [-5, 5] }, { uniform = [-6, 6] }]");
  const PadSource sweep = source(text);
  const ContactSet whole = SetSimulator(executor_, sweep, options_).simulate(0, 30);
  EXPECT_EQ(whole.unsolved, 0u);
  EXPECT_LT(whole.fell_back, 3u);  // the kernel solves nearly all
  EXPECT_EQ(whole.near_edge, 0u);
  Executor one{Device("").for_one_contact()};
  expect_ranges_make(whole, SetSimulator(one, sweep, options_), {{0, 7}, {7, 7}, {14, 16}});
  // The host's answers.
  SolveOptions solving;
  solving.rung = "pad-8";
  for (std::size_t row = 0; row < whole.rows() && whole.contact[row] < 4; ++row) {
    const auto [scene, kind] = sweep.contact(whole.contact[row]);
    if (row > 0 && whole.contact[row] == whole.contact[row - 1]) continue;
    const PadOutcome outcome = solve(scene, solving);
    const fem::PadStep& step = outcome.solution.steps[whole.step[row]];
    EXPECT_NEAR(whole.normal_force[row], step.P, 1e-3 * step.P) << whole.contact[row];
    EXPECT_NEAR(whole.slip_index[row], *step.slip_index, 2e-3) << whole.contact[row];
  }
}

/// Depths from 0 on: the smallest contacts have cells far below the ladder's usual rungs, the first touches nothing.
TEST_F(PadSet, DepthsFromZeroOn) {
  std::string text = sweep_text;
  text.replace(text.find("[0.05,"), 6, "[0.0,");
  const ContactSet set = SetSimulator(executor_, source(text), options_).simulate(0, 60);
  EXPECT_EQ(std::set(set.contact.begin(), set.contact.end()).size(), 60u);
  const std::string shallow =
      "[sweep]\ncontacts = 40\n[sensor]\nkind = \"pad\"\nthickness = 2.0\n"
      "[indenter]\nshape = \"sphere\"\nradius = 8\n"
      "[load]\nindentation = { choice = [0.0, 2e-5, 0.1] }\n";
  const ContactSet few = SetSimulator(executor_, source(shallow), options_).simulate(0, 40);
  const std::set<float> forces(few.normal_force.begin(), few.normal_force.end());  // no rows where nothing touches
  ASSERT_EQ(forces.size(), 2u);
  // Hertz: the rubber is thick beside the smaller contact.
  const double hertz = 4.0 / 3 * 2 / (1 - 0.45 * 0.45) * std::sqrt(8.0) * std::pow(2e-5, 1.5);
  EXPECT_NEAR(*forces.begin() / hertz, 1, 0.02);  // 8 cells along a side, and a / H = 0.006
}

std::string marked(const std::string& markers) {
  std::string text = sweep_text;
  const std::string thickness = "thickness = { uniform = [1.5, 2.5] }", poisson = "poisson = { choice = [0.4, 0.5] }";
  text.replace(text.find(thickness), thickness.size(), "thickness = 2");
  text.replace(text.find(poisson), poisson.size(), "poisson = 0.45");
  return text + "[markers]\n" + markers;
}

/// As a GPU has them: one lane, work-groups of 64 with a ragged end, and memory of its own.
TEST_F(PadSet, OnAGpuTheBytesAreTheSame) {
  const PadSource sweep = source(marked("counts = [3, 2]\n[camera]\nnoise_px = 1\n"));
  Executor gpu{Device("").as_gpu()};
  const ContactSet expected = SetSimulator(executor_, sweep, options_).simulate(0, 60),
                   found = SetSimulator(gpu, sweep, options_).simulate(0, 60);
  EXPECT_GT(expected.rows(), 60u);
  expect_same_bytes(found, expected);
}

const std::string at_a_tactel =
    "[sweep]\ncontacts = 2\n[sensor]\nkind = \"pad\"\ntactels = [4, 3]\npitch = 3\nthickness = 1.5\n"
    "[indenter]\nshape = \"sphere\"\nradius = 5\nposition = [-1.5, 3]\n"  // tactel 1 along x, 2 along y
    "[load]\nindentation = 0.15\ntangential = [[0.05, 0]]\n";

/// The rubber under the sphere is pressed, and dragged to +x: sigma_z < 0, tau_x > 0, each largest at its tactel.
TEST_F(PadSet, InputsAreSigmaZThenTauXThenTauY) {
  const ContactSet set = SetSimulator(executor_, source(at_a_tactel), options_).simulate(0, 1);
  ASSERT_EQ(set.rows(), 2u);
  const std::vector<float> pressed = row_of(set.frames, 0, 36);
  std::vector<float> dragged = row_of(set.frames, 1, 36);
  for (std::size_t k = 0; k < 36; ++k) dragged[k] -= pressed[k];  // which shears outwards
  const auto largest = [](const std::vector<float>& frame, int axis) {
    const auto at = frame.begin() + 12 * axis;
    return std::max_element(at, at + 12, [](float a, float b) { return std::abs(a) < std::abs(b); }) - at;
  };
  EXPECT_EQ(largest(pressed, 0), 2 * 4 + 1);
  EXPECT_LT(pressed[9], 0);
  EXPECT_EQ(largest(dragged, 1), 2 * 4 + 1);
  EXPECT_GT(dragged[12 + 9], 0);
  EXPECT_GT(dragged[12 + 9], 10 * std::abs(dragged[24 + 9]));  // along y nothing drags
}

TEST_F(PadSet, OneAxisIsTheFirstOfThree) {
  std::string text = at_a_tactel;
  const ContactSet three = SetSimulator(executor_, source(text), options_).simulate(0, 1);
  text.insert(text.find("tactels"), "axes = 1\n");
  const ContactSet one = SetSimulator(executor_, source(text), options_).simulate(0, 1);
  ASSERT_EQ(one.inputs, 12);
  for (std::size_t row = 0; row < 2; ++row) {
    const std::vector<float> all = row_of(three.frames, row, 36);
    EXPECT_EQ(row_of(one.frames, row, 12), std::vector<float>(all.begin(), all.begin() + 12));
  }
}

/// The rows of the pressing come first; after a release nothing is left to judge.
TEST_F(PadSet, PathsReleaseAndPressAgain) {
  const PadSource sweep = source(
      "[sweep]\ncontacts = 3\npress_rows = true\n[sensor]\nkind = \"pad\"\nthickness = 2\n"
      "[indenter]\nshape = \"sphere\"\nradius = 6\n[load]\nindentation = 0.2\n"
      "[load.irregular]\npresses = 2\npress_steps = 2\nstroke = 0.05\nstroke_steps = 2\ntwist = 2\n");
  const ContactSet set = SetSimulator(executor_, sweep, options_).simulate(0, 3);
  // a press of 2, a stroke of 2, a release of 2 that ends without contact, a press of 2, a stroke of 2
  ASSERT_EQ(set.rows(), 3u * 9);
  const std::vector<std::uint32_t> steps(set.step.begin(), set.step.begin() + 9);
  EXPECT_EQ(steps, (std::vector<std::uint32_t>{0, 1, 2, 3, 4, 6, 7, 8, 9}));
  EXPECT_TRUE(std::ranges::all_of(set.status, [](int status) { return status != 2; }));
  EXPECT_NEAR(set.normal_force[6] / set.normal_force[1], 1, 0.02);  // at the same depth, but for friction's memory
}

/// Cells are laid for the deepest step: those of the pressing on few of them are solved alone, those after a release
/// are marked. Pressed alone, a step has the bits of `solve`.
TEST_F(PadSet, RowsOnFewCellsAreSolvedAloneOrMarked) {
  const std::string text =
      "[sweep]\ncontacts = 4\npress_rows = true\n[sensor]\nkind = \"pad\"\nthickness = 2\n"
      "[indenter]\nshape = \"cone\"\nangle = 80\n[load]\nindentation = 0.2\n[load.irregular]\n"
      "press_steps = 4\nstroke = 0.05\nstroke_steps = 2\nrelease = 1\nrelease_to = 0.2\nrelease_steps = 1\n";
  for (const std::string& chain : {std::string(), std::string("[transducer]\nnoise_of_largest = 1e-9\n")}) {
    const PadSource sweep = source(text + chain);
    const ContactSet set = SetSimulator(executor_, sweep, options_).simulate(0, 4);
    std::size_t alone = 0, marked = 0;
    for (std::size_t row = 0; row < set.rows(); ++row) {
      const bool released = set.step[row] >= 4 && set.indentation[row] < 0.1;  // to 0.04 mm, from 0.2
      EXPECT_EQ(set.status[row] == coarse_row, released) << row;
      marked += released;
      fem::PadScene scene = sweep.contact(set.contact[row]).scene;
      const std::vector<double> depths = scene.load.indentation;
      if (set.step[row] + 1 >= depths.size()) continue;
      EXPECT_LT(set.status[row], 2);
      const double depth = depths[set.step[row]];
      scene.load = {.indentation = {depth}};
      if (depth > 0.5 * depths.back()) continue;
      ++alone;
      const PadOutcome outcome = solve(scene, {.rung = "pad-8", .precision = "fp32"});
      const fem::PadStep& expected = outcome.solution.steps.front();
      EXPECT_EQ(set.normal_force[row], static_cast<float>(expected.P)) << depth;
      EXPECT_EQ(set.slip_index[row], static_cast<float>(*expected.slip_index)) << depth;
      for (std::size_t i = 0; i < 48; ++i)
        EXPECT_NEAR(set.frames[48 * row + i],
                    expected.stress(static_cast<Eigen::Index>(i % 16), static_cast<Eigen::Index>(i / 16)),
                    chain.empty() ? 0 : 1e-6)
            << depth;
    }
    EXPECT_GE(alone, 4u);
    EXPECT_GE(marked, 4u);
    EXPECT_EQ(set.coarse, marked);
    const ContactSet part = SetSimulator(executor_, sweep, options_).simulate(2, 1);
    const auto first = static_cast<std::size_t>(std::ranges::find(set.contact, 2u) - set.contact.begin());
    for (std::size_t k = 0; k < part.rows(); ++k) EXPECT_EQ(part.normal_force[k], set.normal_force[first + k]);
  }
}

TEST_F(PadSet, FilesHoldTheColumnsOfPads) {
  const PadSource sweep = source();
  ContactSet set = SetSimulator(executor_, sweep, options_).simulate(0, 20);
  set.sweep = sweep_text, set.rung = "pad-8", set.plan = "a plan";
  const auto file = folder_ / "set.h5";
  write_contact_set(file, set);
  EXPECT_TRUE(check_contact_set(file, {}).damage.empty());
  const ContactSet read = read_contact_set(file);
  EXPECT_TRUE(read.pad);
  EXPECT_EQ(read.inputs, 36);
  EXPECT_EQ(read.axes, 3);
  EXPECT_EQ(read.frames_with_answers().axes, 3);  // a bound counts the tactels that touch
  std::vector<std::string> names;
  each_dataset(read, [&](const char* name, const auto&, int, const char*) { names.emplace_back(name); });
  EXPECT_THAT(names, testing::ElementsAre("inputs", "slip_index", "normal_force", "tangential_force", "torque",
                                          "force_ratio", "slid", "slip_path", "indentation", "tangential", "twist",
                                          "friction", "stick_fraction", "contact_nodes", "outside", "contact", "step",
                                          "indenter", "status", "residual", "poisson", "thickness", "young"));
  EXPECT_EQ(read.tangential, set.tangential);
  EXPECT_EQ(read.tangential_force, set.tangential_force);
  EXPECT_EQ(read.torque, set.torque);
  EXPECT_EQ(read.tactel_x, set.tactel_x);
  EXPECT_EQ(read.tactel_y, set.tactel_y);
  EXPECT_EQ(read.frames, set.frames);
  const SetColumns fewer = only_columns(columns_of(sweep), "inputs,torque");
  EXPECT_TRUE(fewer.has("torque"));
  EXPECT_FALSE(fewer.has("tactel_y"));
  EXPECT_FALSE(fewer.has("twist"));
}

/// Any Poisson's ratio: by polynomials, which leave 1e-7 of the tables; the sweeps' tolerance is 1e-3.
TEST_F(PadSet, EveryContactHasItsOwnPoissonsRatio) {
  std::string text = sweep_text;
  const std::string choice = "{ choice = [0.4, 0.5] }";
  text.replace(text.find(choice), choice.size(), "{ uniform = [0.2, 0.5] }");
  const PadSource sweep = source(text);
  const SetSimulator simulator(executor_, sweep, options_);
  const ContactSet whole = simulator.simulate(0, 60);
  const ContactSet part = simulator.simulate(23, 1);
  const auto row = static_cast<std::size_t>(std::ranges::find(whole.contact, 23u) - whole.contact.begin());
  ASSERT_GT(part.rows(), 0u);
  EXPECT_GT(std::set<float>(whole.poisson.begin(), whole.poisson.end()).size(), 50u);
  for (std::size_t k = 0; k < part.rows(); ++k) {
    EXPECT_EQ(row_of(part.frames, k, 36), row_of(whole.frames, row + k, 36));
    EXPECT_EQ(part.slip_index[k], whole.slip_index[row + k]);
  }
  for (std::size_t k = 0; k < whole.rows(); k += 37) {
    const fem::PadScene scene = sweep.contact(whole.contact[k]).scene;
    SCOPED_TRACE(testing::Message() << "contact " << whole.contact[k]);
    const PadOutcome outcome = solve(scene, {.rung = "pad-8", .precision = "fp32"});
    const fem::PadStep& expected = outcome.solution.steps[whole.step[k]];
    EXPECT_NEAR(whole.normal_force[k] / expected.P, 1, 1e-3);
    EXPECT_NEAR(whole.slip_index[k], *expected.slip_index, 1e-3);
    const Eigen::MatrixX3f stress = expected.stress.cast<float>();
    const float largest = stress.cwiseAbs().maxCoeff();
    for (Eigen::Index i = 0; i < 36; ++i)
      EXPECT_NEAR(whole.frames[36 * k + static_cast<std::size_t>(i)], stress(i % 12, i / 12), 1e-3 * largest);
  }
}

/// Markers have a quadrature of each cell, of even points no farther apart than the markers are deep, three or more.
/// Over a half-space a lone cell's miss 2.4 % of its largest at most, an equal pressure on 4 x 4 cells 0.22 %. Contacts
/// lie between: 1 %.
TEST_F(PadSet, MarkersMoveAsTheForcesOfSolveSay) {
  double farthest = 0;
  for (const char* depth : {"0.04", "0.3"}) {
    const PadSource sweep = source(marked("counts = [9, 5]\npitch = [0.7, 1]\ndepth = ") + depth);
    const ContactSet set = SetSimulator(executor_, sweep, options_).simulate(0, 60);
    ASSERT_EQ(set.marker_numbers, 3 * 45);
    ASSERT_EQ(set.markers.size(), 3 * 45 * set.rows());
    std::uint64_t solved = sweep.contacts();
    PadOutcome outcome;
    for (std::size_t row = 0; row < set.rows(); ++row) {
      if (set.contact[row] % 4 != 0) continue;
      if (solved != set.contact[row]) {
        outcome = solve(sweep.contact(solved = set.contact[row]).scene, {.rung = "pad-8", .precision = "fp32"});
        for (fem::PadStep& step : outcome.solution.steps) step.markers.resize(0, 3);  // of the kernel
        fem::see_markers(outcome.scene, outcome.solution);
      }
      const fem::PadStep& step = outcome.solution.steps[set.step[row]];
      const double most = step.markers.cwiseAbs().maxCoeff();
      for (Eigen::Index m = 0; m < 45; ++m)
        for (Eigen::Index axis = 0; axis < 3; ++axis)
          ASSERT_NEAR(set.markers[135 * row + static_cast<std::size_t>(3 * m + axis)], step.markers(m, axis),
                      1e-2 * most)
              << "contact " << solved << ", marker " << m << ", axis " << axis << ", depth " << depth;
      farthest = std::max(farthest, most);
    }
  }
  EXPECT_GT(farthest, 0.1);
}

TEST_F(PadSet, MarkersChangeNothingElse) {
  const std::string text = marked("counts = [4, 4]\ndepth = 0.2\n");
  const PadSource sweep = source(text);
  const SetSimulator simulator(executor_, sweep, options_);
  ContactSet set = simulator.simulate(0, 30);
  const ContactSet part = simulator.simulate(17, 2);
  const auto row = static_cast<std::size_t>(std::ranges::find(set.contact, 17u) - set.contact.begin());
  ASSERT_GT(part.rows(), 0u);
  for (std::size_t k = 0; k < part.rows(); ++k)
    EXPECT_EQ(row_of(part.markers, k, 48), row_of(set.markers, row + k, 48)) << k;
  const PadSource plain = source(text.substr(0, text.find("[markers]")));
  ContactSet without = SetSimulator(executor_, plain, options_).simulate(0, 30);
  EXPECT_TRUE(without.markers.empty());
  EXPECT_EQ(without.frames, set.frames);
  EXPECT_EQ(without.slip_index, set.slip_index);
  const auto file = folder_ / "marked.h5";
  set.sweep = text, set.rung = "pad-8", set.plan = "a plan";
  write_contact_set(file, set);
  EXPECT_TRUE(check_contact_set(file, {}).damage.empty());
  const ContactSet read = read_contact_set(file);
  EXPECT_EQ(read.marker_numbers, 48);
  EXPECT_EQ(read.markers, set.markers);
  const std::uint64_t chunks = check_contact_set(file, {}).chunks;
  set.marker_numbers = 3 * 4096, set.markers.resize(set.rows() * 3 * 4096);
  write_contact_set(file, set);
  EXPECT_GT(check_contact_set(file, {}).chunks, 3 * chunks);  // of 1 MiB at most, 4 for 64 rows
  EXPECT_FALSE(only_columns(columns_of(sweep), "inputs").has("markers"));
  EXPECT_TRUE(only_columns(columns_of(sweep), "inputs,markers").has("markers"));
}

/// Noise of 0.5 pixels: its mean over n numbers is within 4 / sqrt(n) of that of 0, its square within 4 sqrt(2 / n),
/// and its product with the next number, the next marker's, the next row's and that of another seed as far from 0.
TEST_F(PadSet, PixelsAreThoseOfTheMarkersWithNoise) {
  const std::string text = marked("counts = [7, 5]\ndepth = 0.3\n[camera]\ndistance = 25\ncentre = [320, 240]\n");
  const auto simulate = [&](const std::string& text, std::uint64_t first, std::uint64_t count) {
    const PadSource sweep = source(text);
    return SetSimulator(executor_, sweep, options_).simulate(first, count);
  };
  const ContactSet plain = simulate(text, 0, 60), set = simulate(text + "noise_px = 0.5\n", 0, 60);
  std::string reseeded = text + "noise_px = 0.5\n";
  reseeded.replace(reseeded.find("seed = 26"), 9, "seed = 27");
  ASSERT_EQ(set.pixel_numbers, 70);
  EXPECT_EQ(set.markers, plain.markers);
  EXPECT_EQ(set.frames, plain.frames);
  const PadSource sweep = source(text);
  for (std::size_t row = 0; row < set.rows(); ++row) {
    Eigen::MatrixX3d moved(35, 3);
    for (int k = 0; k < 105; ++k) moved(k / 3, k % 3) = set.markers[105 * row + static_cast<std::size_t>(k)];
    const Eigen::MatrixX2d pixels = fem::pixels_of(*sweep.camera(), *sweep.markers(), moved);
    for (int k = 0; k < 70; ++k)
      ASSERT_EQ(plain.pixels[70 * row + static_cast<std::size_t>(k)], static_cast<float>(pixels(k / 2, k % 2)));
  }
  const ContactSet other = simulate(reseeded, 0, 60);
  const auto noise_of = [](const ContactSet& seen) {  // where nothing moves is not seen: of a set without noise
    std::vector<double> noise;
    for (std::size_t i = 0; i < seen.pixels.size(); ++i) {
      const std::size_t row = i / 70, marker = i % 70 / 2, axis = i % 2;
      const double place = axis == 0 ? (marker % 7) - 3.0 : (marker / 7) - 2.0;  // mm
      const float* u = &seen.markers[105 * row + 3 * marker];
      const double at = (axis == 0 ? 320 : 240) + 20 * (place + u[axis] - place * u[2] / 25);
      noise.push_back((seen.pixels[i] - at) / 0.5);
    }
    return noise;
  };
  const std::vector<double> noise = noise_of(set), others = noise_of(other);
  const auto n = static_cast<double>(noise.size());
  ASSERT_GT(n, 1e4);
  const auto mean = [&](const auto& of) {
    double sum = 0;
    for (std::size_t i = 0; i < noise.size(); ++i) sum += of(i);
    return sum / n;
  };
  EXPECT_NEAR(mean([&](std::size_t i) { return noise[i]; }), 0, 4 / std::sqrt(n));
  EXPECT_NEAR(mean([&](std::size_t i) { return noise[i] * noise[i]; }), 1, 4 * std::sqrt(2 / n));
  for (const std::size_t apart : {1u, 2u, 4u, 70u, 140u})
    EXPECT_NEAR(mean([&](std::size_t i) { return noise[i] * noise[(i + apart) % noise.size()]; }), 0, 4 / std::sqrt(n));
  EXPECT_NEAR(mean([&](std::size_t i) { return noise[i] * others[i % others.size()]; }), 0, 4 / std::sqrt(n));
  const ContactSet part = simulate(text + "noise_px = 0.5\n", 17, 2);
  const auto row = static_cast<std::size_t>(std::ranges::find(set.contact, 17u) - set.contact.begin());
  ASSERT_GT(part.rows(), 0u);
  for (std::size_t k = 0; k < part.rows(); ++k)
    EXPECT_EQ(row_of(part.pixels, k, 70), row_of(set.pixels, row + k, 70)) << k;
  const auto file = folder_ / "seen.h5";
  write_contact_set(file, set);
  EXPECT_TRUE(check_contact_set(file, {}).damage.empty());
  EXPECT_EQ(read_contact_set(file).pixels, set.pixels);
  EXPECT_TRUE(read_contact_set(file, "markers").pixels.empty());
}

/// With rows of the pressing, first presses that touch few cells are solved alone, on cells of their own.
TEST_F(PadSet, MarkersOfPressesThatAreSolvedAlone) {
  std::string text = marked("counts = [3, 3]\npitch = 0.5\ndepth = 0.2\n");
  text.insert(text.find("seed"), "press_rows = true\n");
  const PadSource sweep = source(text);
  const ContactSet set = SetSimulator(executor_, sweep, options_).simulate(0, 30);
  std::size_t alone = 0;
  for (std::size_t row = 0; row < set.rows(); ++row) {
    const fem::PadScene scene = sweep.contact(set.contact[row]).scene;
    if (set.step[row] != 0 || pressing_targets(scene.load) < 2 || alone == 8) continue;
    const PadOutcome outcome = solve(scene, {.rung = "pad-8", .precision = "fp32"}),
                     twin = solve(scene, {.rung = "pad-8", .solver = "twin"});
    const Eigen::MatrixX3d &expected = outcome.solution.steps[0].markers, &exact = twin.solution.steps[0].markers;
    const double allowed = 1.3e-2 * exact.cwiseAbs().maxCoeff();  // 1 % by quadrature, and what sweeps leave
    for (std::size_t m = 0; m < 27; ++m) {
      const auto marker = static_cast<Eigen::Index>(m / 3), axis = static_cast<Eigen::Index>(m % 3);
      EXPECT_EQ(set.markers[27 * row + m], static_cast<float>(expected(marker, axis)));
      EXPECT_NEAR(set.markers[27 * row + m], exact(marker, axis), allowed);
    }
    ++alone;
  }
  EXPECT_GT(alone, 5u);
}

const std::string crept_text = R"(
[sweep]
contacts = 40
seed = 3
press_rows = true
[sensor]
kind = "pad"
tactels = [4, 3]
pitch = [2, 3]
thickness = 2
poisson = 0.45
young = { log_uniform = [0.5, 3] }
relaxation = [[0.15, 0.3], [0.10, 3.0]]
[[contact]]
friction = { uniform = [0.1, 1] }
[[contact]]
friction_map = [[0.7, 0.2, 0.5], [0.1, 0.6, 0.3]]
friction_pitch = 0.7
[indenter]
shape = "sphere"
radius = { log_uniform = [3, 20] }
position = [{ uniform = [-3, 3] }, { uniform = [-3, 3] }]
[[load]]
indentation = [0.05, { uniform = [0.1, 0.25] }]
tangential = [[{ uniform = [-0.1, 0.1] }, 0.05], [0.1, { uniform = [-0.1, 0.1] }], [0.1, 0.1]]
times = [0.1, 0.2, 0.3, 0.5, { log_uniform = [0.6, 100] }]
[[load]]
normal_force = { log_uniform = [0.5, 3] }
tangential_step = [{ uniform = [-0.05, 0.05] }, 0.03]
tangential_steps = 2
times = [0.1, 0.2, { log_uniform = [0.2, 100] }]
[markers]
counts = [3, 2]
depth = 0.3
)";

/// Rows of sweeps of fp32, tolerance 1e-3, beside the twin's. Where a first press touches few cells, markers miss as
/// those of lone ones: it is not solved alone, for its way counts.
TEST_F(PadSet, PathsOnRubberThatCreepsAreThoseOfSolve) {
  const PadSource sweep = source(crept_text);
  const SetSimulator simulator(executor_, sweep, options_);
  const ContactSet set = simulator.simulate(0, 40);
  EXPECT_EQ(set.fell_back, 0u);
  std::uint64_t solved = sweep.contacts();
  PadOutcome outcome;
  std::set<std::uint32_t> mapped;
  for (std::size_t row = 0; row < set.rows(); ++row) {
    if (set.contact[row] % 2 == 0) continue;
    if (solved != set.contact[row]) outcome = solve(sweep.contact(solved = set.contact[row]).scene, {.rung = "pad-8"});
    const fem::PadStep& step = outcome.solution.steps[set.step[row]];
    EXPECT_NEAR(set.normal_force[row], step.P, 3e-3 * step.P) << row;
    EXPECT_NEAR(set.tangential_force[2 * row], step.Q[0], 3e-3 * step.P) << row;
    EXPECT_NEAR(set.slip_index[row], *step.slip_index, 5e-3) << row;
    EXPECT_NEAR(set.force_ratio[row], *step.force_ratio, 5e-3) << row;
    EXPECT_NEAR(set.friction[row], step.mu, 2e-3) << row;
    if (outcome.scene.friction_map) mapped.insert(set.step[row]);
    for (int m = 0; m < 18; ++m)
      EXPECT_NEAR(set.markers[18 * row + static_cast<std::size_t>(m)], step.markers(m / 3, m % 3),
                  2.5e-2 * step.markers.cwiseAbs().maxCoeff())
          << row;
  }
  EXPECT_EQ(mapped.size(), 5u);
  const ContactSet part = simulator.simulate(17, 2);
  const auto row = static_cast<std::size_t>(std::ranges::find(set.contact, 17u) - set.contact.begin());
  for (std::size_t k = 0; k < part.rows(); ++k) {
    EXPECT_EQ(part.normal_force[k], set.normal_force[row + k]);
    EXPECT_EQ(row_of(part.markers, k, 18), row_of(set.markers, row + k, 18)) << k;
    EXPECT_EQ(row_of(part.frames, k, 36), row_of(set.frames, row + k, 36)) << k;
  }
  Executor gpu{Device("").as_gpu()};
  expect_same_bytes(SetSimulator(gpu, sweep, options_).simulate(0, 40), set);
}

/// The sphere touches less than 2 mm around its axis: 3 mm from the edge it comes nearer than the thickness. A drag of
/// 2 mm is more than a tenth of its contact.
TEST_F(PadSet, CountsContactsAtEdgesAndFarSlip) {
  const auto counts = [&](const std::string& more, const std::string& drag) {
    std::string text = at_a_tactel;
    text.insert(text.find("pitch"), more);
    const std::string old = "[[0.05, 0]]";
    text.replace(text.find(old), old.size(), drag);
    const ContactSet set = SetSimulator(executor_, source(text), options_).simulate(0, 2);
    return std::pair(set.near_edge, set.far_slip);
  };
  EXPECT_EQ(counts("", "[[0.05, 0]]"), std::pair(0ul, 0ul));
  EXPECT_EQ(counts("width = 16\n", "[[0.05, 0]]"), std::pair(0ul, 0ul));
  EXPECT_EQ(counts("width = 10\n", "[[0.05, 0]]"), std::pair(2ul, 0ul));
  EXPECT_EQ(counts("width = 10\n", "[[2, 0]]"), std::pair(2ul, 2ul));
}

/// The value of `outside` in all rows of a text's first contact.
class PadOutsideTest : public PadSet {
 protected:
  int outside(const std::string& text) {
    const ContactSet set = SetSimulator(executor_, source(text), options_).simulate(0, 1);
    EXPECT_EQ(set.outside.size(), set.rows());
    EXPECT_TRUE(std::ranges::all_of(set.outside, [&](int value) { return value == set.outside[0]; }));
    EXPECT_EQ(set.near_edge, (set.outside[0] & 1) != 0);
    EXPECT_EQ(set.unseen, (set.outside[0] & 2) != 0);
    EXPECT_EQ(set.wide_cells, (set.outside[0] & 4) != 0);
    return set.outside[0];
  }
};

/// A sphere of 5 mm, 0.15 mm deep, touches less than sqrt(2 * 5 * 0.15) = 1.22 mm around its axis at (-1.5, 3); the
/// layer is 1.5 mm thick. With a pitch of 6 mm the nearest tactel, (-3, 6), is 3.35 mm from the axis.
TEST_F(PadOutsideTest, MarksWhatTheModelDoesNotServe) {
  const auto changed = [](const std::string& from, const std::string& to) {
    std::string text = at_a_tactel;
    text.replace(text.find(from), from.size(), to);
    return text;
  };
  EXPECT_EQ(outside(at_a_tactel), 0);
  EXPECT_EQ(outside(changed("pitch", "width = 10\npitch")), 1);
  EXPECT_EQ(outside(changed("pitch = 3", "pitch = 6")), 2);
  EXPECT_EQ(outside(changed("pitch = 3", "pitch = 6\ntactel_size = 4")), 0) << "its side reaches the contact";
  EXPECT_EQ(outside(changed("position = [-1.5, 3]", "position = [-1.5, 1.5]")), 0) << "a pitch of two thicknesses";
  const std::string box = "shape = \"box\"\nhalf_widths = [";  // 8 cells a side, a little beyond a sharp edge
  EXPECT_EQ(outside(changed("shape = \"sphere\"\nradius = 5", box + "1, 1]")), 0);
  EXPECT_EQ(outside(changed("shape = \"sphere\"\nradius = 5", box + "5.5, 1]")), 0);
  EXPECT_EQ(outside(changed("shape = \"sphere\"\nradius = 5", box + "6.5, 1]")), 4);
  EXPECT_EQ(outside(changed("shape = \"sphere\"\nradius = 5", box + "1, 6.5]")), 4);
}

TEST_F(PadSet, TactelsHaveTheirPlaces) {
  const SetColumns columns = columns_of(source(at_a_tactel));
  EXPECT_EQ(columns.tactel_x, (std::vector<float>{-4.5, -1.5, 1.5, 4.5, -4.5, -1.5, 1.5, 4.5, -4.5, -1.5, 1.5, 4.5}));
  EXPECT_EQ(columns.tactel_y, (std::vector<float>{-3, -3, -3, -3, 0, 0, 0, 0, 3, 3, 3, 3}));
}

}  // namespace tactel::host::pad_set_test
