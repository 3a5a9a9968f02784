// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <tactel/pad.h>
#include <tactel/sweep.h>

#include <string>
#include <utility>

#include "fem/pad/pad_scene.h"
#include "fem/scenes/scene.h"
#include "host/answers/solve.h"
#include "host/sets/contact_set.h"

namespace tactel::api {

/// Throws the public exception for the one that is being handled: InputError for a value or file that cannot be used,
/// HardwareError for devices, kernels and sensors. `item` names the input where the error does not, "scenes[3]". Others
/// pass on.
[[noreturn]] void rethrow_public(const std::string& item);

/// Returns function(), with public exceptions in place of internal ones.
template <class Function>
auto with_public_errors(Function&& function, const std::string& item = {}) -> decltype(function()) {
  try {
    return std::forward<Function>(function)();
  } catch (...) {
    rethrow_public(item);
  }
}

/// Returns the scene as the mechanics have it.
fem::Scene to_fem(const Scene& scene);
fem::PadScene to_fem(const PadScene& scene);
/// Returns the scene as users have it.
Scene from_fem(const fem::Scene& scene);
PadScene from_fem(const fem::PadScene& scene);

/// Returns the scenes as the mechanics have them. Throws InputError naming a scene that the model rejects.
template <class Scene>
auto checked_scenes(std::span<const Scene> scenes) {
  std::vector<decltype(to_fem(scenes[0]))> all;
  for (const Scene& scene : scenes)
    with_public_errors([&] { all.push_back(to_fem(scene)), all.back().validate(); },
                       "scenes[" + std::to_string(all.size()) + "]");
  return all;
}

/// Throws ConfigError for what is neither "", "fp32" nor "fp64".
void check_precision(const std::string& precision);
/// Throws ConfigError for options that are wrong for many scenes.
void check_for_many(const SolveOptions& options);

/// Returns the rows and counts of a set as users have them.
Set from_host(host::ContactSet&& set);
/// Returns the rows as the rooms of host have them. Throws InputError naming `set` where its arrays differ in length.
host::ContactSet to_host(const Set& set);

}  // namespace tactel::api
