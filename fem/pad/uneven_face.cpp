// SPDX-License-Identifier: Apache-2.0
#include "fem/pad/uneven_face.h"

#include <cmath>
#include <complex>

namespace tactel::fem {

UnevenFace UnevenFace::of(double rms, double length, std::span<const double> normal, std::span<const double> phase) {
  UnevenFace face{rms * std::sqrt(2.0 / static_cast<double>(phase.size()))};
  for (std::size_t k = 0; k < phase.size(); ++k)
    face.waves.push_back({normal[2 * k] / length, normal[2 * k + 1] / length, phase[k]});
  return face;
}

double UnevenFace::height(double x, double y) const {
  double sum = 0;
  for (const Wave& wave : waves) sum += std::cos(wave.kx * x + wave.ky * y + wave.phase);
  return amplitude * sum;
}

// On a grid the phase of a wave is a part of the row and one of the column: cos of their sum, by powers of two phases.
void UnevenFace::add(const PadCells& cells, std::array<double, 2> place, double angle,
                     std::span<double> heights) const {
  const double cosine = std::cos(angle), sine = std::sin(angle);
  const auto nx = static_cast<std::size_t>(cells.n), ny = static_cast<std::size_t>(cells.ny());
  std::vector<double> real(ny), imaginary(ny);
  for (const Wave& wave : waves) {
    const double kx = cosine * wave.kx - sine * wave.ky, ky = sine * wave.kx + cosine * wave.ky;  // on the pad
    const std::complex<double> along_x = std::polar(1.0, kx * cells.hx), along_y = std::polar(1.0, ky * cells.hy);
    std::complex<double> column = 1;
    for (std::size_t j = 0; j < ny; ++j, column *= along_y) real[j] = column.real(), imaginary[j] = column.imag();
    std::complex<double> row =
        std::polar(amplitude, wave.phase + kx * (cells.x(0) - place[0]) + ky * (cells.y(0) - place[1]));
    for (std::size_t i = 0; i < nx; ++i, row *= along_x) {
      const double a = row.real(), b = row.imag();
      for (std::size_t j = 0; j < ny; ++j) heights[i * ny + j] += a * real[j] - b * imaginary[j];
    }
  }
}

}  // namespace tactel::fem
