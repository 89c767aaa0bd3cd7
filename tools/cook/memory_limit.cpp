#include "cook/memory_limit.h"

#include <fstream>
#include <limits>

#include <sys/resource.h>
#include <unistd.h>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define LOCKSTONE_SANITIZED 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define LOCKSTONE_SANITIZED 1
#endif
#endif

namespace lockstone::cook {

MemoryLimit::MemoryLimit(std::uint64_t bytes)
    : most(std::numeric_limits<std::uint64_t>::max()), before(most) {
#ifndef LOCKSTONE_SANITIZED
    std::uint64_t pages = 0;
    rlimit now{};
    if (!(std::ifstream("/proc/self/statm") >> pages) || getrlimit(RLIMIT_AS, &now) != 0) return;
    const std::uint64_t wanted = pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE)) + bytes;
    if (now.rlim_cur != RLIM_INFINITY && now.rlim_cur <= wanted) return; // the caller's limit is lower
    before = now.rlim_cur;
    now.rlim_cur = wanted;
    is_set = setrlimit(RLIMIT_AS, &now) == 0;
    if (is_set) most = wanted;
#else
    static_cast<void>(bytes);
#endif
}

MemoryLimit::~MemoryLimit() {
    rlimit now{};
    if (!is_set || getrlimit(RLIMIT_AS, &now) != 0) return;
    now.rlim_cur = before;
    setrlimit(RLIMIT_AS, &now);
}

} // namespace lockstone::cook
