// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <sys/ioctl.h>

namespace tactel::hw {

/// The rate of a terminal, bit/s; 0: it has none. glibc 2.36 knows some rates alone, and <asm/termbits.h>, which has
/// this struct, excludes its <termios.h>.
inline unsigned serial_rate(int file) {
  struct Settings {
    unsigned flags[4];
    unsigned char line, characters[19];
    unsigned in, out;
  } found{};
  return ::ioctl(file, _IOR('T', 0x2A, Settings), &found) == 0 ? found.out : 0;
}

}  // namespace tactel::hw
