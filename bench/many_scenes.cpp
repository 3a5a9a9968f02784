// SPDX-License-Identifier: Apache-2.0

// The rate of tactel::solve_many, for bench/many_scenes.py: a line of seconds for each call. Usage: tactel_many_scenes
// SCENES CALLS [pads]
#include <tactel/simulate.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace {

/// Number k of a sequence that fills 0 ... 1 evenly.
double spread(std::size_t k, double step) { return std::fmod(0.5 + static_cast<double>(k) * step, 1.0); }

/// The scenes of bench/many_scenes.py.
std::vector<tactel::Scene> scenes(std::size_t count) {
  std::vector<tactel::Scene> all(count);
  for (std::size_t k = 0; k < count; ++k) {
    all[k].indenter.shape = tactel::Parabola{.radius = 5 + 45 * spread(k, 0.6180339887498949)};
    all[k].friction = 0.1 + 0.9 * spread(k, 0.7548776662466927);
    all[k].load = tactel::press(0.05 + 0.15 * spread(k, 0.5698402909980532)).drag(0.03, 8);
  }
  return all;
}

/// The same on pads.
std::vector<tactel::PadScene> pad_scenes(std::size_t count) {
  std::vector<tactel::PadScene> all(count);
  for (std::size_t k = 0; k < count; ++k) {
    all[k].indenter.shape = tactel::Sphere{.radius = 5 + 10 * spread(k, 0.6180339887498949)};
    all[k].friction = 0.1 + 0.9 * spread(k, 0.7548776662466927);
    all[k].load = tactel::press_pad(0.05 + 0.25 * spread(k, 0.5698402909980532)).drag({0.03, 0.01}, 8, 0.2);
  }
  return all;
}

template <class Scene>
void time_calls(const std::vector<Scene>& all, long calls) {
  tactel::solve_many(std::span(all).first(std::min<std::size_t>(all.size(), 100)));  // kernels are compiled
  for (long k = 0; k < calls; ++k) {
    const auto start = std::chrono::steady_clock::now();
    const auto paths = tactel::solve_many(all);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    double sum = 0;
    for (const double s : paths.slip_index) sum += s;
    std::printf("%.4f %.17g\n", seconds, sum);
  }
}

}  // namespace

int main(int count, char** words) try {
  const std::size_t scenes_asked = count > 1 ? std::strtoul(words[1], nullptr, 10) : 100000;
  const long calls = count > 2 ? std::strtol(words[2], nullptr, 10) : 3;
  if (count > 3)
    time_calls(pad_scenes(scenes_asked), calls);
  else
    time_calls(scenes(scenes_asked), calls);
} catch (const tactel::Error& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 2;
}
