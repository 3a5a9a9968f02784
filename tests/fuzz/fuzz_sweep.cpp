// SPDX-License-Identifier: Apache-2.0

// Sweep files, and the first and last contacts that they draw.
#include "host/scenes/sweep_file.h"
#include "tests/fuzz/fuzz.h"
#include "tests/fuzz/measured_profile.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactel;
  fuzz::provide_measured_profile();
  const auto path = fuzz::write_file("sweep.toml", {data, size});
  std::optional<host::Sweep> sweep;
  if (!fuzz::accepts([&] { sweep = host::read_sweep(path); })) return 0;
  const host::SceneSource& source = sweep->source;
  fuzz::check(source.contacts() > 0, "an accepted sweep has a contact");
  fuzz::check(source.tactels() >= 2, "an accepted sweep has two tactels at least");
  for (const std::uint64_t k : {std::uint64_t{0}, std::uint64_t{1}, source.contacts() - 1}) {
    if (k >= source.contacts()) continue;
    // Drawn numbers that do not fit each other are a ValueError, by contract.
    fuzz::accepts<ValueError>([&] {
      const host::SceneSource::Contact contact = source.contact(k);
      fuzz::check(contact.kind < source.kind_names().size(), "a contact's indenter has a name");
      fuzz::check(!fem::load_path(contact.scene.load).steps.empty(), "a drawn contact has a load step");
    });
  }
  return 0;
}
