// The last message of a program that ends itself. It runs in a child process, so that the test continues.
#pragma once

#include <csignal>
#include <cstdio>
#include <string>
#include <sys/wait.h>
#include <unistd.h>

namespace lockstone::test {

/// Returns the line that a call prints on stderr before it ends the program; empty when it returned, "died" when the
/// program ended without a sentence.
template <class Call> std::string last_words(Call&& call) {
    int ends[2];
    if (::pipe(ends) != 0) return "no pipe";
    std::fflush(nullptr); // flushes the buffers, so that they are not written twice
    const pid_t child = fork();
    if (child == 0) {
        dup2(ends[1], STDERR_FILENO);
        std::signal(SIGABRT, SIG_DFL); // the test program's handler would print a report
        std::signal(SIGSEGV, SIG_DFL);
        call();
        _exit(0);
    }
    close(ends[1]);
    std::string words;
    char buffer[512];
    for (ssize_t got; (got = ::read(ends[0], buffer, sizeof buffer)) > 0;)
        words.append(buffer, static_cast<std::size_t>(got));
    close(ends[0]);
    int status = 0;
    waitpid(child, &status, 0);
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return {};
    const bool said_so =
        WIFSIGNALED(status) && WTERMSIG(status) == SIGABRT && words.starts_with("lockstone: broken rule: ");
    return said_so ? words : "died: " + words;
}

} // namespace lockstone::test
