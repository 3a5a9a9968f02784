// SPDX-License-Identifier: Apache-2.0

// Measured profiles (CSV).
#include <cmath>

#include "host/scenes/profile_csv.h"
#include "tests/fuzz/fuzz.h"

namespace tactel::fuzz {
namespace {

const Target profile_csv("profile_csv", [](Bytes input) {
  const auto path = write_file("profile.csv", input);
  fem::Profile profile;
  if (!accepts([&] { host::read_profile_csv(path, profile); })) return;
  check(profile.x.size() == profile.y.size() && profile.x.size() >= 2, "two points at least, as many y as x");
  for (std::size_t i = 0; i < profile.x.size(); ++i) {
    check(std::isfinite(profile.x[i]) && std::isfinite(profile.y[i]), "numbers are finite");
    check(i == 0 || profile.x[i] > profile.x[i - 1], "x increases");
  }
  fem::Indenter indenter;
  indenter.shape = profile;
  accepts<ValueError>([&] { fem::validate(indenter); });
});

}  // namespace
}  // namespace tactel::fuzz
