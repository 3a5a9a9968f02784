// SPDX-License-Identifier: Apache-2.0

// The reference solver judged by another program, independent_contact.py.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iomanip>

#include "fem/gap/gap_reference.h"
#include "test_paths.h"

namespace tactel::fem::independent_contact_test {

struct Case {
  std::string name, shape;
  double size;  // radius, edge angle or half-width
  Element element;
  double poisson, friction, position;
};

Scene scene_of(const Case& c) {
  Scene scene{.sensor = {.poisson = c.poisson, .element = c.element},
              .indenter = {.position = c.position},
              .friction = c.friction};
  if (c.shape == "parabola") scene.indenter.shape = Parabola{c.size};
  if (c.shape == "wedge") scene.indenter.shape = Wedge{c.size};
  if (c.shape == "flat") scene.indenter.shape = Flat{c.size};
  scene.load.indentation_steps = 2;
  scene.load.tangential = {0.05, 0.15, 0.3, 0.2, -0.05};
  return scene;
}

void write(std::ostream& out, const Eigen::VectorXd& values) {
  for (Eigen::Index i = 0; i < values.size(); ++i) out << (i ? ", " : "[") << values[i];
  out << "]";
}

void write(std::ostream& out, const Case& c) {
  const Scene scene = scene_of(c);
  const Sensor& s = scene.sensor;
  out << "{\"name\": \"" << c.name << "\", \"sensor\": {\"length\": " << s.length << ", \"thickness\": " << s.thickness
      << ", \"young\": " << s.young << ", \"poisson\": " << s.poisson << ", \"columns\": " << s.columns
      << ", \"rows\": " << s.rows << ", \"grading\": " << s.grading << ", \"element\": \"" << name(s.element)
      << "\"}, \"shape\": \"" << c.shape << "\", \"size\": " << c.size << ", \"position\": " << c.position
      << ", \"friction\": " << c.friction << ", \"steps\": [";
  const ContactSolution solution = solve_gap_reference(scene);
  for (const ContactStep& step : solution.steps) {
    EXPECT_TRUE(step.converged) << c.name;
    out << (&step == &solution.steps.front() ? "" : ", ") << "{\"indentation\": " << step.indentation
        << ", \"tangential\": " << step.tangential << ", \"base_force_x\": ";
    write(out, step.base_force_x);
    out << ", \"base_force_y\": ";
    write(out, step.base_force_y);
    out << "}";
  }
  out << "]}";
}

TEST(IndependentContact, AnotherProgramFindsTheSameBaseForces) {
  const std::vector<Case> cases{
      {"parabola bbar 0.45", "parabola", 10, Element::bbar, 0.45, 0.5, 0},
      {"parabola bbar 0.4999", "parabola", 10, Element::bbar, 0.4999, 0.5, 0},
      {"parabola q4 0.3", "parabola", 10, Element::q4, 0.3, 0.5, 0},
      {"parabola q4 0.49", "parabola", 50, Element::q4, 0.49, 0.2, 0.13},
      {"parabola bbar 0, mu 1", "parabola", 20, Element::bbar, 0, 1, -2.2},
      {"parabola bbar 0.49, no friction", "parabola", 20, Element::bbar, 0.49, 0, 1.1},
      {"wedge bbar 0.45", "wedge", 160, Element::bbar, 0.45, 0.4, 0.2},
      {"wedge q4 0", "wedge", 170, Element::q4, 0, 0.1, 0},
      {"wedge bbar 0.4999", "wedge", 165, Element::bbar, 0.4999, 0.8, 3},
      {"flat bbar 0.45", "flat", 2, Element::bbar, 0.45, 0.5, 0},
      {"flat q4 0.45", "flat", 3.1, Element::q4, 0.45, 0.3, 0.4},
      {"flat at the end bbar 0.3", "flat", 2, Element::bbar, 0.3, 0.2, 9},
  };
  const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "independent_contact_cases.json";
  {
    std::ofstream out(file);
    // 1e-10 is what the dense inverse of the other program leaves at nu = 0.4999; the rest agree to 1e-12.
    out << std::setprecision(17) << "{\"agreement\": 1e-10, \"cases\": [";
    for (const Case& c : cases) {
      if (&c != &cases.front()) out << ",\n";
      write(out, c);
    }
    out << "]}\n";
  }
  // Debian's python3 is the one that has numpy, whatever else comes first in PATH.
  const std::string command =
      "/usr/bin/python3 " TACTEL_SOURCE_DIR "/tests/fem/independent_contact.py " + file.string();
  EXPECT_EQ(std::system(command.c_str()), 0) << command;
}

}  // namespace tactel::fem::independent_contact_test
