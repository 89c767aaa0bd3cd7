#include "cook/memory_limit.h"

#include <fstream>
#include <limits>

#include <sys/resource.h>
#include <unistd.h>

namespace lockstone::cook {

MemoryLimit::MemoryLimit(std::uint64_t bytes)
    : most(std::numeric_limits<std::uint64_t>::max()), before(most) {
    if (!limits_memory) return;
    std::uint64_t pages = 0;
    rlimit now{};
    if (!(std::ifstream("/proc/self/statm") >> pages) || getrlimit(RLIMIT_AS, &now) != 0) return;
    const std::uint64_t wanted = pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE)) + bytes;
    if (now.rlim_cur != RLIM_INFINITY && now.rlim_cur <= wanted) return; // an existing limit is lower
    before = now.rlim_cur;
    now.rlim_cur = wanted;
    is_set = setrlimit(RLIMIT_AS, &now) == 0;
    if (is_set) most = wanted;
}

MemoryLimit::~MemoryLimit() {
    rlimit now{};
    if (!is_set || getrlimit(RLIMIT_AS, &now) != 0) return;
    now.rlim_cur = before;
    setrlimit(RLIMIT_AS, &now);
}

} // namespace lockstone::cook
