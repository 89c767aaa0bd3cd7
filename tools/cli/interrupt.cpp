#include "cli/interrupt.h"

#include <csignal>
#include <cstdio>

namespace lockstone::cli {
namespace {

volatile std::sig_atomic_t signal_seen = 0;

constexpr int caught[] = {
    SIGINT,
    SIGTERM,
#ifdef SIGHUP
    SIGHUP,
#endif
};

void note(int signal) {
    signal_seen = signal;
    std::signal(signal, SIG_DFL);
}

} // namespace

Interrupt::Interrupt() {
    for (const int signal : caught)
        // An ignored signal stays ignored, as under nohup.
        if (std::signal(signal, note) == SIG_IGN) std::signal(signal, SIG_IGN);
}

Interrupt::~Interrupt() {
    for (const int signal : caught)
        if (std::signal(signal, SIG_DFL) == SIG_IGN) std::signal(signal, SIG_IGN);
}

bool Interrupt::came() const { return signal_seen != 0; }

void Interrupt::follow() const {
    if (!came()) return;
    std::fflush(stdout);
    std::signal(signal_seen, SIG_DFL);
    std::raise(signal_seen);
}

} // namespace lockstone::cli
