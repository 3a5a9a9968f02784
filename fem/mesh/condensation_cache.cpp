// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <utility>

#include "fem/mesh/condensation.h"
#include "fem/numbers/array_cache.h"
#include "fem/numbers/number_text.h"
#include "fem/numbers/processor.h"

namespace tactel::fem {
namespace {

/// All that C, T and the tactel stresses depend on, to the last digit: not E, which only scales. TACTEL_FEM_FINGERPRINT
/// is made of the sources that form them and of the compiler's options; the processor orders sums. Another formula or
/// rounding, another key.
std::string key_text(const Sensor& s) {
  return "tactel condensation\nbuild " TACTEL_FEM_FINGERPRINT "\nprocessor " + processor_text() + "\nlength " +
         number_text(s.length) + "\nthickness " + number_text(s.thickness) + "\npoisson " + number_text(s.poisson) +
         "\ncolumns " + std::to_string(s.columns) + "\nrows " + std::to_string(s.rows) + "\ngrading " +
         number_text(s.grading) + "\nelement " + name(s.element) + "\ntactels " + std::to_string(s.tactels) +
         "\nspan " + number_text(s.span()) + "\nwidth " + number_text(s.tactel_width) + "\nstress " + name(s.stress) +
         "\n" + layers_text(s);
}

/// A result of the right sizes for this sensor, to be filled.
Condensation empty_condensation(const Sensor& s) {
  const Eigen::Index loads = 2 * s.columns, base_nodes = s.element == Element::q8 ? 2 * s.columns - 1 : s.columns;
  return {Eigen::MatrixXd(loads, loads),         Eigen::MatrixXd(2 * base_nodes, loads),
          Eigen::MatrixXd(2 * s.tactels, loads), Eigen::VectorXd(s.columns),
          Eigen::VectorXd(base_nodes),           Eigen::VectorXd(s.tactels)};
}

/// The arrays in the file's order; `Number`: double, or const double of a constant result.
template <class Number, class Result>
std::array<std::span<Number>, 6> arrays_of(Result& c) {
  const auto all = [](auto& matrix) {
    return std::span<Number>(matrix.data(), static_cast<std::size_t>(matrix.size()));
  };
  return {all(c.compliance), all(c.base_force), all(c.tactel_stress), all(c.surface_x), all(c.base_x), all(c.tactel_x)};
}

}  // namespace

Condensation condense_cached(const Sensor& sensor, const std::filesystem::path& directory) {
  validate(sensor);
  const CacheFile file = cache_file(directory, "block", "condensation", key_text(sensor));
  Condensation result = empty_condensation(sensor);
  if (read_arrays(file, arrays_of<double>(result))) return result;
  result = condense(sensor);
  write_arrays(file, arrays_of<const double>(std::as_const(result)));
  return result;
}

}  // namespace tactel::fem
