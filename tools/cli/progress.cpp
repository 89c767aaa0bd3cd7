#include "cli/progress.h"

#include "cli/text.h"

#include <algorithm>
#include <cstdio>
#include <utility>

#include <unistd.h>

namespace lockstone::cli {

Progress::Progress(std::string what, std::uint64_t all)
    : label(cli::shown(what)), total(all), on(isatty(2) == 1) {}

Progress::~Progress() { wipe(); }

void Progress::wipe() {
    if (on && shown != ~std::uint64_t{0}) std::fputs("\r\033[K", stderr);
    shown = ~std::uint64_t{0};
}

void Progress::at(std::uint64_t done) {
    if (!on || total == 0) return;
    const std::uint64_t percent = std::min(done, total) * 100 / total;
    if (percent == shown) return;
    shown = percent;
    constexpr std::size_t width = 40;
    const std::size_t filled = static_cast<std::size_t>(percent) * width / 100;
    const std::string bar = std::string(filled, '#') + std::string(width - filled, '.');
    std::fprintf(stderr, "\r%s [%s] %3u %%", label.c_str(), bar.c_str(), static_cast<unsigned>(percent));
    std::fflush(stderr);
}

} // namespace lockstone::cli
