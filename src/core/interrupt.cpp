#include "jaculus/core/interrupt.h"

#include <signal.h>

#include <atomic>

namespace jaculus {
namespace {

std::atomic<bool> requested{false};
static_assert(std::atomic<bool>::is_always_lock_free,
              "a signal handler may touch lock-free atomics only");

extern "C" void raise_flag(int) { requested.store(true); }

}  // namespace

void install_interrupt_handler() {
  struct sigaction action = {};
  action.sa_handler = raise_flag;
  sigemptyset(&action.sa_mask);
  action.sa_flags =
      // the second signal finds the default action: impatience is honoured
      static_cast<int>(SA_RESETHAND);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

void restore_default_interrupts() {
  signal(SIGINT, SIG_DFL);
  signal(SIGTERM, SIG_DFL);
}

bool interrupt_requested() { return requested.load(); }
void request_interrupt() { requested.store(true); }
void clear_interrupt() { requested.store(false); }

}  // namespace jaculus
