// SPDX-License-Identifier: Apache-2.0
#include "tests/hw/usb/terminal_node.h"

#include <fcntl.h>
#include <stdlib.h>
#include <termios.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

namespace tactel::hw::tests {
namespace {

int checked(int result, const char* what) {
  if (result < 0) throw std::system_error(errno, std::generic_category(), what);
  return result;
}

}  // namespace

TerminalNode::TerminalNode(const std::string& path) {
  master_ = checked(posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC), "posix_openpt");
  checked(grantpt(master_), "grantpt");
  checked(unlockpt(master_), "unlockpt");
  const std::string terminal = ptsname(master_);
  slave_ = checked(open(terminal.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC), "opening a terminal");
  set_ready(false);
  unlink(path.c_str());
  checked(symlink(terminal.c_str(), path.c_str()), "symlink");
}

TerminalNode::~TerminalNode() {
  close(master_);
  close(slave_);
}

void TerminalNode::set_ready(bool ready) {
  if (ready == ready_) return;
  checked(tcflow(slave_, ready ? TCOON : TCOOFF), "tcflow");
  ready_ = ready;
}

}  // namespace tactel::hw::tests
