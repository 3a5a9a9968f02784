// SPDX-License-Identifier: Apache-2.0

// Writes what fem/ makes of a sensor, for independent programs: `dump_condensation ELEMENT STRESS NU COLUMNS ROWS
// GRADING LENGTH THICKNESS TACTELS` prints to stdout, as raw doubles in row order, C, T and the tactel stresses.
#include <cstdio>
#include <cstdlib>
#include <string>

#include "fem/mesh/condensation.h"

namespace {

void write(const Eigen::MatrixXd& matrix) {
  const Eigen::Matrix<double, -1, -1, Eigen::RowMajor> rows = matrix;
  std::fwrite(rows.data(), sizeof(double), static_cast<std::size_t>(rows.size()), stdout);
}

}  // namespace

int main(int count, char** word) {
  if (count != 10) return 2;
  using namespace tactel::fem;
  Sensor sensor;
  for (Element element : {Element::bbar, Element::q4, Element::q4i, Element::q8})
    if (std::string(word[1]) == name(element)) sensor.element = element;
  for (StressRecovery recovery : {StressRecovery::reaction, StressRecovery::element})
    if (std::string(word[2]) == name(recovery)) sensor.stress = recovery;
  sensor.poisson = std::atof(word[3]);
  sensor.columns = std::atoi(word[4]);
  sensor.rows = std::atoi(word[5]);
  sensor.grading = std::atof(word[6]);
  sensor.length = std::atof(word[7]);
  sensor.thickness = std::atof(word[8]);
  sensor.tactels = std::atoi(word[9]);
  const Condensation c = condense(sensor);
  write(c.compliance);
  write(c.base_force);
  write(c.tactel_stress);
}
