#pragma once
// A polite end on SIGINT and SIGTERM: the handler only raises a flag, long work looks at it and
// keeps what is finished.

namespace jaculus {

/// Installs the handler for SIGINT and SIGTERM; a second signal ends the program at once. For the
/// command line only.
void install_interrupt_handler();

/// Lets a signal end the program at once, where nothing half done is worth keeping.
void restore_default_interrupts();

/// True once a signal has come (or request_interrupt() was called).
bool interrupt_requested();

void request_interrupt();
void clear_interrupt();

}  // namespace jaculus
