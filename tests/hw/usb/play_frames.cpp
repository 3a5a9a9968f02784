// SPDX-License-Identifier: Apache-2.0

// A command with an emulated sensor beside it: a bulk device 1209:0002 that sends the frames of a file by a clock.
// Usage: LD_PRELOAD=libumockdev-preload.so.0 tactel_play_frames FRAMES BYTES RATE COMMAND...
// FRAMES: a file of frames of BYTES bytes each. RATE: frames a second. The clock starts with the first byte that the
// command sends to the device (`start` of its profile), so that the first frame is the file's. Ends with the exit code
// of the command, or with 1 where its frames were lost in the device.
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>

#include "tests/hw/usb/emulated_device.h"

namespace tactel::hw::tests {
namespace {

constexpr std::size_t queue = 4096;  // frames that wait in the device: none is lost on a busy machine

int play(int count, char** words) {
  if (count < 5) throw std::runtime_error("usage: tactel_play_frames FRAMES BYTES RATE COMMAND...");
  std::ifstream in(words[1], std::ios::binary);
  const ByteVector stream(std::istreambuf_iterator<char>(in), {});
  const std::size_t bytes = std::strtoul(words[2], nullptr, 10);
  const double rate = std::strtod(words[3], nullptr);
  if (stream.empty() || bytes == 0 || stream.size() % bytes != 0 || !(rate > 0))
    throw std::runtime_error("FRAMES must hold whole frames of BYTES bytes, and RATE must be above 0");
  EmulatedDevice device(fast_kind());
  pid_t child = 0;
  if (::posix_spawnp(&child, words[4], nullptr, nullptr, words + 4, environ) != 0)
    throw std::runtime_error(std::string(words[4]) + " cannot be run");
  const std::chrono::nanoseconds period(static_cast<std::int64_t>(1e9 / rate));
  int status = 0;
  for (bool playing = false; ::waitpid(child, &status, WNOHANG) == 0;) {
    if (!playing && !device.received().empty()) {
      playing = true;
      device.send_by_clock(period, queue, [&](std::size_t i, ByteVector& packet) {  // empty packets after the end
        const std::size_t from = i * bytes;
        if (from < stream.size())
          packet.insert(packet.end(), stream.begin() + static_cast<std::ptrdiff_t>(from),
                        stream.begin() + static_cast<std::ptrdiff_t>(from + bytes));
      });
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  device.stop_clock();
  if (device.lost() > 0) return 1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : 1;
}

}  // namespace
}  // namespace tactel::hw::tests

int main(int count, char** words) try {
  return tactel::hw::tests::play(count, words);
} catch (const std::exception& error) {
  std::fprintf(stderr, "error: %s\n", error.what());
  return 2;
}
