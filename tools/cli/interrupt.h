// SIGTERM, SIGHUP and Ctrl-C while something is recorded: the recording is ended first.
//
//   const Interrupt interrupt;
//   while (ticks are left && !interrupt.came()) ...
//   close the recording
//   interrupt.follow();                          // ends the program as the signal would have
#pragma once

namespace lockstone::cli {

/// Catches the signals while it lives; a second one ends the program at once.
class Interrupt {
  public:
    Interrupt();
    Interrupt(const Interrupt&) = delete;
    Interrupt& operator=(const Interrupt&) = delete;
    ~Interrupt();

    bool came() const;
    /// Does nothing when no signal came; else does not return: the caller's shell sees the signal.
    void follow() const;
};

} // namespace lockstone::cli
