// SPDX-License-Identifier: Apache-2.0
#include "host/scenes/scene_json.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "fem/scenes/indenter.h"
#include "fem/scenes/scene.h"
#include "host/scenes/scene_file.h"
#include "tests/host/support/run_tactel.h"

namespace tactel::host::scene_json_test {

// What an answer says of its indenter, written as a scene file, is the same indenter.
TEST(SceneJson, HoldsEveryNumberOfAShape) {
  const fem::Shape shapes[] = {fem::Flat{2.0},
                               fem::Wedge{150},
                               fem::Parabola{7},
                               fem::Cylinder{8},
                               fem::Exponential{0.1, 1.5},
                               fem::Trapezoid{1.0, 0.5},
                               fem::RoundedFlat{1.0, 9.0},
                               fem::Taylor{.powers = {1, 3}, .scale = 9, .height = 4.0},
                               fem::Taylor{.powers = {2, 4}, .scale = 9, .height = 4.0, .coefficients = {0.25, 0.75}}};
  const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(21, -4, 4);
  const ScratchFolder folder;
  for (const fem::Shape& shape : shapes) {
    const fem::Scene scene{.indenter = {.shape = shape}};
    const nlohmann::ordered_json json = to_json(scene);
    std::string text = "[indenter]\n";
    for (const auto& [key, value] : json["indenter"].items()) text += fmt::format("{} = {}\n", key, value.dump());
    folder.write("scene.toml", text + "[load]\nindentation = 0.1\n");
    EXPECT_EQ(fem::profile_heights(read_scene(folder / "scene.toml").indenter, x),
              fem::profile_heights(scene.indenter, x))
        << text;
  }
}

}  // namespace tactel::host::scene_json_test
