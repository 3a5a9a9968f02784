#pragma once

namespace tactel::host {

/// While one lives, Ctrl-C (SIGINT) and SIGTERM ask for a clean stop instead of ending the program; a second one ends
/// it at once. One at a time.
class Interrupt {
 public:
  Interrupt();
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;
  bool requested() const;
};

/// Exit code of a program that stopped because it was asked to, as shells give it for SIGINT.
inline constexpr int interrupted = 130;

}  // namespace tactel::host
