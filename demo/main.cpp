/// lockstone-demo shows the engine at work. It contains no simulation logic: worlds, games, sessions and replays come
/// from the library, which runs every tick.

#include "app.h"

#include <cstdio>
#include <exception>

int main(int argc, char** argv) {
    using namespace lockstone::demo;
    try {
        const auto parsed = parse_options(argc, argv);
        if (const int* status = std::get_if<int>(&parsed)) return *status;
        return run(std::get<Options>(parsed));
    } catch (const std::exception& error) {
        std::fprintf(stderr, "lockstone-demo: %s\n", error.what());
        return 2;
    }
}
