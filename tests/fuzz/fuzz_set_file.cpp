// SPDX-License-Identifier: Apache-2.0

// Set files (HDF5) of any bytes. What HDF5's own library makes of a damaged file is looked at, too.
#include "tests/fuzz/fuzz.h"
#include "tests/fuzz/set_read.h"

namespace tactel::fuzz {
namespace {

const Target set_file("set_file", [](Bytes input) { read_set(write_file("set.h5", input)); });

}  // namespace
}  // namespace tactel::fuzz
