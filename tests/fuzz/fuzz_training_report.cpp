// SPDX-License-Identifier: Apache-2.0

// training.json of a training's folder, as `tactel train` meets it there.
#include "host/training/training_directory.h"
#include "tests/fuzz/fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactel;
  const host::TrainingDirectory directory(fuzz::folder());
  fuzz::write_file("training.json", {data, size});
  fuzz::check(directory.finished(), "the report is there");
  fuzz::accepts([&] { directory.check(true, false); });
  fuzz::accepts([&] { directory.check(false, true); });
  fuzz::accepts([&] { directory.expect_same("0123456789abcdef"); });
  fuzz::accepts([&] { directory.clear(); });
  fuzz::check(!directory.finished(), "a folder that was cleared holds no report");
  return 0;
}
