// SPDX-License-Identifier: Apache-2.0

// Checkpoints of trainings, of two networks, 4-3-1 and 2-2-2-1. The input is read as it is, then with the checksum
// made right.
#include <algorithm>
#include <cstring>
#include <vector>

#include "host/networks/training_checkpoint.h"
#include "host/support/checksum.h"
#include "tests/fuzz/checkpoint_records.h"
#include "tests/fuzz/fuzz.h"

namespace tactel::fuzz {
namespace {

constexpr std::size_t magic_size = 20;  // "tactel checkpoint 5\n"

std::string with_right_checksum(std::string bytes) {
  std::uint64_t sum = 0;
  if (bytes.size() < magic_size + sizeof sum) return bytes;
  sum = host::checksum(std::string_view(bytes).substr(magic_size + sizeof sum));
  std::memcpy(bytes.data() + magic_size, &sum, sizeof sum);
  return bytes;
}

void read(const std::string& bytes) {
  const auto path = write_file("checkpoint", as_bytes(bytes));
  const auto expected = checkpoint_records();
  auto records = expected;
  accepts([&] { host::expect_checkpoint_of(path, checkpoint_plan); });
  const bool read = accepts([&] {
    check(host::read_checkpoint<float>(path, checkpoint_plan, records), "a file that is there is read or refused");
  });
  if (!read) return;
  for (std::size_t i = 0; i < records.size(); ++i) {
    const nn::BatchState<float>&state = records[i].state, &its = expected[i].state;
    check(state.weights.values.size() == its.weights.values.size(), "weights keep their number");
    check(state.first.values.size() == its.first.values.size(), "first moments keep their number");
    check(state.second.values.size() == its.second.values.size(), "second moments keep their number");
    const std::vector<host::CurvePoint>& curve = records[i].network.curve;
    check(std::ranges::is_sorted(curve, {}, &host::CurvePoint::cycle), "the cycles of a curve rise");
  }
}

const Target checkpoint("checkpoint", [](Bytes input) { read_twice(input, read, with_right_checksum); });

}  // namespace
}  // namespace tactel::fuzz
