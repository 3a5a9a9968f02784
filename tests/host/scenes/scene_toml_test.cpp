// SPDX-License-Identifier: Apache-2.0

// Scenes as files, and back.

#include <gmock/gmock.h>

#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>

#include "host/scenes/scene_file.h"
#include "host/scenes/scene_json.h"
#include "host/support/errors.h"
#include "tests/host/support/run_tactel.h"
#include "tests/scratch.h"
#include "tests/thrown_message.h"

namespace tactel::host::scene_toml_test {

std::string json_of(const AnyScene& scene) {
  return std::visit([](const auto& one) { return to_json(one).dump(); }, scene);
}

TEST(SceneToml, EveryExampleComesBack) {
  const ScratchFolder folder;
  int scenes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(source_file("examples"))) {
    if (entry.path().extension() != ".toml") continue;
    std::optional<AnyScene> scene;
    try {
      scene = read_any_scene(entry.path());
    } catch (const ConfigError&) {
      continue;  // a sweep
    }
    const std::string text = std::visit([](const auto& one) { return scene_toml(one); }, *scene);
    EXPECT_EQ(json_of(read_any_scene(folder.write("scene.toml", text))), json_of(*scene)) << entry.path() << text;
    ++scenes;
  }
  EXPECT_GE(scenes, 15);
}

TEST(SceneToml, BondedAndTexts) {
  fem::Scene scene;
  scene.title = "a \"quoted\" title \\ µ";
  scene.friction = std::numeric_limits<double>::infinity();
  const ScratchFolder folder;
  const auto back = std::get<fem::Scene>(read_any_scene(folder.write("scene.toml", scene_toml(scene))));
  EXPECT_EQ(back.title, scene.title);
  EXPECT_EQ(back.friction, scene.friction);
}

TEST(SceneToml, PointsWithoutAFileAreRefused) {
  fem::Scene scene;
  scene.indenter.shape = fem::Profile({-1, 0, 1}, {1, 0, 1});
  EXPECT_THAT(thrown_message<ConfigError>([&] { scene_toml(scene); }), ::testing::HasSubstr("indenter.file"));
}

}  // namespace tactel::host::scene_toml_test
