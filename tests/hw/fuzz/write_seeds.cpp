// Streams of whole frames for the fuzzers to start from, which no random bytes would hit past a checksum:
// fuzz_seeds DIR writes DIR/FORMAT/seed.
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>

#include "tests/hw/byte_vectors.h"
#include "tests/hw/fuzz/counted_layout.h"

namespace tactel::hw::testing {
namespace {

ByteVector generic_frame(int i) {
  const GenericLayout layout = counted_layout();
  const double samples[] = {1, 2, 3, 4};
  ByteVector frame(generic_frame_length(layout));
  write_generic_frame(layout, static_cast<std::uint64_t>(i), 100 * static_cast<std::uint64_t>(i), samples, frame);
  return frame;
}

/// As many frames as the format wants in a row, and more. The first byte says how the stream is split
/// (fuzz_format.cpp): parts of 64 bytes.
void write(const std::filesystem::path& folder, int frames, const std::function<ByteVector(int)>& frame) {
  ByteVector stream = {2};
  for (int i = 0; i < frames; ++i) append(stream, frame(i));
  std::filesystem::create_directories(folder);
  std::ofstream file(folder / "seed", std::ios::binary);
  file.write(reinterpret_cast<const char*>(stream.data()), static_cast<std::streamsize>(stream.size()));
}

}  // namespace
}  // namespace tactel::hw::testing

int main(int count, char** arguments) {
  using namespace tactel::hw::testing;
  if (count != 2) {
    std::cerr << "fuzz_seeds DIR\n";
    return 2;
  }
  const std::filesystem::path folder = arguments[1];
  write(folder / "glove", 2, glove_frame);
  write(folder / "papillarray", 2, [](int i) {
    return papillarray_frame({.sensors = 2, .counter = static_cast<std::uint32_t>(i), .undocumented = i == 1});
  });
  write(folder / "anyskin", 5, [](int i) { return anyskin_frame(static_cast<float>(i)); });
  write(folder / "agni", 2, agni_frame);
  write(folder / "paxini", 3, [](int i) { return paxini_frame(static_cast<std::uint8_t>(i)); });
  write(folder / "generic", 3, generic_frame);
}
