// SPDX-License-Identifier: Apache-2.0

// Errors of the paper's labels, judged by patches of 24 elements, which takes a second; `tactel tradeoff --labels`
// takes the reference.
#include "host/studies/tradeoff/paper_labels.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "host/contact/solve_on_rung.h"
#include "host/scenes/paper_sets.h"
#include "host/sets/simulate_family.h"

namespace tactel::host {
namespace {

class PaperLabelsTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    executor = new Executor{Device("")};
    labels = new PaperLabels(measure_paper_labels(*executor, {}, rung_named("patch-24")));
  }
  static void TearDownTestSuite() {
    delete labels;
    delete executor;
  }
  static const LabelGroup& group(const std::string& what) {
    return *std::ranges::find(labels->groups, what, &LabelGroup::what);
  }
  static inline Executor* executor = nullptr;
  static inline PaperLabels* labels = nullptr;
};

TEST_F(PaperLabelsTest, AreTheRowsOfTheSets) {
  const fem::Scene base = paper_set_scene();
  EXPECT_EQ(labels->unjudged, 0u);
  EXPECT_EQ(group("learning set").labels,
            simulate_family(*executor, paper_learning_family(base, 10, 10), Precision::fp64, 0).slip_index.size());
  EXPECT_EQ(group("recall set").labels,
            simulate_family(*executor, paper_recall_family(base), Precision::fp64, 0).slip_index.size());
  std::size_t of_classes = 0;
  for (const std::string& shapes : paper_recall_family(base).kind_names) {
    EXPECT_EQ(group("  " + shapes).contacts, 4u) << shapes;
    of_classes += group("  " + shapes).labels;
  }
  EXPECT_EQ(of_classes, group("recall set").labels);
}

TEST_F(PaperLabelsTest, ErrorIsThatOfTheContactItself) {
  // The paper's parabolas, label by label. The drag on the mesh ends when all slides; the judge takes as many steps.
  const SceneFamily family = paper_recall_family(paper_set_scene());
  double largest = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < family.scenes.size(); ++i) {
    if (family.kind_names[family.kind[i]] != "parabolic") continue;
    const auto mesh = solve_on_meshes(*executor, {&family.scenes[i], 1}, Precision::fp64).front();
    fem::Scene same = family.scenes[i];
    same.load.tangential_steps = static_cast<int>(mesh.steps.size()) - same.load.indentation_steps;
    const auto judge = solve_on_rung(*executor, {&same, 1}, rung_named("patch-24")).front();
    for (std::size_t k = same.load.indentation_steps - 1; k < mesh.steps.size(); ++k, ++count)
      largest = std::max(largest, std::abs(*mesh.steps[k].slip_index - *judge.steps[k].slip_index));
  }
  EXPECT_EQ(group("  parabolic").labels, count);
  EXPECT_NEAR(group("  parabolic").mesh.largest, largest, 1e-3);  // sides of another grading
}

TEST_F(PaperLabelsTest, SharpContactsAreTheWorst) {
  // docs/accuracy.md tells so.
  EXPECT_GT(group("  1 to 3 nodes touch").mesh.largest, 3 * group("  11 or more nodes touch").mesh.largest);
  EXPECT_LT(group("learning set").patch.most95, group("learning set").mesh.most95 / 5);
  EXPECT_EQ(labels->learning.size(), group("learning set").labels);
}

}  // namespace
}  // namespace tactel::host
