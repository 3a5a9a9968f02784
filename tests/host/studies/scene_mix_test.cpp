// SPDX-License-Identifier: Apache-2.0

// The mix of scenes on which models are judged, and those unlike it.
#include <gtest/gtest.h>

#include "bench/unlike_scenes.h"

namespace tactel::host::scene_mix_test {

TEST(SceneMix, ASmallerOneIsTheBeginningOfALargerOne) {
  const auto small = mixed_scenes(3, 8), large = mixed_scenes(3, 64);
  for (std::size_t k = 0; k < small.size(); ++k) {
    EXPECT_EQ(small[k].indenter.position, large[k].indenter.position);
    EXPECT_EQ(small[k].load.tangential, large[k].load.tangential);
  }
}

TEST(SceneMix, ScenesUnlikeItAreValidAndDifferInThatRespect) {
  const auto mix = mixed_scenes(5, 200);
  for (const auto& [name, description, respect] : all_unlike) {
    const auto scenes = unlike_scenes(respect, 5, 200);
    ASSERT_EQ(scenes.size(), mix.size());
    for (std::size_t k = 0; k < scenes.size(); ++k) {
      EXPECT_NO_THROW(scenes[k].validate()) << description << ", scene " << k;
      const bool same = scenes[k].sensor == mix[k].sensor && scenes[k].load.indentation == mix[k].load.indentation &&
                        scenes[k].indenter.position == mix[k].indenter.position &&
                        scenes[k].indenter.shape.index() == mix[k].indenter.shape.index();
      const bool slippery = respect == Unlike::slippery, pressed_by_depth = scenes[k].load.normal_force.empty();
      EXPECT_EQ(same, slippery && pressed_by_depth) << description << ", scene " << k;
      EXPECT_EQ(scenes[k].friction < 0.1, slippery) << "scene " << k;
      EXPECT_TRUE(slippery || scenes[k].friction == mix[k].friction) << description << ", scene " << k;
    }
  }
}

}  // namespace tactel::host::scene_mix_test
