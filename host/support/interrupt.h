#pragma once
#include <csignal>

namespace tactel::host {

/// During its life, Ctrl-C (SIGINT) and SIGTERM request a clean stop instead of ending the program. Signals within
/// 0.5 s of the first are the same request: `timeout -s INT` sends one to the program and one to its group. A later
/// one ends the program at once. One object at a time.
class Interrupt {
 public:
  Interrupt();
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;
  bool requested() const;
  /// Whether one was asked for while the last Interrupt lived, which may be gone.
  static bool seen();
};

/// While one lives, SIGINT and SIGTERM wait in this thread, and in the programs and threads that it starts: Ctrl-C goes
/// to all processes of a terminal, and a compiler whose linker it ends reports a failure. Another thread, or this one
/// later, takes the signal.
class HeldSignals {
 public:
  enum When { always, handled };  ///< `handled`: only those that would not end this program at once
  explicit HeldSignals(When when);
  ~HeldSignals();
  HeldSignals(const HeldSignals&) = delete;
  HeldSignals& operator=(const HeldSignals&) = delete;

 private:
  sigset_t before_;
};

}  // namespace tactel::host
