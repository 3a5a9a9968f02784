// SPDX-License-Identifier: Apache-2.0

// Set files (HDF5) of any bytes. What HDF5's own library makes of a damaged file is looked at, too.
#include "tests/fuzz/fuzz.h"
#include "tests/fuzz/set_read.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactel::fuzz;
  read_set(write_file("set.h5", {data, size}));
  return 0;
}
