#pragma once
// A polite end on SIGINT and SIGTERM: the handler only raises a flag, long work looks at it and
// keeps what is finished.

#include <signal.h>

#include <stdexcept>

namespace jaculus {

/// Installs the handler for SIGINT and SIGTERM; a second signal ends the program at once. For the
/// command line only.
void install_interrupt_handler();

/// Lets a signal end the program at once, where nothing half done is worth keeping.
void restore_default_interrupts();

/// True once a signal has come (or request_interrupt() was called).
bool interrupt_requested();

/// What stop_if_interrupted() throws.
class Interrupted : public std::runtime_error {
 public:
  Interrupted() : std::runtime_error("interrupted") {}
};

/// For work that keeps nothing half done: throws Interrupted once interrupt_requested().
void stop_if_interrupted();

/// Takes SIGINT for as long as it lives, in a program that has a handler of its own: a signal
/// raises the flag, however often it comes. Ignored signals stay so. The flag is down at the start
/// and at the end.
class InterruptScope {
 public:
  InterruptScope();
  ~InterruptScope();
  InterruptScope(const InterruptScope&) = delete;
  InterruptScope& operator=(const InterruptScope&) = delete;

 private:
  struct sigaction before_;
};

void request_interrupt();
void clear_interrupt();

}  // namespace jaculus
