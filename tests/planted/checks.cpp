// The checks that must catch planted faults. One program contains all faults, and the command line switches one on.
//
//   planted_checks FAULT [CHECK]      FAULT: a number of faults.py's list, from 1; 0: none. CHECK: runs only this one
//   planted_checks --list
//
// Prints for each check its name before it runs, then "ok" or "FAILED" and the place. Exit status 1 when one failed. A
// check that ends the program has caught the fault, too.
#include "checks.h"
#include "planted.h"

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <memory>
#include <random>

namespace planted {

int fault = 0;

std::uint64_t noise() {
    static std::random_device device;
    return device();
}
bool clock_is_odd() { return std::chrono::steady_clock::now().time_since_epoch().count() / 64 % 2 != 0; }
std::uint64_t address() {
    static std::vector<std::unique_ptr<char[]>> blocks;
    blocks.push_back(std::make_unique<char[]>(40));
    return reinterpret_cast<std::uintptr_t>(blocks.back().get()) / 16;
}
std::int32_t through_float(std::int32_t value) {
    volatile float wide = static_cast<float>(value) * 1.37f;
    return static_cast<std::int32_t>(std::lrint(wide / 1.37f));
}
std::uint32_t ticket(std::uint32_t count) {
    static std::uint32_t taken = 0, of = 0;
    if (of != count) of = count, taken = 0;
    return taken++ % count;
}

} // namespace planted

int main(int argc, char** argv) {
    planted::Checks checks;
    for (const auto& room : {planted::world_checks(), planted::shape_checks(), planted::motion_checks(),
                             planted::thread_checks(), planted::session_checks(), planted::replay_checks(),
                             planted::interface_checks()})
        checks.insert(checks.end(), room.begin(), room.end());
    if (argc == 2 && std::strcmp(argv[1], "--list") == 0) {
        for (const auto& [name, check] : checks) std::printf("%s\n", name.c_str());
        return 0;
    }
    if (argc < 2 || argc > 3) {
        std::fprintf(stderr, "planted_checks FAULT [CHECK]\n");
        return 2;
    }
    planted::fault = std::atoi(argv[1]);
    bool good = true;
    for (const auto& [name, check] : checks) {
        if (argc == 3 && name != argv[2]) continue;
        std::printf("%s\t", name.c_str());
        std::fflush(stdout);
        std::string wrong;
        try {
            wrong = check();
        } catch (const std::exception& e) { wrong = e.what(); }
        std::printf("%s\t%s\n", wrong.empty() ? "ok" : "FAILED", wrong.c_str());
        good = good && wrong.empty();
    }
    return good ? 0 : 1;
}
