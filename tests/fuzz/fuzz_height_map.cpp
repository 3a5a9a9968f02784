// SPDX-License-Identifier: Apache-2.0

// Height maps (CSV).
#include "host/scenes/profile_csv.h"
#include "tests/fuzz/fuzz.h"

namespace tactel::fuzz {
namespace {

const Target height_map("height_map", [](Bytes input) {
  const auto path = write_file("heights.csv", input);
  fem::HeightMap map;
  if (!accepts([&] { host::read_heights_csv(path, map); })) return;
  check(map.heights.rows() >= 2 && map.heights.cols() >= 2, "two heights at least along each side");
  check(map.heights.rows() <= Eigen::Index{host::longest_height_map} &&
            map.heights.cols() <= Eigen::Index{host::longest_height_map},
        "a side is as long as said");
  check(map.heights.allFinite() && map.heights.minCoeff() == 0, "heights are finite, the lowest is 0");
  fem::PadIndenter indenter;
  map.pitch = 0.1;
  indenter.shape = map;
  accepts<ValueError>([&] { indenter.validate(); });
});

}  // namespace
}  // namespace tactel::fuzz
