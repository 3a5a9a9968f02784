// SPDX-License-Identifier: Apache-2.0

// Height maps (CSV).
#include "host/scenes/profile_csv.h"
#include "tests/fuzz/fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactel;
  const auto path = fuzz::write_file("heights.csv", {data, size});
  fem::HeightMap map;
  if (!fuzz::accepts([&] { host::read_heights_csv(path, map); })) return 0;
  fuzz::check(map.heights.rows() >= 2 && map.heights.cols() >= 2, "two heights at least along each side");
  fuzz::check(map.heights.rows() <= Eigen::Index{host::longest_height_map} &&
                  map.heights.cols() <= Eigen::Index{host::longest_height_map},
              "a side is as long as said");
  fuzz::check(map.heights.allFinite() && map.heights.minCoeff() == 0, "heights are finite, the lowest is 0");
  fem::PadIndenter indenter;
  map.pitch = 0.1;
  indenter.shape = map;
  fuzz::accepts<ValueError>([&] { indenter.validate(); });
  return 0;
}
