// SPDX-License-Identifier: Apache-2.0

// Scene files of lines and pads. A measured profile lies beside the input as measured.csv.
#include "fem/scenes/scene.h"
#include "host/scenes/scene_file.h"
#include "tests/fuzz/fuzz.h"
#include "tests/fuzz/measured_profile.h"

namespace tactel::fuzz {
namespace {

const Target scene("scene", [](Bytes input) {
  provide_measured_profile();
  const auto path = write_file("scene.toml", input);
  host::AnyScene any;
  if (!accepts([&] { any = host::read_any_scene(path); })) return;
  std::visit([](const auto& scene) { scene.validate(); }, any);
  if (const auto* pad = std::get_if<fem::PadScene>(&any)) {
    check(!fem::pad_targets(pad->load).empty(), "an accepted scene of a pad has a load step");
    return;
  }
  const fem::LoadPath steps = fem::load_path(std::get<fem::Scene>(any).load);
  check(!steps.steps.empty(), "an accepted scene has a load step");
});

}  // namespace
}  // namespace tactel::fuzz
