// SPDX-License-Identifier: Apache-2.0

// Measured profiles (CSV).
#include <cmath>

#include "host/scenes/profile_csv.h"
#include "tests/fuzz/fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactel;
  const auto path = fuzz::write_file("profile.csv", {data, size});
  fem::Profile profile;
  if (!fuzz::accepts([&] { host::read_profile_csv(path, profile); })) return 0;
  fuzz::check(profile.x.size() == profile.y.size() && profile.x.size() >= 2, "two points at least, as many y as x");
  for (std::size_t i = 0; i < profile.x.size(); ++i) {
    fuzz::check(std::isfinite(profile.x[i]) && std::isfinite(profile.y[i]), "numbers are finite");
    fuzz::check(i == 0 || profile.x[i] > profile.x[i - 1], "x increases");
  }
  fem::Indenter indenter;
  indenter.shape = profile;
  fuzz::accepts<ValueError>([&] { fem::validate(indenter); });
  return 0;
}
