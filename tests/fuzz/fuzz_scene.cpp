// SPDX-License-Identifier: Apache-2.0

// Scene files. A measured profile lies beside the input as measured.csv.
#include "fem/scene.h"
#include "host/scenes/scene_file.h"
#include "tests/fuzz/fuzz.h"
#include "tests/fuzz/measured_profile.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactel;
  fuzz::provide_measured_profile();
  const auto path = fuzz::write_file("scene.toml", {data, size});
  fem::Scene scene;
  if (!fuzz::accepts([&] { scene = host::read_scene(path); })) return 0;
  scene.validate();
  const fem::LoadPath steps = fem::load_path(scene.load);
  fuzz::check(!steps.steps.empty(), "an accepted scene has a load step");
  return 0;
}
