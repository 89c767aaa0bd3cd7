#include "cli/gnuplot.h"

#include <cstdio>

#include <sys/wait.h>

namespace lockstone::cli {

Status draw(const std::string& script, const std::string& file) {
    constexpr int absent = 127;
    // The standard output of gnuplot is dropped: gnuplot prints a picture there that it cannot write into the file.
    // `cat` reads the rest of the script in every case, so that no write goes to a closed pipe.
    std::FILE* const gnuplot =
        ::popen("if command -v gnuplot >/dev/null; then gnuplot >/dev/null; status=$?; else "
                "status=127; fi; cat >/dev/null; exit $status",
                "w");
    if (gnuplot == nullptr) return Error{"--plot " + file + ": cannot start gnuplot"};
    const bool read = std::fwrite(script.data(), 1, script.size(), gnuplot) == script.size();
    const int status = ::pclose(gnuplot);
    const bool ended = WIFEXITED(status);
    if (ended && WEXITSTATUS(status) == absent)
        return Error{"--plot " + file + ": gnuplot is missing; install it (Debian package gnuplot-nox)"};
    if (!read || !ended || WEXITSTATUS(status) != 0)
        return Error{"--plot " + file + ": gnuplot failed with status " +
                     std::to_string(ended ? WEXITSTATUS(status) : WTERMSIG(status))};
    return {};
}

} // namespace lockstone::cli
