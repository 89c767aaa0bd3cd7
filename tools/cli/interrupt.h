// Handles SIGTERM, SIGHUP and Ctrl-C during a recording, so that the recording is closed before the program ends.
//
//   const Interrupt interrupt;
//   while (ticks are left && !interrupt.came()) ...
//   close the recording
//   interrupt.follow();                          // ends the program as the signal would have
#pragma once

namespace lockstone::cli {

/// Catches the signals during its lifetime. A second signal ends the program at once.
class Interrupt {
  public:
    Interrupt();
    Interrupt(const Interrupt&) = delete;
    Interrupt& operator=(const Interrupt&) = delete;
    ~Interrupt();

    bool came() const;
    /// Returns if no signal came. Otherwise ends the program by that signal, so that the caller's shell sees it.
    void follow() const;
};

} // namespace lockstone::cli
