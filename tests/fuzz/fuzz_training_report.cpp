// SPDX-License-Identifier: Apache-2.0

// training.json of a training's folder, as `tactel train` meets it there.
#include "host/training/training_directory.h"
#include "tests/fuzz/fuzz.h"

namespace tactel::fuzz {
namespace {

const Target training_report("training_report", [](Bytes input) {
  const host::TrainingDirectory directory(folder());
  write_file("training.json", input);
  check(directory.finished(), "the report is there");
  accepts([&] { directory.check(true, false); });
  accepts([&] { directory.check(false, true); });
  accepts([&] { directory.expect_same("0123456789abcdef"); });
  accepts([&] { directory.clear(); });
  check(!directory.finished(), "a folder that was cleared holds no report");
});

}  // namespace
}  // namespace tactel::fuzz
