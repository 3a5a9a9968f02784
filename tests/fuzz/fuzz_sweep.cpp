// SPDX-License-Identifier: Apache-2.0

// Sweep files, and the first and last contacts that they draw.
#include "host/scenes/sweep_file.h"
#include "tests/fuzz/fuzz.h"
#include "tests/fuzz/measured_profile.h"

namespace {
bool has_step(const tactel::fem::Scene& scene) { return !tactel::fem::load_path(scene.load).steps.empty(); }
bool has_step(const tactel::fem::PadScene& scene) { return !tactel::fem::pad_targets(scene.load).empty(); }
}  // namespace

namespace tactel::fuzz {
namespace {

const Target sweep("sweep", [](Bytes input) {
  provide_measured_profile();
  const auto path = write_file("sweep.toml", input);
  std::optional<host::Sweep> sweep;
  if (!accepts([&] { sweep = host::read_sweep(path); })) return;
  const host::ContactSource& all = sweep->contacts();
  check(all.contacts() > 0, "an accepted sweep has a contact");
  check(all.inputs() >= 1, "a frame of an accepted sweep has a number");
  for (const std::uint64_t k : {std::uint64_t{0}, std::uint64_t{1}, all.contacts() - 1}) {
    if (k >= all.contacts()) continue;
    // Drawn numbers that do not fit each other are a ValueError, by contract.
    accepts<ValueError>([&] {
      std::visit(
          [&](const auto& source) {
            const auto contact = source.contact(k);
            check(contact.kind < all.kind_names().size(), "a contact's indenter has a name");
            check(has_step(contact.scene), "a drawn contact has a load step");
          },
          sweep->source);
    });
  }
});

}  // namespace
}  // namespace tactel::fuzz
