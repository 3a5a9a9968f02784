// SPDX-License-Identifier: Apache-2.0
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <string_view>

#include "host/commands/live/monitor.h"
#include "host/support/terminal.h"

namespace tactel::host {

MonitorCalls AskedLines::operator()() {
  pollfd input{STDIN_FILENO, POLLIN, 0};
  MonitorCalls asked;
  // Reading a terminal stops a program in its background.
  while (open_ && !(isatty(STDIN_FILENO) && tcgetpgrp(STDIN_FILENO) != getpgrp()) && ::poll(&input, 1, 0) > 0) {
    char bytes[256];
    const ssize_t size = ::read(STDIN_FILENO, bytes, sizeof bytes);
    if (size < 0 && (errno == EINTR || errno == EAGAIN)) break;
    open_ = size > 0;
    for (const char byte : std::string_view(bytes, static_cast<std::size_t>(std::max<ssize_t>(size, 0)))) {
      if (byte != '\n' && byte != '\r') {
        if (line_.size() < sizeof bytes) line_ += byte;
      } else if (byte == '\n') {
        take(asked);
        line_.clear();
      }
    }
  }
  return asked;
}

void AskedLines::take(MonitorCalls& asked) const {
  if (line_.empty() || line_ == "rest")
    asked.rest = true;
  else if (line_ == "slides")
    asked.slides = true;
  else if (!quiet_)
    print_warning("a line of standard input was left out: it is neither \"rest\" nor \"slides\"");
}

}  // namespace tactel::host
