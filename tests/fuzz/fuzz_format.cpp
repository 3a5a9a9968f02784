// SPDX-License-Identifier: Apache-2.0

// One target a wire format (FUZZ_FORMAT, set by CMake): the input, decoded at once and in parts whose length it says
// itself.
#include <cmath>
#include <cstdlib>
#include <span>

#include "hw/decoder.h"
#include "hw/formats.h"
#include "hw/generic_format.h"
#include "tests/fuzz/counted_layout.h"

namespace tactel::hw {
namespace {

void check(bool met) {
  if (!met) std::abort();
}

}  // namespace
}  // namespace tactel::hw

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace tactel::hw;
  if (size < 1) return 0;
  static const std::size_t parts[] = {1, 3, 64, 512};
  const std::size_t part = parts[data[0] % 4];
  Bytes rest(data + 1, size - 1);
  Decoder decoder(FUZZ_FORMAT);
  std::uint64_t frames = 0, whole_frames = 0;
  decoder.feed(rest, [&](const DecodedFrame& frame) {
    ++whole_frames;
    check(frame.values.size() == decoder.format().channels());
  });
  const DecoderCounts at_once = decoder.counts();
  Decoder again(FUZZ_FORMAT);
  while (!rest.empty()) {
    const std::size_t count = std::min(part, rest.size());
    again.feed(rest.first(count), [&](const DecodedFrame&) { ++frames; });
    rest = rest.subspan(count);
  }
  check(again.counts() == at_once && frames == whole_frames && at_once.frames == frames);
  check(at_once.discarded <= size);
  return 0;
}
