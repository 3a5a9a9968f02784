#include "host/interrupt.h"

#include <csignal>

namespace tactel::host {
namespace {

volatile std::sig_atomic_t asked = 0;
struct sigaction before_int, before_term;

void on_signal(int) { asked = 1; }

}  // namespace

Interrupt::Interrupt() {
  asked = 0;
  struct sigaction action {};
  action.sa_handler = on_signal;
  action.sa_flags = SA_RESETHAND;  // the second signal ends the program
  sigemptyset(&action.sa_mask);
  sigaction(SIGINT, &action, &before_int);
  sigaction(SIGTERM, &action, &before_term);
}

Interrupt::~Interrupt() {
  sigaction(SIGINT, &before_int, nullptr);
  sigaction(SIGTERM, &before_term, nullptr);
}

bool Interrupt::requested() const { return asked != 0; }

}  // namespace tactel::host
