// SPDX-License-Identifier: Apache-2.0

// Scene files of lines and pads. A measured profile lies beside the input as measured.csv.
#include "fem/scene.h"
#include "host/scenes/scene_file.h"
#include "tests/fuzz/fuzz.h"
#include "tests/fuzz/measured_profile.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactel;
  fuzz::provide_measured_profile();
  const auto path = fuzz::write_file("scene.toml", {data, size});
  host::AnyScene any;
  if (!fuzz::accepts([&] { any = host::read_any_scene(path); })) return 0;
  std::visit([](const auto& scene) { scene.validate(); }, any);
  if (const auto* pad = std::get_if<fem::PadScene>(&any)) {
    fuzz::check(!fem::pad_targets(pad->load).empty(), "an accepted scene of a pad has a load step");
    return 0;
  }
  const fem::LoadPath steps = fem::load_path(std::get<fem::Scene>(any).load);
  fuzz::check(!steps.steps.empty(), "an accepted scene has a load step");
  return 0;
}
