// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "fem/scenes/scene.h"
#include "host/scenes/scene_source.h"

namespace tactel::host {

/// The sets of the paper's sections V.C and V.D.

/// Scenes that share everything but the indenter, and the kind of indenter of each.
struct SceneFamily {
  std::vector<fem::Scene> scenes;
  std::vector<std::uint16_t> kind;  ///< [scenes] index in kind_names
  std::vector<std::string> kind_names;
};

/// Returns the 32 Taylor shapes: y = height * sum (r / scale)^k over every subset of the powers 1 ... 5 (mm). The
/// paper gives no units: 10 and 10 are its sums with x and y in centimetres.
SceneFamily paper_learning_family(const fem::Scene& base, double scale, double height);

/// Returns seven common shapes, four examples of each. The paper names the classes (section V.D); the sizes are
/// chosen here.
SceneFamily paper_recall_family(const fem::Scene& base);

/// Returns the defaults of the paper's sets: its preset, 0.15 mm deep, dragged by 0.05 mm until the contact
/// slides.
fem::Scene paper_set_scene();

/// Returns a family as the contacts of a set.
SceneSource source_of(const SceneFamily& family);

}  // namespace tactel::host
