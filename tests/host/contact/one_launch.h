// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <xxhash.h>

#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "fem/gap/contact_solution.h"
#include "fem/scenes/scene.h"

namespace tactel::tests {

/// The batch of one launch of PatchContact or GapSweep; outputs and all unused inputs hold NaN before it.
template <class Launcher>
auto ran(const Launcher& launcher, std::span<const fem::Scene> scenes, std::size_t largest_chunk = 4096) {
  auto batch = launcher.prepare(scenes);
  batch.fill_outputs(NAN);
  batch.fill_unused(NAN);
  batch.run({.largest_chunk = largest_chunk});
  return batch;
}

using Hashes = std::vector<std::uint64_t>;

/// Of all numbers of a solution.
inline std::uint64_t hash(const fem::ContactSolution& solution) {
  std::vector<double> numbers(solution.surface_x.begin(), solution.surface_x.end());
  for (const fem::ContactStep& s : solution.steps) {
    numbers.insert(numbers.end(), {s.indentation, s.tangential, s.P, s.Q, s.slip_index.value_or(-1), s.slip_distance,
                                   double(s.converged), double(s.iterations), s.residual.penetration, s.residual.cone,
                                   s.residual.complementarity, s.residual.drift, s.residual.balance});
    for (const auto* values :
         {&s.normal_force, &s.tangential_force, &s.base_force_x, &s.base_force_y, &s.sigma_y, &s.tau_xy})
      numbers.insert(numbers.end(), values->begin(), values->end());
    for (const fem::GapStatus status : s.status) numbers.push_back(double(status));
  }
  return XXH3_64bits(numbers.data(), numbers.size() * sizeof(double));
}

/// Of each scene's solution, of one launch.
template <class Launcher>
Hashes hashes(const Launcher& launcher, std::span<const fem::Scene> scenes, std::size_t largest_chunk = 4096) {
  const auto batch = ran(launcher, scenes, largest_chunk);
  Hashes found;
  for (std::size_t i = 0; i < scenes.size(); ++i) found.push_back(hash(batch.solution(i)));
  return found;
}

}  // namespace tactel::tests
