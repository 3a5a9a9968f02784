// SPDX-License-Identifier: Apache-2.0

// One target a wire format: the input, decoded at once and in parts whose length it says itself.
#include <algorithm>
#include <memory>

#include "hw/decoder.h"
#include "hw/formats.h"
#include "hw/generic_format.h"
#include "tests/fuzz/counted_layout.h"
#include "tests/fuzz/fuzz.h"

namespace tactel::fuzz {
namespace {

void decode(Bytes input, std::unique_ptr<const hw::WireFormat> (*format)()) {
  if (input.empty()) return;
  static const std::size_t parts[] = {1, 3, 64, 512};
  const std::size_t part = parts[input[0] % 4];
  Bytes rest = input.subspan(1);
  hw::Decoder decoder(format());
  std::uint64_t frames = 0, whole_frames = 0;
  decoder.feed(rest, [&](const hw::DecodedFrame& frame) {
    ++whole_frames;
    check(frame.values.size() == decoder.format().channels(), "a frame has a number a channel");
  });
  const hw::DecoderCounts at_once = decoder.counts();
  hw::Decoder again(format());
  while (!rest.empty()) {
    const std::size_t count = std::min(part, rest.size());
    again.feed(rest.first(count), [&](const hw::DecodedFrame&) { ++frames; });
    rest = rest.subspan(count);
  }
  check(again.counts() == at_once && frames == whole_frames && at_once.frames == frames, "parts give the same frames");
  check(at_once.discarded <= input.size(), "no more bytes are dropped than there were");
}

const Target glove("decode_glove", [](Bytes input) { decode(input, hw::glove_format); });
const Target papillarray("decode_papillarray",
                         [](Bytes input) { decode(input, [] { return hw::papillarray_format(2); }); });
const Target anyskin("decode_anyskin", [](Bytes input) { decode(input, [] { return hw::anyskin_format(); }); });
const Target agni("decode_agni", [](Bytes input) { decode(input, hw::agni_format); });
const Target paxini("decode_paxini", [](Bytes input) { decode(input, [] { return hw::paxini_format(2, 2); }); });
const Target generic("decode_generic",
                     [](Bytes input) { decode(input, [] { return hw::generic_format(hw::counted_layout()); }); });

}  // namespace
}  // namespace tactel::fuzz
