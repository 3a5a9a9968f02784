// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <csignal>

namespace tactel::host {

/// During its life, Ctrl-C (SIGINT), SIGTERM and SIGHUP request a clean stop instead of ending the program; a SIGHUP
/// that nohup has ignored stays so. Signals within
/// 0.5 s of the first are the same request: `timeout -s INT` sends one to the program and one to its group. A later
/// one ends the program at once. One object at a time.
class Interrupt {
 public:
  Interrupt();
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;
  bool requested() const;
  /// Returns true where a stop was requested during the life of the last Interrupt, also after its end.
  static bool seen();
};

/// During its life, blocks these signals in this thread and in the programs and threads that it starts. Ctrl-C
/// reaches all processes of a terminal, and a compiler whose linker it ends reports a failure. Another thread, or
/// this one later, receives the signal.
class HeldSignals {
 public:
  enum When { always, handled };  ///< `handled`: only signals that do not end this program at once
  explicit HeldSignals(When when);
  ~HeldSignals();
  HeldSignals(const HeldSignals&) = delete;
  HeldSignals& operator=(const HeldSignals&) = delete;

 private:
  sigset_t before_;
};

}  // namespace tactel::host
