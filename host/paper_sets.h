#pragma once
#include <string>
#include <vector>

#include "fem/scene.h"
#include "host/contact_set.h"
#include "host/executor.h"
#include "host/scene_source.h"

namespace tactel::host {

/// The sets of the paper's sections V.C and V.D.

/// Scenes that share everything but the indenter, and what kind of indenter each has.
struct SceneFamily {
  std::vector<fem::Scene> scenes;
  std::vector<std::uint16_t> kind;  ///< [scenes] place in kind_names
  std::vector<std::string> kind_names;
};

/// The 32 Taylor shapes: y = height * sum (r / scale)^k over every subset of the powers 1 ... 5 (mm). The paper gives
/// no units: 10 and 10 are its sums with x and y in centimetres.
SceneFamily paper_learning_family(const fem::Scene& base, double scale, double height);

/// Seven common shapes, four examples of each; the paper names the classes (section V.D), the sizes are our choice.
SceneFamily paper_recall_family(const fem::Scene& base);

/// What the paper's sets share unless a file says otherwise: its preset, 0.15 mm deep, dragged by 0.05 mm until the
/// contact slides.
fem::Scene paper_set_scene();

/// A family as the contacts of a set.
SceneSource source_of(const SceneFamily& family);

/// Simulates a family as SetSimulator does.
ContactSet simulate_family(Executor& executor, const SceneFamily& family, Precision precision, double tolerance);

}  // namespace tactel::host
